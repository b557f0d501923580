"""`scaloft-fi run`: fly baseline and mutants over the grid, then print the score."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.errors import InputError
from scaloft_fi.verbs import names
from scaloft_fi.verbs.options import (
    all_option,
    baseline_from_option,
    campaign_option,
    campaign_over,
    fail_under_option,
    format_option,
    grid_option,
    quiet_option,
    same_platform_option,
    study_option,
    tables_option,
    typed,
    warnings_option,
)
from scaloft_fi.verbs.verb import verb


@verb(
    "run",
    examples=(
        ("Fly one fault over the whole grid; the same command resumes", "scaloft-fi run --mutant LATE-human"),
        ("Fly every fault of a guideword with three seeds", "scaloft-fi run --mutant 'NO-*' --seeds 3"),
        ("Fly every cell's default within two hours, as in CI", "scaloft-fi run --budget 2h --fail-under-firm 0.25"),
    ),
    sections={
        "Where": "--study --campaign --grid",
        "Which faults": "--mutant",
        "In which situations": "--situation --choose --choose-seed",
        "How often": "--seeds --baseline-seeds --baseline-from --sequential",
        "How": "--jobs --budget --no-share --same-platform",
        "On many machines": "--shard --executor --cluster-security",
        "What fails the run": "--fail-under --fail-under-firm --max-invalid",
        "What is printed": "--all --format --tables --warnings --quiet --help",
    },
)
@study_option
@campaign_option
@grid_option
@click.option(
    "--mutant",
    "mutants",
    multiple=True,
    shell_complete=names.mutants,
    metavar="ID|GLOB",
    help="A cell's name (its default), an id, or a pattern over names and ids (repeatable).  "
    "[default: every cell's default and the controls]",
)
@click.option(
    "--situation",
    "situations",
    multiple=True,
    shell_complete=names.situations,
    metavar="KEY|GLOB",
    help="A situation's key or alias, or a pattern (repeatable).  [default: those of --choose]",
)
@click.option(
    "--choose",
    "how",
    shell_complete=names.choices,
    metavar="HOW",
    help="Which of these situations: all, random:N (distinct), draws:N (with replacement; a repetition takes the next "
    "seed), draws:P% (until that share was drawn), sobol:N (distinct, spread evenly over all axes), first:N (in the "
    "grid's order), or a covering array such as 2-way.  random, draws and sobol draw numbers from ranges.  "
    "[default: what the grid says, else all; with --situation all]",
)
@click.option(
    "--choose-seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    metavar="S",
    help="Seed of the choice: another seed makes another choice of the same kind.",
)
@click.option(
    "--seeds", shell_complete=names.seeds, metavar="N|A-B", help="Seeds 0..N-1, or A to B inclusive.  [default: 1]"
)
@click.option(
    "--baseline-seeds",
    metavar="N|A-B",
    help="Seeds of the baseline pool, flown in each situation where a mutant infects, beside the mutants' own.  "
    "[default: as many as make ten]",
)
@baseline_from_option
@click.option(
    "--sequential",
    is_flag=True,
    help="Fly 1, 3, 5 and 10 seeds in whole rounds: only the mutants that a round leaves undecided fly on, and each "
    "round spends a quarter of alpha.",
)
@click.option("--jobs", type=click.IntRange(min=1), metavar="N", help="Worker processes.  [default: the processors]")
@click.option(
    "--executor",
    "executor",
    default="local",
    show_default=True,
    metavar="local|dask://HOST:PORT",
    help="What runs the flights: processes of this machine, or the workers of a Dask scheduler.",
)
@click.option(
    "--cluster-security",
    "certificates",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="The folder of cert.pem and key.pem that scheduler and workers of --executor=dask://... have too.",
)
@click.option("--shard", metavar="K/N", help="Fly the K-th of N parts of the run; `merge` joins them.")
@click.option("--no-share", is_flag=True, help="Fly every flight whole from take-off; the outcomes are the same.")
@click.option(
    "--budget",
    metavar="TIME",
    help="Begin no more flights after this wall time (90s, 10m, 2h); the order is random and stratified.",
)
@click.option(
    "--max-invalid",
    type=click.FloatRange(0.0, 1.0),
    default=0.1,
    show_default=True,
    metavar="SHARE",
    help="Exit with 4 when the harness fails over a larger share (0..1) of the flights.",
)
@same_platform_option
@all_option
@format_option
@tables_option
@fail_under_option
@warnings_option
@quiet_option
def run_command(
    study_folder: Path | None,
    campaign: str,
    grid: str | None,
    mutants: tuple[str, ...],
    situations: tuple[str, ...],
    how: str | None,
    choose_seed: int,
    seeds: str | None,
    baseline_seeds: str | None,
    baseline_from: str | None,
    sequential: bool,
    jobs: int | None,
    executor: str,
    certificates: Path | None,
    shard: str | None,
    no_share: bool,
    budget: str | None,
    max_invalid: float,
    same_platform: bool,
    everything: bool,
    style: str,
    tables_folder: Path | None,
    fail_under: float | None,
    fail_under_firm: float | None,
    warnings: bool,
    quiet: bool,
) -> int:
    """Fly the baseline, PLACEBO and the mutants in every situation, then print which faults the tests would have shown.

    A flight that the campaign holds is not flown again, so the same command resumes an interrupted run.
    """
    from scaloft_fi.campaign.processes import one_thread_each

    one_thread_each()
    from scaloft_fi.analysis.pool import LEAST
    from scaloft_fi.campaign.flights.fork import CAN_FORK
    from scaloft_fi.campaign.plan import parse_seeds, parse_shard
    from scaloft_fi.campaign.progress import Progress, Silence
    from scaloft_fi.campaign.runs.gates import RunOptions
    from scaloft_fi.campaign.runs.request import Request, fly, planned_run
    from scaloft_fi.campaign.runs.run import budget_s
    from scaloft_fi.campaign.store.archive import campaign_folder
    from scaloft_fi.campaign.store.flown_grid import study_of
    from scaloft_fi.campaign.workers.cluster import executor_named
    from scaloft_fi.verbs.score import Bars, detected_so_far, report, scored_run
    from scaloft_fi.verbs.score_record import RUN

    campaign = campaign_over(grid, campaign)
    request = Request(
        mutants=mutants,
        situations=situations,
        choose=how,
        choose_seed=choose_seed,
        seeds=parse_seeds(seeds) if seeds else None,
        baseline_seeds=parse_seeds(baseline_seeds, "--baseline-seeds") if baseline_seeds else None,
        baseline_from=baseline_from,
        sequential=sequential,
        shard=parse_shard(shard) if shard is not None else None,
        budget_s=budget_s(budget) if budget is not None else None,
    )
    if (bars := Bars(fail_under, fail_under_firm)) and request.short_of_pool is not None:
        raise InputError(
            f"{bars} needs a baseline pool of at least {LEAST} seeds, and --baseline-seeds="
            f"{baseline_seeds!r} makes {request.short_of_pool} of them; leave one out"
        )
    options = RunOptions(
        executor=executor_named(executor, jobs, certificates),
        share=CAN_FORK and not no_share,
        max_invalid=max_invalid,
        warnings=warnings,
        same_platform=same_platform,
        command=typed(),
    )
    study = study_of(study_folder, campaign, grid)
    planned = planned_run(study, request)
    progress = Silence() if quiet else Progress(tally=detected_so_far)
    flown = fly(planned, campaign_folder(study, campaign), options, progress=progress)
    scored = scored_run(flown, campaign)
    return report(
        scored,
        RUN,
        grouping=None,
        everything=everything,
        style=style,
        tables=tables_folder,
        bars=bars,
    )
