"""Kills so far, for the eye of a person who waits; the score counts by itself."""

from __future__ import annotations

from collections import Counter, defaultdict

from scaloft_fi.results.flights import flight_of
from scaloft_fi.results.outcome import BASELINE, PLACEBO, Outcome
from scaloft_fi.results.roster import Roster
from scaloft_fi.results.status import Status

Draw = tuple[str, int]


class Tally:
    """Killed flights by guideword, each counted once its baseline is home; controls are not counted.

    Args:
        roster: tells the controls.
    """

    def __init__(self, roster: Roster) -> None:
        self._roster = roster
        self._baselines: dict[Draw, Outcome] = {}
        self._waiting: dict[Draw, list[Outcome]] = defaultdict(list)
        self.kills: Counter[str] = Counter()

    def add(self, outcome: Outcome) -> None:
        """Take one outcome, in whatever order they come."""
        draw = outcome.situation, outcome.seed
        if outcome.mutant == BASELINE:
            self._baselines[draw] = outcome
            for waiting in self._waiting.pop(draw, []):
                self._count(waiting, outcome)
        elif outcome.mutant != PLACEBO and not self._roster.is_control(outcome.subject):
            if draw in self._baselines:
                self._count(outcome, self._baselines[draw])
            else:
                self._waiting[draw].append(outcome)

    def _count(self, outcome: Outcome, baseline: Outcome) -> None:
        if flight_of(outcome, baseline).status is Status.KILLED:
            self.kills[outcome.subject.guideword] += 1

    def __str__(self) -> str:
        """`LATE 3, NO 5`; empty before the first kill."""
        return ", ".join(f"{guideword} {count}" for guideword, count in sorted(self.kills.items()))
