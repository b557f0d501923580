"""What `seek` answers: the situations that a search found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from scaloft_fi.campaign.plan import parse_mutants
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.seeking.breaks import seek_breaks
from scaloft_fi.campaign.seeking.finds import (
    Allowance,
    Unnamed,
    anew,
    break_saver,
    holding,
    interrupted,
    keep,
    replicate,
    saver,
)
from scaloft_fi.campaign.seeking.proposals import require_optuna
from scaloft_fi.campaign.seeking.seek import seek as seek_mutants
from scaloft_fi.campaign.store.archive import campaign_folder
from scaloft_fi.campaign.store.flown_grid import study_of
from scaloft_fi.defaults import SEARCHED
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import find_study
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.sim.found import FILE, read_finds
from scaloft_fi.sim.grids import grid_names, own_name
from scaloft_fi.sim.load import claims_of
from scaloft_fi.study import Study
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.own_study import check_own
from scaloft_fi.views.runs.breaks import breaks_table
from scaloft_fi.views.runs.seek import replica_table, seek_tables
from scaloft_fi.views.runs.seek_record import SEEK, breaks_values, replica_values, seek_values
from scaloft_fi.views.snapshot import snapshot


@dataclass(frozen=True)
class Search:
    """How a search is made.

    Attributes:
        into: name of the campaign that holds its flights.
        options: options of the run.
        seed: its seed.
        allowance: its budget.
        progress: its progress display.
        anyhow: whether a situation counts where the unmutated drone does not do its mission.
        replicate: whether the finds are flown again instead.
    """

    into: str
    options: RunOptions
    seed: int
    allowance: Allowance
    progress: Progress
    anyhow: bool = False
    replicate: bool = False


def study_to_search(folder: Path | None, grid: str, into: str) -> Study:
    """The study with the grid that is searched.

    Args:
        folder: the study, as for `Study.open`.
        grid: name of the grid.
        into: name of the campaign that holds the flights of the search.

    Raises:
        InputError: there is no such study or grid, or the campaign was flown over another grid.
    """
    if grid == SEARCHED and grid not in (there := grid_names(find_study(folder) / "sim")):
        raise InputError(
            f"the study has no grid {grid!r}, which is searched by default: write sim/grids/{grid}.yaml, as "
            f"docs/seek.md says, or name another grid, such as --grid {there[0]}"
        )
    return study_of(folder, into, grid)


def seek(study: Study, campaign: str, mutants: Sequence[str], search: Search, named: Path | None = None) -> Answer:
    """Find situations that show mutants, or with `baseline` those that break the unmutated drone.

    With `search.replicate` the finds of the study are flown on fresh seeds instead, and those that hold stay.
    What is found is written to the study's `sim/found.yaml`.  The same call resumes a search that was interrupted.

    Args:
        study: the study, with the grid that is searched.
        campaign: name of the campaign whose score says what is not detected, where `mutants` is empty.
        mutants: ids or patterns, or `baseline` alone; by default every default that is not detected and not shown.
        search: how the search is made.
        named: the folder of the study, where the user named it.

    Raises:
        GateError: a gate failed.
        InputError: a mutant stands beside `baseline`, Optuna is missing, nothing is left to seek or to replicate, the
            study cannot be flown, or it is that of the installation.
        Interrupted: the user stopped the search; all outcomes and finds are saved.
    """
    others = [text for text in mutants if text != BASELINE]
    if others and len(others) < len(mutants):
        raise InputError(f"mutant {others[0]!r} must not stand beside {BASELINE!r}; seek each with its own command")
    if search.replicate and len(others) < len(mutants):
        raise InputError(f"--replicate must not stand with {BASELINE!r}: it flies situations that show mutants again")
    if not search.replicate:
        require_optuna()
    check_own(study, named, study.folder / "sim" / FILE)
    study.check()
    if search.replicate:
        return _replicated(study, mutants, search)
    if mutants and not others:
        return _breaks(study, search)
    return _shows(study, campaign, mutants, search)


def _shows(study: Study, campaign: str, mutants: Sequence[str], search: Search) -> Answer:
    """Search for situations that show mutants."""
    folder = study.folder / "sim"
    unnamed = None if mutants else _unnamed(study, campaign, search)
    sought = _named(study, mutants) if unnamed is None else [realise(study.matrix, id_) for id_ in unnamed.mutants]
    report = seek_mutants(
        study,
        sought,
        campaign_folder(study, search.into),
        search.options,
        seed=search.seed,
        allowance=search.allowance,
        progress=search.progress,
        save=saver(folder, study.grid.name),
        unnamed=unnamed,
        anyhow=search.anyhow,
    )
    return Answer(SEEK, lambda: seek_values(report), lambda: seek_tables(report, own_name(folder)))


def _replicated(study: Study, mutants: Sequence[str], search: Search) -> Answer:
    """Fly the finds of the study on fresh seeds, and keep those that hold."""
    folder = study.folder / "sim"
    found = read_finds(folder)
    wanted = {mutant.id for mutant in parse_mutants(study, mutants)} if mutants else None
    finds = found.finds if found else ()
    ask = {find.name: [one for one in find.shows if wanted is None or one in wanted] for find in finds}
    if found is None or not any(ask.values()):
        which = f" of {', '.join(mutants)}" if mutants else ""
        raise InputError(f"{folder / FILE}: there is no find{which} to replicate; `scaloft-fi seek` finds some")
    if found.grid != study.grid.name:
        raise InputError(f"--grid={study.grid.name!r} must be {found.grid!r}, the grid that was searched")
    report = replicate(
        study,
        finds,
        ask,
        campaign_folder(study, search.into),
        search.options,
        progress=search.progress,
        anyhow=search.anyhow,
    )
    keep(folder, found.grid, holding(finds, report.replicas))
    return Answer(SEEK, lambda: replica_values(report), lambda: (replica_table(report),))


def _breaks(study: Study, search: Search) -> Answer:
    """Search for situations that break the unmutated drone."""
    claims = claims_of(study.stack, study.signals)
    report = seek_breaks(
        study,
        campaign_folder(study, search.into),
        search.options,
        seed=search.seed,
        allowance=search.allowance,
        progress=search.progress,
        save=break_saver(study.folder / "sim", study.grid.name),
    )
    return Answer(
        SEEK, lambda: breaks_values(report), lambda: (breaks_table(report, search.into, claims=bool(claims)),)
    )


def _named(study: Study, mutants: Sequence[str]) -> Sequence[Mutant]:
    others = [text for text in mutants if text != PLACEBO.id]
    return [*([PLACEBO] if len(others) < len(mutants) else []), *(parse_mutants(study, others) if others else ())]


def _unnamed(study: Study, campaign: str, search: Search) -> Unnamed:
    """What is sought when nobody names mutants: the same as before where that search was interrupted.

    Raises:
        InputError: nothing is left to seek.
    """
    folder = campaign_folder(study, search.into)
    defaults = study.roster.defaults.values()
    before = interrupted(folder, search.seed, campaign)
    if before is not None and set(before.mutants) <= set(defaults):
        return before
    survivors = _survivors(replace(study, grid_name=None), campaign)
    for sentence in study.finds.warnings:
        search.progress.line(f"warning: {sentence}")
    mutants = [id_ for id_ in defaults if id_ in survivors and not study.finds.of(id_)]
    if not mutants:
        least = f"every default is detected or shown by a situation in sim/{FILE}"
        raise InputError(f"--campaign={campaign!r}: {least}; name the mutants to seek")
    if len(mutants) < len(survivors):
        shown = f"{len(survivors) - len(mutants)} of {len(survivors)} defaults that are not detected"
        search.progress.line(
            f"not sought: {shown}, because situations in sim/{FILE} show them; a mutant that is named is sought again"
        )
    return anew(folder, search.seed, campaign, mutants)


def _survivors(study: Study, campaign: str) -> set[str]:
    """The defaults that the score of a campaign does not call detected."""
    with snapshot(study, campaign) as now:
        detected = {mutant.subject.id for mutant in now.score.mutants if mutant.detected}
    return set(study.roster.defaults.values()) - detected
