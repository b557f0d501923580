"""Files of some kilobytes to some megabytes that unpack to 2 GiB, one for each format that can pack."""

from __future__ import annotations

import bz2
import io
import json
import struct
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import lz4.frame
import mcap.writer
import openpyxl
import pyarrow.parquet
import pytest
import records
import rosbags.rosbag1
import rosbags.rosbag2.writer
import zstandard
from rosbags.rosbag2 import CompressionFormat, CompressionMode

ZEROS, TIMES = bytes(1 << 22), 512
"""They make 2 GiB."""


def by_bz2(data: bytes) -> bytes:
    """The data, and 2 GiB of zeros."""
    return bz2.compress(data) + bz2.compress(ZEROS) * TIMES


def by_lz4(data: bytes) -> bytes:
    """The data, and 2 GiB of zeros, in one frame."""
    packer = lz4.frame.LZ4FrameCompressor()
    begun = packer.begin() + packer.compress(data)
    return b"".join([begun, *(packer.compress(ZEROS) for _ in range(TIMES)), packer.flush()])


def by_zstd(data: bytes) -> bytes:
    """The data, and 2 GiB of zeros, in one frame that declares its size."""
    packer = zstandard.ZstdCompressor().compressobj(size=len(data) + len(ZEROS) * TIMES)
    return b"".join([packer.compress(data), *(packer.compress(ZEROS) for _ in range(TIMES)), packer.flush()])


def bag(folder: Path, format_: str) -> Path:
    """A bag of ROS 1 whose chunk unpacks to more than it says."""
    packed, writer = {"BZ2": by_bz2, "LZ4": by_lz4}[format_], rosbags.rosbag1.Writer

    class Packing(writer):
        def __enter__(self) -> Packing:
            self.set_compression(writer.CompressionFormat[format_])
            self.compressor = packed
            super().__enter__()
            return self

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rosbags.rosbag1, "Writer", Packing)
        return records.rosbag1(folder)


def chunks(folder: Path, packed: Callable[[bytes], bytes], *, summary: bool = True) -> Path:
    """An MCAP whose chunks unpack to more than they say."""
    kind = mcap.writer.CompressionType.LZ4 if packed is by_lz4 else mcap.writer.CompressionType.ZSTD
    path = folder / "flight.mcap"
    with pytest.MonkeyPatch.context() as patch, path.open("wb") as file:
        patch.setattr(mcap.writer, "zstandard", SimpleNamespace(compress=packed))
        patch.setattr(mcap.writer, "lz4", SimpleNamespace(frame=SimpleNamespace(compress=packed)))
        none = mcap.writer.IndexType.NONE
        index = {} if summary else {"index_types": none, "repeat_channels": False, "repeat_schemas": False}
        writer = mcap.writer.Writer(file, compression=kind, use_statistics=summary, **index)
        writer.start()
        topic = writer.register_channel("/x", "json", 0)
        for second in range(3):
            at_ns = 7_000_000_000 + second * 10**9
            writer.add_message(topic, at_ns, json.dumps({"data": second}).encode(), at_ns)
        writer.finish()
    return path


def rosbag2(folder: Path, mode: CompressionMode) -> Path:
    """A folder of rosbag2 whose file, or whose messages, unpack to 2 GiB."""
    writer = rosbags.rosbag2.writer.Writer

    class Packing(writer):
        def __init__(self, *words: object, **named: object) -> None:
            super().__init__(*words, **named)
            self.set_compression(mode, CompressionFormat.ZSTD)

    packed: list[bytes] = []

    def once(data: bytes) -> bytes:
        """The first message is a bomb, the others are as small as they can be."""
        packed.append(by_zstd(data) if not packed else zstandard.compress(data))
        return packed[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rosbags.rosbag2, "Writer", Packing)
        if mode is CompressionMode.MESSAGE:
            patch.setattr(rosbags.rosbag2.writer, "zstd", SimpleNamespace(compress=once))
        path = records.rosbag2(folder)
    for file in path.glob("*.zstd"):
        file.write_bytes(by_zstd(zstandard.ZstdDecompressor().decompressobj().decompress(file.read_bytes())))
    return path


def glb(folder: Path) -> Path:
    """A mesh that declares a thousand million places, of which it has one."""
    count = 1_000_000_000
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"},
            {"bufferView": 0, "componentType": 5125, "count": count, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 12 * count}],
        "buffers": [{"byteLength": 12 * count}],
    }
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    path = folder / "mine.glb"
    parts = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", 12, b"BIN\0") + bytes(12)
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts)
    return path


def ply(folder: Path) -> Path:
    """A mesh that declares 2,000 million vertices, of which it has none."""
    path = folder / "mine.ply"
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 2000000000\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz")
    path.write_bytes(f"{head}element face 1\nproperty list uchar int vertex_indices\nend_header\n".encode() + bytes(99))
    return path


def stl(folder: Path) -> Path:
    """A mesh that declares 4,000 million triangles, of which it has one."""
    path = folder / "mine.stl"
    path.write_bytes(bytes(80) + struct.pack("<I", 4_000_000_000) + bytes(50))
    return path


RECORDS: Mapping[str, Callable[[Path], Path]] = {
    "bag of bz2": lambda folder: bag(folder, "BZ2"),
    "bag of lz4": lambda folder: bag(folder, "LZ4"),
    "mcap of zstd": lambda folder: chunks(folder, by_zstd),
    "mcap of zstd without a summary": lambda folder: chunks(folder, by_zstd, summary=False),
    "mcap of lz4": lambda folder: chunks(folder, by_lz4),
    "rosbag2 of a file of zstd": lambda folder: rosbag2(folder, CompressionMode.FILE),
    "rosbag2 of messages of zstd": lambda folder: rosbag2(folder, CompressionMode.MESSAGE),
}
MESHES: Mapping[str, Callable[[Path], Path]] = {"glb": glb, "ply": ply, "stl": stl}


def slow_bag(folder: Path) -> Path:
    """A bag of 82 chunks, each of which unpacks to 96 MiB, in the time that they take."""
    zeros = bz2.compress(ZEROS) * 24
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(globals(), "by_bz2", lambda data: bz2.compress(data) + zeros)
        patch.setattr(rosbags.rosbag1.Writer, "__init__", _of_small_chunks(rosbags.rosbag1.Writer.__init__))
        return bag(folder, "BZ2")


def _of_small_chunks(made: Callable[..., None]) -> Callable[..., None]:
    def init(self: Any, *words: Any, **named: Any) -> None:
        made(self, *words, **named)
        self.chunk_threshold = 1

    return init


def parquet(folder: Path) -> Path:
    """A column whose one value of 100,000 letters is meant 50,000 times."""
    path = folder / "outcomes.parquet"
    with pyarrow.parquet.ParquetWriter(path, pyarrow.schema([("text", pyarrow.string())])) as writer:
        for _ in range(50):
            writer.write_table(pyarrow.table({"text": ["x" * 100_000] * 1_000}))
    return path


def workbook(folder: Path, cells: int = 20_000_000, at: str = "") -> Path:
    """A worksheet of so many cells in one row, or with a cell at a place far away."""
    path, made = folder / "risks.xlsx", io.BytesIO()
    book = openpyxl.Workbook()
    book.save(made)
    cell = b'<c%s t="inlineStr"><is><t>Node</t></is></c>' % (f' r="{at}"'.encode() if at else b"")
    row = b'<row r="%d">' % int(at.strip("XFD") or 1)
    with zipfile.ZipFile(made) as source, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for entry in source.infolist():
            if entry.filename != "xl/worksheets/sheet1.xml":
                file.writestr(entry, source.read(entry))
        with file.open("xl/worksheets/sheet1.xml", "w", force_zip64=True) as sheet:
            sheet.write(b'<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>')
            sheet.write(row)
            for _ in range(max(1, cells // 10_000)):
                sheet.write(cell * min(cells, 10_000))
            sheet.write(b"</row></sheetData></worksheet>")
    return path


SHEETS: Mapping[str, Callable[[Path], Path]] = {
    "a row of 20 million cells": workbook,
    "a cell far away": lambda folder: workbook(folder, 1, "XFD1048576"),
}


def archive(folder: Path) -> Path:
    """An archive whose only document unpacks to 640 MiB."""
    path = folder / "campaign.zip"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file,
        file.open("hazop/dispositions.yaml", "w", force_zip64=True) as document,
    ):
        for _ in range(160):
            document.write(ZEROS)
    return path
