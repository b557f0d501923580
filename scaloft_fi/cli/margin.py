"""`scaloft-fi margin`: the smallest magnitude of a fault that is killed, by bisection."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

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
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.name import cell_of

if TYPE_CHECKING:
    from scaloft_fi.analysis.when import When


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
    "[default: a tenth of the severe end's distance from no fault]",
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

    The whole ladder is flown, then the interval between the severest magnitude that survives and the mildest of which
    most flights violate a requirement is halved, in all situations at once.  A magnitude is killed where its flights
    detect the mutant; else it is only seen, and the table says how many --seeds would decide.  A cell's name means its
    first fault; an id with a magnitude picks a fault by the unit, and a phase by #, a time or an event (NO-depth@3s#5s,
    NO-depth@3s#waypoint).  The flights are ordinary flights of the campaign: nothing is flown twice, and
    `scaloft-fi matrix --margins` shows what was found.
    """
    from scaloft_fi.campaign.processes.start import cores, one_thread_each

    one_thread_each()
    from scaloft_fi.views.tables.table import render
    from scaloft_fi.views.worksheet.margin_record import MARGIN, margin_values, when_values
    from scaloft_fi.views.worksheet.margins import margin_tables
    from scaloft_fi.views.worksheet.when import when_tables

    campaign = campaign_over(grid, campaign)
    if when:
        if situations or seeds != "1" or tolerance is not None:
            raise click.UsageError("--when flies nothing and goes with no --situation, --seeds or --tolerance")
        strikes = _when(mutants, study_folder, campaign, grid, operability=operability)
        answer(
            MARGIN, lambda: when_values(strikes), style, lambda how: render(when_tables(strikes), how), tables_folder
        )
        return
    from scaloft_fi.campaign.plan import choose
    from scaloft_fi.campaign.progress.progress import Progress, Silence
    from scaloft_fi.campaign.runs import choice
    from scaloft_fi.campaign.runs.margin import find, target
    from scaloft_fi.campaign.runs.options import RunOptions
    from scaloft_fi.campaign.store.flown_grid import study_of
    from scaloft_fi.campaign.store.folder import campaign_folder
    from scaloft_fi.judge.requirement import Kind

    study = study_of(study_folder, campaign, grid)
    study.check()
    targets = {one.subject: one for one in (target(study.matrix, text, tolerance) for text in mutants)}
    numbers = choose.seeds(seeds)
    chosen = study.grid.select(situations)
    if not situations:
        chosen = choice.choose(study.grid.choose, chosen, numbers, 0, study.space, study.grid.chosen_at).situations
    by_fault = find(
        study,
        tuple(targets.values()),
        chosen,
        numbers,
        campaign_folder(study, campaign),
        RunOptions(jobs=jobs or cores(), warnings=warnings, same_platform=same_platform, command=typed()),
        kind=Kind.OPERABILITY if operability else Kind.SAFETY,
        progress=Silence if quiet else Progress,
    )
    answer(
        MARGIN,
        lambda: margin_values(by_fault),
        style,
        lambda how: render(margin_tables(by_fault, study.requirements, len(numbers), campaign, study.space.grid), how),
        tables_folder,
    )


def _when(
    mutants: tuple[str, ...],
    study_folder: Path | None,
    campaign: str,
    grid: str | None,
    *,
    operability: bool,
) -> list[When]:
    """What the flights of a campaign say of the phases of these mutants.

    Raises:
        InputError: a mutant has no phases, or the campaign fewer than two of them.
    """
    from scaloft_fi.analysis.when import whens
    from scaloft_fi.judge.requirement import Kind
    from scaloft_fi.mutants.derive import realise, source_of
    from scaloft_fi.study import Study
    from scaloft_fi.views.snapshot import snapshot

    study = Study.open(study_folder, grid)
    asked = {text: realise(study.matrix, text) for text in mutants}
    for text, mutant in asked.items():
        if not source_of(study.matrix, mutant)[0].phases:
            raise InputError(f"mutant {text!r} has no phases: {mutant.cell} strikes all the time, or at one time")
    with snapshot(study, campaign) as now:
        flown = whens(now.outcomes, now.score, Kind.OPERABILITY if operability else Kind.SAFETY)
    found = []
    for text, mutant in asked.items():
        bare = mutant.id.partition("#")[0]
        own = [one for one in flown if one.fault == bare or (text == mutant.cell and cell_of(one.fault) == text)]
        if not own:
            command = f"scaloft-fi run --mutant '{bare}' --mutant '{bare}#*' --campaign {campaign}"
            raise InputError(f"campaign {campaign!r} has fewer than two phases of {bare}; fly them: {command}")
        found += own
    return found
