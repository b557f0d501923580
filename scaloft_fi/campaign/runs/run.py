"""A run: fly the flights of the plan that the store lacks, save every outcome when it arrives, check the gates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.pool import LEAST
from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.plan.arrange import alone
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.plan.plan import Plan, canary_flight
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.runs.budget import Budget, fair_order
from scaloft_fi.campaign.runs.campaign import Campaign, opened
from scaloft_fi.campaign.runs.mission_log import mission_log, to_json
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.spending import remember_seeds, spending_of
from scaloft_fi.campaign.store.folder import LOG_NAME
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.campaign.store.platforms import Platforms
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.output import write_whole
from scaloft_fi.study import Study


@dataclass(frozen=True)
class Report:
    """The result of a run.

    Attributes:
        outcomes: all outcomes of the plan.
        flown: number of flights that this run flew.
        left: flights of the plan without an outcome, because the run ended early.
        spending: the campaign's spending of alpha on its mutants.
        mixture: a sentence about the platforms of the outcomes; empty for one platform.
    """

    outcomes: tuple[Outcome, ...]
    flown: int
    left: tuple[Flight, ...] = ()
    spending: Spending = field(default_factory=Spending)
    mixture: str = ""


def run(
    study: Study,
    planned: Plan,
    folder: Path,
    options: RunOptions | None = None,
    *,
    progress: Progress,
    flyer: Flyer | None = None,
) -> Report:
    """Fly the missing flights of `planned`, save their outcomes, write the mission log, check the gates.

    Args:
        study: the study.
        planned: the plan.
        folder: folder of the campaign; a missing folder is created.
        options: options of the run; one process when None.
        progress: progress display.
        flyer: flies; PyBullet when None.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written.
        Interrupted: the user stopped the run.
    """
    options = options or RunOptions()
    budget = Budget(options.budget_s)
    with opened(study, folder, options, progress=progress, flyer=flyer, first=planned.known) as campaign:
        report = _fly(planned, campaign, budget)
        campaign.raise_if_stopped(f"{len(report.outcomes)} flights are")
        campaign.hold_gates(planned, report.outcomes, part=bool(report.left))
    return report


def _fly(planned: Plan, campaign: Campaign, budget: Budget) -> Report:
    """Fly until the plan is complete, the budget is used up or the user stops the run."""
    flights = planned.known
    remember_seeds(campaign.store, (flight.subject.id for flight in planned.mutants), planned.seeds)
    campaign.plan(flights)
    campaign.reporter.progress.most_s = lambda: budget.left_s
    campaign.reporter.progress.stored = lambda: (
        campaign.study,
        current_in(campaign.study, campaign.store),
        spending_of(campaign.study, campaign.store),
    )
    campaign.announce_pool(planned)
    if campaign.options.budget_s is None:
        campaign.fly(flights)
    else:
        campaign.fly(
            flights,
            lambda missing: budget.while_it_lasts(
                fair_order(campaign.study, planned, campaign.unit, missing), campaign.wall_s
            ),
        )
    pool = fly_pool(planned, campaign, budget)
    done = {outcome.name for outcome in campaign.outcomes((*flights, *pool))}
    left = tuple(flight for flight in (*flights, *pool) if flight.name not in done)
    return finish(campaign, planned, (*flights, *pool), left)


def finish(campaign: Campaign, planned: Plan, flights: Sequence[Flight], left: tuple[Flight, ...] = ()) -> Report:
    """Fly the canary, unless flights are `left`, repeat a baseline and write the mission log; what a run ends with."""
    canary = canary_flight(planned, campaign.outcomes(planned.baselines)) if not left else None
    if canary is not None:
        campaign.plan([canary], canary=True)
        campaign.fly([canary])
    campaign.repeat(planned.baselines)
    campaign.reporter.close()
    outcomes = campaign.outcomes((*flights, *([canary] if canary else [])))
    write_log(campaign.study, campaign.folder, current_in(campaign.study, campaign.store))
    mixture = Platforms(campaign.store).mixture(outcomes)
    return Report(outcomes, campaign.flown, left, spending_of(campaign.study, campaign.store), mixture)


def fly_pool(planned: Plan, campaign: Campaign, budget: Budget | None = None) -> tuple[Flight, ...]:
    """Fly the baseline pool in the situations in which a mutant of the plan infects; returns its flights."""
    situations = planned.infected(campaign.outcomes(planned.mutants))
    pool = tuple(flight for situation in situations for flight in planned.pool(situation, LEAST))
    campaign.plan(pool)
    if budget is None or campaign.options.budget_s is None:
        campaign.fly(pool)
    else:
        campaign.fly(pool, lambda missing: budget.while_it_lasts(alone(missing), campaign.wall_s))
    return pool


def write_log(study: Study, folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Write the campaign's mission log.

    Raises:
        InputError: the file cannot be written.
    """
    path = folder / LOG_NAME
    try:
        write_whole(path, to_json(mission_log(outcomes, study.roster, study.space)).encode())
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
