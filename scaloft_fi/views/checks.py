"""What the dry check of a study found, as lines and as tables."""

from __future__ import annotations

from scaloft_fi.checks.check import Check
from scaloft_fi.inert import line
from scaloft_fi.views.tables.table import Table

FINDINGS = "Findings"
CHECKED = "Checked"
_COLUMNS = ("severity", "file", "line", "what", "situation", "remedy")


def finding_lines(check: Check) -> str:
    """One line for each finding, as compilers write them, so that an editor jumps to the place."""
    return "".join(f"{line(str(finding))}\n" for finding in check.findings)


def findings_table(check: Check) -> Table:
    """The findings as a table."""
    rows = ((f.severity.value, f.file, f.line, f.what, f.situation, f.remedy) for f in check.findings)
    return Table(FINDINGS, _COLUMNS, tuple(rows))


def checked_table(check: Check) -> Table:
    """What was checked, and how much of it."""
    return Table(CHECKED, ("what", "checked"), check.counts, (verdict(check),))


def verdict(check: Check) -> str:
    """The sum in a sentence."""
    notes = len(check.findings) - check.errors
    errors = f"{check.errors} error{'s' * (check.errors != 1)}" if check.errors else "no errors"
    return f"{check.folder}: {errors}, {notes} note{'s' * (notes != 1)}."
