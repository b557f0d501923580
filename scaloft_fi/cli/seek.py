"""`scaloft-fi seek`: find a situation that would have shown a fault."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click
from click.core import ParameterSource

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.finds import told
from scaloft_fi.cli.options import (
    campaign_option,
    format_option,
    quiet_option,
    same_platform_option,
    study_option,
    typed,
    warnings_option,
)
from scaloft_fi.cli.own_study import check_own
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import say
from scaloft_fi.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scaloft_fi.campaign.progress.progress import Progress
    from scaloft_fi.campaign.runs.options import RunOptions
    from scaloft_fi.campaign.runs.seeking.flights import Allowance
    from scaloft_fi.campaign.runs.seeking.sought import Unnamed
    from scaloft_fi.mutants.mutant import Mutant
    from scaloft_fi.study import Study
    from scaloft_fi.views.tables.table import Table

FILE = "sim/found.yaml"


@verb(
    "seek",
    examples=(
        ("Seek situations for all that the last score calls not detected", "scaloft-fi seek --budget 1h"),
        (
            "Seek a situation for one fault, with 2,000 flights at most",
            "scaloft-fi seek LESS-depth --budget 2000flights",
        ),
        ("Seek situations that break the unmutated drone", "scaloft-fi seek baseline --budget 30m"),
    ),
    sections={
        "Where": "--study --campaign --grid --into",
        "How": "--budget --seed --jobs --same-platform",
        "What is printed": "--format --tables --warnings --quiet --help",
    },
)
@click.argument("mutants", nargs=-1, shell_complete=names.sought, metavar="[baseline | ID|GLOB...]")
@study_option
@campaign_option
@click.option(
    "--grid",
    shell_complete=names.grids,
    default="search",
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
    budget: str | None,
    seed: int,
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
    Robustness guides the search.  What it finds is shrunk towards the benign values, confirmed on seeds that the search
    never flew, by the score's own test, and written to sim/found.yaml, which `scaloft-fi run --grid NAME+found` flies
    (NAME: the study's own grid).  An interrupted search resumes with the same command.

    `seek baseline` finds situations that break the unmutated drone itself, each in a way of its own: it violates
    another requirement, strikes something else or elsewhere, or another stage believed what is not true.
    """
    from scaloft_fi.campaign.processes.start import cores, one_thread_each
    from scaloft_fi.campaign.runs.options import RunOptions
    from scaloft_fi.judge.outcome import BASELINE

    others = [text for text in mutants if text != BASELINE]
    if others and len(others) < len(mutants):
        raise InputError(f"mutant {others[0]!r} must not stand beside {BASELINE!r}; seek each with its own command")
    one_thread_each()
    from scaloft_fi.campaign.progress.progress import Progress, Silence
    from scaloft_fi.campaign.runs.seeking.flights import Allowance
    from scaloft_fi.campaign.runs.seeking.proposals import require_optuna
    from scaloft_fi.campaign.store.flown_grid import study_of
    from scaloft_fi.campaign.store.folder import campaign_folder
    from scaloft_fi.mutants.derive import realise
    from scaloft_fi.sim.found import FILE
    from scaloft_fi.views.runs.seek_record import SEEK
    from scaloft_fi.views.tables.table import render

    allowance = Allowance.parse(budget)
    require_optuna()
    _check_there(study_folder, grid)
    study = study_of(study_folder, into or grid, grid)
    check_own(study, study_folder, study.folder / "sim" / FILE)
    study.check()
    folder = campaign_folder(study, into or grid)
    search = _Search(
        study,
        folder,
        RunOptions(jobs=jobs or cores(), warnings=warnings, same_platform=same_platform, command=typed()),
        seed,
        allowance,
        Silence() if quiet else Progress(),
    )
    if mutants and not others:
        found = search.breaks(into or grid)
    else:
        unnamed = None if mutants else _unnamed(study, study_folder, campaign, folder, seed, quiet=quiet)
        sought = _named(study, mutants) if unnamed is None else [realise(study.matrix, id_) for id_ in unnamed.mutants]
        found = search.mutants(sought, unnamed)
    answer(SEEK, lambda: found.values, style, lambda how: render(found.tables, how), tables_folder)


class _Found(NamedTuple):
    """What is printed of a search: as plain JSON values, and as tables."""

    values: Mapping[str, Any]
    tables: Sequence[Table]


def _check_there(folder: Path | None, grid: str) -> None:
    """Refuse the grid that is searched by default where the study has none of its name.

    Raises:
        InputError: as above.
    """
    from scaloft_fi.hazop.folder import find_study
    from scaloft_fi.sim.grids import grid_names

    source = click.get_current_context().get_parameter_source("grid")
    if source is ParameterSource.DEFAULT and grid not in (there := grid_names(find_study(folder) / "sim")):
        raise InputError(
            f"the study has no grid {grid!r}, which is searched by default: write sim/grids/{grid}.yaml, as "
            f"docs/seek.md says, or name another grid, such as --grid {there[0]}"
        )


@dataclass(frozen=True)
class _Search:
    """A search that the user asked for; each method makes one kind of search."""

    study: Study
    folder: Path
    options: RunOptions
    seed: int
    allowance: Allowance
    progress: Progress

    def mutants(self, sought: Sequence[Mutant], unnamed: Unnamed | None) -> _Found:
        """Search for situations that show mutants; `unnamed` if nobody named them."""
        from scaloft_fi.campaign.runs.seeking.finds import saver
        from scaloft_fi.campaign.runs.seeking.seek import seek
        from scaloft_fi.sim.grids import own_name
        from scaloft_fi.views.runs.seek import seek_tables
        from scaloft_fi.views.runs.seek_record import seek_values

        folder = self.study.folder / "sim"
        report = seek(
            self.study,
            sought,
            self.folder,
            self.options,
            seed=self.seed,
            allowance=self.allowance,
            progress=self.progress,
            save=saver(folder, self.study.grid.name),
            unnamed=unnamed,
        )
        return _Found(seek_values(report), seek_tables(report, own_name(folder)))

    def breaks(self, campaign: str) -> _Found:
        """Search for situations that break the unmutated drone; `campaign` holds the flights."""
        from scaloft_fi.campaign.runs.seeking.breaks import seek_breaks
        from scaloft_fi.campaign.runs.seeking.finds import break_saver
        from scaloft_fi.sim.claims import claims_of
        from scaloft_fi.views.runs.breaks import breaks_table
        from scaloft_fi.views.runs.seek_record import breaks_values

        claims = claims_of(self.study.stack, self.study.signals)
        report = seek_breaks(
            self.study,
            self.folder,
            self.options,
            seed=self.seed,
            allowance=self.allowance,
            progress=self.progress,
            save=break_saver(self.study.folder / "sim", self.study.grid.name),
        )
        return _Found(breaks_values(report), (breaks_table(report, campaign, claims=bool(claims)),))


def _named(study: Study, mutants: Sequence[str]) -> Sequence[Mutant]:
    from scaloft_fi.campaign.plan import choose
    from scaloft_fi.mutants.mutant import PLACEBO

    others = [text for text in mutants if text != PLACEBO.id]
    return [*([PLACEBO] if len(others) < len(mutants) else []), *(choose.mutants(study, others) if others else ())]


def _unnamed(study: Study, opened: Path | None, campaign: str, folder: Path, seed: int, *, quiet: bool) -> Unnamed:
    """What is sought when nobody names mutants: the same as before where that search was interrupted.

    Args:
        study: the study, with the grid that is searched.
        opened: the study as the user named it.
        campaign: the campaign whose score says what is not detected.
        folder: folder of the campaign that holds the flights of the search.
        seed: seed of the search.
        quiet: whether nothing is said of what is left out.

    Raises:
        InputError: nothing is left to seek.
    """
    from scaloft_fi.campaign.runs.seeking.sought import anew, interrupted

    defaults = study.roster.defaults.values()
    before = interrupted(folder, seed, campaign)
    if before is not None and set(before.mutants) <= set(defaults):
        return before
    survivors = _survivors(opened, campaign)
    finds = told(study.finds)
    mutants = [id_ for id_ in defaults if id_ in survivors and not finds.of(id_)]
    if not mutants:
        least = f"every default is detected or shown by a situation in {FILE}"
        raise InputError(f"--campaign={campaign!r}: {least}; name the mutants to seek")
    if len(mutants) < len(survivors) and not quiet:
        shown = f"{len(survivors) - len(mutants)} of {len(survivors)} defaults that are not detected"
        say(f"not sought: {shown}, because situations in {FILE} show them; a mutant that is named is sought again")
    return anew(folder, seed, campaign, mutants)


def _survivors(folder: Path | None, campaign: str) -> set[str]:
    """The defaults that the score of a campaign does not call detected."""
    from scaloft_fi.study import Study
    from scaloft_fi.views.snapshot import snapshot

    study = Study.open(folder)
    with snapshot(study, campaign) as now:
        detected = {mutant.subject.id for mutant in now.score.mutants if mutant.detected}
    return set(study.roster.defaults.values()) - detected
