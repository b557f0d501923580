from __future__ import annotations

import io
import lzma
import tarfile
from collections.abc import Callable
from pathlib import Path

import pytest

from scaloft_fi.campaign.workers import cluster
from scaloft_fi.campaign.workers.cluster import packed, unpacked
from scaloft_fi.errors import InputError

Entry = tuple[str, bytes, bytes]
"""Name, type and content."""


def _made(*entries: Entry) -> bytes:
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w") as archive:
        for name, kind, data in entries:
            entry = tarfile.TarInfo(name)
            entry.type, entry.size = kind, len(data)
            entry.linkname = "/etc/passwd" if kind in (tarfile.SYMTYPE, tarfile.LNKTYPE) else ""
            archive.addfile(entry, io.BytesIO(data))
    return lzma.compress(content.getvalue())


def test_what_is_packed_is_unpacked_again(tmp_path: Path) -> None:
    for name in ("sim/world.yaml", "sim/deep/mine.obj", "hazop/a.yaml", "mutants/catalogue.jsonl", "sim/.hidden"):
        path = tmp_path / "study" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(name.encode())
    folder = unpacked(packed(tmp_path / "study"), tmp_path / "there")
    found = {path.relative_to(folder).as_posix(): path.read_text() for path in folder.rglob("*") if path.is_file()}
    names = ("sim/world.yaml", "sim/deep/mine.obj", "hazop/a.yaml", "mutants/catalogue.jsonl")
    assert found == {name: name for name in names}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["study", "there"]


@pytest.mark.parametrize(
    "made",
    [
        lambda: _made(("../out.yaml", tarfile.REGTYPE, b"x")),
        lambda: _made(("sim/../../out.yaml", tarfile.REGTYPE, b"x")),
        lambda: _made(("/tmp/out.yaml", tarfile.REGTYPE, b"x")),
        lambda: _made(("other/file", tarfile.REGTYPE, b"x")),
        lambda: _made(("sim/link", tarfile.SYMTYPE, b"")),
        lambda: _made(("sim/link", tarfile.LNKTYPE, b"")),
        lambda: _made(("sim/pipe", tarfile.FIFOTYPE, b"")),
        lambda: _made(*((f"sim/{number}", tarfile.REGTYPE, b"") for number in range(6))),
        lambda: _made(("sim/zeros", tarfile.REGTYPE, bytes(200_000))),
        lambda: _made(("sim/file", tarfile.REGTYPE, b"x"))[:-20],
        lambda: lzma.compress(b"no archive" * 200),
        lambda: b"no bundle",
    ],
)
def test_a_bundle_that_no_study_makes_is_refused_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, made: Callable[[], bytes]
) -> None:
    monkeypatch.setattr(cluster, "MOST_FILES", 5)
    monkeypatch.setattr(cluster, "MOST_BYTES", 100_000)
    (tmp_path / "in").mkdir()
    with pytest.raises(InputError, match="the bundle of the study is refused"):
        unpacked(made(), tmp_path / "in" / "study")
    assert [path.name for path in tmp_path.rglob("*")] == ["in"]
