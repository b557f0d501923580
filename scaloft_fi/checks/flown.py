"""Which seams the stack polls: one baseline flight, with the identity on every seam."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scaloft_fi.checks.finding import Finding, Findings, Severity

if TYPE_CHECKING:
    from scaloft_fi.study import Study


def check_seams(study: Study, findings: Findings) -> tuple[int | None, str]:
    """Fly the baseline once in the first situation, and hold every poll against the declaration.

    Returns:
        How many seams the stack polls, and ""; or None, and why nothing was flown.
    """
    from scaloft_fi.campaign.flights.check_stack import polls_of

    if findings.errors:
        return None, "not flown, because the study has errors"
    if study.command is not None:
        return None, "not flown, because a command flies this study"
    situation, place = study.grid.situations[0], str(study.folder / "sim" / "stack.yaml")
    seen = polls_of(study, situation)
    for failure in seen.failures:
        remedy = "mend the stack, or its declaration"
        findings.add(Finding(Severity.ERROR, place, 1, failure, remedy, situation.key))
    if seen.silent:
        what = f"in one baseline flight nothing was sent over {', '.join(seen.silent)}"
        remedy = "a fault there is reached only in situations that bring samples"
        findings.add(Finding(Severity.NOTE, place, 1, what, remedy, situation.key))
    return seen.polled, ""
