from __future__ import annotations

from pathlib import Path

import pytest

from scaloft_fi.sources import SourceCache


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "scaloft-fi"


def test_a_later_process_finds_what_was_kept_and_only_for_the_same_content(folder: Path) -> None:
    first = SourceCache(b"reader")
    assert first.get(b"x = 1") is None
    first.put(b"x = 1", ("meaning", ("a", "b")))
    first.save()
    assert len(list(folder.iterdir())) == 1
    later = SourceCache(b"reader")
    assert later.get(b"x = 1") == ("meaning", ("a", "b"))
    assert later.get(b"x = 2") is None


def test_another_reader_finds_nothing_of_it(folder: Path) -> None:
    first = SourceCache(b"reader")
    first.put(b"x = 1", ("meaning", ()))
    first.save()
    assert SourceCache(b"another").get(b"x = 1") is None


@pytest.mark.parametrize("content", [b"", b"[1]", b"{", b'{"a": 1}', b"[" * 100_000, b"\xff"])
def test_a_file_that_holds_nonsense_counts_as_empty_and_is_written_anew(folder: Path, content: bytes) -> None:
    cache = SourceCache(b"reader")
    cache.put(b"x = 1", ("meaning", ()))
    cache.save()
    (path,) = folder.iterdir()
    path.write_bytes(content)
    later = SourceCache(b"reader")
    assert later.get(b"x = 1") is None
    later.put(b"x = 1", ("meaning", ()))
    later.save()
    assert SourceCache(b"reader").get(b"x = 1") == ("meaning", ())


def test_a_folder_that_cannot_be_written_is_no_hindrance(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    cache = SourceCache(b"reader")
    assert cache.get(b"x = 1") is None
    cache.put(b"x = 1", ("meaning", ()))
    cache.save()
    assert cache.get(b"x = 1") == ("meaning", ())


def test_what_has_nothing_new_writes_nothing(folder: Path) -> None:
    SourceCache(b"reader").save()
    assert not folder.exists()
