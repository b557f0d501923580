"""A sequential run: looks at 1, 3, 5 and 10 seeds; only the mutants that a look leaves undecided fly on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.analysis.scoring.detection import LOOKS, Verdict
from scaloft_fi.analysis.scoring.score import Score, score
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
        seeds: how many seeds it looks at.
        mutants: how many were judged at it.
        flights: of theirs that it planned.
        fates: how many of them have each verdict.
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
    """Fly whole rounds: all flights of a look are flown and judged before the next one is planned.

    What is undecided flies on, in the situations whose pool has a steady pair; what is detected, not detected or not
    tested does not.  What is flown follows from the outcomes alone: neither the order in which they arrive nor an
    interruption changes it.  That there are looks is kept before the first, so each spends its share of alpha.

    Args:
        study: what is flown.
        question: which mutants, in which situations; its seeds are not used.
        folder: of the campaign; made when it does not exist.
        options: how; one process when None.
        others: baselines of another campaign, to decide by.
        progress: what a person sees.
        flyer: what flies; PyBullet when None.

    Returns:
        All flights' outcomes; the looks.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written.
        Interrupted: the user stopped it.
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
    """What was asked for so far.

    Attributes:
        flights: of all looks, with their baselines and the pool.
    """

    def __init__(self, campaign: Campaign, first: Plan, others: Sequence[Outcome]) -> None:
        self._campaign, self._first, self._others = campaign, first, others
        self.flights: list[Flight] = []

    def looks(self, mutants: Sequence[Mutant], situations: Sequence[Situation]) -> list[Look]:
        """Look by look, until all is decided or the user stops it."""
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
        """Fly a look, and the pool of the situations where a mutant infects."""
        self._campaign.plan(due.known)
        self._campaign.fly(due.known)
        pool = fly_pool(due, self._campaign)
        self.flights = list(dict.fromkeys((*self.flights, *due.known, *pool)))

    def _scored(self) -> Score:
        study, spending = self._campaign.study, spending_of(self._campaign.study, self._campaign.store)
        return score(self._campaign.outcomes(self.flights), study.roster, study.space, spending, self._others)
