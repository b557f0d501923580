"""Pack a study into bytes for machines without a shared disk."""

from __future__ import annotations

import hashlib
import io
import lzma
import os
import shutil
import tarfile
import tempfile
from pathlib import Path

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.folder import FOLDERS
from scaloft_fi.reading import FILE_BYTES, is_file, read_bytes

MOST_BYTES = FILE_BYTES
"""Largest archive of a study."""


def packed(study: Path) -> bytes:
    """Pack the three folders of a study without hidden files; equal content gives equal bytes.

    Raises:
        InputError: a file cannot be read.
    """
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w") as archive:
        for path in sorted(path for name in FOLDERS for path in (study / name).rglob("*")):
            name = path.relative_to(study)
            if is_file(path) and not any(part.startswith((".", "__")) for part in name.parts):
                entry = tarfile.TarInfo(name.as_posix())
                data = read_bytes(path, MOST_BYTES - content.tell())
                entry.size = len(data)
                archive.addfile(entry, io.BytesIO(data))
    return lzma.compress(content.getvalue())


def digest_of(bundle: bytes) -> str:
    """The name of a bundle: its hash."""
    return hashlib.sha256(bundle).hexdigest()


def unpacked(bundle: bytes, folder: Path) -> Path:
    """Unpack the study of `bundle` into `folder` once; other processes may do the same at the same time."""
    if not folder.is_dir():
        begun = Path(tempfile.mkdtemp(prefix=f"{folder.name}-", dir=folder.parent))
        with tarfile.open(fileobj=io.BytesIO(_decompressed(bundle))) as archive:
            archive.extractall(begun, filter="data")
        try:
            os.rename(begun, folder)  # noqa: PTH104 - it must fail if another process was faster
        except OSError:
            shutil.rmtree(begun, ignore_errors=True)
    return folder


def _decompressed(bundle: bytes) -> bytes:
    """The archive of a bundle.

    Raises:
        InputError: the bundle is damaged, or its archive is larger than `MOST_BYTES`.
    """
    unpacking = lzma.LZMADecompressor()
    try:
        content = unpacking.decompress(bundle, MOST_BYTES)
    except lzma.LZMAError as error:
        raise InputError(f"the study that was sent cannot be unpacked: {error}") from error
    if not unpacking.eof:
        raise InputError(f"the study that was sent is damaged, or unpacks to more than {MOST_BYTES:,} bytes")
    return content
