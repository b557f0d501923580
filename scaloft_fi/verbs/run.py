"""`scaloft-fi run`: fly baseline and mutants over the grid, then print the score."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import click

from scaloft_fi.defaults import Seeds
from scaloft_fi.errors import InputError
from scaloft_fi.verbs import names, options
from scaloft_fi.verbs.options import Option, SeedOption, SeedsOption, Several, campaign_over, several, typed, verb

MOST_INVALID = 0.1
FlownMutants = Annotated[
    Several,
    Option(
        "A cell's name (its default), an id, or a pattern over names and ids (repeatable).",
        "--mutant",
        metavar="ID|GLOB",
        complete=names.mutants,
        otherwise="every cell's default and the controls",
    ),
]
FlownSituations = Annotated[options.Situations, options.DefaultWords("those of --choose")]
Choose = Annotated[
    str | None,
    Option(
        "Which of these situations: all, first:N (in the grid's order), random:N (distinct), a covering array such "
        "as 2-way, or one of these.  sobol:N: distinct, spread evenly over all axes.  draws:N: with replacement; a "
        "repetition takes the next seed.  draws:P%: until that share was drawn.  random, draws and sobol draw "
        "numbers from ranges.",
        metavar="HOW",
        complete=names.choices,
        otherwise="what the grid says, else all; with --situation all",
    ),
]
ChooseSeed = Annotated[int, SeedOption("Seed of the choice: another seed makes another choice of the same kind.")]
FlownSeeds = Annotated[
    Seeds | None, SeedsOption("Seeds 0..N-1, or A to B inclusive.", complete=names.seeds, otherwise="1")
]
BaselineSeeds = Annotated[
    Seeds | None,
    SeedsOption(
        "Seeds of the baseline pool, flown in each situation where a mutant infects, beside the mutants' own.",
        otherwise="as many as make ten",
    ),
]
Sequential = Annotated[
    bool,
    Option(
        "Fly 1, 3, 5 and 10 seeds in whole rounds.  Only the mutants that a round leaves undecided fly on.  Each "
        "round spends a quarter of alpha."
    ),
]
ExecutorName = Annotated[
    str,
    Option(
        "What runs the flights: processes of this machine, or the workers of a Dask scheduler.",
        metavar="local|dask://HOST:PORT",
        default="local",
    ),
]
ClusterSecurity = Annotated[
    Path | str | None,
    Option(
        "The folder of cert.pem and key.pem that scheduler and workers of --executor=dask://... have too.",
        metavar="DIR",
    ),
]
Shard = Annotated[str | None, Option("Fly the K-th of N parts of the run; `merge` joins them.", metavar="K/N")]
Share = Annotated[bool, Option("Fly every flight whole from take-off; the outcomes are the same.")]
BudgetTime = Annotated[
    str | None,
    Option(
        "Begin no more flights after this wall time (90s, 10m, 2h); the order is random and stratified.", metavar="TIME"
    ),
]
MaxInvalid = Annotated[
    float,
    Option(
        "Exit with 4 when the harness fails over a larger share (0..1) of the flights.",
        metavar="SHARE",
        type=click.FloatRange(0.0, 1.0),
        default=MOST_INVALID,
    ),
]


@verb(
    "run",
    sections={
        "Where": "--study --campaign --grid",
        "Which faults": "--mutant",
        "In which situations": "--situation --choose --choose-seed",
        "How often": "--seeds --baseline-seeds --baseline-from --sequential",
        "How": "--jobs --budget --no-share --same-platform --untrusted",
        "On many machines": "--shard --executor --cluster-security",
        "What fails the run": "--fail-under --fail-under-firm --max-invalid",
        "What is printed": "--all --format --tables --warnings --quiet --help",
    },
)
def run_command(
    *,
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    grid: options.FlownGrid,
    mutants: FlownMutants,
    situations: FlownSituations,
    choose: Choose,
    choose_seed: ChooseSeed,
    seeds: FlownSeeds,
    baseline_seeds: BaselineSeeds,
    baseline_from: options.BaselineFrom,
    sequential: Sequential,
    jobs: options.Jobs,
    executor: ExecutorName,
    cluster_security: ClusterSecurity,
    shard: Shard,
    no_share: Share,
    budget: BudgetTime,
    max_invalid: MaxInvalid,
    same_platform: options.SamePlatform,
    untrusted: options.Untrusted,
    everything: options.Everything,
    style: options.TableFormat,
    tables_folder: options.TablesFolder,
    fail_under: options.FailUnder,
    fail_under_firm: options.FailUnderFirm,
    warnings: options.Warnings,
    quiet: options.Quiet,
) -> int:
    """Fly the baseline, PLACEBO and the mutants in every situation, then print which faults the tests would have shown.

    A flight that the campaign holds is not flown again, so the same command resumes an interrupted run.

    Examples:
        Fly one fault over the whole grid; the same command resumes: `scaloft-fi run --mutant LATE-human`
        Fly every fault of a guideword with three seeds: `scaloft-fi run --mutant 'NO-*' --seeds 3`
        Fly every cell's default within two hours, as in CI: `scaloft-fi run --budget 2h --fail-under-firm 0.25`
    """
    from scaloft_fi.campaign.processes import one_thread_each

    one_thread_each()
    from scaloft_fi.analysis.detection import LEAST
    from scaloft_fi.campaign import plan, progress
    from scaloft_fi.campaign.flights.fly import CAN_FORK
    from scaloft_fi.campaign.runs import gates, request, run
    from scaloft_fi.campaign.store import archive
    from scaloft_fi.campaign.workers import executor_named
    from scaloft_fi.verbs import score

    campaign = campaign_over(grid, campaign)
    asked = request.Request(
        mutants=several(mutants, "mutants"),
        situations=several(situations, "situations"),
        choose=choose,
        choose_seed=choose_seed,
        seeds=plan.parse_seeds(seeds) if seeds else None,
        baseline_seeds=plan.parse_seeds(baseline_seeds, "--baseline-seeds") if baseline_seeds else None,
        baseline_from=baseline_from,
        sequential=sequential,
        shard=plan.parse_shard(shard) if shard is not None else None,
        budget_s=run.budget_s(budget) if budget is not None else None,
    )
    bars = score.bars_of(fail_under, fail_under_firm)
    for option, least in bars.items() if asked.short_of_pool is not None else ():
        raise InputError(
            f"{option}={least:g} needs a baseline pool of at least {LEAST} seeds, and --baseline-seeds="
            f"{baseline_seeds!r} makes {asked.short_of_pool} of them; leave one out"
        )
    run_options = gates.RunOptions(
        executor=executor_named(executor, jobs, None if cluster_security is None else Path(cluster_security)),
        share=CAN_FORK and not no_share,
        max_invalid=max_invalid,
        warnings=warnings,
        same_platform=same_platform,
        command=typed(),
    )
    study = archive.study_of(study_folder, campaign, grid)
    planned = request.planned_run(study, asked)
    options.allow(study, untrusted=untrusted)
    shown = progress.Silence() if quiet else progress.Progress(tally=score.shown_so_far)
    flown = request.fly(planned, archive.campaign_folder(study, campaign), run_options, progress=shown)
    scored = score.scored_run(flown, campaign)
    return score.report(scored, score.RUN, everything=everything, style=style, tables=tables_folder, bars=bars)
