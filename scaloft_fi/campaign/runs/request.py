"""A request for a run: what the verb `run` and a script ask for, read into a plan, then flown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.analysis.pool import LEAST
from scaloft_fi.campaign.plan import choose
from scaloft_fi.campaign.plan.plan import Plan, plan_draws
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.runs import choice
from scaloft_fi.campaign.runs.baseline_pool import borrowed
from scaloft_fi.campaign.runs.looks import Look, run_looks
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.run import Report, run
from scaloft_fi.campaign.runs.strategy import OPTION
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import Rulings, rulings_of
from scaloft_fi.sim.grid import ALL

if TYPE_CHECKING:
    from scaloft_fi.study import Study

ONE_SEED = (0,)


@dataclass(frozen=True)
class Request:
    """A request for a run; everything in it decides which flights are flown.

    Attributes:
        mutants: names, ids or patterns of mutants; empty = every cell's default and the controls.
        situations: keys, aliases or patterns of situations; empty = those that `choose` chooses.
        choose: which of the situations, such as `random:8`; None = what the grid says, or all of `situations`.
        choose_seed: seed of the choice.
        seeds: seeds of the mutants' flights; None = seed 0.
        baseline_seeds: seeds of the baseline pool in addition to `seeds`; None = as many as a pool needs.
        baseline_from: name of a campaign that lends its baselines.
        sequential: whether to fly in looks at 1, 3, 5 and 10 seeds.
        shard: (k, n) for the k-th of n parts; `merge` joins them.
        budget_s: wall time after which no flight begins [s]; None = unlimited.
    """

    mutants: tuple[str, ...] = ()
    situations: tuple[str, ...] = ()
    choose: str | None = None
    choose_seed: int = 0
    seeds: tuple[int, ...] | None = None
    baseline_seeds: tuple[int, ...] | None = None
    baseline_from: str | None = None
    sequential: bool = False
    shard: tuple[int, int] | None = None
    budget_s: float | None = None

    @property
    def pool_seeds(self) -> tuple[int, ...] | None:
        """Seeds of the baseline pool; a campaign that lends its baselines makes more of them needless."""
        return () if self.baseline_seeds is None and self.baseline_from else self.baseline_seeds

    @property
    def short_of_pool(self) -> int | None:
        """The number of baseline seeds, where it is too small for a pool; else None."""
        if self.pool_seeds is None or self.baseline_from:
            return None
        flown = len({*self.pool_seeds, *(self.seeds or ONE_SEED)})
        return flown if flown < LEAST else None


@dataclass(frozen=True)
class PlannedRun:
    """A request that was read and checked; nothing is written yet.

    Attributes:
        study: the study, with the grid of the campaign.
        request: what was asked for.
        chosen: the test cases.
        plan: the flights.
        others: baselines of the campaign that lends them.
    """

    study: Study
    request: Request
    chosen: choice.Choice
    plan: Plan
    others: tuple[Outcome, ...]


@dataclass(frozen=True)
class Flown:
    """A run that ended.

    Attributes:
        planned: what was to be flown.
        report: the outcomes.
        looks: the looks of a sequential run.
    """

    planned: PlannedRun
    report: Report
    looks: tuple[Look, ...] = ()

    @cached_property
    def rulings(self) -> Rulings:
        """What each flight of the run shows beside its baseline."""
        return rulings_of(self.report.outcomes)


def planned_run(study: Study, request: Request) -> PlannedRun:
    """Read a request into a plan, and check the study in the situations of the plan.

    Raises:
        InputError: the request names something that the study lacks, contradicts itself or asks for no flight, or parts
            of the study contradict each other.
    """
    how, place = request.choose, OPTION
    if how is None:
        how = ALL if request.situations else study.grid.choose
        place = study.grid.chosen_at or place
    if request.sequential:
        _refuse_with_looks(request, how)
    pool = study.grid.select(request.situations)
    seeds = request.seeds or ONE_SEED
    chosen = choice.choose(how, pool, seeds, request.choose_seed, study.space, place)
    study.check(chosen.situations)
    mutants = choose.mutants(study, request.mutants)
    plan = plan_draws(chosen.draws, mutants, choose.canary(study)).with_pool(request.pool_seeds)
    if request.shard is not None:
        plan = plan.shard(*request.shard)
        if not plan.baselines:
            shard = "{}/{}".format(*request.shard)
            raise InputError(f"--shard={shard!r} has no flights: there are fewer situations and seeds than shards")
    keys = [situation.key for situation in chosen.situations]
    others = borrowed(study, request.baseline_from, keys) if request.baseline_from else ()
    return PlannedRun(study, request, chosen, plan, others)


def fly(planned: PlannedRun, folder: Path, options: RunOptions, *, progress: Progress) -> Flown:
    """Fly what the campaign in `folder` lacks of a planned run; the same call resumes a run that was interrupted.

    Args:
        planned: the run.
        folder: folder of the campaign; a missing folder is created.
        options: options that change no outcome; part and budget are those of the request.
        progress: progress display.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written.
        Interrupted: the user stopped the run.
    """
    study, asked = planned.study, planned.request
    options = replace(options, part=asked.shard is not None, budget_s=asked.budget_s)
    choice.remember(study, folder, planned.chosen)
    if asked.sequential:
        report, looks = run_looks(study, planned.plan, folder, options, others=planned.others, progress=progress)
        return Flown(planned, report, looks)
    return Flown(planned, run(study, planned.plan, folder, options, progress=progress))


def _refuse_with_looks(request: Request, how: str) -> None:
    """Refuse what contradicts a sequential run, whose looks have their own seeds.

    Raises:
        InputError: the message names the first contradiction.
    """
    values: Sequence[tuple[str, object]] = (
        ("seeds", request.seeds and f"{request.seeds[0]}-{request.seeds[-1]}"),
        ("budget", request.budget_s and f"{request.budget_s:g}s"),
        ("shard", request.shard and "{}/{}".format(*request.shard)),
        ("choose", how if how.startswith("draws") else None),  # a draw has one seed, a look several
    )
    for name, value in values:
        if value is not None:
            raise InputError(f"--sequential and --{name}={value} do not go together; leave one out")
