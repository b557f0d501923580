"""The rulings of a campaign's flights, the input of scores."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from operator import itemgetter
from typing import NamedTuple

from scaloft_fi.judge.flights import apart
from scaloft_fi.judge.outcome import Outcome, Subject, Violation
from scaloft_fi.judge.status import INVALID, Ruling, counting, rule


class Ruled(NamedTuple):
    """A mutant's flight with its ruling.

    Attributes:
        seed: seed of the noise.
        ruling: result of the comparison with the baseline.
        violations: first violation of each violated requirement.
    """

    seed: int
    ruling: Ruling
    violations: Sequence[Violation]


Situations = Mapping[str, Sequence[Ruled]]
"""Flights of a mutant by situation, in the order of their seeds."""


@dataclass(frozen=True)
class Rulings:
    """The flights of a campaign.

    Attributes:
        baselines: outcomes of the drone without a fault.
        mutants: flights by mutant (PLACEBO included).
        draws: situations and seeds with a valid flight of a mutant.
        behaviours: by id of the mutant a digest of all its valid flights; equal ones flew the same everywhere.
    """

    baselines: tuple[Outcome, ...]
    mutants: Mapping[Subject, Situations]
    draws: frozenset[tuple[str, int]]
    behaviours: Mapping[str, str]

    @property
    def situations(self) -> set[str]:
        """Keys of the flown situations."""
        return {outcome.situation for outcome in self.baselines}.union(*self.mutants.values())

    def __bool__(self) -> bool:
        """Whether there is any flight."""
        return bool(self.baselines or self.mutants)


def rulings_of(outcomes: Iterable[Outcome]) -> Rulings:
    """The rulings of outcomes, which may be in any order."""
    baselines, flown = apart(outcomes)
    counted = {(baseline.situation, baseline.seed): counting(baseline) for baseline in baselines}
    subjects = {outcome.subject.id: outcome.subject for outcome in flown}
    flights = defaultdict[tuple[str, str], list[Ruled]](list)
    digests = defaultdict[str, list[str]](list)
    for outcome in flown:
        ruling = rule(outcome, counted.get((outcome.situation, outcome.seed)))
        violations = () if ruling is INVALID else outcome.violations
        flights[outcome.subject.id, outcome.situation].append(Ruled(outcome.seed, ruling, violations))
        if not outcome.invalid:
            digests[outcome.subject.id].append(f"{outcome.situation}/{outcome.seed} {outcome.digest}")
    mutants = defaultdict[Subject, dict[str, Sequence[Ruled]]](dict)
    for (mutant, situation), ruled in flights.items():
        mutants[subjects[mutant]][situation] = sorted(ruled, key=_seed)
    draws = frozenset((outcome.situation, outcome.seed) for outcome in flown if not outcome.invalid)
    behaviours = {mutant: sha256("\n".join(sorted(own)).encode()).hexdigest() for mutant, own in digests.items()}
    return Rulings(tuple(baselines), dict(mutants), draws, behaviours)


_seed = itemgetter(0)
