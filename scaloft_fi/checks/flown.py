"""Which seams the stack polls: one baseline flight, with the identity on every seam."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scaloft_fi.checks.finding import Finding, Findings, Severity

if TYPE_CHECKING:
    from scaloft_fi.study import Study


def check_seams(study: Study, findings: Findings) -> str:
    """Fly the baseline once in the first situation, and hold every poll against the declaration.

    Returns:
        What was seen, in words.
    """
    from scaloft_fi.campaign.flights.check_stack import polls_of

    if findings.errors:
        return "not flown, because the study has errors"
    if study.command is not None:
        return "not flown: a command flies this study"
    situation = study.grid.situations[0]
    seen = polls_of(study, situation)
    place = study.folder / "sim" / "stack.yaml"
    for failure in seen.failures:
        what, remedy = failure, "mend the stack, or its declaration"
        findings.add(Finding(Severity.ERROR, str(place), 1, what, remedy, situation.key))
    if seen.silent:
        what = f"carried no sample over {', '.join(seen.silent)} in one baseline flight"
        remedy = "fly a situation in which they carry something, or faults there are never reached"
        findings.add(Finding(Severity.NOTE, str(place), 1, f"the stack {what}", remedy, situation.key))
    return f"{seen.polled} of {len(study.stack.seams)}, in one baseline flight of {seen.duration_s:.0f} s"
