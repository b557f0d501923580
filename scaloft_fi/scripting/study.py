"""An open study for scripts and notebooks: its parts, single flights, its campaigns with what verbs do with them."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, update_wrapper
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, TypeVar

from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import By, MutantScore
from scaloft_fi.campaign.flights.fly import CAN_FORK
from scaloft_fi.campaign.plan import parse_seeds
from scaloft_fi.campaign.plan import parse_shard as shard_in
from scaloft_fi.campaign.processes import cores, started_clean
from scaloft_fi.campaign.progress import Progress, Silence
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.request import Request, fly, planned_run
from scaloft_fi.campaign.seeking.finds import Allowance
from scaloft_fi.campaign.store.archive import STORE_NAME, campaign_folder, is_archive, study_of, study_of_all
from scaloft_fi.campaign.workers import LOCAL, Executor, Local, executor_named
from scaloft_fi.checks.check import check_study
from scaloft_fi.defaults import CAMPAIGN, SEARCHED
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.output import write_named
from scaloft_fi.outside.suite import injecting
from scaloft_fi.scripting.flight import Figure, FlownFlight, described, in_python, number
from scaloft_fi.study import Study
from scaloft_fi.verbs import campaigns, kills, margin, situations, worksheet
from scaloft_fi.verbs import propose as proposing
from scaloft_fi.verbs import run as flying
from scaloft_fi.verbs import seek as seeking
from scaloft_fi.verbs import suite as testing
from scaloft_fi.verbs.campaigns import MergedCampaigns, MergedPlatform
from scaloft_fi.verbs.check import checked
from scaloft_fi.verbs.export.dossier import FORMATS, dossier, flight_columns
from scaloft_fi.verbs.judge import JudgedFiles, RecordedIn, RecordMapping, judge
from scaloft_fi.verbs.margin import MarginMutants, MarginSeeds, Tolerance
from scaloft_fi.verbs.options import (
    AsOf,
    BaselineFrom,
    FlightSeed,
    Jobs,
    Operability,
    SamePlatform,
    Situations,
    Today,
    several,
)
from scaloft_fi.verbs.replay import comparison, fly_with_log, ready_to_fly
from scaloft_fi.verbs.report.analyses import gather
from scaloft_fi.verbs.report.page import page
from scaloft_fi.verbs.score import SCORE, ScoredFlights, scored_campaign, scored_run
from scaloft_fi.verbs.score import dispositions as dispositions_of
from scaloft_fi.verbs.signals import signal_list
from scaloft_fi.verbs.situations import plan_of
from scaloft_fi.views.output import Answer, Columns, ColumnType, plain
from scaloft_fi.views.picture import draw_plan
from scaloft_fi.views.table import Format, Table, html

Told = bool | Callable[[int, int], object]
"""True for lines on the standard error, or a function of the flights flown and expected so far; False for nothing."""


class Calls(Silence):
    """Calls a function after each flight.

    Args:
        tell: the function; its arguments are the number of flights flown and that of flights expected.
    """

    def __init__(self, tell: Callable[[int, int], object]) -> None:
        super().__init__()
        self._tell = tell

    def advance(self) -> None:
        """Count one more flight, and call the function."""
        super().advance()
        self._tell(self.done, self.flights)


def progress_of(told: Told) -> Progress:
    """The progress display for the argument `progress`.

    Raises:
        InputError: it is neither a truth value nor a function.
    """
    if isinstance(told, bool):
        return Progress() if told else Silence()
    if not callable(told):
        raise InputError(f"progress={told!r} must be True, False, or a function of two numbers")
    return Calls(told)


TEXT, WHOLE, NUMBER, TEXTS = ColumnType.TEXT, ColumnType.WHOLE, ColumnType.NUMBER, ColumnType.TEXTS
MUTANT_COLUMNS = {
    **dict.fromkeys(("mutant", "guideword", "parameter", "magnitude", "verdict", "firm", "status"), TEXT),
    **dict.fromkeys(("killed_in", "tested_in", "flown_in"), WHOLE),
    "killed_by": TEXTS,
    **dict.fromkeys(("first_s", "seeds", "seeds_needed"), NUMBER),
}
PAIR_COLUMNS = {
    **dict.fromkeys(("situation", "requirement", "kind", "state"), TEXT),
    **dict.fromkeys(("violated", "flights"), WHOLE),
}


class CampaignScore:
    """The score of a campaign; each ratio has `part`, `whole` and `value` (None for 0 of 0).

    Args:
        scored: the campaign with its score.
    """

    def __init__(self, scored: ScoredFlights) -> None:
        self._scored = scored

    @property
    def mutation_score(self) -> Ratio:
        """Mutants that the safety requirements detect, of the credible cells' default mutants flown."""
        return self._scored.score.mutation_score

    @property
    def firm(self) -> Ratio:
        """Mutants detected whichever one seed is left out, of the same."""
        return self._scored.score.firm

    @property
    def exercised(self) -> Ratio:
        """Credible cells whose default mutant was flown, of all credible cells."""
        return self._scored.score.exercised

    @property
    def infected(self) -> Ratio:
        """Mutants that changed a sample, of those flown."""
        return self._scored.score.infected

    @property
    def tested(self) -> Ratio:
        """Mutants that were put to the test, of those flown."""
        return self._scored.score.tested

    @property
    def operability(self) -> Ratio:
        """Mutants that the operability requirements detect, of those flown."""
        return self._scored.score.operability

    @property
    def alpha(self) -> float:
        """Accepted chance 0..1 that a fault without effect is called detected."""
        return self._scored.score.alpha

    @property
    def expected_false(self) -> float:
        """Number of mutants without effect that are called detected, expected at most."""
        return self._scored.score.expected_false

    @cached_property
    def mutants(self) -> Columns:
        """One row for each mutant, ladders too, in the order of the catalogue.

        `firm` says of a detected one whether it hangs on a seed; it is empty for the others.
        `killed_in`, `tested_in` and `flown_in` count situations, `killed_by` has the requirements, `first_s` is the
        earliest violation [s from the start], `seeds` is what the verdict rests on, `seeds_needed` what would decide.
        """
        return Columns("Mutants", MUTANT_COLUMNS, map(_mutant, self._scored.score.mutants))

    @cached_property
    def controls(self) -> Columns:
        """The same of the controls, which are in no ratio."""
        return Columns("Controls", MUTANT_COLUMNS, map(_mutant, self._scored.score.controls))

    @cached_property
    def pairs(self) -> Columns:
        """One row for each situation with a requirement: of how many baseline flights how many violate, and its state.

        The state is `steady`, `red`, `unsteady`, `open`, `vacuous` or `unknown`.
        """
        return Columns("Pairs", PAIR_COLUMNS, plain(self._scored.pairs))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader must know beside the score, in sentences; often nothing."""
        return self._scored.warnings

    @described
    def record(self, by: str | None = None) -> dict[str, Any]:
        """The score as plain JSON values: what `scaloft-fi score --format json` prints.

        Args:
            by: `guideword`, `parameter`, `severity`, `situation`, `requirement` or `axis`, to have the score part by
                part too.

        Raises:
            InputError: there is no such grouping.
        """
        return SCORE.record(replace(self._scored, by=_by(by)))

    @described
    def text(self, *, by: str | None = None, everything: bool = False) -> str:
        """What `scaloft-fi score` prints.

        Args:
            by: as for `record`.
            everything: whether every mutant and every table is shown, not only the first screen.

        Raises:
            InputError: there is no such grouping.
        """
        return replace(self._scored, by=_by(by)).text(Format.TABLE, everything=everything)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"<score of campaign {self._scored.campaign!r}: {self.mutation_score} detected>"

    def _repr_html_(self) -> str:
        return html((*self._scored.screen.tables, *self._scored.run))


def _mutant(mutant: MutantScore) -> Mapping[str, Any]:
    rate, safety = mutant.kill_rate, mutant.safety
    return {
        "mutant": mutant.subject.id,
        "guideword": mutant.subject.guideword,
        "parameter": mutant.subject.parameter,
        "magnitude": mutant.subject.magnitude,
        "verdict": mutant.verdict.value,
        "firm": mutant.firmness.value if mutant.firmness else "",
        "status": mutant.status.value,
        "killed_in": rate.part,
        "tested_in": rate.whole,
        "flown_in": mutant.kill_rate_flown.whole,
        "killed_by": [name for name, _ in mutant.requirements],
        "first_s": mutant.first.t_s if mutant.first else None,
        "seeds": safety.seeds,
        "seeds_needed": safety.needed,
    }


def _by(name: str | None) -> By | None:
    if name is None:
        return None
    if name not in {by.value for by in By}:
        raise InputError(f"by={name!r} must be a grouping of the score{did_you_mean(name, [by.value for by in By])}")
    return By(name)


P = ParamSpec("P")
R = TypeVar("R")


def of_campaign(verb: Callable[Concatenate[Study, str, P], R]) -> Callable[Concatenate[OpenCampaign, P], R]:
    """The function of a verb as a method of a campaign, whose study and name it gets; errors name its arguments."""

    def method(self: OpenCampaign, /, *args: P.args, **named: P.kwargs) -> R:
        return verb(self._study, self.name, *args, **named)

    update_wrapper(method, verb)
    return described(method, without=2)


REPORT_NAME = "report.html"
MOST_JOBS = 1024
LEAST_TOLERANCE = 1e-9


@dataclass(frozen=True)
class OpenCampaign:
    """A campaign of a study, which need not exist yet.

    Each method reads study and campaign as they are when it is called.

    Attributes:
        study_folder: folder of the study.
        name: name of the campaign.
        grid: name of the grid; None for that of the campaign.
    """

    study_folder: Path
    name: str
    grid: str | None = None

    @property
    def folder(self) -> Path:
        """Folder of the campaign."""
        with in_python():
            return campaign_folder(self._study, self.name)

    @described
    def score(self, *, baseline_from: BaselineFrom = None, today: Today = None) -> CampaignScore:
        """Score the flights that the campaign holds, without flying.

        Raises:
            InputError: there is no campaign, or it holds no flight that counts.
        """
        return CampaignScore(scored_campaign(self._study, self.name, baseline_from, today))

    def flights(self) -> Columns:
        """The flights that count, one row each, with the columns of `scaloft-fi export`.

        Raises:
            InputError: there is no campaign, or it holds no flight that counts.
        """
        with in_python():
            made = dossier(self._study, self.name)
            return flight_columns(made.rows, made.columns)

    @described
    def export(
        self,
        format: str = "json",  # noqa: A002 - the name of the option
        *,
        today: Today = None,
    ) -> bytes:
        """The campaign in a format of `scaloft-fi export`, as the bytes of a file.

        Args:
            format: name of the format.

        Raises:
            InputError: there is no such format or campaign, or the campaign holds no flight that counts.
        """
        chosen = FORMATS[format]
        return chosen.content(dossier(self._study, self.name, today))

    @described
    def report(self, path: Path | str | None = None, *, today: AsOf = None) -> Path:
        """Write one HTML file that tells the whole campaign; returns its path.

        Args:
            path: path of the file; by default `report.html` in the folder of the campaign.

        Raises:
            InputError: there is no campaign, it holds no flight that counts, or the file cannot be written.
        """
        if path is None and is_archive(self.folder):
            raise InputError(f"{self.folder}: an archive is a record, into which no report is written: give path")
        content = page(gather(self._study, self.name, today)).encode()
        file = self.folder / REPORT_NAME if path is None else Path(path)
        write_named(file, content, "path")
        return file

    status = of_campaign(campaigns.status)
    coverage = of_campaign(situations.coverage)
    kills = of_campaign(kills.kills)
    when = of_campaign(margin.when_answer)
    worksheet = of_campaign(worksheet.worksheet)
    dispositions = of_campaign(dispositions_of)
    compare = of_campaign(campaigns.compare)
    diff = of_campaign(campaigns.diff)

    @described
    def run(
        self,
        mutants: flying.FlownMutants = (),
        situations: flying.FlownSituations = (),
        *,
        seeds: flying.FlownSeeds = None,
        baseline_seeds: flying.BaselineSeeds = None,
        baseline_from: BaselineFrom = None,
        choose: flying.Choose = None,
        choose_seed: flying.ChooseSeed = 0,
        sequential: flying.Sequential = False,
        shard: flying.Shard = None,
        budget_s: float | None = None,
        jobs: Jobs = None,
        executor: flying.ExecutorName = LOCAL,
        cluster_security: flying.ClusterSecurity = None,
        share: bool = True,
        max_invalid: flying.MaxInvalid = flying.MOST_INVALID,
        same_platform: SamePlatform = False,
        progress: Told = False,
    ) -> CampaignScore:
        """Fly the flights that the campaign lacks, and score those of this call; the same call resumes.

        Args:
            budget_s: wall time after which no flight begins [s].
            share: whether mutants share the beginning of their baseline; the outcomes are the same.
            progress: True for lines on the standard error, or a function of the flights flown and expected so far.

        Raises:
            GateError: a gate failed, so there is no valid score.
            InputError: an argument is not allowed, or the study cannot be flown.
            Interrupted: the user stopped the run; every flight that ended is saved.
        """
        request = Request(
            mutants=several(mutants, "mutants"),
            situations=several(situations, "situations"),
            choose=choose,
            choose_seed=choose_seed,
            seeds=None if seeds is None else parse_seeds(seeds),
            baseline_seeds=None if baseline_seeds is None else parse_seeds(baseline_seeds, "--baseline-seeds"),
            baseline_from=baseline_from,
            sequential=sequential,
            shard=None if shard is None else shard_in(shard),
            budget_s=None if budget_s is None else number(budget_s, "budget_s", 0.0, 1e9),
        )
        options = RunOptions(
            executor=_executor(executor, jobs, cluster_security),
            share=CAN_FORK and share,
            max_invalid=max_invalid,
            same_platform=same_platform,
        )
        shown = progress_of(progress)
        study = self._study
        flown = fly(planned_run(study, request), campaign_folder(study, self.name), options, progress=shown)
        return CampaignScore(scored_run(flown, self.name))

    @described
    def replay(self, mutant: str, situation: str, seed: FlightSeed = 0, *, same_platform: bool = False) -> FlownFlight:
        """Fly one flight again, in this process; its `comparison` says how it compares with that of the campaign.

        Args:
            mutant: `baseline`, `PLACEBO`, or name or id of a mutant.
            situation: key or alias of a situation.
            same_platform: whether only an equal digest will do, also beside a flight of another platform.

        Raises:
            GateError: the flight differs from that of the campaign.
            InputError: there is no such mutant or situation, or the study cannot be flown.
        """
        study = self._study
        flown = fly_with_log(study, ready_to_fly(study, mutant, situation, seed, lambda _text: None))
        return FlownFlight(flown, comparison(flown, self.name, same_platform=same_platform).passed())

    @described
    def margin(
        self,
        mutants: MarginMutants,
        situations: Situations = (),
        *,
        seeds: MarginSeeds = 1,
        tolerance: Tolerance = None,
        operability: Operability = False,
        jobs: Jobs = None,
        same_platform: SamePlatform = False,
        progress: Told = False,
    ) -> Answer:
        """Find the smallest magnitude of each fault that is killed, by bisection; flies what the campaign lacks.

        Args:
            progress: as for `run`, round by round.

        Raises:
            GateError: a gate failed.
            InputError: an argument is not allowed, a fault has no order, or the study cannot be flown.
            Interrupted: the user stopped the search; every flight that ended is saved.
        """
        progress_of(progress)
        return margin.margin(
            self._study,
            self.name,
            several(mutants, "mutants"),
            _options(jobs, same_platform),
            situations=several(situations, "situations"),
            seeds=parse_seeds(seeds),
            tolerance=None if tolerance is None else number(tolerance, "tolerance", LEAST_TOLERANCE, 1e9),
            operability=operability,
            progress=lambda: progress_of(progress),
        )

    @described
    def propose(
        self,
        mutants: proposing.MissingMutants = (),
        *,
        seeds: proposing.SeedCount = 3,
        most: proposing.SituationCount = 8,
        jobs: Jobs = None,
        progress: Told = False,
    ) -> Answer:
        """Propose the requirement that is missing, for faults that are put to the test and violate none; flies.

        Args:
            progress: as for `run`.

        Raises:
            InputError: an argument is not allowed, a mutant was not flown, or the study cannot be flown.
        """
        asked, how, size = several(mutants, "mutants"), progress_of(progress), proposing.Size(seeds, most)
        found = proposing.proposed(self._study, self.name, asked, size, _jobs(jobs), how, started_clean)
        return proposing.answer_of(found)

    @described
    def seek(
        self,
        mutants: seeking.SoughtMutants = (),
        *,
        grid: seeking.SearchedGrid = SEARCHED,
        into: seeking.Into = None,
        budget: seeking.SearchBudget = None,
        seed: seeking.SearchSeed = 0,
        anyhow: seeking.Anyhow = False,
        replicate: seeking.Replicate = False,
        jobs: Jobs = None,
        same_platform: SamePlatform = False,
        progress: Told = False,
    ) -> Answer:
        """Find situations that would have shown mutants, and write them to the study's `sim/found.yaml`.

        Args:
            progress: as for `run`.

        Raises:
            GateError: a gate failed.
            InputError: an argument is not allowed, Optuna is missing, or the study cannot be flown or written.
            Interrupted: the user stopped the search; flights and finds are saved.
        """
        with in_python(budget="budget"):
            options, allowance = _options(jobs, same_platform), Allowance.parse(budget)
            search = seeking.Search(
                into or grid,
                options,
                seed,
                allowance,
                progress_of(progress),
                anyhow,
                replicate,
            )
            study = seeking.study_to_search(self.study_folder, grid, search.into)
            return seeking.seek(study, self.name, several(mutants, "mutants"), search, named=self.study_folder)

    @described
    def merge(self, others: MergedCampaigns, *, same_platform: MergedPlatform = False) -> Answer:
        """Add the flights of other campaigns to this one, which need not exist.

        Raises:
            GateError: a flight has other digests on one platform, or other facts on two; nothing is written.
            InputError: there is no such campaign, two have different grids, or the campaign cannot be written.
        """
        sources = several(others, "others")
        if not sources:
            raise InputError("others=() must name a campaign")
        study = study_of_all(self.study_folder, [*sources, self.name])
        return campaigns.merge(study, self.name, sources, same_platform=same_platform)

    @property
    def _study(self) -> Study:
        return study_of(self.study_folder, self.name, self.grid)

    def _repr_html_(self) -> str:
        if is_archive(self.folder) or (self.folder / STORE_NAME).is_file():
            return self.status()._repr_html_()
        return html((Table(f"Campaign {self.folder}", (), (), ("Nothing was flown here yet.",)),))


def _options(jobs: int | None, same_platform: bool) -> RunOptions:
    """Options of a run without options of its own."""
    count = _jobs(jobs)
    return RunOptions(jobs=count, executor=_executor("local", count, None), same_platform=same_platform)


def _jobs(jobs: int | None) -> int:
    return cores() if jobs is None else int(number(jobs, "jobs", 1, MOST_JOBS))


def _executor(name: str, jobs: int | None, cluster_security: Path | str | None) -> Executor:
    """What runs the flights; on this machine, new interpreters where the system can hand them a connection."""
    count = None if jobs is None else _jobs(jobs)
    if name == LOCAL and os.name == "posix" and cluster_security is None:
        return Local(count or cores(), clean=True)
    return executor_named(name, count, None if cluster_security is None else Path(cluster_security))


MUTANT_FACTS = dict.fromkeys(("guideword", "parameter", "magnitude", "seam", "operator"), TEXT)
SIGNAL_FACTS = {"unit": TEXT, "least": NUMBER, "most": NUMBER, "meaning": TEXT}
REQUIREMENT_FACTS = {"requirement": "name", "kind": "kind", "formula": "text", "unit": "unit", "title": "title"}


@dataclass(frozen=True)
class OpenStudy:
    """An open study; each method reads the folder as it is when it is called.

    Attributes:
        folder: folder of the study.
        grid: name of the grid; None for the study's own, or that of a campaign.
    """

    folder: Path
    grid: str | None = None

    @property
    def definition(self) -> Study:
        """The study as plugins know it: every part of it, as `scaloft_fi.api.Study`.

        Raises:
            InputError: the folder is no study any more.
        """
        with in_python():
            return Study.open(self.folder, self.grid)

    @property
    def mutants(self) -> Columns:
        """The catalogue, one row for each mutant; `counted` marks those that the ratios of a score count."""
        with in_python():
            study = self.definition
            defaults = set(study.roster.defaults.values())
            rows = (
                {"mutant": one.id, **{name: getattr(one, name) for name in MUTANT_FACTS}, "counted": one.id in defaults}
                for one in study.catalogue
            )
            return Columns("Mutants", {"mutant": TEXT, **MUTANT_FACTS, "counted": ColumnType.TRUTH}, rows)

    @property
    def situations(self) -> Columns:
        """The situations of the grid, one row each: key, other names, title of each axis's value."""
        with in_python():
            grid = self.definition.grid
            axes = [axis.id for axis in grid.axes]
            rows = (
                {
                    "situation": situation.key,
                    "aliases": list(grid.aliases_of(situation)),
                    **dict(zip(axes, grid.titles(situation), strict=False)),
                }
                for situation in grid.situations
            )
            return Columns("Situations", {"situation": TEXT, "aliases": TEXTS, **dict.fromkeys(axes, TEXT)}, rows)

    @property
    def requirements(self) -> Columns:
        """The requirements, one row each: name, kind, formula, unit of the robustness, title."""
        with in_python():
            listed = self.definition.requirements
            rows = ({key: str(getattr(one, name)) for key, name in REQUIREMENT_FACTS.items()} for one in listed)
            return Columns("Requirements", dict.fromkeys(REQUIREMENT_FACTS, TEXT), rows)

    @property
    def signals(self) -> Columns:
        """The signals that requirements and axes may use, one row each: name, unit, range (NaN: no bound), meaning."""
        with in_python():
            listed = signal_list(self.definition).entries
            rows = ({"signal": one.name, **{name: getattr(one, name) for name in SIGNAL_FACTS}} for one in listed)
            return Columns("Signals", {"signal": TEXT, **SIGNAL_FACTS}, rows)

    @property
    def campaigns(self) -> tuple[str, ...]:
        """Names of the campaigns in the folder of results, in alphabetical order."""
        stores = (self.definition.results_folder / "campaigns").glob(f"*/{STORE_NAME}")
        return tuple(sorted(store.parent.name for store in stores))

    @described
    def campaign(self, name: str | None = None) -> OpenCampaign:
        """A campaign, which need not exist yet.

        Args:
            name: a folder in the study's `results/campaigns/`, or with a `/` the path of a folder; by default the name
                of the grid, or `default` for a study that was opened without one.

        Raises:
            InputError: the campaign was flown over another grid.
        """
        chosen = name if name is not None else self.grid or CAMPAIGN
        study_of(self.folder, chosen, self.grid)
        return OpenCampaign(self.folder, chosen, self.grid)

    @described
    def fly(self, mutant: str, situation: str, seed: FlightSeed = 0) -> FlownFlight:
        """Fly one flight, in this process; nothing is stored.

        In a test that `scaloft-fi suite` runs, a flight of the baseline is one of the fault that is put to the test.

        Args:
            mutant: `baseline`, `PLACEBO`, or name or id of a mutant.
            situation: key or alias of a situation.

        Raises:
            InputError: there is no such mutant or situation, or the study cannot be flown.
        """
        with injecting(mutant, BASELINE) as (subject, tell):
            study = self.definition
            flown = fly_with_log(study, ready_to_fly(study, subject, situation, seed, lambda _text: None))
            tell(flown.log.counts)
        return FlownFlight(flown)

    @described
    def map(self, situation: str | None = None) -> Figure:
        """Mine, bodies, route and happenings of a situation, without flying it.

        Args:
            situation: key or alias of the situation; by default every axis has its benign value.

        Raises:
            InputError: there is no such situation, or the study cannot be read.
        """
        study = self.definition
        one = study.grid.situation(situation) if situation else study.grid.situations[0]
        titles = ", ".join(study.grid.titles(one))
        return Figure(f"map of {one.key}", draw_plan(plan_of(study, one), title=one.key, subtitle=titles))

    @described
    def suite(
        self,
        file: testing.SuiteFile,
        *,
        campaign: testing.OwnCampaign = None,
        mutants: testing.AskedMutants = (),
        shard: testing.SuiteShard = None,
        jobs: testing.SuiteJobs = 1,
        progress: Told = False,
    ) -> Answer:
        """Put the faults of the study to one's own tests: which test shows what, and which fault no test shows.

        Args:
            progress: as for `OpenCampaign.run`.

        Raises:
            GateError: a gate failed.
            InputError: the file or an argument is not allowed, or a command says nothing.
            Interrupted: the user stopped the run; every run that ended is saved.
        """
        study, place, how = self.definition, Path(file), _options(jobs, same_platform=False)
        asked, name = testing.asked_mutants(study, several(mutants, "mutants"), shard), campaign or place.stem
        opened = testing.opened(study, place, name)
        suite = opened.look(opened.suite.tests, time.monotonic)
        return testing.tested(suite, asked, name, how, progress_of(progress)).answer()

    @described
    def judge(self, files: JudgedFiles, *, record: RecordMapping = None, situation: RecordedIn = None) -> Answer:
        """What the study's requirements say of records of flights, from any drone or simulator.

        Raises:
            InputError: a file cannot be read, or there is no such situation.
        """
        return judge(self.definition, files, record=record, situation=situation)

    @described
    def check(self, *, fly: bool = False) -> Columns:
        """Check the whole study; one row for each finding, errors first, with its place and remedy.

        Args:
            fly: whether to fly one baseline flight too, which shows the seams that the stack polls.
        """
        return checked(check_study(self.folder, fly=fly))["findings"]

    def _repr_html_(self) -> str:
        study = self.definition
        rows: Sequence[tuple[str, str]] = (
            ("grid", f"{study.grid.name}, {len(study.grid.situations)} situations"),
            ("mutants", f"{len(study.catalogue)}, of which {len(study.roster.defaults)} count in the score"),
            ("requirements", ", ".join(requirement.name for requirement in study.requirements)),
            ("campaigns", ", ".join(self.campaigns) or "none"),
        )
        return html((Table(f"Study {self.folder}", ("what", ""), tuple(rows)),))


@described
def open_study(study: Path | str | None = None, grid: str | None = None) -> OpenStudy:
    """Open a study.

    Args:
        study: folder with `hazop/`, `mutants/` and `sim/`; by default the nearest one upwards from the current folder,
            else the packaged study.
        grid: name of one of its grids; by default its own grid, or that of a campaign.

    Raises:
        InputError: the folder is no study, or has no such grid.

    >>> import scaloft_fi
    >>> study = scaloft_fi.open()
    >>> study.requirements["requirement"].tolist()
    ['SR1', 'SR2', 'SR2-literal', 'OP1']
    """
    return OpenStudy(Study.open(study, grid).folder, grid)
