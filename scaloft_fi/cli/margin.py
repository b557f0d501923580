"""`scaloft-fi margin`: the smallest magnitude of a fault that is killed, by bisection."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.options import (
    campaign_option,
    campaign_over,
    format_option,
    grid_option,
    operability_option,
    quiet_option,
    same_platform_option,
    study_option,
    typed,
    warnings_option,
)
from scaloft_fi.cli.verb import verb


@verb(
    "margin",
    examples=(
        ("Find how late a detection may come", "scaloft-fi margin LATE-human"),
        (
            "Search two faults in light only, to a tenth of their unit",
            "scaloft-fi margin LESS-depth LATE-human --situation '*D0*' --tolerance 0.1",
        ),
        ("Show at which times of the flight a fault is killed", "scaloft-fi margin NO-depth --when"),
    ),
    sections={
        "Where": "--study --campaign --grid",
        "What is flown": "--situation --seeds --tolerance --when --operability",
        "How": "--jobs --same-platform",
        "What is printed": "--format --tables --warnings --quiet --help",
    },
)
@click.argument("mutants", nargs=-1, required=True, shell_complete=names.mutants, metavar="CELL|ID...")
@study_option
@campaign_option
@grid_option
@click.option(
    "--situation",
    "situations",
    multiple=True,
    shell_complete=names.situations,
    metavar="KEY|GLOB",
    help="A situation's key or alias, or a pattern (repeatable).  [default: the whole grid]",
)
@click.option(
    "--seeds",
    shell_complete=names.seeds,
    default="1",
    show_default=True,
    metavar="N|A-B",
    help="Seeds 0..N-1, or A to B inclusive.",
)
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="NUMBER",
    help="Bisect until the interval is no wider than this, in the magnitude's own unit.  "
    "[default: a tenth of the strong end's distance from no fault]",
)
@click.option(
    "--when",
    is_flag=True,
    help="Fly nothing; show of the flights of --campaign at which times and events of the flight the fault is killed.",
)
@operability_option
@click.option("--jobs", type=click.IntRange(min=1), metavar="N", help="Worker processes.  [default: the processors]")
@same_platform_option
@format_option
@tables_option
@warnings_option
@quiet_option
def margin_command(
    mutants: tuple[str, ...],
    study_folder: Path | None,
    campaign: str,
    grid: str | None,
    situations: tuple[str, ...],
    seeds: str,
    tolerance: float | None,
    when: bool,
    operability: bool,
    jobs: int | None,
    same_platform: bool,
    style: str,
    tables_folder: Path | None,
    warnings: bool,
    quiet: bool,
) -> None:
    """Find the smallest magnitude of each fault that is killed, situation by situation.

    The whole ladder is flown, then the interval between the strongest magnitude that survives and the mildest of which
    most flights violate a requirement is halved, in all situations at once.  A magnitude is killed where its flights
    detect the mutant; else it is only seen, and the table says how many --seeds would decide.  A cell's name means its
    first fault; an id with a magnitude picks a fault by the unit, and a phase by #, a time or an event (NO-depth@3s#5s,
    NO-depth@3s#waypoint).  The flights are ordinary flights of the campaign: nothing is flown twice, and
    `scaloft-fi matrix --margins` shows what was found.
    """
    from scaloft_fi.campaign.processes import cores, one_thread_each

    one_thread_each()
    campaign = campaign_over(grid, campaign)
    if when:
        if situations or seeds != "1" or tolerance is not None:
            raise click.UsageError("--when flies nothing and goes with no --situation, --seeds or --tolerance")
        from scaloft_fi.study import Study
        from scaloft_fi.views.answers.margin import when as when_killed

        struck = when_killed(Study.open(study_folder, grid), campaign, mutants, operability=operability)
        answer(struck, style, tables_folder)
        return
    from scaloft_fi.campaign.plan import parse_seeds
    from scaloft_fi.campaign.progress import Progress, Silence
    from scaloft_fi.campaign.runs.gates import RunOptions
    from scaloft_fi.campaign.store.flown_grid import study_of
    from scaloft_fi.views.answers.margin import margin

    found = margin(
        study_of(study_folder, campaign, grid),
        campaign,
        mutants,
        RunOptions(jobs=jobs or cores(), warnings=warnings, same_platform=same_platform, command=typed()),
        situations=situations,
        seeds=parse_seeds(seeds),
        tolerance=tolerance,
        operability=operability,
        progress=Silence if quiet else Progress,
    )
    answer(found, style, tables_folder)
