"""An archive is opened as a campaign is and holds outcomes whole; what is damaged or hostile is refused.

The grid of a campaign, and its folder: a name, or a path that the system accepts.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from array import array
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pyarrow
import pyarrow.parquet
import pytest
from builders import AXES, GRID, KINDS, ROSTER, campaigns, outcome
from crafted import campaign
from hypothesis import given
from refused import refusal
from studies import copied

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.store import archive
from scaloft_fi.campaign.store import archive as archives
from scaloft_fi.campaign.store.held import Keys, Now, held_in
from scaloft_fi.campaign.store.record import MOST_FLIGHTS
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, track_values
from scaloft_fi.study import Study
from scaloft_fi.verbs.export.dossier import archive_files, outcome_file, track_file, unzipped, zipped

STUDY = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("results") / "night"
    campaign(Study.open(STUDY), folder / archives.STORE_NAME)
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


def without_documents(files: dict[str, bytes]) -> dict[str, bytes]:
    """The archive without its study."""
    said = json.loads(files[archives.MANIFEST])
    said["files"] = {name: digest for name, digest in said["files"].items() if "/" not in name}
    bare = {name: content for name, content in files.items() if "/" not in name}
    return bare | {archives.MANIFEST: json.dumps(said).encode()}


def refused(place: Path) -> str:
    told = refusal(lambda: list(archives.opened(Study.open(STUDY), place)[1].rows()))
    assert str(place) in told
    return told


def test_a_folder_and_a_zip_file_give_back_the_flights_with_their_tracks(
    files: dict[str, bytes], folder: Path, tmp_path: Path
):
    place = tmp_path / "night.zip"
    place.write_bytes(zipped(files))
    store_folder = tmp_path / "store"
    campaign(Study.open(STUDY), store_folder / archives.STORE_NAME)
    _, flown = archives.opened(Study.open(STUDY), store_folder)
    expected = dict(flown.rows())
    for one in (folder, place):
        study, read = archives.opened(Study.open(STUDY), one)
        assert (study.name, read.meta(), read.notes()) == (STUDY.name, flown.meta(), flown.notes())
        rows = dict(read.rows())
        assert rows.keys() == expected.keys() == read.known(expected)
        assert all(rows[key].digest == expected[key].digest and rows[key].track for key in rows)
        assert [f[:4] for f in read.flights()] == [f[:4] for f in flown.flights()]
    flown.close()


def test_the_same_campaign_makes_the_same_archive(files: dict[str, bytes]):
    assert unzipped(zipped(files)) == files
    assert zipped(files) == zipped(files)
    assert next(iter(files)) == archives.MANIFEST


def test_an_archive_is_read_with_its_own_study(folder: Path, files: dict[str, bytes], tmp_path: Path):
    study, store = archives.opened(Study.open(STUDY), folder)
    assert isinstance(store, archives.Archive)
    assert study.folder == folder
    study, _ = archives.opened(Study.open(STUDY), written(without_documents(files), tmp_path / "bare"))
    assert study.folder == STUDY


def test_its_grid_is_that_of_the_campaign(files: dict[str, bytes], tmp_path: Path):
    said = json.loads(files[archives.MANIFEST])
    said["notes"]["grid flown"] = json.dumps("wide")
    place = written(files | {archives.MANIFEST: json.dumps(said).encode()}, tmp_path / "wide")
    assert archives.study_of(STUDY, str(place)).grid.name == "wide"
    assert archives.study_of(STUDY, str(place), "wide").grid.name == "wide"
    with pytest.raises(InputError, match="was flown over grid 'wide'"):
        archives.study_of(STUDY, str(place), "search")


def test_nothing_is_written_into_an_archive_and_it_lends_no_flights(folder: Path):
    assert archives.is_archive(folder)
    for refuse in (archives.promising, archives.writable):
        with pytest.raises(InputError, match="an archive is a record, into which nothing is flown or merged"):
            refuse(folder)
    with pytest.raises(InputError, match="an archive is a record, which lends no flights"):
        archives.existing(folder)
    with pytest.raises(InputError, match="an archive is a record"):
        archives.opened(Study.open(STUDY), folder)[1].set_notes({"a": "b"})


def test_a_folder_with_a_store_is_a_campaign_whatever_lies_beside_it(folder: Path):
    campaign(Study.open(STUDY), folder / archives.STORE_NAME)
    assert not archives.is_archive(folder)


def change(path: Path) -> None:
    path.write_bytes(path.read_bytes() + b"\n")


@pytest.mark.parametrize("name", ["outcomes.parquet", "tracks.parquet", "sim/world.yaml", "hazop/score.yaml"])
def test_a_file_that_was_changed_added_or_removed_is_named(folder: Path, name: str):
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
def test_a_record_that_says_something_else_is_refused(folder: Path, said: object):
    (folder / archives.MANIFEST).write_text(json.dumps(said))
    assert archives.MANIFEST in refused(folder)


def zipped_as(path: Path, fill: Callable[[zipfile.ZipFile], None]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        fill(file)
    return path


@pytest.mark.parametrize("name", ["../outside", "/root", "hazop/../../outside", "a\\b", "C:", "evil.py", "mutants//x"])
def test_a_zip_file_with_another_file_is_refused_and_nothing_is_written_outside(tmp_path: Path, name: str):
    place = zipped_as(tmp_path / "x.zip", lambda file: file.writestr(name, "x"))
    before = sorted(tmp_path.rglob("*"))
    assert "it has a file" in refused(place)
    assert sorted(tmp_path.rglob("*")) == before


def test_a_zip_file_that_grows_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
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
def test_a_file_that_is_no_zip_file_is_refused(tmp_path: Path, content: bytes):
    place = tmp_path / "x.zip"
    place.write_bytes(content)
    assert refused(place)


def test_a_flight_that_occurs_twice_is_refused(folder: Path):
    table = pyarrow.parquet.read_table(folder / "outcomes.parquet")
    pyarrow.parquet.write_table(pyarrow.concat_tables([table, table]), folder / "outcomes.parquet")
    said = json.loads((folder / archives.MANIFEST).read_text())
    said["files"]["outcomes.parquet"] = hashlib.sha256((folder / "outcomes.parquet").read_bytes()).hexdigest()
    (folder / archives.MANIFEST).write_text(json.dumps(said))
    assert "a flight occurs twice" in refused(folder)


def test_a_flight_that_the_study_no_longer_has_is_stale(folder: Path, files: dict[str, bytes], tmp_path: Path):
    study = copied(tmp_path / "study")
    place = written(without_documents(files), tmp_path / "bare")
    axes = study / "sim" / "situations.yaml"
    axes.write_text(re.sub(r"\bT(?=[:01])", "U", axes.read_text()))
    now, store = archives.opened(Study.open(study), place)
    held = held_in(Now(now, store), place)
    assert store.standing(Now(now, store).stands) == ()
    assert held.why == {"the situation is not in the grid any more": len(store.flights())}


PATH = Path("archive/outcomes.parquet")
FAKE: Any = SimpleNamespace(
    roster=ROSTER, space=GRID, requirements=[SimpleNamespace(name=name, kind=kind) for name, kind in KINDS.items()]
)
Change = Callable[[pyarrow.Table], pyarrow.Table]


def read(content: bytes) -> list[Outcome]:
    return list(archives.read_outcomes(PATH, content, tuple(KINDS.items()), AXES))


def flown(one: Outcome) -> Outcome:
    """The outcome as a flight has it: an invalid one has no readings, and only measured robustness is kept."""
    if one.invalid:
        return replace(one, readings=(), violations=(), realised=())
    order = list(KINDS)
    return replace(
        one,
        readings=tuple(replace(r, rho=r.rho if r.robustness is not None else 0.0) for r in one.readings),
        violations=tuple(sorted(one.violations, key=lambda violation: order.index(violation.requirement))),
    )


@given(campaigns())
def test_every_outcome_comes_back_as_it_was(outcomes: list[Outcome]):
    once = {one.name: flown(one) for one in outcomes}
    assert {one.name: one for one in read(outcome_file(tuple(once.values()), FAKE))} == once


def test_what_export_leaves_out_comes_back_too():
    one = outcome("LATE-human@3s", violated={"SR1": 5.0, "SR2": 4.0}, struck="wall")
    one = replace(
        one,
        stack_error="ZeroDivisionError",
        perceived_digest="seen",
        readings=tuple(replace(reading, triggered=3) for reading in one.readings),
        violations=tuple(replace(v, x=v.t_s, y=-v.t_s, z=0.5) for v in one.violations),
    )
    assert read(outcome_file([one], FAKE)) == [flown(one)]


def changed(change: Change) -> bytes:
    table = pyarrow.parquet.read_table(io.BytesIO(outcome_file([outcome(), outcome(seed=1)], FAKE)))
    file = io.BytesIO()
    pyarrow.parquet.write_table(change(table), file)
    return file.getvalue()


def put(name: str, values: list[Any], kind: Any = None) -> Change:
    def change(table: pyarrow.Table) -> pyarrow.Table:
        column = pyarrow.array(values, kind or table.schema.field(name).type)
        return table.set_column(table.column_names.index(name), name, column)

    return change


NAN = float("nan")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda table: table.drop_columns(["episodes"]), "column 'episodes' must be list<int64>"),
        (put("seed", ["0", "1"], pyarrow.string()), "column 'seed' must be int64, and is string"),
        (put("seed", [0, 2**40]), "column seed must be a whole number from 0 to"),
        (put("seed", [0, None]), "column seed must be a whole number"),
        (put("mutant", ["baseline", "a\nb"]), "column mutant must be a text of at most"),
        (put("digest", ["", None]), "column digest must be a text"),
        (put("duration_s", [1.0, NAN]), "column duration_s must be a finite number"),
        (put("rho_SR1", [None, float("inf")]), "column rho_SR1 must be a finite number or NULL"),
        (put("held", [[], None]), "column held must be a list"),
        (put("violated", [[], ["SR9"]]), "must be as long as violated"),
        (put("episodes", [[], []]), "column episodes must be as long as triggered"),
    ],
)
def test_what_no_store_holds_is_refused(change: Change, said: str):
    told = refusal(read, changed(change))
    assert told.startswith(f"{PATH}: ")
    assert said in told


def test_a_requirement_that_the_archive_does_not_name_is_refused():
    names = {"violated": ["SR9"], "violation_times_s": [1.0], "violation_bodies": [""]}
    places = {f"violation_{axis}": [0.0] for axis in "xyz"}

    def change(table: pyarrow.Table) -> pyarrow.Table:
        for name, values in (names | places).items():
            table = put(name, [[], values])(table)
        return table

    with pytest.raises(InputError, match="column violated must be names of SR1, SR2"):
        read(changed(change))


@pytest.mark.parametrize("content", [b"", b"PAR1", b"PAR1" + bytes(100) + b"PAR1", changed(lambda table: table)[:-9]])
def test_a_damaged_file_is_refused(content: bytes):
    assert "holds no flights of an archive" in refusal(read, content)


def test_a_file_that_grows_in_memory_is_refused(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(MOST_FLIGHTS, "2")
    assert len(read(changed(lambda table: table))) == 2
    bomb = changed(put("stack_error", ["x" * 200_000] * 2))  # one value in the file, two in memory
    assert len(bomb) < 20_000
    with pytest.raises(InputError, match="more rows than the limit for 2 flights"):
        read(bomb)
    monkeypatch.setenv(MOST_FLIGHTS, "1")
    with pytest.raises(InputError, match="SCALOFT_MOST_FLIGHTS raises the limit"):
        read(changed(put("seed", [4, 5])))


def test_without_pyarrow_the_remedy_is_told(monkeypatch: pytest.MonkeyPatch):
    content = changed(put("seed", [6, 7]))
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(InputError, match=r"needs pyarrow: pip install 'scaloft-fi\[parquet\]'"):
        read(content)


WIDTH = len(TRACK_COLUMNS)


def test_a_trajectory_comes_back_by_the_digest_of_its_flight():
    tracks = {"a": array("f", map(float, range(2 * WIDTH))), "b": array("f", [0.5] * WIDTH), "c": array("f")}
    kept = archives.Trajectories(PATH, track_file(tracks))
    assert {digest: track_values(kept.of(digest)) for digest in tracks} == tracks
    assert kept.of("d") == b""
    assert archives.Trajectories(PATH, track_file({})).of("a") == b""


def test_trajectories_of_unequal_columns_are_refused():
    table = pyarrow.parquet.read_table(io.BytesIO(track_file({"a": array("f", [0.5] * WIDTH)})))
    file = io.BytesIO()
    pyarrow.parquet.write_table(put("x_m", [[1.0, 2.0]])(table), file)
    with pytest.raises(InputError, match="of equal length"):
        archives.Trajectories(PATH, file.getvalue())


def planned(folder: Path, grid: str | None) -> str:
    """A campaign over a grid, with one planned flight; returns its name."""
    study = Study.open(STUDY, grid)
    with Store(folder / archives.STORE_NAME) as store:
        archives.remember_grid(store, study)
        store.plan([Keys(study).planned(Flight(None, study.grid.situations[0], 0))])
    return str(folder)


@pytest.fixture(scope="module")
def over_grids(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """Campaigns over the wide grid and over that of the paper, which are only read."""
    folder = tmp_path_factory.mktemp("grids")
    return planned(folder / "wide", "wide"), planned(folder / "paper", None)


def test_a_campaign_opens_the_study_with_the_grid_over_which_it_was_flown(over_grids: tuple[str, str]):
    wide, paper = over_grids
    assert archives.study_of(STUDY, wide).grid_name == "wide"
    assert archives.study_of(STUDY, wide, "wide").grid_name == "wide"
    assert archives.study_of(STUDY, paper).grid_name is None
    assert archives.study_of(STUDY, paper, "paper").grid_name is None


def test_a_campaign_that_does_not_exist_has_the_grid_that_the_user_names(tmp_path: Path):
    assert archives.study_of(STUDY, str(tmp_path / "none")).grid_name is None
    assert archives.study_of(STUDY, str(tmp_path / "none"), "wide").grid_name == "wide"
    (tmp_path / "empty").mkdir()
    Store(tmp_path / "empty" / archives.STORE_NAME).close()
    assert archives.study_of(STUDY, str(tmp_path / "empty"), "wide").grid_name == "wide"


def test_a_campaign_takes_no_flights_of_another_grid(over_grids: tuple[str, str]):
    wide, paper = over_grids
    with pytest.raises(InputError, match=r"^--grid=paper: campaign .* was flown over grid 'wide'; name another"):
        archives.study_of(STUDY, wide, "paper")
    with pytest.raises(InputError, match=r"^--grid=wide: campaign .* was flown over grid 'paper'; name another"):
        archives.study_of(STUDY, paper, "wide")


def test_campaigns_are_joined_and_compared_over_one_grid_only(over_grids: tuple[str, str], tmp_path: Path):
    (wide, paper), new = over_grids, str(tmp_path / "new")
    assert archives.study_of_all(STUDY, [wide, new]).grid_name == "wide"
    assert archives.study_of_all(STUDY, [paper, new]).grid_name is None
    with pytest.raises(InputError, match=r"over grid 'wide', and .* over 'paper'; only campaigns of one grid"):
        archives.study_of_all(STUDY, [paper, wide])


def test_a_record_that_is_no_name_is_refused(tmp_path: Path):
    with Store(tmp_path / "c" / archives.STORE_NAME) as store:
        store.set_notes({"grid flown": "[1]"})
    with pytest.raises(InputError, match="must be a record of `run`"):
        archives.study_of(STUDY, str(tmp_path / "c"))


@pytest.mark.parametrize("name", ["../../secret", "", "wid", ".hidden"])
def test_a_record_of_a_grid_that_the_study_lacks_is_one_sentence(tmp_path: Path, name: str):
    with Store(tmp_path / "c" / archives.STORE_NAME) as store:
        store.set_notes({"grid flown": json.dumps(name)})
        with pytest.raises(InputError, match=r"was flown over grid '.*', which the study lacks"):
            archives.with_grid(Study.open(STUDY), store)


@pytest.mark.parametrize("name", ["~nosuchuser/a", "/" + "a" * 300, "a/b\0", "a" * 256, "é" * 128, "..", " ", "a\0"])
def test_a_name_that_the_system_refuses_is_refused_in_a_sentence(tmp_path, name):
    with pytest.raises(InputError, match=r"^--campaign: name=.* must be the (path|name) of a folder"):
        archives.campaign_folder(Study(tmp_path), name)


def test_a_name_stands_for_a_folder_of_the_results_and_a_path_for_itself(tmp_path):
    assert archives.campaign_folder(Study(tmp_path), "a" * 255).parent == tmp_path / "results" / "campaigns"
    assert archives.campaign_folder(Study(tmp_path), f"{tmp_path}/new") == tmp_path / "new"
