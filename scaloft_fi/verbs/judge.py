"""`scaloft-fi judge`: judge records of flights with the study's requirements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import click

from scaloft_fi.campaign.flights.command import JudgedRequirement, judged_record, known_of, mapping_of
from scaloft_fi.judge.requirement import Compliance, measured_rho
from scaloft_fi.sim.log import Ending
from scaloft_fi.study import Study
from scaloft_fi.verbs.names import situations
from scaloft_fi.verbs.options import Option, verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table


@dataclass(frozen=True)
class RecordReading:
    """A requirement on a record.

    Attributes:
        file: path of the record.
        requirement: name of the requirement.
        verdict: what it says.
        robustness: distance to a violation, in the requirement's own unit; below 0 it is violated; null: the record
            does not put it to the test.
        violated_at_s: time of the first violation [s from take-off]; null: it is not violated.
        x: x of the vehicle then [m, world]; null: it is not violated.
        y: y of the vehicle then [m, world]; null: it is not violated.
        z: z of the vehicle then [m, world]; null: it is not violated.
    """

    file: Path
    requirement: str
    verdict: Compliance
    robustness: float | None
    violated_at_s: float | None
    x: float | None
    y: float | None
    z: float | None

    @classmethod
    def of(cls, file: Path, finding: JudgedRequirement) -> RecordReading:
        """What is told of a reading."""
        one, rho = finding.reading, measured_rho(finding.reading)
        x, y, z = (None, None, None) if finding.place is None else (round(value, 3) for value in finding.place)
        robustness = None if rho is None else round(rho, 6)
        return cls(file, one.requirement, one.compliance, robustness, one.violated_at_s, x, y, z)


@dataclass(frozen=True)
class FlightRecord:
    """A record.

    Attributes:
        file: path of the record.
        ending: how the flight ended.
        duration_s: how long it lasted [s].
    """

    file: Path
    ending: Ending
    duration_s: float


@dataclass(frozen=True)
class JudgedRecords:
    """What the study's requirements say of records of flights.

    Attributes:
        readings: what each requirement says of each record.
        records: the records.
    """

    readings: tuple[RecordReading, ...]
    records: tuple[FlightRecord, ...]


HEADERS = ("file", "requirement", "verdict", "robustness", "violated_at_s", "x", "y", "z")
JUDGE = Output("judge", "1.0", JudgedRecords, rows="readings")


def judged_table(told: JudgedRecords) -> Table:
    """A row for each record and requirement, and a note for each record."""
    rows = tuple(
        (str(one.file), one.requirement, one.verdict.value, one.robustness, one.violated_at_s, one.x, one.y, one.z)
        for one in told.readings
    )
    verdicts = [one.verdict for one in told.readings]
    notes = [f"{one.file}: {one.ending.sentence} after {one.duration_s:.2f} s" for one in told.records]
    counted = f"{verdicts.count(Compliance.VIOLATED)} of {len(rows)} readings are violated."
    if Compliance.VACUOUS in verdicts:
        counted += "  Vacuous: the condition of the requirement never came true."
    return Table("Requirements on records", HEADERS, rows, (*notes, counted))


JudgedFiles = Annotated[
    Path | str | Sequence[Path | str], Option("The records.", "", metavar="FILE...", type=click.Path(path_type=Path))
]
RecordMapping = Annotated[
    Path | str | None,
    Option(
        "Where the signals stand in the records.",
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


def judge(study: Study, files: JudgedFiles, *, record: RecordMapping = None, situation: RecordedIn = None) -> Answer:
    """Judge records of flights (.csv, .mcap, .ulg, .bag, .db3, or a folder of rosbag2) with the study's requirements.

    Nothing is flown and no campaign is read.  A violation is a finding: the exit code is 0.

    Raises:
        InputError: a file or the mapping cannot be read, or there is no such situation.
    """
    mapping = mapping_of(study, None if record is None else Path(record))
    known = known_of(study, study.grid.situation(situation) if situation else None)
    listed = [files] if isinstance(files, Path | str) else files
    records = [judged_record(study, Path(path), mapping, known) for path in listed]
    told = JudgedRecords(
        tuple(RecordReading.of(one.path, finding) for one in records for finding in one.findings),
        tuple(FlightRecord(one.path, one.log.ending, one.log.duration_s) for one in records),
    )
    return Answer(JUDGE, lambda: told, lambda: (judged_table(told),))


judge_command = verb(
    "judge",
    examples=(
        ("Judge a record of a flight in a known situation", "scaloft-fi judge flight.csv --situation T0O0W0D0H1"),
        (
            "Judge PX4's logs, with where the signals stand in them",
            "scaloft-fi judge monday.ulg tuesday.ulg --record px4.yaml",
        ),
        ("Let a script read the verdicts", "scaloft-fi judge bag/ --format json"),
    ),
)(judge)
