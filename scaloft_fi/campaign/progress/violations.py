"""Count violations as outcomes arrive.  The mission log lists them."""

from __future__ import annotations

from collections import Counter

from scaloft_fi.judge.outcome import BASELINE, PLACEBO, Outcome, Violation
from scaloft_fi.judge.requirement import Kind

MUTANTS = "mutants"


class Violations:
    """Number of violations of safety and operability requirements, by subject."""

    def __init__(self) -> None:
        self._counts = Counter[str]()

    def add(self, outcome: Outcome) -> list[str]:
        """Count the violations of an outcome; returns a line for each."""
        group = outcome.mutant if outcome.mutant in (BASELINE, PLACEBO) else MUTANTS
        lines = [violation_line(outcome, entry) for entry in outcome.violations if entry.kind is not Kind.REPORTED]
        self._counts[group] += len(lines)
        return lines

    def __str__(self) -> str:
        """`57 (baseline 16, mutants 25, PLACEBO 16)`; empty before the first one."""
        groups = [f"{group} {self._counts[group]}" for group in (BASELINE, MUTANTS, PLACEBO) if self._counts[group]]
        return f"{self._counts.total()} ({', '.join(groups)})" if groups else ""


def violation_line(outcome: Outcome, violation: Violation) -> str:
    """The warning line of a violation."""
    struck = f", struck {violation.struck}" if violation.struck else ""
    place = f"({violation.x:.2f}, {violation.y:.2f}, {violation.z:.2f})"
    return f"{violation.requirement} violated at {violation.t_s:.2f} s at {place} m{struck}: {outcome.name}"
