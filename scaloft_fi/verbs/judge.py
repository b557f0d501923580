"""`scaloft-fi judge`: judge records of flights with the study's requirements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import click

from scaloft_fi.campaign.flights.command import JudgedRecord, JudgedRequirement, judged_record, known_of, mapping_of
from scaloft_fi.errors import InputError
from scaloft_fi.judge.requirement import Compliance
from scaloft_fi.outside.records import READY, Gap, Loss, Lost, draft, fields_of
from scaloft_fi.registry import grouped
from scaloft_fi.sim.log import Ending
from scaloft_fi.study import Study
from scaloft_fi.verbs.names import situations
from scaloft_fi.verbs.options import Option, verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Format, Table, render

AT_LIMIT_S = 1.0
"""A record that ends this long before the time limit has reached it [s]: its clock may be coarse."""


class RecordVerdict(StrEnum):
    """What a record says about a requirement."""

    VIOLATED = Compliance.VIOLATED.value
    OPEN = Compliance.OPEN.value
    VACUOUS = Compliance.VACUOUS.value
    HELD = Compliance.HELD.value
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class RecordReading:
    """A requirement on a record.

    Attributes:
        file: path of the record.
        requirement: name of the requirement.
        verdict: what it says; unknown: a signal that it needs is older than it may be held.
        robustness: distance to a violation, in the requirement's own unit; below 0 it is violated; null: the record
            does not put it to the test.
        violated_at_s: time of the first violation [s from take-off]; null: it is not violated.
        x: x of the vehicle then [m, world]; null: it is not violated.
        y: y of the vehicle then [m, world]; null: it is not violated.
        z: z of the vehicle then [m, world]; null: it is not violated.
        unknown: the signal that is too old; null: every signal is known.
        between_s: when messages between two samples violate what holds in the samples [s]; null: nowhere.
    """

    file: Path
    requirement: str
    verdict: RecordVerdict
    robustness: float | None
    violated_at_s: float | None
    x: float | None
    y: float | None
    z: float | None
    unknown: str | None
    between_s: float | None

    @classmethod
    def of(cls, file: Path, finding: JudgedRequirement) -> RecordReading:
        """What is told of a reading."""
        one, unknown = finding.reading, finding.unknown or None
        x, y, z = (None, None, None) if finding.place is None else (round(value, 3) for value in finding.place)
        if unknown:
            return cls(file, one.requirement, RecordVerdict.UNKNOWN, *(None,) * 5, unknown, finding.between_s)
        verdict, rho = RecordVerdict(one.compliance.value), rounded(one.robustness)
        return cls(file, one.requirement, verdict, rho, one.violated_at_s, x, y, z, unknown, finding.between_s)


@dataclass(frozen=True)
class FlightRecord:
    """A record.

    Attributes:
        file: path of the record.
        ending: how the flight ended; null: the record ends before it.
        duration_s: how long it lasted [s].
        begins_s: time of the record at which the flight begins [s].
        waits_for: the signal whose first message begins the flight; null: the position does, or the mapping says when.
        gaps: the longest time without a message, of each signal that was read.
    """

    file: Path
    ending: Ending | None
    duration_s: float
    begins_s: float
    waits_for: str | None
    gaps: tuple[Gap, ...]

    @classmethod
    def of(cls, one: JudgedRecord, limit_s: float | None) -> FlightRecord:
        """What is told of a record; `limit_s`: the time limit of its flight, None where nobody knows it [s]."""
        flight = one.flight
        limited = limit_s is not None and flight.log.duration_s > limit_s - AT_LIMIT_S
        ending = flight.log.ending if limited or flight.log.ending is not Ending.TIMED_OUT else None
        waits_for = flight.waits_for or None
        return cls(one.path, ending, flight.log.duration_s, round(flight.begins_s, 6), waits_for, flight.gaps)

    @property
    def notes(self) -> Iterator[str]:
        """How it ends and begins, and which signals have a gap that is too long."""
        ends = self.ending.sentence if self.ending else "the record ends"
        yield f"{self.file}: {ends} after {self.duration_s:.2f} s"
        if self.waits_for:
            begins = f"{self.begins_s:.3f} s of the record"
            yield f"{self.file}: the flight begins at {begins}, when {self.waits_for} is known"
        long = (gap for gap in self.gaps if gap.limit_s is not None and gap.longest_s > gap.limit_s)
        alike = grouped(long, lambda gap: (gap.longest_s, gap.from_s, gap.limit_s))
        for (longest_s, from_s, limit_s), gaps in alike.items():
            silent = f"{', '.join(gap.signal for gap in gaps)}: no message for {longest_s:.2f} s from {from_s:.2f} s on"
            yield f"{self.file}: {silent}; the value is held for {limit_s:g} s (gap_s), then unknown"


@dataclass(frozen=True)
class UnreadRecord:
    """A record that cannot be judged.

    Attributes:
        file: path of the record.
        error: why.
    """

    file: Path
    error: str


@dataclass(frozen=True)
class FieldOfRecord:
    """A column, or a field of messages, of a record.

    Attributes:
        file: path of the record.
        field: the column, or the field after its topic.
        messages: how many messages, or cells, it has.
        rate_hz: messages a second; null: not known.
        first_s: time of the first in the record [s]; null: there is none, or its time is not known.
        last_s: time of the last [s].
    """

    file: Path
    field: str
    messages: int
    rate_hz: float | None
    first_s: float | None
    last_s: float | None


@dataclass(frozen=True)
class RecordLoss:
    """Something that a record lost.

    Attributes:
        file: path of the record.
        kind: cut: nothing is read from then on; drop-out: its writer says that it was too slow; damaged: bytes that are
            no message are skipped; unread: the messages of a topic cannot be read.
        at_s: when [s, time of the record]: of a cut, the last message that is read; null: not known.
        lasts_s: how long [s]; null: to the end, or not known.
        why: how it is known, in words.
    """

    file: Path
    kind: Lost
    at_s: float | None
    lasts_s: float | None
    why: str

    @classmethod
    def of(cls, file: Path, loss: Loss) -> RecordLoss:
        """What is told of a loss."""
        return cls(file, loss.kind, rounded(loss.at_s), rounded(loss.lasts_s), loss.why)


def notes_on(losses: Sequence[RecordLoss], begins_s: float | None = None) -> Iterator[str]:
    """What a record lost, at the times of its flight, which begins at `begins_s` of the record, else of the record."""

    def at(loss: RecordLoss) -> str:
        if loss.at_s is None:
            return ""
        if begins_s is None:
            return f" at {loss.at_s:.2f} s of the record"
        since_s = loss.at_s - begins_s
        return f" at {since_s:.2f} s" if since_s >= 0.0 else f" {-since_s:.2f} s before the flight begins"

    drops = [one for one in losses if one.kind is Lost.DROPOUT]
    if drops:
        longest = sorted(drops, key=lambda one: -(one.lasts_s or 0.0))[:SHOWN_DROPS]
        each = ", ".join(f"{one.lasts_s:.3f} s{at(one)}" for one in longest)
        shown, all_s = "" if len(drops) == len(longest) else "the longest ", sum(one.lasts_s or 0.0 for one in drops)
        yield f"{drops[0].file}: drop-outs of its writer: {len(drops)}, {all_s:.3f} s in all: {shown}{each}"
    for one in losses:
        if one.kind is Lost.CUT:
            last = "its last message is" if one.at_s is not None else "nothing of it can be read"
            yield f"{one.file}: the record is cut; {last}{at(one)}: {one.why}"
        elif one.kind is Lost.DAMAGED:
            yield f"{one.file}: the record is damaged{at(one)}, and read without the damaged part: {one.why}"
        elif one.kind is Lost.UNREAD:
            yield f"{one.file}: messages of a topic cannot be read: {one.why}"


@dataclass(frozen=True)
class JudgedRecords:
    """What the study's requirements say of records of flights, or with --fields what the records hold.

    Attributes:
        readings: what each requirement says of each record.
        records: the records.
        unread: the records that cannot be judged.
        losses: what the records lost.
        fields: what the records hold.
        mappings: a drafted mapping of each record, as YAML.
    """

    readings: tuple[RecordReading, ...]
    records: tuple[FlightRecord, ...]
    unread: tuple[UnreadRecord, ...]
    losses: tuple[RecordLoss, ...] = ()
    fields: tuple[FieldOfRecord, ...] = ()
    mappings: tuple[str, ...] = ()


HEADERS = ("file", "requirement", "verdict", "robustness", "violated_at_s", "x", "y", "z")
JUDGE = Output("judge", "2.0", JudgedRecords, rows="readings")
SHOWN_DROPS = 5
"""Most drop-outs that a note tells."""


def judged_table(told: JudgedRecords) -> Table:
    """A row for each record and requirement, and a note for each record."""
    rows = tuple(
        (str(one.file), one.requirement, one.verdict.value, one.robustness, one.violated_at_s, one.x, one.y, one.z)
        for one in told.readings
    )
    verdicts = [one.verdict for one in told.readings]
    lost = grouped(told.losses, lambda loss: loss.file)
    notes = [note for one in told.records for note in (*one.notes, *notes_on(lost[one.file], one.begins_s))]
    notes += [
        f"{one.file}: {one.requirement} holds in the samples (20 Hz), and messages between them violate it at "
        f"{one.between_s:.2f} s"
        for one in told.readings
        if one.between_s is not None
    ]
    vacuous = "  Vacuous: the condition of the requirement never came true." * (RecordVerdict.VACUOUS in verdicts)
    counted = f"{verdicts.count(RecordVerdict.VIOLATED)} of {len(rows)} readings are violated.{vacuous}"
    return Table("Requirements on records", HEADERS, rows, (*notes, counted))


JudgedFiles = Annotated[
    Path | str | Sequence[Path | str], Option("The records.", "", metavar="FILE...", type=click.Path(path_type=Path))
]
RecordMapping = Annotated[
    Path | str | None,
    Option(
        f"Where the signals stand in the records: a file, or ready: {', '.join(READY)}.",
        metavar="MAPPING.yaml",
        type=click.Path(path_type=Path),
        otherwise="sim/record.yaml of the study, else the mapping of the records that `replay --output` writes",
    ),
]
RecordedIn = Annotated[
    str | None,
    Option(
        "The situation that was flown, which has a route and a time limit.",
        metavar="KEY",
        complete=situations,
        otherwise="not known",
    ),
]


ShownFields = Annotated[
    bool, Option("Judge nothing: show what each record holds, with rates and times, and draft a mapping.")
]
FIELD_HEADERS = ("field", "messages", "rate [Hz]", "first [s]", "last [s]")


def held(study: Study, files: Sequence[Path]) -> Answer:
    """What records hold, and a mapping of the study's signals to begin with.

    Raises:
        InputError: a record cannot be read.
    """
    found = [(path, fields_of(path)) for path in files]
    fields = tuple(
        FieldOfRecord(path, one.name, one.messages, rounded(one.rate_hz), rounded(one.first_s), rounded(one.last_s))
        for path, (own, _) in found
        for one in own
    )
    losses = tuple(RecordLoss.of(path, loss) for path, (_, own) in found for loss in own)
    told = JudgedRecords((), (), (), losses, fields, tuple(draft(own, study.signals) for _, (own, _) in found))

    def table(path: Path) -> Table:
        own = (one for one in fields if one.file == path)
        rows = tuple((one.field, one.messages, one.rate_hz, one.first_s, one.last_s) for one in own)
        notes = notes_on([loss for loss in losses if loss.file == path])
        return Table(f"What {path} holds", FIELD_HEADERS, rows, tuple(notes))

    tables = [table(path) for path, _ in found]

    def text(how: Format) -> str:
        mark, shown = "```" if how is Format.MARKDOWN else "", list[str]()
        for table, own in zip(tables, told.mappings, strict=True):
            shown += [render((table,), how), "A mapping to begin with (--record):", mark, own, mark]
        return "\n".join(shown)

    return Answer(JUDGE, lambda: told, lambda: tables, told=text, rows="fields")


def rounded(value: float | None) -> float | None:
    """A number to show, with six decimals."""
    return None if value is None else round(value, 6)


def judge(
    study: Study,
    files: JudgedFiles,
    *,
    record: RecordMapping = None,
    situation: RecordedIn = None,
    fields: ShownFields = False,
) -> Answer:
    """Judge records of flights (.csv, .ulg, .bin, .tlog, .mcap, .bag, .db3, a folder of rosbag2) with the requirements.

    Nothing is flown and no campaign is read.  A violation is a finding: the exit code is 0.  A record that cannot be
    judged is told after the verdicts of the others: the exit code is 2.

    Examples:
        Judge a record of a flight in a known situation: `scaloft-fi judge flight.csv --situation T0O0W0D0H1`
        Judge PX4's logs: `scaloft-fi judge monday.ulg tuesday.ulg --record px4`
        See what a log holds, and draft a mapping: `scaloft-fi judge flight.ulg --fields`
        Let a script read the verdicts: `scaloft-fi judge bag/ --format json`

    Raises:
        InputError: a file or the mapping cannot be read, or there is no such situation.
    """
    listed = [files] if isinstance(files, Path | str) else list(files)
    if fields:
        return held(study, [Path(path) for path in listed])
    known = known_of(study, study.grid.situation(situation) if situation else None)
    records, unread = list[JudgedRecord](), list[UnreadRecord]()
    for path in map(Path, listed):
        try:
            records.append(judged_record(study, path, mapping_of(study, record, path), known))
        except InputError as error:
            if len(listed) == 1:
                raise
            unread.append(UnreadRecord(path, str(error)))
    told = JudgedRecords(
        tuple(RecordReading.of(one.path, finding) for one in records for finding in one.findings),
        tuple(FlightRecord.of(one, known.limit_s) for one in records),
        tuple(unread),
        tuple(RecordLoss.of(one.path, loss) for one in records for loss in one.flight.losses),
    )
    errors = [one.error for one in unread]
    return Answer(JUDGE, lambda: told, lambda: (judged_table(told),) if records else (), errors=errors)


judge_command = verb("judge")(judge)
