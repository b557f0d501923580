"""`scaloft-fi seek`: find a situation that would have shown a fault."""

from __future__ import annotations

from pathlib import Path

import click
from click.core import ParameterSource

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.options import (
    campaign_option,
    format_option,
    quiet_option,
    same_platform_option,
    study_option,
    typed,
    warnings_option,
)
from scaloft_fi.cli.verb import verb
from scaloft_fi.defaults import SEARCHED
from scaloft_fi.errors import InputError


@verb(
    "seek",
    examples=(
        ("Seek situations for all that the last score calls not detected", "scaloft-fi seek --budget 1h"),
        (
            "Seek a situation for one fault, with 2,000 flights at most",
            "scaloft-fi seek LESS-depth --budget 2000flights",
        ),
        ("Seek situations that break the unmutated drone", "scaloft-fi seek baseline --budget 30m"),
        ("Fly what was found on seeds that nothing before used", "scaloft-fi seek --replicate"),
    ),
    sections={
        "Where": "--study --campaign --grid --into",
        "How": "--replicate --budget --seed --any --jobs --same-platform",
        "What is printed": "--format --tables --warnings --quiet --help",
    },
)
@click.argument("mutants", nargs=-1, shell_complete=names.sought, metavar="[baseline | ID|GLOB...]")
@study_option
@campaign_option
@click.option(
    "--grid",
    shell_complete=names.grids,
    default=SEARCHED,
    show_default=True,
    metavar="NAME",
    help="The grid that is searched: a file in the study's sim/grids/, with free axes.",
)
@click.option(
    "--into",
    shell_complete=names.campaigns,
    metavar="NAME",
    help="The campaign that holds the flights of the search.  [default: the name of the grid]",
)
@click.option(
    "--budget",
    metavar="TIME|FLIGHTS",
    help="End after this wall time (90s, 10m, 2h), or after this number of flights (2000flights), stored ones "
    "included.  It decides how far the search goes, not what it finds before.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    metavar="S",
    help="Seed of the search: the same seed and mutants make the same finds.",
)
@click.option(
    "--replicate",
    is_flag=True,
    help="Search nothing: fly the finds in sim/found.yaml (of the named mutants) on seeds that nothing before used; "
    "what does not hold leaves the file.",
)
@click.option(
    "--any",
    "anyhow",
    is_flag=True,
    help="Take situations too where the unmutated drone violates an operability requirement, or does not meet the "
    "value of an axis; the find says so.",
)
@click.option("--jobs", type=click.IntRange(min=1), metavar="N", help="Worker processes.  [default: the processors]")
@same_platform_option
@format_option
@tables_option
@warnings_option
@quiet_option
def seek_command(
    mutants: tuple[str, ...],
    study_folder: Path | None,
    campaign: str,
    grid: str,
    into: str | None,
    replicate: bool,
    budget: str | None,
    seed: int,
    anyhow: bool,
    jobs: int | None,
    same_platform: bool,
    style: str,
    tables_folder: Path | None,
    warnings: bool,
    quiet: bool,
) -> None:
    """Find situations that show mutants: the mutant violates a safety requirement, the unmutated drone does not.

    Sought are the named mutants, else every cell's default that the score of --campaign does not call detected and no
    situation in the study's sim/found.yaml shows.
    PLACEBO stands for the unmutated drone under other seeds, which no search should find anything for.
    A situation counts where the unmutated drone does its mission in nine of ten flights (--any lifts that).
    Robustness guides the search.  What it finds is shrunk towards the benign values, confirmed on seeds that the search
    never flew, by the score's own test, and written to sim/found.yaml, which `scaloft-fi run --grid NAME+found` flies
    (NAME: the study's own grid).  An interrupted search resumes with the same command.  A search picks what it finds by
    its flights; --replicate flies the finds again on other seeds, with one test over all of them.

    `seek baseline` finds situations that break the unmutated drone itself, each in a way of its own: it violates
    another requirement, strikes something else or elsewhere, or another stage believed what is not true.
    """
    from scaloft_fi.campaign.processes import cores, one_thread_each

    one_thread_each()
    from scaloft_fi.campaign.progress import Progress, Silence
    from scaloft_fi.campaign.runs.gates import RunOptions
    from scaloft_fi.campaign.seeking.finds import Allowance
    from scaloft_fi.views.answers.seek import Search, seek, study_to_search

    _refuse_with_replicate(replicate=replicate)
    options = RunOptions(jobs=jobs or cores(), warnings=warnings, same_platform=same_platform, command=typed())
    progress = Silence() if quiet else Progress()
    search = Search(into or grid, options, seed, Allowance.parse(budget), progress, anyhow, replicate)
    study = study_to_search(study_folder, grid, search.into)
    answer(seek(study, campaign, mutants, search, named=study_folder), style, tables_folder)


def _refuse_with_replicate(*, replicate: bool) -> None:
    """Refuse the options of a search where none is made.

    Raises:
        InputError: there is one.
    """
    context = click.get_current_context()
    for name in ("budget", "seed"):
        if replicate and context.get_parameter_source(name) is not ParameterSource.DEFAULT:
            raise InputError(f"--{name}={context.params[name]} must not stand with --replicate, which searches nothing")
