"""What the flights say: the published kills and pool, and the bugs' own flights by the score's test."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from experiments.bugs.bug import Bug
from experiments.bugs.coupling import Coupling
from experiments.published_outcomes import Row, outcomes
from scaloft_fi.analysis.detection import Detection, Sample, Spending, detect
from scaloft_fi.analysis.pool import Pool
from scaloft_fi.analysis.score import MutantScore, score
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.study import Study

POOL = range(10)
"""Seeds of the baselines that a bug is compared with."""

Samples = Mapping[str, Sample]
"""A bug's flights by situation."""


@dataclass(frozen=True)
class Published:
    """The published campaign.

    Attributes:
        mutants: the score of each default mutant, by cell.
        pool: of ten seeds.
        violated: requirements that each baseline violates, by name of the flight.
        alpha: the study's.
    """

    mutants: Mapping[str, MutantScore]
    pool: Pool
    violated: Mapping[str, frozenset[str]]
    alpha: float

    @property
    def tested(self) -> frozenset[str]:
        """The situations with a steady safety requirement: only they put a fault to the test."""
        return frozenset(place[0] for place in self.pool.pairs if self.pool.steady(place[0], Kind.SAFETY))

    def killing(self, cell: str) -> frozenset[str]:
        """The situations in which the cell's default mutant is killed."""
        return frozenset(kill.situation for kill in self.mutants[cell].kills)


def published(study: Study, rows: Iterable[Row]) -> Published:
    """The published campaign, of the rows of its export."""
    listed = list(rows)
    flown = outcomes(study, listed)
    by_id = {mutant.subject.id: mutant for mutant in score(flown, study.roster, study.space).mutants}
    clean = [outcome for outcome in flown if outcome.mutant == BASELINE]
    return Published(
        {cell: by_id[mutant] for cell, mutant in study.roster.defaults.items() if mutant in by_id},
        Pool.of(outcome for outcome in clean if outcome.seed in POOL),
        {outcome.name: violated_by(outcome) for outcome in clean},
        study.alpha,
    )


def violated_by(flown: Outcome) -> frozenset[str]:
    """The requirements that a flight violates."""
    return frozenset(violation.requirement for violation in flown.violations)


def samples(flights: Iterable[Outcome], reference: Mapping[str, Outcome]) -> Samples:
    """A bug's flights by situation; one differs if its digest is not that of the reference stack's flight.

    Args:
        flights: of the bug.
        reference: flights of the reference stack on the same machine, by name.
    """
    by_situation: dict[str, list[Outcome]] = {}
    for outcome in sorted(flights, key=lambda outcome: outcome.seed):
        by_situation.setdefault(outcome.situation, []).append(outcome)
    return {
        key: Sample(
            key,
            tuple(tuple(violation.requirement for violation in one.violations) for one in own),
            any(one.digest != reference[one.name].digest for one in own),
        )
        for key, own in by_situation.items()
    }


def verdict(bug: str, own: Samples, seen: Published, situations: Collection[str]) -> Detection:
    """The score's verdict on a bug, of its flights in some of the situations."""
    chosen = [sample for key, sample in own.items() if key in situations]
    return detect(bug, chosen, seen.pool, Spending(seen.alpha), Kind.SAFETY)


def coupling(bug: Bug, own: Samples, seen: Published, twins: int) -> Coupling:
    """The bug beside its cell's mutant; `twins` bugs, itself among them, have the same flights."""
    alone = frozenset(key for key in own if verdict(bug.key, own, seen, {key}).detected)
    return Coupling(bug.key, seen.killing(bug.cell), alone, 1.0 / twins)
