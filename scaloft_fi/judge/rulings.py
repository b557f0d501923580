"""Rulings: what the flights of a campaign came to, and no more of them than scores are made of."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import NamedTuple

from scaloft_fi.judge.flights import apart
from scaloft_fi.judge.outcome import Outcome, Subject, Violation
from scaloft_fi.judge.status import INVALID, Baseline, Ruling, counting


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


Facts = tuple[str, int, int, str, Sequence[Violation]]
"""All that a ruling follows from: what an outcome has as `invalid`, `carried`, `altered`, `digest`, `violations`."""


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
    court = Court(baselines)
    for outcome in flown:
        court.hear(outcome.subject.id, outcome.situation, outcome.seed, facts(outcome))
    return court.rulings({outcome.subject.id: outcome.subject for outcome in flown})


def facts(outcome: Outcome) -> Facts:
    """Those of an outcome."""
    return outcome.invalid, outcome.carried, outcome.altered, outcome.digest, outcome.violations


def ruled(seed: int, said: Facts, baseline: Baseline | None) -> Ruled:
    """A flight beside a baseline that counts; without one it is invalid."""
    invalid, carried, altered, digest, violations = said
    if invalid or baseline is None:
        return Ruled(seed, INVALID, ())
    return Ruled(seed, baseline.rule(carried, altered, digest, violations), violations)


class Court:
    """Hears mutants' flights one by one, each beside its baseline.

    Args:
        baselines: their outcomes.
    """

    def __init__(self, baselines: Iterable[Outcome]) -> None:
        self._outcomes = tuple(baselines)
        self._baselines = {(outcome.situation, outcome.seed): counting(outcome) for outcome in self._outcomes}
        self._draws: set[tuple[str, int]] = set()
        self._ruled = defaultdict[tuple[str, str], list[Ruled]](list)

    def hear(self, mutant: str, situation: str, seed: int, said: Facts) -> None:
        """Take one flight."""
        draw = situation, seed
        if not said[0]:
            self._draws.add(draw)
        self._ruled[mutant, situation].append(ruled(seed, said, self._baselines.get(draw)))

    def rulings(self, subjects: Mapping[str, Subject]) -> Rulings:
        """All that was heard; `subjects` are the mutants by their ids."""
        mutants = defaultdict[Subject, dict[str, Sequence[Ruled]]](dict)
        for (mutant, situation), flights in self._ruled.items():
            flights.sort(key=_seed)
            mutants[subjects[mutant]][situation] = flights
        return Rulings(self._outcomes, dict(mutants), frozenset(self._draws))


_seed = itemgetter(0)
