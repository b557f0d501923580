"""An archive is opened as a campaign is, and one that is damaged, changed or hostile is refused in one sentence."""

from __future__ import annotations

import json
import re
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from crafted import campaign

from scaloft_fi.campaign.store import archive
from scaloft_fi.campaign.store.archive import MANIFEST, STORE_NAME, Archive, existing, is_archive, promising, writable
from scaloft_fi.campaign.store.flown_grid import opened, study_of
from scaloft_fi.campaign.store.held import held_in
from scaloft_fi.errors import InputError
from scaloft_fi.study import Study
from scaloft_fi.verbs.export.archive import archive_files, unzipped, zipped

STUDY = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("results") / "night"
    campaign(Study.open(STUDY), folder / STORE_NAME)
    return archive_files(Study.open(STUDY), str(folder))


@pytest.fixture
def folder(files: dict[str, bytes], tmp_path: Path) -> Path:
    return written(files, tmp_path / "archive")


def written(files: dict[str, bytes], folder: Path) -> Path:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return folder


def refused(place: Path) -> str:
    with pytest.raises(InputError) as error:
        list(opened(Study.open(STUDY), place)[1].rows())
    told = str(error.value)
    assert "\n" not in told
    assert str(place) in told
    return told


def test_a_folder_and_a_zip_file_give_back_the_flights_with_their_tracks(
    files: dict[str, bytes], folder: Path, tmp_path: Path
) -> None:
    place = tmp_path / "night.zip"
    place.write_bytes(zipped(files))
    store_folder = tmp_path / "store"
    campaign(Study.open(STUDY), store_folder / STORE_NAME)
    _, flown = opened(Study.open(STUDY), store_folder)
    expected = dict(flown.rows())
    for one in (folder, place):
        study, read = opened(Study.open(STUDY), one)
        assert (study.name, read.meta(), read.notes()) == (STUDY.name, flown.meta(), flown.notes())
        rows = dict(read.rows())
        assert rows.keys() == expected.keys() == read.known(expected)
        assert all(rows[key].digest == expected[key].digest and rows[key].track for key in rows)
        assert [f[:4] for f in read.flights()] == [f[:4] for f in flown.flights()]
    flown.close()


def test_the_same_campaign_makes_the_same_archive(files: dict[str, bytes]) -> None:
    assert unzipped(zipped(files)) == files
    assert zipped(files) == zipped(files)
    assert next(iter(files)) == MANIFEST


def test_an_archive_is_read_with_its_own_study(folder: Path, files: dict[str, bytes], tmp_path: Path) -> None:
    study, store = opened(Study.open(STUDY), folder)
    assert isinstance(store, Archive)
    assert study.folder == folder
    bare = {name: content for name, content in files.items() if "/" not in name}
    said = json.loads(bare[MANIFEST])
    said["files"] = {name: digest for name, digest in said["files"].items() if "/" not in name}
    bare[MANIFEST] = json.dumps(said).encode()
    study, _ = opened(Study.open(STUDY), written(bare, tmp_path / "bare"))
    assert study.folder == STUDY


def test_its_grid_is_that_of_the_campaign(files: dict[str, bytes], tmp_path: Path) -> None:
    said = json.loads(files[MANIFEST])
    said["notes"]["grid flown"] = json.dumps("wide")
    place = written(files | {MANIFEST: json.dumps(said).encode()}, tmp_path / "wide")
    assert study_of(STUDY, str(place)).grid.name == "wide"
    assert study_of(STUDY, str(place), "wide").grid.name == "wide"
    with pytest.raises(InputError, match="was flown over grid 'wide'"):
        study_of(STUDY, str(place), "search")


def test_nothing_is_written_into_an_archive_and_it_lends_no_flights(folder: Path) -> None:
    assert is_archive(folder)
    for refuse in (promising, writable):
        with pytest.raises(InputError, match="an archive is a record, into which nothing is flown or merged"):
            refuse(folder)
    with pytest.raises(InputError, match="an archive is a record, which lends no flights"):
        existing(folder)
    with pytest.raises(InputError, match="an archive is a record"):
        opened(Study.open(STUDY), folder)[1].set_notes({"a": "b"})


def test_a_folder_with_a_store_is_a_campaign_whatever_lies_beside_it(folder: Path) -> None:
    campaign(Study.open(STUDY), folder / STORE_NAME)
    assert not is_archive(folder)


def change(path: Path) -> None:
    path.write_bytes(path.read_bytes() + b"\n")


@pytest.mark.parametrize("name", ["outcomes.parquet", "tracks.parquet", "sim/world.yaml", "hazop/score.yaml"])
def test_a_file_that_was_changed_added_or_removed_is_named(folder: Path, name: str) -> None:
    if (folder / name).exists():
        change(folder / name)
        assert f"{name} is not what was archived" in refused(folder)
        (folder / name).unlink()
        assert name in refused(folder)
    else:
        (folder / name).write_text("alpha: 0.1\n")
        assert f"{name} is not what was archived" in refused(folder)


EMPTY = {name: {} for name in ("platform", "notes", "requirements", "files")}
RIGHT = {"archive": 1, "study": "s", "campaign": "c", "axes": [], **EMPTY}


@pytest.mark.parametrize(
    "said",
    [
        *([], {}, {"archive": 1}, {"archive": 2}),
        *({**RIGHT, name: 4} for name in RIGHT),
        *({**RIGHT, name: {"a": 4}} for name in ("platform", "notes", "requirements", "files")),
        {**RIGHT, "requirements": {"SR1": "kind"}},
        {**RIGHT, "more": ""},
    ],
    ids=json.dumps,
)
def test_a_record_that_says_something_else_is_refused(folder: Path, said: object) -> None:
    (folder / MANIFEST).write_text(json.dumps(said))
    assert MANIFEST in refused(folder)


def zipped_as(path: Path, fill: Callable[[zipfile.ZipFile], None]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        fill(file)
    return path


@pytest.mark.parametrize("name", ["../outside", "/root", "hazop/../../outside", "a\\b", "C:", "evil.py", "mutants//x"])
def test_a_zip_file_with_another_file_is_refused_and_nothing_is_written_outside(tmp_path: Path, name: str) -> None:
    place = zipped_as(tmp_path / "x.zip", lambda file: file.writestr(name, "x"))
    before = sorted(tmp_path.rglob("*"))
    assert "it has a file" in refused(place)
    assert sorted(tmp_path.rglob("*")) == before


def test_a_zip_file_that_grows_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archive, "FILE_BYTES", 1000)
    place = zipped_as(tmp_path / "x.zip", lambda file: file.writestr("sim/world.yaml", "0" * 2000))
    assert place.stat().st_size < 1000
    assert "more than 10000 files or 1,000 bytes" in refused(place)
    content = bytearray(place.read_bytes())
    at = content.rindex(b"PK\x01\x02") + 24  # the size that the list of files tells
    content[at : at + 4] = (10).to_bytes(4, "little")
    place.write_bytes(content)
    assert refused(place)
    monkeypatch.setattr(archive, "MOST_FILES", 1)
    many = zipped_as(tmp_path / "y.zip", lambda file: [file.writestr(f"sim/{n}", "") for n in range(2)] and None)
    assert "more than 1 files" in refused(many)


@pytest.mark.parametrize("content", [b"", b"PK", b"no archive at all", b"PK\x05\x06" + bytes(18)])
def test_a_file_that_is_no_zip_file_is_refused(tmp_path: Path, content: bytes) -> None:
    place = tmp_path / "x.zip"
    place.write_bytes(content)
    assert refused(place)


def test_a_flight_that_occurs_twice_is_refused(folder: Path) -> None:
    import hashlib

    import pyarrow
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(folder / "outcomes.parquet")
    pyarrow.parquet.write_table(pyarrow.concat_tables([table, table]), folder / "outcomes.parquet")
    said = json.loads((folder / MANIFEST).read_text())
    said["files"]["outcomes.parquet"] = hashlib.sha256((folder / "outcomes.parquet").read_bytes()).hexdigest()
    (folder / MANIFEST).write_text(json.dumps(said))
    assert "a flight occurs twice" in refused(folder)


def test_a_flight_that_the_study_no_longer_has_is_stale(folder: Path, files: dict[str, bytes], tmp_path: Path) -> None:
    study = tmp_path / "study"
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(STUDY / name, study / name)
    bare = {name: content for name, content in files.items() if "/" not in name}
    said = json.loads(bare[MANIFEST])
    said["files"] = {name: digest for name, digest in said["files"].items() if "/" not in name}
    place = written(bare | {MANIFEST: json.dumps(said).encode()}, tmp_path / "bare")
    axes = study / "sim" / "situations.yaml"
    axes.write_text(re.sub(r"\bT(?=[:01])", "U", axes.read_text()))
    now, store = opened(Study.open(study), place)
    held = held_in(now, store, place)
    assert held.current == ()
    assert held.why == {"the situation is not in the grid any more": len(store.flights())}
