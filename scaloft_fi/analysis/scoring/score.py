"""The mutation score: what the campaign's flights say about each mutant, and about all of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.scoring.detection import Spending, Verdict
from scaloft_fi.analysis.scoring.mutant_score import MutantScore, mutant_score
from scaloft_fi.analysis.scoring.pool import Pool
from scaloft_fi.analysis.scoring.redraw import Redraw, redraw
from scaloft_fi.judge.outcome import PLACEBO, Outcome
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Rulings, rulings_of


@dataclass(frozen=True)
class Score:
    """The campaign's score.  Ratios count the default mutants of credible cells and nothing else.

    Attributes:
        alpha: accepted chance that a fault which does nothing is called detected.
        exercised: cells flown, of all credible cells.
        infected: mutants that changed a sample, of those flown.
        tested: mutants put to the test, of those flown.
        mutation_score: mutants detected by safety requirements, of those flown; 0 of 0 without a pool.
        operability: the same by operability requirements.
        mutants: every mutant flown, ladders too, in the canonical order.
        counted: those of them that the ratios count and of which a flight counts.
        controls: every control flown.
        placebo: PLACEBO, when flown.
        pool: the pairs of the unmutated drone.
        redraw: how often redraws of the unmutated drone are called detected.
        lacking: situations where a mutant, controls left out, infects and the pool has too few flights, in order.
        pooled: whether there is a pool to decide by where mutants infect; without one there are only observations.
        selected: the situations flown that a search found because of verdicts; a score that uses them is selected.
        behaviours: the counted mutants that are detected, those whose flights all equal each other's together.
    """

    alpha: float
    exercised: Ratio
    infected: Ratio
    tested: Ratio
    mutation_score: Ratio
    operability: Ratio
    mutants: tuple[MutantScore, ...]
    counted: tuple[MutantScore, ...]
    controls: tuple[MutantScore, ...]
    placebo: MutantScore | None
    pool: Pool
    redraw: Redraw
    lacking: tuple[str, ...]
    pooled: bool
    selected: tuple[str, ...] = ()
    behaviours: tuple[tuple[str, ...], ...] = ()

    @property
    def firm(self) -> Ratio:
        """Mutants detected whichever seed is left out, of those that `mutation_score` counts."""
        return Ratio(sum(mutant.firm for mutant in self.counted) if self.pooled else 0, self.mutation_score.whole)

    @property
    def without_kill(self) -> tuple[MutantScore, ...]:
        """Counted mutants that are detected, and killed in no situation."""
        return tuple(mutant for mutant in self.counted if mutant.detected and not mutant.kills)

    @property
    def trivial(self) -> tuple[MutantScore, ...]:
        """Counted mutants that are detected where any test would do."""
        return tuple(mutant for mutant in self.counted if mutant.trivial)

    @property
    def without_effect(self) -> tuple[MutantScore, ...]:
        """Counted mutants whose flights all equal the baseline's to the bit."""
        return tuple(mutant for mutant in self.counted if mutant.without_effect)

    @property
    def expected_false(self) -> float:
        """Mutants called detected that do nothing, expected at most: alpha for each one that is put to the test."""
        return self.alpha * self.tested.part

    @property
    def fates(self) -> Counter[Verdict]:
        """Mutants of each verdict; they sum to the mutants."""
        return Counter(mutant.verdict for mutant in self.mutants)


def score(
    outcomes: Iterable[Outcome],
    roster: Roster,
    space: Space,
    spending: Spending | None = None,
    others: Iterable[Outcome] = (),
) -> Score:
    """Score a campaign's outcomes, in whatever order they come.

    Args:
        outcomes: of the campaign.
        roster: which mutants count.
        space: the grid.
        spending: how alpha is spent; by default all of it once.
        others: baselines of another campaign that the pool has too.
    """
    return score_of(rulings_of(outcomes), roster, space, spending, others)


def score_of(
    rulings: Rulings,
    roster: Roster,
    space: Space,
    spending: Spending | None = None,
    others: Iterable[Outcome] = (),
) -> Score:
    """The same of flights that are ruled already."""
    spending = spending or Spending()
    baselines = {(o.situation, o.seed): o for o in (*others, *rulings.baselines) if not o.invalid}
    pool = Pool.of(baselines.values())
    ranked = sorted(rulings.mutants.items(), key=lambda mutant: roster.rank(mutant[0].id))
    scored = [
        replace(mutant_score(subject, situations, space, pool, spending), severity=roster.severity(subject.id))
        for subject, situations in ranked
    ]
    mutants = tuple(m for m in scored if m.subject.id != PLACEBO and not roster.is_control(m.subject))
    counted = tuple(mutant for mutant in mutants if roster.counts(mutant.subject) and mutant.flown)
    infected = {r.situation for m in mutants for r in m.results if r.infected}
    pooled = not infected or bool(infected & pool.flown)
    decided = len(counted) if pooled else 0
    seeds = max((result.flown for mutant in counted for result in mutant.results), default=0)
    return Score(
        alpha=spending.alpha,
        exercised=Ratio(len(counted), len(roster.defaults)),
        infected=Ratio(sum(mutant.infected for mutant in counted), len(counted)),
        tested=Ratio(sum(mutant.tested for mutant in counted), len(counted)),
        mutation_score=Ratio(sum(mutant.detected for mutant in counted), decided),
        operability=Ratio(sum(mutant.operability.detected for mutant in counted), decided),
        mutants=mutants,
        counted=counted,
        controls=tuple(mutant for mutant in scored if roster.is_control(mutant.subject)),
        placebo=next((mutant for mutant in scored if mutant.subject.id == PLACEBO), None),
        pool=pool,
        redraw=redraw(baselines.values(), seeds, spending.alpha),
        lacking=tuple(sorted(infected - pool.flown, key=space.rank)),
        pooled=pooled,
        selected=tuple(sorted(space.selected & rulings.situations, key=space.rank)),
        behaviours=_behaviours(counted, rulings),
    )


def _behaviours(counted: Iterable[MutantScore], rulings: Rulings) -> tuple[tuple[str, ...], ...]:
    """The detected among the counted mutants, grouped by equal flights, in order."""
    groups: dict[str, list[str]] = {}
    for mutant in counted:
        if mutant.detected:
            groups.setdefault(rulings.behaviours[mutant.subject.id], []).append(mutant.subject.id)
    return tuple(map(tuple, groups.values()))
