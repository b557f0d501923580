"""A sequential run with looks at 1, 3, 5 and 10 seeds; only undecided mutants fly in the next look."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.analysis.detection import LOOKS, Verdict
from scaloft_fi.analysis.score import Score, score
from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.plan.plan import Plan, plan
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.runs.campaign import Campaign, opened
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.run import Report, finish, fly_pool
from scaloft_fi.campaign.runs.spending import remember_seeds, spending_of
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation


@dataclass(frozen=True)
class Look:
    """One look.

    Attributes:
        seeds: number of seeds at this look.
        mutants: number of mutants judged at this look.
        flights: number of their flights that the look planned.
        fates: number of mutants by verdict.
    """

    seeds: int
    mutants: int
    flights: int
    fates: Counter[Verdict]


def run_looks(
    study: Study,
    question: Plan,
    folder: Path,
    options: RunOptions | None = None,
    *,
    others: Sequence[Outcome] = (),
    progress: Progress,
    flyer: Flyer | None = None,
) -> tuple[Report, tuple[Look, ...]]:
    """Fly whole looks: all flights of a look are flown and judged before the next look is planned.

    Undecided mutants fly on in the situations whose pool has a steady pair; all other mutants stop.  The flights follow
    from the outcomes alone: neither the order of arrival nor an interruption changes them.  The store records the looks
    before the first one, so each look spends its share of alpha.

    Args:
        study: the study.
        question: mutants and situations; its seeds are not used.
        folder: folder of the campaign; a missing folder is created.
        options: options of the run; one process when None.
        others: baselines of another campaign, used for the decisions.
        progress: progress display.
        flyer: flies; PyBullet when None.

    Returns:
        The outcomes of all flights; the looks.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written.
        Interrupted: the user stopped the run.
    """
    options = options or RunOptions()
    situations = list(dict.fromkeys(flight.situation for flight in question.baselines))
    mutants = list(dict.fromkeys(f.mutant for f in question.mutants if f.mutant is not None and f.mutant != PLACEBO))
    first = replace(plan(situations, range(LOOKS[0]), mutants, question.canary), pool_seeds=question.pool_seeds)
    with opened(study, folder, options, progress=progress, flyer=flyer, first=first.known) as campaign:
        for seeds in LOOKS:
            remember_seeds(campaign.store, (mutant.id for mutant in mutants), range(seeds))
        campaign.announce_pool(first)
        rounds = _Rounds(campaign, first, others)
        looks = tuple(rounds.looks(mutants, situations))
        report = finish(campaign, first, rounds.flights)
        campaign.raise_if_stopped(f"{len(report.outcomes)} flights are")
        campaign.hold_gates(question, report.outcomes)
        return report, looks


class _Rounds:
    """The looks of a run so far.

    Attributes:
        flights: flights of all looks, with their baselines and the pool.
    """

    def __init__(self, campaign: Campaign, first: Plan, others: Sequence[Outcome]) -> None:
        self._campaign, self._first, self._others = campaign, first, others
        self.flights: list[Flight] = []

    def looks(self, mutants: Sequence[Mutant], situations: Sequence[Situation]) -> list[Look]:
        """Fly look by look until every mutant is decided or the user stops the run."""
        looks: list[Look] = []
        for number, (before, seeds) in enumerate(pairwise((0, *LOOKS)), start=1):
            if not mutants or not situations or self._campaign.stopped():
                break
            self._campaign.reporter.progress.stage = f"look {number} of {len(LOOKS)}"
            due = plan(situations, range(before, seeds), mutants, None)
            self._fly(replace(due, pool_seeds=self._first.pool_seeds))
            scored = self._scored()
            judged = {one.subject.id: one for one in (*scored.mutants, *scored.controls)}
            verdicts = {m: judged[m.id].verdict if m.id in judged else Verdict.NOT_TESTED for m in mutants}
            flights = sum(flight.mutant != PLACEBO for flight in due.mutants)
            looks.append(Look(seeds, len(mutants), flights, Counter(verdicts.values())))
            mutants = [mutant for mutant, verdict in verdicts.items() if verdict is Verdict.UNDECIDED]
            situations = [s for s in situations if scored.pool.steady(s.key, Kind.SAFETY)]
        return looks

    def _fly(self, due: Plan) -> None:
        """Fly a look, and the pool of the situations in which a mutant infects."""
        self._campaign.plan(due.known)
        self._campaign.fly(due.known)
        pool = fly_pool(due, self._campaign)
        self.flights = list(dict.fromkeys((*self.flights, *due.known, *pool)))

    def _scored(self) -> Score:
        study, spending = self._campaign.study, spending_of(self._campaign.study, self._campaign.store)
        return score(self._campaign.outcomes(self.flights), study.roster, study.space, spending, self._others)
