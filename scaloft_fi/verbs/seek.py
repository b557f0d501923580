"""`scaloft-fi seek`: find a situation that would have shown a fault."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import click
from click.core import ParameterSource

from scaloft_fi.campaign.plan import parse_mutants
from scaloft_fi.campaign.processes import cores, one_thread_each
from scaloft_fi.campaign.progress import Progress, Silence
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.seeking import finds
from scaloft_fi.campaign.seeking.breaks import seek_breaks
from scaloft_fi.campaign.seeking.seek import require_optuna
from scaloft_fi.campaign.seeking.seek import seek as seek_mutants
from scaloft_fi.campaign.store.archive import campaign_folder, study_of
from scaloft_fi.defaults import SEARCHED
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import find_study
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.sim.grid import FOUND_FILE, Break, grid_names, own_name, read_finds
from scaloft_fi.sim.stacks import claims_of
from scaloft_fi.study import Study
from scaloft_fi.verbs import names, options
from scaloft_fi.verbs.options import CampaignOption, GridOption, Option, SeedOption, Several, check_own, typed, verb
from scaloft_fi.verbs.snapshot import snapshot
from scaloft_fi.verbs.verdict import words
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table, counted


def breaks_table(report: finds.SeekReport, campaign: str, *, claims: bool) -> Table:
    """The breaks; `campaign` holds their flights, `claims` tells whether the stack declares claims."""
    rows = tuple(
        (
            number,
            f"{one.requirement} {one.violated}/{one.flights}",
            one.struck or "nothing",
            place(one),
            belief(one),
            f"{one.alike}/{one.flights}",
        )
        for number, one in enumerate(report.breaks, 1)
    )
    told = [
        f"{number}: {one.situation}: {words(one)}; after {one.t_s:.1f} s: "
        f"`scaloft-fi replay baseline/{one.situation}/{one.flight} --campaign {campaign}`."
        for number, one in enumerate(report.breaks, 1)
    ]
    known = "the stage that was the most wrong in the last second before, and by how much"
    wrong = known if claims else "not known, because the stack declares no claims (`declare_claims` of scaloft_fi.api)"
    again = f"{report.again} flown again to see what the drone believed"
    notes = (
        *told,
        "violates: of the flights with fresh seeds; alike: those that do so in this way.",
        f"wrong belief: {wrong}.",
        f"The drone broke in {report.broken} of {report.situations} situations.",
        f"{_flights(report)}, {again}; {_ended(report)}.",
    )
    headers = ("", "violates", "strikes", "where", "wrong belief", "alike")
    return Table(f"The unmutated drone breaks in {counted(len(rows), 'way')}", headers, rows, notes)


def place(one: Break) -> str:
    """Where the drone is: the leg of the route, and the nearer of its ends unless a body is struck."""
    return one.leg if one.near == one.struck else f"near {one.near}, {one.leg}"


def belief(one: Break) -> str:
    """The belief that was the most wrong, and by how much."""
    return f"{one.belief}, {one.error:.2f} {one.unit}" if one.belief else "none"


def seek_tables(report: finds.SeekReport, own: str) -> tuple[Table, Table]:
    """The finds, and the mutants without one; `own` is the name of the study's own grid."""
    rows = tuple(
        (
            mutant,
            evidence.requirement + f", strikes {evidence.struck}" * bool(evidence.struck),
            f"{evidence.violated}/{evidence.flights}",
            f"{evidence.p:.2g}",
            f"{evidence.held}/{evidence.baselines}",
            f"{evidence.margin:.2g}",
            f"{evidence.mission}/{evidence.baselines}",
            len(find.shows) - 1,
            find.name,
        )
        for find in report.finds
        for mutant, evidence in find.shows.items()
    )
    headers = ("mutant", "violates", "flights", "p", "baseline", "margin", "mission", "others", "find")
    written = any(find.mutant != PLACEBO.id for find in report.finds)
    notes = (
        *(f"{find.name}: {find.situation}: {words(find)}." for find in report.finds),
        "Confirmed on seeds that the search never flew.  others: more sought mutants that the situation shows.",
        spending(report),
        "baseline: flights that hold the requirement by more than their spread; margin: what nine in ten reach.",
        "mission: baselines that hold every operability requirement and meet the value of every axis.",
        *([f"`scaloft-fi run --grid {own}+found` flies the situations."] if written else []),
    )
    left = [one for one in report.sought if not one.shown_in]
    lacking = tuple((one.mutant, one.effort.situations, why_not(one)) for one in left)
    shown = len(report.sought) - len(left)
    mission = "" if report.anyhow else " and does its mission"
    room = f"situations: flown with one seed, where the unmutated drone holds a safety requirement with room{mission}."
    ends = room, f"{_flights(report)}; {_ended(report)}."
    return (
        Table(f"Found: {shown} of {len(report.sought)} mutants, {len(report.finds)} situations", headers, rows, notes),
        Table(f"Not found: {len(left)}", ("mutant", "situations", "why"), lacking, ends),
    )


def _flights(report: finds.SeekReport) -> str:
    return f"{report.used} flights in all, {report.flown} of them flown now"


def _ended(report: finds.SeekReport) -> str:
    unflown = f" before its first flights; `--budget {report.needed}flights` is the least" if report.needed else ""
    return f"the budget ended the search{unflown * (not report.used)}" if report.spent else "the search came to its end"


def replica_table(report: finds.SeekReport) -> Table:
    """The pairs of find and mutant that were flown again, and which of them hold."""
    rows = tuple(
        (
            one.mutant,
            one.requirement,
            f"{one.again.violated}/{one.again.flights}",
            f"{one.again.p:.2g}",
            f"{one.again.held}/{one.again.baselines}",
            f"{one.again.mission}/{one.again.baselines}",
            {True: "yes", False: "no", None: "undecided"}[one.holds],
            one.find,
        )
        for one in report.replicas
    )
    held, first = sum(bool(one.holds) for one in report.replicas), report.first or 0
    does, again = {False: "left", None: "stays in"}, "; the same command flies it again"
    notes = (
        *(
            f"{one.find}: {one.mutant} {does[one.holds]} sim/{FOUND_FILE}: {one.why}{again * (one.holds is None)}."
            for one in report.replicas
            if not one.holds
        ),
        f"Flown on the seeds {first}, {first + 1}, ..., which no other replication that the study knows used.",
        f"p: by the exact test, adjusted by Holm over all pairs here; a pair holds at alpha={report.alpha:g} or less.",
        "baseline: flights that hold the requirement by more than their spread; mission: flights that do the mission.",
        f"{_flights(report)}.",
    )
    headers = ("mutant", "violates", "flights", "p", "baseline", "mission", "holds", "find")
    return Table(f"Replicated: {held} of {len(rows)} pairs of find and mutant hold", headers, rows, notes)


def spending(report: finds.SeekReport) -> str:
    """How many candidates a search tested or began to test, and what they spent of alpha."""
    tested = [one for one in report.sought if one.spent]
    if not tested:
        return f"Tested on fresh seeds: no candidate; nothing of alpha={report.alpha:g} is spent."
    candidates, spent = sum(one.candidates for one in tested), [one.spent for one in tested]
    begun = f" (and {left} not flown on all of them)" if (left := sum(one.untested for one in tested)) else ""
    return (
        f"Tested on fresh seeds: {counted(candidates, 'candidate')}{begun} of {counted(len(tested), 'mutant')}, at "
        f"alpha / 2, / 4, ... for the first, second, ... of a mutant: at most {max(spent):g} of alpha="
        f"{report.alpha:g} for one mutant, {sum(spent):g} summed over all."
    )


def why_not(sought: finds.Sought) -> str:
    """Why nothing was found for a mutant: the stage at which the fault stopped, and how near it came."""
    effort = sought.effort
    ends = {"that fresh seeds did not confirm": sought.candidates, "not flown on all fresh seeds": sought.untested}
    if told := [f"{counted(number, 'candidate')} {end}" for end, number in ends.items() if number]:
        return ", ".join(told)
    if not effort.situations:
        return "not flown"
    if not effort.reached:
        return "its seam carried no sample"
    if not effort.infected:
        return "it changed no sample"
    if not effort.diverged:
        return f"it changed samples in {effort.infected}, and the drone flew the same to the bit"
    if not effort.requirement:
        return f"no safety requirement is held with room in the {effort.infected} where it changed samples"
    if effort.showed:
        return f"it violated {effort.requirement} in {effort.showed}, not with every seed of the search"
    return f"it kept {effort.nearest:.0%} of the robustness of {effort.requirement} in {effort.situation}"


SEEK = Output("seek", "1.3", finds.SeekReport, rows="finds")


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
    allowance: finds.Allowance
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
            f"the site's page Finding missing tests says, or name another grid, such as --grid {there[0]}"
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
    baseline = len(others) < len(mutants)
    if others and baseline:
        raise InputError(f"mutant {others[0]!r} must not stand beside {BASELINE!r}; seek each with its own command")
    if search.replicate and baseline:
        raise InputError(f"--replicate must not stand with {BASELINE!r}: it flies situations that show mutants again")
    if not search.replicate:
        require_optuna()
    check_own(study, named, study.folder / "sim" / FOUND_FILE)
    study.check()
    if search.replicate:
        return _replicated(study, mutants, search)
    return _breaks(study, search) if baseline else _shows(study, campaign, mutants, search)


def _shows(study: Study, campaign: str, mutants: Sequence[str], search: Search) -> Answer:
    """Search for situations that show mutants."""
    folder = study.folder / "sim"
    unnamed = None if mutants else _unnamed(study, campaign, search)
    others = [text for text in mutants if text != PLACEBO.id]
    sought = [PLACEBO] if len(others) < len(mutants) else []
    sought += parse_mutants(study, others) if others else ()
    sought += [realise(study.matrix, id_) for id_ in unnamed.mutants] if unnamed else ()
    report = seek_mutants(
        study,
        sought,
        campaign_folder(study, search.into),
        search.options,
        seed=search.seed,
        allowance=search.allowance,
        progress=search.progress,
        save=finds.saver(folder, study.grid.name),
        unnamed=unnamed,
        anyhow=search.anyhow,
    )
    return Answer(SEEK, lambda: report, lambda: seek_tables(report, own_name(folder)))


def _replicated(study: Study, mutants: Sequence[str], search: Search) -> Answer:
    """Fly the finds of the study on fresh seeds, and keep those that hold."""
    folder = study.folder / "sim"
    found = read_finds(folder)
    wanted = {mutant.id for mutant in parse_mutants(study, mutants)} if mutants else None
    known = found.finds if found else ()
    ask = {find.name: [one for one in find.shows if wanted is None or one in wanted] for find in known}
    if found is None or not any(ask.values()):
        which = f" of {', '.join(mutants)}" if mutants else ""
        raise InputError(f"{folder / FOUND_FILE}: there is no find{which} to replicate; `scaloft-fi seek` finds some")
    if found.grid != study.grid.name:
        raise InputError(f"--grid={study.grid.name!r} must be {found.grid!r}, the grid that was searched")
    into = campaign_folder(study, search.into)
    report = finds.replicate(study, known, ask, into, search.options, progress=search.progress, anyhow=search.anyhow)
    finds.keep(folder, found.grid, finds.holding(known, report.replicas))
    return Answer(SEEK, lambda: report, lambda: (replica_table(report),))


def _breaks(study: Study, search: Search) -> Answer:
    """Search for situations that break the unmutated drone."""
    claims = claims_of(study.stack, study.signals)
    folder, save = campaign_folder(study, search.into), finds.break_saver(study.folder / "sim", study.grid.name)
    report = seek_breaks(
        study, folder, search.options, seed=search.seed, allowance=search.allowance, progress=search.progress, save=save
    )
    return Answer(SEEK, lambda: report, lambda: (breaks_table(report, search.into, claims=bool(claims)),))


def _unnamed(study: Study, campaign: str, search: Search) -> finds.Unnamed:
    """What is sought when nobody names mutants: the same as before where that search was interrupted.

    Raises:
        InputError: nothing is left to seek.
    """
    folder = campaign_folder(study, search.into)
    defaults = study.roster.defaults.values()
    before = finds.interrupted(folder, search.seed, campaign)
    if before is not None and set(before.mutants) <= set(defaults):
        return before
    with snapshot(replace(study, grid_name=None), campaign) as now:
        survivors = set(defaults) - {mutant.subject.id for mutant in now.score.mutants if mutant.detected}
        warnings = (*now.stale.invalid, *study.finds.warnings)
    for sentence in warnings:
        search.progress.line(f"warning: {sentence}")
    mutants = [id_ for id_ in defaults if id_ in survivors and not study.finds.of(id_)]
    if not mutants:
        least = f"every default is detected or shown by a situation in sim/{FOUND_FILE}"
        raise InputError(f"--campaign={campaign!r}: {least}; name the mutants to seek")
    if len(mutants) < len(survivors):
        shown = f"{len(survivors) - len(mutants)} of {len(survivors)} defaults that are not detected"
        because = f"because situations in sim/{FOUND_FILE} show them"
        search.progress.line(f"not sought: {shown}, {because}; a mutant that is named is sought again")
    return finds.anew(folder, search.seed, campaign, mutants)


SoughtMutants = Annotated[
    Several,
    Option(
        "Ids or patterns, or `baseline` for situations that break the unmutated drone.",
        "",
        metavar="[baseline | ID|GLOB...]",
        complete=names.sought,
        otherwise="every cell's default that the campaign does not detect and no found situation shows",
    ),
]
SearchedGrid = Annotated[
    str,
    GridOption("The grid that is searched: a file in the study's sim/grids/, with free axes.", default=SEARCHED),
]
Into = Annotated[
    str | None,
    CampaignOption("The campaign that holds the flights of the search.", otherwise="the name of the grid"),
]
SearchBudget = Annotated[
    str | None,
    Option(
        "End after this wall time (90s, 10m, 2h), or after this number of flights (2000flights), stored ones "
        "included.  It decides how far the search goes, not what it finds before.",
        metavar="TIME|FLIGHTS",
    ),
]
SearchSeed = Annotated[
    int,
    SeedOption("Seed of the search: the same seed and mutants make the same finds.", type=click.IntRange(0, 2**31 - 1)),
]
Replicate = Annotated[
    bool,
    Option(
        "Search nothing: fly the finds in sim/found.yaml (of the named mutants) on fresh seeds; "
        "what does not hold leaves the file."
    ),
]
Anyhow = Annotated[
    bool,
    Option(
        "Take situations too where the unmutated drone violates an operability requirement, or does not meet the "
        "value of an axis; the find says so.",
        "--any",
    ),
]


@verb(
    "seek",
    sections={
        "Where": "--study --campaign --grid --into",
        "How": "--replicate --budget --seed --any --jobs --same-platform --untrusted",
        "What is printed": "--format --tables --warnings --quiet --help",
    },
)
def seek_command(
    *,
    mutants: SoughtMutants = (),
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    grid: SearchedGrid,
    into: Into,
    budget: SearchBudget,
    seed: SearchSeed,
    replicate: Replicate,
    anyhow: Anyhow,
    jobs: options.Jobs,
    same_platform: options.SamePlatform,
    untrusted: options.Untrusted,
    warnings: options.Warnings,
    quiet: options.Quiet,
) -> Answer:
    """Find situations that show mutants: the mutant violates a safety requirement, the unmutated drone does not.

    Without an ID the search takes every cell's default that the score of --campaign does not call detected.  Those that
    a situation in the study's sim/found.yaml shows are left out.  PLACEBO stands for the unmutated drone under other
    seeds, which no search should find anything for.  A situation counts where the unmutated drone does its mission in
    nine of ten flights (--any lifts that).  Robustness guides the search.  What it finds is shrunk towards the benign
    values, and confirmed by the score's own test on seeds that the search never flew.  It is written to sim/found.yaml,
    which `scaloft-fi run --grid NAME+found` flies (NAME: the study's own grid).  An interrupted search resumes with the
    same command.  A search picks what it finds by its flights; --replicate flies the finds again on other seeds, with
    one test over all of them.

    `seek baseline` finds situations that break the unmutated drone itself, each in a way of its own.  Another
    requirement is violated, something else is struck or elsewhere, or another stage believed what is not true.

    Examples:
        Seek situations for all that the last score calls not detected: `scaloft-fi seek --budget 1h`
        Seek a situation for one fault, with 2,000 flights at most: `scaloft-fi seek LESS-depth --budget 2000flights`
        Seek situations that break the unmutated drone: `scaloft-fi seek baseline --budget 30m`
        Fly what was found on fresh seeds: `scaloft-fi seek --replicate`
    """
    one_thread_each()

    context = click.get_current_context()
    for name in ("budget", "seed"):
        if replicate and context.get_parameter_source(name) is not ParameterSource.DEFAULT:
            raise InputError(f"--{name}={context.params[name]} must not stand with --replicate, which searches nothing")
    run_options = RunOptions(jobs=jobs or cores(), warnings=warnings, same_platform=same_platform, command=typed())
    progress = Silence() if quiet else Progress()
    search = Search(into or grid, run_options, seed, finds.Allowance.parse(budget), progress, anyhow, replicate)
    study = study_to_search(study_folder, grid, search.into)
    options.allow(study, untrusted=untrusted)
    return seek(study, campaign, mutants, search, named=study_folder)
