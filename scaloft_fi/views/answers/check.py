"""What `check` answers."""

from __future__ import annotations

from scaloft_fi.checks.check import Check
from scaloft_fi.views.checks import CHECK, check_values, checked_table, finding_lines, findings_table
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.tables.table import Format, render


def checked(check: Check) -> Answer:
    """Every finding of a check with its place and remedy, and how much was checked."""

    def told(how: Format) -> str:
        if how is not Format.TABLE:
            return render((findings_table(check), checked_table(check)), how)
        lines, summary = finding_lines(check), render((checked_table(check),), how)
        return f"{lines}\n{summary}" if lines else summary

    return Answer(CHECK, lambda: check_values(check), lambda: (findings_table(check), checked_table(check)), told=told)
