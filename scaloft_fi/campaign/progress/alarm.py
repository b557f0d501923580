"""Which violations are told as they happen.  All of them are in the mission log."""

from __future__ import annotations

from collections.abc import Iterator

from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.requirement import Kind
from scaloft_fi.results.telling.mission_log import violation_line


class Alarm:
    """Warning lines.

    Args:
        every: whether every violation of every flight is told.  Else the baselines' are, and of each mutant the first
            of each requirement: in a whole campaign a mutant that violates one mostly does so in many situations.

    Attributes:
        untold: how many violations were left to the mission log.
    """

    def __init__(self, *, every: bool) -> None:
        self._every = every
        self._told: set[tuple[str, str]] = set()
        self.untold = 0

    def lines(self, outcome: Outcome) -> Iterator[str]:
        """What to say of an outcome."""
        if outcome.invalid:
            yield f"warning: invalid, not counted: {outcome.name}: {outcome.invalid}"
        for violation in outcome.violations:
            if violation.kind is Kind.REPORTED:
                continue
            kind = outcome.mutant, violation.requirement
            if self._every or outcome.mutant == BASELINE or kind not in self._told:
                self._told.add(kind)
                yield f"warning: {violation_line(outcome, violation)}"
            else:
                self.untold += 1

    def last(self) -> Iterator[str]:
        """What to say at the end."""
        if self.untold:
            yield f"warning: {self.untold} more violations by mutants named above are in the mission log"
