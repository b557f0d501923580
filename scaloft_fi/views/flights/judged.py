"""What the requirements say of records, as a table and as plain JSON values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scaloft_fi.campaign.flights.command import Finding, JudgedRecord
from scaloft_fi.judge.requirement import Compliance, measured_rho
from scaloft_fi.sim.log import Ending
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import listing, number, optional, record, text
from scaloft_fi.views.tables.table import Table, TableCell

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


def _cells(finding: Finding) -> tuple[TableCell, ...]:
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
