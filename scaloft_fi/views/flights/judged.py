"""What the requirements say of records, as a table."""

from __future__ import annotations

from collections.abc import Sequence

from scaloft_fi.campaign.flights.recorded import Finding, JudgedRecord
from scaloft_fi.judge.requirement import Compliance
from scaloft_fi.judge.robustness import measured_rho
from scaloft_fi.views.tables.table import Table, TableCell

HEADERS = ("file", "requirement", "verdict", "robustness", "violated_at_s", "x", "y", "z")


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
