"""`scaloft-fi judge`: judge records of flights with the study's requirements."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from scaloft_fi.campaign.flights.command import JudgedRecord, JudgedRequirement, judged_record, known_of, mapping_of
from scaloft_fi.judge.requirement import Compliance, measured_rho
from scaloft_fi.sim.log import Ending
from scaloft_fi.study import Study
from scaloft_fi.verbs.names import situations
from scaloft_fi.verbs.options import Option, StudyFolder, TableFormat, TablesFolder, answer
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output, listing, number, optional, record, text
from scaloft_fi.views.table import Table, TableCell

HEADERS = ("file", "requirement", "verdict", "robustness", "violated_at_s", "x", "y", "z")
_NEVER = "it is not violated"
JUDGE = Output(
    "judge",
    "1.0",
    "what the study's requirements say of records of flights",
    {
        "readings": listing(
            "what each requirement says of each record",
            record(
                "a requirement on a record",
                {
                    "file": text("path of the record"),
                    "requirement": text("name of the requirement"),
                    "verdict": text("what it says", [compliance.value for compliance in Compliance]),
                    "robustness": optional(
                        number("distance to a violation, in the requirement's own unit; below 0 it is violated"),
                        "the record does not put it to the test",
                    ),
                    "violated_at_s": optional(number("time of the first violation", "s from take-off"), _NEVER),
                    **{axis: optional(number(f"{axis} of the vehicle then", "m, world"), _NEVER) for axis in "xyz"},
                },
            ),
        ),
        "records": listing(
            "the records",
            record(
                "a record",
                {
                    "file": text("path of the record"),
                    "ending": text("how the flight ended", [ending.value for ending in Ending]),
                    "duration_s": number("how long it lasted", "s"),
                },
            ),
        ),
    },
    rows="readings",
)


def judged_table(records: Sequence[JudgedRecord]) -> Table:
    """A row for each record and requirement, and a note for each record."""
    rows = tuple((str(record.path), *_cells(finding)) for record in records for finding in record.findings)
    violated = sum(finding.reading.violated for record in records for finding in record.findings)
    notes = [f"{record.path}: {record.log.ending.sentence} after {record.log.duration_s:.2f} s" for record in records]
    counted = f"{violated} of {len(rows)} readings are violated."
    if any(finding.reading.compliance is Compliance.VACUOUS for record in records for finding in record.findings):
        counted += "  Vacuous: the condition of the requirement never came true."
    return Table("Requirements on records", HEADERS, rows, (*notes, counted))


def _cells(finding: JudgedRequirement) -> tuple[TableCell, ...]:
    reading, rho = finding.reading, measured_rho(finding.reading)
    place = (None, None, None) if finding.place is None else tuple(round(value, 3) for value in finding.place)
    robustness = None if rho is None else round(rho, 6)
    return (reading.requirement, reading.compliance.value, robustness, reading.violated_at_s, *place)


def judged_values(records: Sequence[JudgedRecord]) -> dict[str, Any]:
    """Plain JSON values of the form `JUDGE`."""
    return {
        "readings": [
            dict(zip(HEADERS, (str(record.path), *_cells(finding)), strict=True))
            for record in records
            for finding in record.findings
        ],
        "records": [
            {"file": str(one.path), "ending": one.log.ending.value, "duration_s": one.log.duration_s} for one in records
        ],
    }


def judge(study: Study, files: Sequence[Path], record: Path | None = None, situation: str | None = None) -> Answer:
    """What the study's requirements say of records of flights.

    Args:
        study: the study.
        files: the records.
        record: a file that says where the signals stand in them; by default the study's, else that of `replay`.
        situation: the situation that was flown, which has a route and a time limit; None when it is not known.

    Raises:
        InputError: a file or the mapping cannot be read, or there is no such situation.
    """
    mapping = mapping_of(study, record)
    known = known_of(study, study.grid.situation(situation) if situation else None)
    records = [judged_record(study, path, mapping, known) for path in files]
    return Answer(JUDGE, lambda: judged_values(records), lambda: (judged_table(records),))


@verb(
    "judge",
    examples=(
        ("Judge a record of a flight in a known situation", "scaloft-fi judge flight.csv --situation T0O0W0D0H1"),
        (
            "Judge PX4's logs, with where the signals stand in them",
            "scaloft-fi judge monday.ulg tuesday.ulg --record px4.yaml",
        ),
        ("Let a script read the verdicts", "scaloft-fi judge bag/ --format json"),
    ),
)
def judge_command(
    *,
    files: Annotated[tuple[Path, ...], Option("", "", metavar="FILE...")],
    study_folder: StudyFolder,
    mapping_file: Annotated[
        Path | None,
        Option(
            "Where the signals stand in the records.",
            "--record",
            metavar="MAPPING.yaml",
            otherwise="sim/record.yaml of the study, else the mapping of the records that replay --output writes",
        ),
    ],
    situation: Annotated[
        str | None,
        Option(
            "The situation that was flown, which has a route and a time limit.",
            metavar="KEY",
            complete=situations,
            otherwise="not known",
        ),
    ],
    style: TableFormat,
    tables_folder: TablesFolder,
) -> None:
    """Judge records of flights (.csv, .mcap, .ulg, .bag, .db3, or a folder of rosbag2) with the study's requirements.

    Nothing is flown and no campaign is read.  A violation is a finding: the exit code is 0.
    """
    answer(judge(Study.open(study_folder), files, mapping_file, situation), style, tables_folder)
