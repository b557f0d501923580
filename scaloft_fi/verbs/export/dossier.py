"""What a campaign's evidence is written from; the formats that are rows, CSV, JSON and Parquet, and the archive of all.

Texts are data in Parquet and stand as the store has them; only lone surrogates, which UTF-8 cannot hold, are spelled
out.  The archive is one ZIP file that every verb opens years later, what a paper cites.  The same campaign gives the
same bytes, for no clock is in it.
"""

from __future__ import annotations

import hashlib
import io
import json
import shlex
import zipfile
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cache, cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeVar

import numpy as np

from scaloft_fi.analysis.coverage import Coverage, coverage
from scaloft_fi.analysis.detection import Spending, Verdict
from scaloft_fi.analysis.margin import Scale
from scaloft_fi.analysis.roster import Ratio, Roster
from scaloft_fi.analysis.score import MutantScore, Score, score
from scaloft_fi.analysis.survivor import Disposition, accepted_survivors, score_without
from scaloft_fi.campaign.store import archive
from scaloft_fi.campaign.store.archive import flown_in
from scaloft_fi.defaults import SEARCHED, __version__
from scaloft_fi.document import is_there, read_bytes, read_text
from scaloft_fi.hazop.matrix import Cell, Matrix, cell_of, worst_first
from scaloft_fi.judge.outcome import BASELINE, TRACK_COLUMNS, Outcome, track_values
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import JudgedFlight, Status, apart, baseline_status, each_flight, flights_of
from scaloft_fi.marks import About, Choices
from scaloft_fi.output import in_campaign, json_text, printable
from scaloft_fi.registry import Registry, grouped
from scaloft_fi.sim.grid import FOLDER
from scaloft_fi.study import NO_FINDS, KnownFinds, Study
from scaloft_fi.verbs.snapshot import Snapshot, snapshot
from scaloft_fi.verbs.verdict import acceptance, next_command, next_find, verdict, why
from scaloft_fi.views.output import Columns, ColumnType, Field, Rows, cell, needed_pyarrow, shape_of, type_of, writer_of
from scaloft_fi.views.table import csv_text, said_text

if TYPE_CHECKING:
    import pyarrow


FlightRow = dict[str, Any]

WAITING = "waiting"
"""Status of a flight that cannot be judged: the baseline of its situation and seed is not flown, or stale."""

FlightStatus = Annotated[str, Choices(dict.fromkeys(("held", "violated", *Status, WAITING)))]
"""What a flight shows beside its baseline, or `waiting` for it; of a baseline held, violated or invalid."""
_Time = Annotated[float, About("time [s from take-off]")]


class _Flight(NamedTuple):
    """A flight.

    Attributes:
        mutant: `baseline`, `PLACEBO` or the id of a mutant.
        situation: key of the situation.
        seed: seed of the flight.
        status: what the flight shows beside its baseline, or `waiting` for it; of a baseline held, violated or invalid.
        ending: how it ended: landed, struck or timed_out; empty when invalid.
        violated: requirements that it violates.
        infected_at_s: first altered sample [s from take-off]; null: no sample was altered.
        violated_at_s: first safety violation [s from take-off]; null: there is none.
        x: x of the vehicle then [m, world]; null: there is none.
        y: y of the vehicle then [m, world]; null: there is none.
        z: z of the vehicle then [m, world]; null: there is none.
        struck: the body that was struck then; empty for none.
        duration_s: how long it lasted [s].
        digest: SHA-256 over the ground truth.
        held: requirements neither violated nor left open by a flight cut short.
        revealed_by: requirements that it violates and its baseline holds: safety first, each earliest first.
        violation_times_s: for each of `violated`, when.
        violation_bodies: for each of `violated`, the body that was struck at that moment.
        triggered: requirements whose condition came true.
        realised: of a baseline, axes whose value came true.
        carried: samples that crossed the patched seams.
        altered: samples that were changed there.
    """

    mutant: str
    situation: str
    seed: int
    status: FlightStatus
    ending: str
    violated: tuple[str, ...]
    infected_at_s: float | None
    violated_at_s: float | None
    x: float | None
    y: float | None
    z: float | None
    struck: str
    duration_s: float
    digest: str
    held: tuple[str, ...]
    revealed_by: tuple[str, ...]
    violation_times_s: tuple[_Time, ...]
    violation_bodies: tuple[str, ...]
    triggered: tuple[str, ...]
    realised: tuple[str, ...]
    carried: int
    altered: int


_RHO = shape_of(
    float | None,
    "robustness of the requirement, in its own unit; below 0 it is violated; null: the flight does not put it to the "
    "test",
)
EXPORT = Rows(
    "export",
    "1.0",
    _Flight,
    rows="flights",
    about="one row per flight, ordered by mutant, situation and seed",
    named=("rho_", _RHO),
)
"""The columns, of JSON and CSV alike; behind those of `HEAD` stands `rho_REQUIREMENT` for each requirement."""
HEAD = _Flight._fields[:6]


def column_type(name: str) -> ColumnType:
    """The type of a column of the rows.

    >>> column_type("seed").value, column_type("rho_SR1").value
    ('int64', 'float64')
    """
    return type_of(Field(name, (), EXPORT.keys.get(name, _RHO)))


def flight_columns(rows: Sequence[FlightRow], names: Sequence[str]) -> Columns:
    """The rows as typed columns; `names` are those of `columns`."""
    return Columns("Flights", {name: column_type(name) for name in names}, rows)


def export_rows(
    outcomes: Iterable[Outcome], roster: Roster, space: Space, requirements: Sequence[str] = ()
) -> list[FlightRow]:
    """The rows of `each_row` in the order of `ordered`.

    Args:
        outcomes: of a campaign.
        roster: gives the order of the mutants.
        space: gives the order of the situations.
        requirements: names that have a `rho_` column even when no flight was judged by them.
    """
    listed = ordered(outcomes, roster, space)
    return list(each_row(listed, judged_by(listed, requirements)))


def judged_by(outcomes: Iterable[Outcome], requirements: Iterable[str]) -> list[str]:
    """The `requirements`, and others by which flights were judged."""
    return list(dict.fromkeys([*requirements, *(r.requirement for outcome in outcomes for r in outcome.readings)]))


def each_row(listed: Sequence[Outcome], names: Sequence[str]) -> Iterator[FlightRow]:
    """One row for each of these flights, made when it is asked for; `names` are those that have a `rho_` column."""
    return (_named(_write(row), dict(zip(names, rho, strict=True))) for row, rho in _each(listed, names))


def each_line(listed: Sequence[Outcome], names: Sequence[str]) -> Iterator[tuple[Any, ...]]:
    """The values of the same rows, in the order of their columns."""
    at = len(HEAD)
    return ((*row[:at], *rho, *row[at:]) for row, rho in _each(listed, names))


def _each(listed: Sequence[Outcome], names: Sequence[str]) -> Iterator[tuple[_Flight, list[float | None]]]:
    """Each flight, and the robustness of each requirement of `names`."""
    baselines, flown = apart(listed)
    flights = each_flight(baselines, flown)
    clean = {(outcome.situation, outcome.seed) for outcome in baselines}
    for one in listed:
        flight = None if one.mutant == BASELINE else next(flights)
        rho = {reading.requirement: reading.robustness for reading in one.readings}
        yield _row(one, flight, (one.situation, one.seed) in clean), [rho.get(name) for name in names]


def ordered(outcomes: Iterable[Outcome], roster: Roster, space: Space) -> list[Outcome]:
    """Flights by mutant (the baseline first, then PLACEBO, then the catalogue's order), situation, seed."""
    mutant_rank, situation_rank = cache(roster.rank), cache(space.rank)
    return sorted(outcomes, key=lambda o: (mutant_rank(o.mutant), situation_rank(o.situation), o.seed))


def columns(rows: Sequence[FlightRow], requirements: Sequence[str] = ()) -> list[str]:
    """The columns of `rows`; of a campaign without flights those it would have."""
    return list(rows[0] if rows else _named(EXPORT.keys, dict.fromkeys(requirements)))


def _named(row: Mapping[str, Any], rho: Mapping[str, Any]) -> FlightRow:
    """A row with the robustness of each requirement behind the columns of `HEAD`."""
    return {**{name: row[name] for name in HEAD}, **{f"rho_{name}": value for name, value in rho.items()}, **row}


_write = writer_of(_Flight)


def _row(outcome: Outcome, flight: JudgedFlight | None, beside: bool) -> _Flight:
    """A row; `beside` tells whether a baseline of its situation and seed counts."""
    status = flight.status if flight else baseline_status(outcome)
    violated = [reading for reading in outcome.readings if reading.violated_at_s is not None]
    struck = {violation.requirement: violation.struck for violation in outcome.violations}
    first = outcome.first_violation
    t_s, x, y, z = (first.t_s, first.x, first.y, first.z) if first else (None,) * 4
    return _Flight(
        *(outcome.mutant, outcome.situation, outcome.seed),
        status if beside or outcome.invalid else WAITING,
        outcome.ending,
        tuple([reading.requirement for reading in violated]),
        outcome.infected_at_s,
        *(t_s, x, y, z),
        first.struck if first else "",
        *(outcome.duration_s, outcome.digest),
        held=tuple([one.requirement for one in outcome.readings if one.violated_at_s is None and not one.open]),
        revealed_by=(*flight.revealed, *flight.operability_revealed) if flight else (),
        violation_times_s=tuple([reading.violated_at_s or 0.0 for reading in violated]),
        violation_bodies=tuple([struck.get(reading.requirement, "") for reading in violated]),
        triggered=tuple([reading.requirement for reading in outcome.readings if reading.triggered]),
        realised=tuple([axis for axis, came_true in outcome.realised if came_true]),
        carried=outcome.carried,
        altered=outcome.altered,
    )


def to_json(rows: Iterable[FlightRow]) -> str:
    """A JSON list, one flight a line."""
    lines = ",\n".join(map(json_text, rows))
    return f"[\n{lines}\n]\n" if lines else "[]\n"


def to_csv(rows: Iterable[Iterable[Any]], columns: Sequence[str]) -> str:
    """CSV of the values of `columns`; lists joined by `;`, nothing where there is no value.

    A text that would be a formula in a spreadsheet has a `'` before it: see `spreadsheet_text`.
    """
    return csv_text(
        columns, ([cell(one) if isinstance(one, tuple | list | bool) else one for one in row] for row in rows)
    )


Content = str | bytes | Mapping[str, Any] | Sequence[Any]
"""What a format may give: a text, the bytes of a file, or plain JSON values."""
Made = TypeVar("Made", bound=Content)


@dataclass(frozen=True)
class ExportFormat:
    """A format that `scaloft-fi export` writes.

    Attributes:
        name: as `--format` takes it.
        summary: what it is, in half a sentence, for the help.
        make: gives a campaign's content from its dossier.
        text: whether it can be printed; a format that is no text needs `--output`.
        ends: usual ends of the names of its files; by default any.
    """

    name: str
    summary: str
    make: Callable[[Dossier], Content]
    text: bool = True
    ends: tuple[str, ...] = ()

    def content(self, dossier: Dossier) -> bytes:
        """A campaign in this format, as the bytes of a file; a text is made printable, bytes are taken as they are."""
        made = self.make(dossier)
        if isinstance(made, bytes):
            return made
        if isinstance(made, str):
            return printable(made).encode()
        return f"{json_text(made, indent=2, letters=True)}\n".encode()


FORMATS: Registry[ExportFormat] = Registry("export format")
"""Every format, those of plugins too."""


def export_format(
    name: str, summary: str, *, text: bool = True, ends: tuple[str, ...] = ()
) -> Callable[[Callable[[Dossier], Made]], Callable[[Dossier], Made]]:
    """Declare the function below it as an export format.

    Args:
        name: as `--format` takes it.
        summary: what it is, in half a sentence, for the help.
        text: whether it can be printed.
        ends: usual ends of the names of its files, such as `.csv`; by default any.

    Raises:
        ValueError: the name is taken.
    """

    def declare(make: Callable[[Dossier], Made]) -> Callable[[Dossier], Made]:
        FORMATS.declare(name, ExportFormat(name, summary, make, text, ends))
        return make

    return declare


@dataclass(frozen=True)
class Dossier:
    """A campaign and what it was flown with: all that an export format is made of.

    Attributes:
        study, campaign: names.
        version: of scaloft-fi.
        platform: on which the campaign was flown.
        matrix, space, roster, requirements: of the study.
        outcomes: of the campaign that count.
        spending: how the campaign spends alpha.
        sources: per file of the deviation matrix, by its path in the study, its text.
        grid_file: path of the grid's file in the study.
        finds: of the study.
        deterministic: whether flights of its stack repeat their bits.
        searchable: whether `seek` can search it.
        dispositions: the survivors that somebody accepted.
        today: the day by which dispositions expire; None = none does.
        archive: reads the files of the campaign's archive, by their paths.
        invalid: why no score of the campaign is valid, each reason in a sentence; often none.
        within: path of the study in its Git repository, with a / at its end; empty where it is its root, or in none.
    """

    study: str
    campaign: str
    version: str
    platform: Mapping[str, str]
    matrix: Matrix
    space: Space
    roster: Roster
    requirements: tuple[Requirement, ...]
    outcomes: tuple[Outcome, ...]
    spending: Spending
    sources: Mapping[str, str]
    grid_file: str = "sim/situations.yaml"
    finds: KnownFinds = NO_FINDS
    deterministic: bool = True
    searchable: bool = True
    dispositions: tuple[Disposition, ...] = ()
    today: date | None = None
    archive: Callable[[], Mapping[str, bytes]] = dict
    invalid: tuple[str, ...] = ()
    within: str = ""

    @cached_property
    def score(self) -> Score:
        """The campaign's score."""
        return score(self.outcomes, self.roster, self.space, self.spending)

    @cached_property
    def rows(self) -> list[FlightRow]:
        """One row per flight, in the order of mutants, situations and seeds: see `scaloft_fi.verbs.export.dossier`."""
        return list(self.each_row())

    def each_row(self) -> Iterator[FlightRow]:
        """The same, each made when it is asked for."""
        return each_row(ordered(self.outcomes, self.roster, self.space), self._names)

    def each_line(self) -> Iterator[tuple[Any, ...]]:
        """Their values, in the order of `columns`."""
        return each_line(ordered(self.outcomes, self.roster, self.space), self._names)

    @property
    def columns(self) -> list[str]:
        """The columns of the rows."""
        return columns((), self._names)

    @cached_property
    def _names(self) -> list[str]:
        return judged_by(self.outcomes, [requirement.name for requirement in self.requirements])

    @cached_property
    def coverage(self) -> Coverage:
        """Its situation coverage."""
        return coverage(self.outcomes, self.space)

    def of(self, *verdicts: Verdict) -> tuple[MutantScore, ...]:
        """The mutants with one of these verdicts, those of the worst class of severity first.

        Of each credible cell flown it is the default; where no default was flown, every mutant that was.
        """
        members = (mutant for mutant in self.score.faults if mutant.verdict in verdicts)
        return tuple(worst_first(members, lambda mutant: mutant.severity))

    @cached_property
    def accepted(self) -> Mapping[str, Disposition]:
        """The survivors that somebody accepted, of the mutants that the ratios count, by id."""
        known = accepted_survivors(self.score, self.roster, self.dispositions, self.today)
        return {one.mutant: one for one in known}

    @property
    def without_accepted(self) -> Ratio:
        """Mutants detected, of those flown that are no accepted survivors."""
        return score_without(self.score, self.accepted.values())

    def acceptance(self, mutant: MutantScore) -> str:
        """Who accepted a survivor, until when and why; empty where nobody did."""
        return acceptance(known) if (known := self.accepted.get(mutant.subject.id)) else ""

    def verdict(self, mutant: MutantScore) -> str:
        """The verdict on a mutant and what it rests on, in a line."""
        return said_text(verdict(mutant, self.score.lacking), of_tests=self.space.of_tests)

    def why(self, mutant: MutantScore) -> str:
        """What the verdict rests on."""
        return said_text(why(mutant, self.score.lacking), of_tests=self.space.of_tests)

    def next_command(self, mutant: MutantScore) -> str:
        """What to call next for a mutant that is not detected."""
        if self.space.of_tests:
            return f"scaloft-fi kills{in_campaign(self.campaign)} {mutant.subject.id} --show survivors"
        return next_command(mutant, self.score.lacking, self.campaign, self.space, self.finds)

    def steps(self, mutant: MutantScore) -> list[Step]:
        """What to call about a mutant that is not detected, the first to take first."""
        known, cell = in_campaign(self.campaign), self.cell(mutant)
        found = [Step("next", "Next", self.next_command(mutant))]
        if self.space.of_tests:
            return found
        shown = telling(self._judged.get(mutant.subject.id, ()))
        if shown is not None:
            outcome = shown.outcome
            name = shlex.quote(f"{outcome.mutant}/{outcome.situation}/{outcome.seed}")
            found.insert(0, Step("replay", "Fly its most telling flight again", f"scaloft-fi replay {name}{known}"))
        if any(fault.magnitude and Scale.of(fault.magnitude) for fault in cell.faults):
            margin = f"scaloft-fi margin {cell.name}{known}"
            found.append(Step("margin", "Find the smallest magnitude that is killed", margin))
        if self.searchable and next_find(mutant, self.finds) is None:
            seek = f"scaloft-fi seek {shlex.quote(mutant.subject.id)}"
            found.append(Step("seek", "Search for a situation that shows it", seek))
        return found

    @cached_property
    def _judged(self) -> Mapping[str, Sequence[JudgedFlight]]:
        """The flights of each mutant beside their baselines, by its id."""
        return grouped(flights_of(self.outcomes), lambda flight: flight.outcome.mutant)

    def find_told(self, mutant: MutantScore) -> str:
        """`; next: ` and the command, where a search found a situation that shows a mutant; else empty."""
        return f"; next: {self.next_command(mutant)}" if next_find(mutant, self.finds) else ""

    def cell(self, mutant: MutantScore) -> Cell:
        """The cell that a mutant comes from."""
        return self.matrix.cell(cell_of(mutant.subject.id))

    def place(self, mutant: MutantScore) -> tuple[str, int]:
        """File in the study and line of the cell that a mutant comes from."""
        path, _, line = self.cell(mutant).place.rpartition(":")
        path = path.replace("\\", "/")
        return next((name for name in self.sources if path.endswith(name)), path), int(line)

    def words(self, situation: str) -> str:
        """A situation in words: `corner, light`."""
        return ", ".join(self.space.words_of(situation)) if situation in self.space.point else situation


class Step(NamedTuple):
    """A command, and what it does."""

    name: str
    does: str
    command: str


def telling(flights: Iterable[JudgedFlight]) -> JudgedFlight | None:
    """The flight that says most: where the fault got furthest, and of these the one nearest to a safety violation."""

    def rank(flight: JudgedFlight) -> tuple[int, float]:
        measured = [one.robustness for one in flight.outcome.readings if one.kind is Kind.SAFETY]
        return flight.status.stage, -min((rho for rho in measured if rho is not None), default=float("inf"))

    return max(flights, key=rank, default=None)


@export_format("csv", "one row per flight, the columns of json", ends=(".csv", ".txt"))
def csv_rows(dossier: Dossier) -> str:
    """One flight a line, below a line of names."""
    return to_csv(dossier.each_line(), dossier.columns)


@export_format("json", "one row per flight, a list", ends=(".json", ".txt"))
def json_rows(dossier: Dossier) -> str:
    """One flight a line."""
    return to_json(dossier.each_row())


@export_format("parquet", "one row per flight, typed (extra: parquet)", text=False, ends=(".parquet",))
def parquet_rows(dossier: Dossier) -> bytes:
    """The file of a campaign."""
    return parquet(dossier.rows, dossier.columns)


def parquet(rows: Sequence[FlightRow], columns: Sequence[str]) -> bytes:
    """A Parquet file with one row a flight.

    Raises:
        InputError: pyarrow is not installed.
    """
    return parquet_file(flight_columns(rows, columns).arrow())


def parquet_file(table: pyarrow.Table) -> bytes:
    """A Parquet file with the columns of a table."""
    import pyarrow.parquet

    file = io.BytesIO()
    pyarrow.parquet.write_table(table, file, compression="zstd")
    return file.getvalue()


EPOCH = (1980, 1, 1, 0, 0, 0)
"""Date of every file: the earliest that ZIP knows."""
_TYPES = {archive.TEXT: ColumnType.TEXT, archive.WHOLES: ColumnType.WHOLES, archive.NUMBERS: ColumnType.NUMBERS}
"""Types of columns by their names in Arrow."""


@export_format("archive", "all flights with their study, in a new folder or a .zip (extra: parquet)", text=False)
def whole(dossier: Dossier) -> bytes:
    """The ZIP file of a campaign."""
    return zipped(dossier.archive())


def zipped(files: Mapping[str, bytes]) -> bytes:
    """A ZIP file; Parquet is compressed already."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as target:
        for name, content in files.items():
            kind = zipfile.ZIP_STORED if name.endswith(".parquet") else zipfile.ZIP_DEFLATED
            target.writestr(zipfile.ZipInfo(name, EPOCH), content, kind)
    return made.getvalue()


def unzipped(content: bytes) -> dict[str, bytes]:
    """The files of `zipped`, by their paths."""
    with zipfile.ZipFile(io.BytesIO(content)) as source:
        return {name: source.read(name) for name in source.namelist()}


def archive_files(
    study: Study, campaign: str, *, documents: bool = True, kept: Callable[[bytes], array[float]] = track_values
) -> dict[str, bytes]:
    """The files of the archive of a campaign, by their paths: `campaign.json` first.

    Args:
        study: the study, with any of its grids.
        campaign: name of the campaign.
        documents: whether the study is in it.
        kept: the values of `TRACK_COLUMNS` that are kept of a packed track, row by row.

    Raises:
        InputError: there is no campaign, it holds no flight that counts, or pyarrow is not installed.
    """
    with snapshot(study, campaign) as now:
        study = now.study
        files = {archive.OUTCOMES: outcome_file(now.outcomes, study), archive.TRACKS: _tracks(now, kept)}
        platform, notes = now.store.meta(), now.store.notes()
        campaign = flown_in(Path(now.name).name)
    if documents:
        paths = archive.study_files(study.folder)
        files |= {path.relative_to(study.folder).as_posix(): read_bytes(path) for path in paths}
    content = {
        "archive": archive.VERSION,
        "study": study.name,
        "campaign": campaign,
        "platform": platform,
        "notes": notes,
        "requirements": {one.name: one.kind.value for one in study.requirements},
        "axes": list(study.space.axes),
        "files": {name: hashlib.sha256(file).hexdigest() for name, file in files.items()},
    }
    return {archive.MANIFEST: (json.dumps(content, indent=1) + "\n").encode(), **files}


def outcome_file(outcomes: Sequence[Outcome], study: Study) -> bytes:
    """A file of flights: the rows of `export`, and what it leaves out.

    Raises:
        InputError: pyarrow is not installed.
    """
    names = [requirement.name for requirement in study.requirements]
    rows = export_rows(outcomes, study.roster, study.space, names)
    types = {name: column_type(name) for name in columns(rows, names)}
    types |= {name: _TYPES[extra.type] for name, extra in archive.EXTRA.items()}
    listed = ordered(outcomes, study.roster, study.space)
    more = ({name: extra.value(one) for name, extra in archive.EXTRA.items()} for one in listed)
    return parquet_file(Columns("Flights", types, (row | extra for row, extra in zip(rows, more, strict=True))).arrow())


def _tracks(now: Snapshot, kept: Callable[[bytes], array[float]]) -> bytes:
    """The trajectories of the flights, of flights with equal digests one."""
    # flights that begin alike stand beside each other, which makes the file small
    alike = sorted(now.outcomes, key=lambda one: (one.situation, one.seed, one.mutant != BASELINE, one.mutant))
    by_digest = grouped((one for one in alike if one.digest), lambda one: one.digest)
    flown = now.with_tracks([own[0] for own in by_digest.values()])
    return track_file({one.digest: kept(one.track) for one in flown if one.track})


def track_file(tracks: Mapping[str, array[float]]) -> bytes:
    """A file of trajectories.

    Args:
        tracks: by digest of a flight the values of `TRACK_COLUMNS`, row by row, as single floats.

    Raises:
        InputError: pyarrow is not installed.
    """
    pyarrow, width = needed_pyarrow(), len(TRACK_COLUMNS)
    ends = np.cumsum([0, *(len(track) // width for track in tracks.values())])
    samples = np.concatenate([*tracks.values(), np.empty(0, np.float32)]).reshape(-1, width)
    columns = {
        name: pyarrow.ListArray.from_arrays(pyarrow.array(ends, pyarrow.int32()), pyarrow.array(samples[:, number]))
        for number, name in enumerate(TRACK_COLUMNS)
    }
    return parquet_file(pyarrow.table({"digest": pyarrow.array(list(tracks), pyarrow.string()), **columns}))


def dossier(study: Study, campaign: str, today: date | None = None) -> Dossier:
    """The dossier of a campaign.

    Args:
        study: the study, with any of its grids.
        campaign: name of the campaign.
        today: the day by which dispositions expire; by default the system's date.

    Raises:
        InputError: there is no campaign, or it holds no outcome that counts.
    """
    with snapshot(study, campaign) as now:
        study = now.study
        outcomes, platform, spending, invalid = now.outcomes, now.platform, now.spending, now.stale.invalid
    item, cells = study.grid.item, sorted((study.folder / "hazop").rglob("*.yaml"))
    root = study.folder.resolve()
    above = next((one for one in (root, *root.parents) if is_there(one / ".git")), root)
    return Dossier(
        study=study.name,
        campaign=flown_in(Path(now.name).name),
        version=__version__,
        platform=platform,
        matrix=study.matrix,
        space=study.space,
        roster=study.roster,
        requirements=study.requirements,
        outcomes=outcomes,
        spending=spending,
        sources={path.relative_to(study.folder).as_posix(): read_text(path) for path in cells},
        grid_file=item.path.relative_to(study.folder).as_posix() if item else "",
        finds=study.finds,
        deterministic=study.stack.deterministic,
        archive=partial(archive_files, study, campaign),
        searchable=not study.packaged and is_there(study.folder / "sim" / FOLDER / f"{SEARCHED}.yaml"),
        dispositions=study.dispositions,
        today=today or date.today(),  # noqa: DTZ011 - the user's own day
        invalid=invalid,
        within="" if above == root else f"{root.relative_to(above).as_posix()}/",
    )
