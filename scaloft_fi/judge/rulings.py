"""Rulings: what the flights of a campaign came to, as scores count them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import NamedTuple

from scaloft_fi.judge.flights import apart
from scaloft_fi.judge.outcome import Outcome, Subject, Violation
from scaloft_fi.judge.status import INVALID, Ruling, counting, rule


class Ruled(NamedTuple):
    """A mutant's flight.

    Attributes:
        seed: of the noise.
        ruling: what it came to beside its baseline.
        violations: the first of each requirement that it violates.
    """

    seed: int
    ruling: Ruling
    violations: Sequence[Violation]


Situations = Mapping[str, Sequence[Ruled]]
"""A mutant's flights by situation, in the order of their seeds."""


@dataclass(frozen=True)
class Rulings:
    """The flights of a campaign.

    Attributes:
        baselines: outcomes of the unmutated drone.
        mutants: of each mutant (PLACEBO among them) its flights.
        draws: situations and seeds in which the harness flew a mutant without failing.
    """

    baselines: tuple[Outcome, ...]
    mutants: Mapping[Subject, Situations]
    draws: frozenset[tuple[str, int]]

    @property
    def situations(self) -> set[str]:
        """Keys of those flown."""
        return {outcome.situation for outcome in self.baselines}.union(*self.mutants.values())

    def __bool__(self) -> bool:
        """Whether there is any flight."""
        return bool(self.baselines or self.mutants)


def rulings_of(outcomes: Iterable[Outcome]) -> Rulings:
    """The rulings of outcomes in any order."""
    baselines, flown = apart(outcomes)
    counted = {(baseline.situation, baseline.seed): counting(baseline) for baseline in baselines}
    subjects = {outcome.subject.id: outcome.subject for outcome in flown}
    flights = defaultdict[tuple[str, str], list[Ruled]](list)
    for outcome in flown:
        ruling = rule(outcome, counted.get((outcome.situation, outcome.seed)))
        violations = () if ruling is INVALID else outcome.violations
        flights[outcome.subject.id, outcome.situation].append(Ruled(outcome.seed, ruling, violations))
    mutants = defaultdict[Subject, dict[str, Sequence[Ruled]]](dict)
    for (mutant, situation), ruled in flights.items():
        mutants[subjects[mutant]][situation] = sorted(ruled, key=_seed)
    draws = frozenset((outcome.situation, outcome.seed) for outcome in flown if not outcome.invalid)
    return Rulings(tuple(baselines), dict(mutants), draws)


_seed = itemgetter(0)
