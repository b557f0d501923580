"""`scaloft-fi suite`: the same faults, put to one's own tests: which test shows what, which fault no test shows."""

from __future__ import annotations

import math
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated

from scaloft_fi.analysis.detection import LEAST, Pair, State
from scaloft_fi.analysis.kill_matrix import Suite, minimal_suite
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.campaign import plan, progress
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.flights.suite import SuiteStudy
from scaloft_fi.campaign.processes import one_thread_each
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.request import run_looks
from scaloft_fi.campaign.runs.run import run
from scaloft_fi.campaign.store.archive import STORE_NAME, campaign_folder, study_of
from scaloft_fi.document import is_file, read_text
from scaloft_fi.errors import InputError, shown
from scaloft_fi.hazop.matrix import CellStatus, cell_of, class_of, worst_first
from scaloft_fi.mutants.catalogue import defaults, realise
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.output import joined, say, show, tell
from scaloft_fi.study import Study
from scaloft_fi.verbs import options, score
from scaloft_fi.verbs import run as run_verb
from scaloft_fi.verbs.options import Option, answer, several, typed, verb
from scaloft_fi.verbs.score import ScoredFlights
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Format, Table, counted, render

STATES: Mapping[State, str] = {
    State.STEADY: "steady",
    State.UNSTEADY: "flaky",
    State.RED: "red",
    State.VACUOUS: "skipped",
    State.UNKNOWN: "unknown",
}
"""What a test is without a fault, by the state of its pair."""


@dataclass(frozen=True)
class OwnTest:
    """A test.

    Attributes:
        test: its name.
        command: name of its command.
        state: without a fault: steady, flaky, red, skipped, or unknown.
        red: red runs without a fault, of those that say something.
        reached: faults that reach it, of those asked for.
        shows: faults that it kills.
        alone: of these, those that no other test kills.
        needed: whether it is in the smallest set of tests with the same kills.
    """

    test: str
    command: str
    state: str
    red: Ratio
    reached: int
    shows: tuple[str, ...]
    alone: tuple[str, ...]
    needed: bool


@dataclass(frozen=True)
class Missed:
    """A fault that no test shows.

    Attributes:
        mutant: its id.
        severity: class of its cell; "" for none.
        verdict: undecided, not_detected or not_tested.
        seam: where a test that shows it has to look.
        tests: tests that it reaches.
        deviation: how the parameter differs from the design intent.
        effect: what follows for the flight, by the matrix.
    """

    mutant: str
    severity: str
    verdict: str
    seam: str
    tests: int
    deviation: str
    effect: str


@dataclass(frozen=True)
class TestedSuite:
    """The faults of a study, put to the tests of a suite.

    Attributes:
        score: which faults the tests show; a test stands where a situation stands.
        study: the study, with the suite.
        unreached: faults asked for that reach no test.
    """

    __test__ = False
    score: ScoredFlights
    study: SuiteStudy
    unreached: tuple[str, ...]
    KEYS = ("tests", "missed", "unreached", "smallest", "score")

    @cached_property
    def kills(self) -> Mapping[str, tuple[str, ...]]:
        """The tests that kill each fault."""
        return {one.id: one.killing for one in self.score.score.faults}

    @property
    def smallest(self) -> tuple[str, ...]:
        """The smallest set of tests that kills every fault that any test kills."""
        return self._smallest.situations

    @cached_property
    def _smallest(self) -> Suite:
        return minimal_suite(self.kills, tuple(self.study.command_of))

    @property
    def tests(self) -> tuple[OwnTest, ...]:
        """Every test, in the order of the suite."""
        pairs, smallest = {pair.situation: pair for pair in self.score.pairs}, set(self.smallest)
        results = (result for one in self.score.score.mutants for result in one.results)
        reached = Counter(result.situation for result in results if result.reached)
        found = []
        for test, command in self.study.command_of.items():
            pair = pairs.get(test)
            red = Ratio(pair.violated, pair.judged) if pair else Ratio(0, 0)
            shows = tuple(id_ for id_, killing in self.kills.items() if test in killing)
            alone = tuple(id_ for id_ in shows if self.kills[id_] == (test,))
            found.append(OwnTest(test, command, state_of(pair), red, reached[test], shows, alone, test in smallest))
        return tuple(found)

    @property
    def unjudged(self) -> tuple[str, ...]:
        """Tests whose runs with a fault are all invalid."""
        faults = self.score.score.mutants
        judged = {result.situation for one in faults for result in one.results}
        run = {test for one in faults for test in self.score.rulings.mutants[one.subject]}
        return tuple(test for test in self.study.command_of if test in run - judged)

    @property
    def missed(self) -> tuple[Missed, ...]:
        """The faults that no test shows, the worst first."""
        matrix = self.study.matrix
        found = []
        for one in worst_first([one for one in self.score.score.faults if not one.detected], lambda one: one.severity):
            cell, seam = matrix.cell(cell_of(one.id)), realise(matrix, one.id).seam
            reached = sum(result.reached for result in one.results)
            told = (class_of(one.severity), str(one.verdict), seam, reached, cell.deviation, cell.effect)
            found.append(Missed(one.id, *told))
        return tuple(found)

    def tables(self) -> tuple[Table, ...]:
        """What the tests show, and the test to write next."""
        tests, missed = self.tests, self.missed
        rows = tuple(
            (one.test, one.state, one.red.short, one.reached, len(one.shows), len(one.alone), "yes" * one.needed)
            for one in tests
        )
        found, unjudged = self._smallest, self.unjudged
        nothing = [one.test for one in tests if not one.shows and one.test not in unjudged]
        how = "the smallest set with the same kills" if found.exact else "a small set with the same kills"
        lists = (
            (f"{len(nothing)} of {counted(len(tests), 'test')} show no fault", nothing),
            (f"{len(unjudged)} could not be judged, as each run with a fault is invalid", unjudged),
            (f"{counted(len(self.unreached), 'fault')} reach no test", self.unreached),
        )
        notes = (
            f"needed: {how} has {counted(len(found.situations), 'test')}.",
            *(f"{words}: {', '.join(named)}." for words, named in lists if named),
        )
        head = ("test", "without a fault", "red", "faults reach it", "shows", "alone", "needed")
        worst = [one for one in missed if one.verdict != "undecided"][:NEXT]
        following = tuple((one.severity, one.mutant, one.seam, one.deviation, one.effect) for one in worst)
        titles = ("severity", "fault", "seam", "deviation", "consequence that a test has to see")
        more = (f"{len(missed)} faults are shown by no test; --format json lists all.",) if len(missed) > NEXT else ()
        return (
            Table("Tests", head, rows, notes),
            *((Table("Write next a test that sees", titles, following, more),) if following else ()),
        )

    def answer(self, *, everything: bool = False) -> Answer:
        """The answer of the verb."""
        return Answer(
            SUITE,
            lambda: self,
            told=lambda how: joined([self.score.text(how, everything=everything), render(self.tables(), how)]),
            warnings=self.score.warnings,
        )


NEXT = 5
"""Most faults that the answer proposes a test for."""
SUITE = Output("suite", "1.1", TestedSuite, "tests", "what each of one's own tests shows, and the score of all of them")


def state_of(pair: Pair | None) -> str:
    """What a test is without a fault."""
    state = State.UNKNOWN if pair is None else pair.called(of_tests=True)
    return STATES.get(state, STATES[State.UNKNOWN])


def changed_since(revision: str, folder: Path) -> list[Path]:
    """The files that differ from a revision of the git repository of a folder, and new ones.

    Raises:
        InputError: there is no git, no repository, or no such revision.
    """

    def git(*words: str) -> list[str]:
        asked = ["git", "-C", str(folder), "-c", "core.quotepath=off", *words]
        try:
            done = subprocess.run(asked, capture_output=True, text=True, check=False)
        except OSError as error:
            raise InputError(f"--since={shown(revision)} needs git: {error.strerror}") from error
        if done.returncode:
            raise InputError(f"--since={shown(revision)}: git says: {done.stderr.strip().partition(chr(10))[0]}")
        return done.stdout.splitlines()

    (top,) = git("rev-parse", "--show-toplevel")
    new = git("ls-files", "--others", "--exclude-standard", "--full-name")
    (known,) = git("rev-parse", "--verify", "--end-of-options", f"{revision}^{{commit}}")
    return [Path(top, name).resolve() for name in (*git("diff", "--name-only", known), *new)]


def commands_since(study: SuiteStudy, revision: str) -> list[str]:
    """The commands of which an input has changed since a revision; all of them where the suite or the study has.

    Raises:
        InputError: as `changed_since`.
    """
    changed = changed_since(revision, study.file.parent)
    shared = [study.file.resolve(), *(study.folder.resolve() / name for name in ("hazop", "mutants", "sim"))]

    def touched(paths: Sequence[Path]) -> bool:
        return any(one == path or path in one.parents for one in changed for path in paths)

    if touched(shared):
        return list(study.suite.tests)
    own = {name: [(study.place / path).resolve() for path in one.inputs] for name, one in study.suite.tests.items()}
    return [name for name, paths in own.items() if touched(paths)]


def asked_mutants(study: Study, patterns: Sequence[str], shard: str | None = None) -> tuple[Mutant, ...]:
    """The mutants that patterns mean, without any the default of each credible cell; of a shard its part of them.

    Raises:
        InputError: there is no such mutant, or the shard has none.
    """
    credible = (one for one in defaults(study.matrix) if study.matrix.cell(one.cell).status is CellStatus.CREDIBLE)
    asked = plan.parse_mutants(study, patterns) if patterns else tuple(credible)
    number, shards = plan.parse_shard(shard) if shard is not None else (1, 1)
    if len(asked) < shards:
        raise InputError(f"--shard={shard!r} may have at most {counted(len(asked), 'shard')}, one for each fault")
    return asked[number - 1 :: shards]


def reach_tables(study: SuiteStudy, mutants: Sequence[Mutant], jobs: int) -> tuple[Table, ...]:
    """Which faults reach which test, and what the run costs."""
    rows, first_s, least = [], 0.0, 0.0
    for name, looked in study.looked.items():
        reaching = [one for one in mutants if study.reaches(one, looked.tests[0])]
        seams = sorted({one.seam for one in reaching})
        runs = LEAST + 1 + len(reaching)
        first_s += (LEAST + 2) * looked.wall_s
        least += len(reaching) * looked.wall_s
        rows.append((name, len(looked.tests), len(reaching), ", ".join(seams) or "none", runs, f"{looked.wall_s:.1f}"))
    minutes = math.ceil((first_s + least) / jobs / 60.0)
    note = f"At least {minutes} min with --jobs {jobs}; a fault that turns a test red runs up to ten times."
    head = ("command", "tests", "faults reach it", "at the seams", "runs", "one run [s]")
    return (Table("What reaches which test", head, tuple(rows), (note,)),)


SuiteFile = Annotated[Path, Option("The YAML file that names the tests.", "", metavar="FILE")]
OwnCampaign = Annotated[
    str | None,
    options.CampaignOption(
        "A folder in the study's results/campaigns/; a NAME with a / is the path of a folder.",
        otherwise="the name of FILE without its ending",
    ),
]
AskedMutants = Annotated[run_verb.FlownMutants, options.DefaultWords("the default of every credible cell")]
SuiteJobs = Annotated[
    int,
    options.CountOption(
        "Commands that run at a time; more than one needs tests that do not meet.", "--jobs", default=1
    ),
]
Since = Annotated[
    str | None,
    Option("Run only the commands of which a declared input has changed since the git revision REV.", metavar="REV"),
]
SuiteShard = Annotated[
    str | None,
    Option(
        "Run the K-th of N parts of the faults, each beside runs without a fault; `merge` joins the campaigns.",
        "--shard",
        metavar="K/N",
    ),
]
Reach = Annotated[bool, Option("Say which faults reach which test and what a run costs, and run no fault.")]


@verb(
    "suite",
    sections={
        "Where": "--study --campaign",
        "Which faults": "--mutant --shard --since --reach",
        "How": "--jobs --untrusted",
        "What fails the run": "--fail-under --fail-under-firm --max-invalid",
        "What is printed": "--all --format --tables --quiet --help",
    },
)
def suite_command(
    *,
    file: SuiteFile,
    study_folder: options.StudyFolder,
    campaign: OwnCampaign,
    mutants: AskedMutants,
    shard: SuiteShard,
    since: Since,
    reach: Reach,
    jobs: SuiteJobs,
    max_invalid: run_verb.MaxInvalid,
    untrusted: options.Untrusted,
    everything: options.Everything,
    style: options.TableFormat,
    tables_folder: options.TablesFolder,
    fail_under: options.FailUnder,
    fail_under_firm: options.FailUnderFirm,
    quiet: options.Quiet,
) -> int:
    """Put the faults of the study to your own tests: which test shows what, and which fault no test shows.

    Each test runs ten times without a fault, then with PLACEBO and with a control that has to turn a test red.  Each
    fault then runs once at the tests that it reaches.  It runs up to ten times where a test turned red, by the looks
    of `run --sequential`.  The campaign is read by `score`, `kills`, `report` and `export` as one of flights.

    Examples:
        Put every fault to your own tests; the same command resumes: `scaloft-fi suite suite.yaml`
        See beforehand which fault reaches which test: `scaloft-fi suite suite.yaml --reach`
        In CI: what a branch has changed: `scaloft-fi suite suite.yaml --since origin/main --fail-under-firm 0.25`
    """
    one_thread_each()
    study = Study.open(study_folder)
    options.allow(study, untrusted=untrusted)
    if untrusted:
        raise InputError(f"--untrusted refuses that {file} starts programs of its own")
    asked, bars = asked_mutants(study, several(mutants, "mutants"), shard), score.bars_of(fail_under, fail_under_firm)
    name = campaign or file.stem
    suite = opened(study, file, name)
    chosen = None if since is None else commands_since(suite, since)
    if chosen == []:
        say(f"no input of a test has changed since {since}: nothing is run")
        return 0
    suite = suite.look(chosen or suite.suite.tests, time.monotonic)
    shown_reach = reach_tables(suite, asked, jobs)
    if reach:
        tell(render(shown_reach, Format(style)))
        return 0
    if not quiet:
        show(sys.stderr, render(shown_reach, Format.TABLE))
    how = RunOptions(jobs=jobs, max_invalid=max_invalid, command=typed())
    bar = progress.Silence() if quiet else progress.Progress(tally=score.shown_so_far, counts=("runs", "done"))
    told = tested(suite, asked, name, how, bar)
    answer(told.answer(everything=everything), style, tables_folder)
    return score.below(told.score.score, bars)


def opened(study: Study, file: Path, campaign: str) -> SuiteStudy:
    """The study with the suite of a file, for a campaign that has no flights.

    Raises:
        InputError: the file or the campaign is not allowed.
    """
    suite = SuiteStudy(study.folder, None, study.archived_name, file.absolute(), read_text(file))
    suite.check()
    if is_file(campaign_folder(suite, campaign) / STORE_NAME) and not study_of(study.folder, campaign).tests_of:
        raise InputError(f"--campaign={campaign}: the campaign holds flights; name another one for the runs of tests")
    return suite


def tested(
    study: SuiteStudy,
    mutants: Sequence[Mutant],
    campaign: str,
    how: RunOptions,
    bar: progress.Progress,
) -> TestedSuite:
    """Run the tests without a fault, with PLACEBO and a control, then with the mutants that reach them.

    Raises:
        GateError: a gate failed.
        InputError: the folder or the store cannot be written, or a command cannot run.
        Interrupted: the user stopped the run; every run that ended is saved.
    """
    folder = campaign_folder(study, campaign)
    tests = study.grid.situations
    control = plan.canary(study)

    def reaches(flight: Flight) -> bool:
        return flight.mutant is None or study.reaches(flight.mutant, flight.situation.key)

    baselines = tuple(Flight(None, test, seed) for seed in range(LEAST) for test in tests)
    first = tuple(Flight(one, test, 0) for one in (PLACEBO, *([control] if control else [])) for test in tests)
    question = plan.Plan(baselines, tuple(filter(reaches, first)), None, tuple(range(LEAST)))
    run(study, question, folder, how, progress=bar)
    faults = plan.plan(tests, (0,), mutants, None).with_pool()
    run_looks(study, faults, folder, how, progress=bar, reaches=reaches)
    unreached = tuple(one.id for one in mutants if not any(study.reaches(one, test.key) for test in tests))
    return TestedSuite(score.scored_campaign(study, campaign), study, unreached)
