"""The search without physics: what it finds, what decides it, that it resumes; families and proposals."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
from finding import BAR, Ruled, everywhere, fast, found, landed, never, small_study, sought
from options import usually
from paper_flyer import Whole
from running import PowerError, dying, quiet

from scaloft_fi.analysis.seeking import POOL, SEEDS
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.run import Budget
from scaloft_fi.campaign.seeking import finds, seek
from scaloft_fi.campaign.seeking import finds as finding
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.workers import Interrupted
from scaloft_fi.errors import GateError, InputError
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.sim.grid import Find, load_grid, read_finds
from scaloft_fi.sim.situation import Situation
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study
from scaloft_fi.verbs.seek import replica_table, seek_tables, spending, why_not

STUDY = Study.open(Path(__file__).parents[3], "search")
LATE, MORE, LESS = (realise(STUDY.matrix, name) for name in ("LATE-human@3s", "MORE-goal@1m", "LESS-depth"))


@pytest.fixture
def flyer(tmp_path: Path) -> Ruled:
    return Ruled(tmp_path / "flown.txt", {LATE.id: fast})


@dataclass
class Listed:
    """Proposes these situations, once."""

    left: list[str]
    nearest: float = 0.0

    def ask(self, count: int) -> list[seek.Proposal]:
        asked, self.left = self.left[:count], self.left[count:]
        return [seek.Proposal(STUDY.grid.situation(key), {}) for key in asked]

    def tell(self, distances: Sequence[tuple[seek.Proposal, float]]) -> None:
        """Nothing is learned."""


def search(
    folder: Path, flyer: Any, *mutants: Any, budget: str | None = None, **more: Any
) -> tuple[finding.SeekReport, list[Find]]:
    saved: list[Find] = []

    def save(finds: Sequence[Find]) -> None:
        saved[:] = finds

    allowance = finding.Allowance.parse(budget)
    report = sought(STUDY, mutants or (LATE,), folder / "c", allowance=allowance, save=save, flyer=flyer, **more)
    return report, saved


def test_a_situation_is_found_shrunk_confirmed_on_fresh_seeds_and_told_in_words(tmp_path: Path, flyer: Ruled):
    report, saved = search(tmp_path, flyer)
    (find,) = report.finds
    assert saved == [find]
    situation = STUDY.grid.situation(find.situation)
    assert [axis for axis, _ in situation.numbers] == ["Cs"]
    assert dict(situation.levels) == {"T": 0, "O": 0, "W": 0, "D": 0, "H": 1}
    assert find.words == ("human", STUDY.grid.titles(situation)[-1])
    assert (find.name, find.mutant) == (f"shows-{LATE.id}", LATE.id)
    evidence = find.shows[LATE.id]
    assert (evidence.requirement, evidence.struck, evidence.candidate) == ("SR2", "person", 1)
    assert evidence.p <= evidence.alpha == 0.005
    assert evidence.violated >= 0.5 * evidence.flights
    assert (evidence.held, evidence.baselines) == (10, 10)
    assert evidence.margin > evidence.spread
    assert report.sought[0].shown_in == find.situation
    assert not report.spent
    seeds = {int(name.rsplit("/", 1)[1]) for name in flyer.flown}
    assert seeds == {*finding.SEEN_ON, *range(10)}
    confirming = {name.split("/")[1] for name in flyer.flown if int(name.rsplit("/", 1)[1]) < 10}
    assert confirming == {report.finds[0].situation}


def test_the_same_seed_makes_the_same_finds_whatever_the_jobs(tmp_path: Path, flyer: Ruled):
    first, _ = search(tmp_path / "a", flyer, LATE, MORE, budget="100flights")
    second, _ = search(tmp_path / "b", flyer, LATE, MORE, budget="100flights", jobs=3)
    assert first == second
    other, _ = search(tmp_path / "d", flyer, LATE, MORE, budget="100flights", seed=1)
    assert other.sought != first.sought


def test_a_search_that_dies_goes_on_where_it_stopped(tmp_path: Path, flyer: Ruled):
    whole, _ = search(tmp_path / "a", flyer)
    flown = sorted(flyer.flown)
    flyer.path.unlink()
    with pytest.raises(PowerError):
        search(tmp_path / "b", flyer, progress=dying(25))
    resumed, saved = search(tmp_path / "b", flyer)
    assert resumed.finds == whole.finds == tuple(saved)
    assert sorted(set(flyer.flown)) == flown
    assert resumed.flown < whole.flown
    again, _ = search(tmp_path / "b", flyer)
    assert (again.finds, again.used, again.flown) == (whole.finds, whole.used, 0)


def test_a_search_that_nobody_named_mutants_for_is_remembered_until_it_ends(tmp_path: Path, flyer: Ruled):
    folder = tmp_path / "c"
    assert finding.interrupted(folder, 0, "default") is None
    first = finding.anew(folder, 0, "default", [LATE.id, MORE.id])
    with pytest.raises(PowerError):
        search(tmp_path, flyer, LATE, MORE, unnamed=first, progress=dying(1))
    assert finding.interrupted(folder, 0, "default") == first
    assert finding.interrupted(folder, 1, "default") is None
    assert finding.interrupted(folder, 0, "other") is None
    search(tmp_path, flyer, LATE, MORE, unnamed=first, budget="20flights")
    assert finding.interrupted(folder, 0, "default") is None
    second = finding.anew(folder, 0, "default", [MORE.id])
    assert second.number == 1
    search(tmp_path, flyer, MORE, unnamed=second, budget="10flights")
    assert finding.interrupted(folder, 0, "default") is None


def test_a_budget_decides_only_how_far_it_goes(tmp_path: Path, flyer: Ruled):
    short, saved = search(tmp_path, flyer, budget="20flights")
    assert (short.spent, short.finds, saved) == (True, (), [])
    assert short.used <= 20
    longer, _ = search(tmp_path, flyer)
    flyer.path.unlink()
    assert longer.finds == search(tmp_path / "whole", flyer)[0].finds


def test_what_was_flown_is_told_though_the_budget_ends_in_a_pursuit(tmp_path: Path, flyer: Ruled):
    flyer.rules = {LATE.id: everywhere}
    report, _ = search(tmp_path, flyer, budget="20flights")
    assert (report.spent, report.finds) == (True, ())
    (sought,) = report.sought
    assert (sought.effort.situations, sought.effort.showed, sought.effort.nearest < 0.0) == (8, 8, True)


def test_a_budget_of_time_ends_among_the_flights_that_were_asked_for_together(
    tmp_path: Path, flyer: Ruled, monkeypatch: pytest.MonkeyPatch
):
    def second_per_flight(seconds: float | None) -> Budget:
        return Budget(seconds, clock=lambda: float(len(flyer.flown)))

    monkeypatch.setattr("scaloft_fi.campaign.seeking.finds.Budget", second_per_flight)
    report, _ = search(tmp_path, flyer, budget="5s")
    assert (report.spent, report.finds) == (True, ())
    assert 5 <= len(flyer.flown) < 10, "the opening asks for sixteen at once"
    assert report.used == report.flown == len(flyer.flown), "flights that it let fly are of the search"


def test_a_budget_below_the_first_flights_says_how_many_these_are(tmp_path: Path, flyer: Ruled):
    report, _ = search(tmp_path, flyer, budget="15flights")
    assert (report.used, report.flown, report.needed) == (0, 0, 16)
    said = seek_tables(report, "paper")[1].notes[-1]
    assert "the budget ended the search before its first flights; `--budget 16flights` is the least." in said
    enough, _ = search(tmp_path, flyer, budget="16flights")
    assert (enough.used, "first flights" in str(seek_tables(enough, "paper"))) == (16, False)
    assert search(tmp_path, flyer)[0].needed is None


@pytest.mark.parametrize("budget", ["29flights", "31flights"])
def test_a_candidate_that_the_budget_ended_before_its_fresh_seeds_were_flown_is_not_one_that_these_refused(
    tmp_path: Path, flyer: Ruled, budget: str
):
    flyer.rules = {LATE.id: everywhere}
    report, _ = search(tmp_path, flyer, budget=budget, shrinks=False)
    (sought,) = report.sought
    assert (sought.candidates, sought.untested, sought.spent) == (0, 1, 0.005)
    assert why_not(sought) == "1 candidate not flown on all fresh seeds"
    assert why_not(replace(sought, candidates=2)).startswith("2 candidates that fresh seeds did not confirm, 1 cand")
    assert "0 candidates (and 1 not flown on all of them) of 1 mutant, at" in spending(report)


def test_a_find_shows_the_other_mutants_that_fail_there_too_on_the_same_seeds(tmp_path: Path, flyer: Ruled):
    flyer.rules = {LATE.id: fast, MORE.id: fast, LESS.id: never}
    report, _ = search(tmp_path, flyer, MORE, LATE, LESS, budget="200flights")
    (find,) = report.finds
    assert set(find.shows) == {MORE.id, LATE.id}
    assert [bool(one.shown_in) for one in report.sought] == [True, True, False]
    for mutant in find.shows:
        flown = {name.rsplit("/", 1)[1] for name in flyer.flown if name.startswith(f"{mutant}/{find.situation}/")}
        assert {*map(str, range(find.shows[mutant].flights))} <= flown


def test_something_else_may_propose_and_what_it_shows_need_not_be_shrunk(tmp_path: Path, flyer: Ruled):
    keys = ["T0O0W0D0H0", "T0O0W1D0H1Cs=1Vx=1"]

    def found(where: str, **more: Any) -> Find:
        report, (find,) = search(tmp_path / where, flyer, proposer=lambda *_: Listed(keys), first=lambda *_: (), **more)
        (sought,) = report.sought
        assert (sought.effort.situations > 2, sought.after) == (more.get("shrinks", True), report.used)
        return find

    assert found("a", shrinks=False).situation == keys[1]
    assert "Vx" not in found("b").situation


def test_a_situation_where_the_unmutated_drone_stands_on_the_edge_is_no_find(tmp_path: Path, flyer: Ruled):
    flyer.baseline, flyer.noise = (lambda _situation: 0.05), 0.1
    flyer.rules = {LATE.id: everywhere}
    report, _ = search(tmp_path, flyer, budget="200flights")
    assert report.finds == ()


def test_what_violates_everywhere_is_found_in_the_benign_situation(tmp_path: Path, flyer: Ruled):
    flyer.rules = {LATE.id: everywhere}
    report, _ = search(tmp_path, flyer)
    assert [find.situation for find in report.finds] == ["T0O0W0D0H0"]
    assert report.finds[0].words == ()


def test_a_baseline_that_violates_too_hides_the_fault(tmp_path: Path, flyer: Ruled):
    def red(situation: Situation) -> float:
        return -0.3 if situation["H"] == 1 else 0.4

    flyer.baseline = red
    report, _ = search(tmp_path, flyer, budget="60flights")
    assert report.finds == ()


def test_a_situation_where_the_unmutated_drone_does_not_do_its_mission_counts_only_when_asked(
    tmp_path: Path, flyer: Ruled
):
    flyer.operable = lambda situation: -0.1 if situation["H"] == 1 else 0.5
    report, _ = search(tmp_path / "a", flyer, budget="150flights")
    assert report.finds == ()
    assert report.sought[0].candidates == 0
    asked, _ = search(tmp_path / "b", flyer, budget="150flights", anyhow=True)
    (find,) = asked.finds
    assert find.shows[LATE.id].mission == 0
    assert asked.anyhow
    assert not report.anyhow


def test_candidates_are_numbered_over_all_searches_of_a_campaign(tmp_path: Path, flyer: Ruled):
    first, _ = search(tmp_path, flyer, shrinks=False)
    again, _ = search(tmp_path, flyer, shrinks=False)
    assert (again.finds, again.sought) == (first.finds, first.sought), "the same search tests the same situations"
    other, _ = search(tmp_path, flyer, seed=1, shrinks=False)
    assert other.finds[0].situation != first.finds[0].situation
    assert [report.finds[0].shows[LATE.id].candidate for report in (first, other)] == [1, 2]
    assert [report.sought[0].spent for report in (first, other)] == [0.005, 0.0025]
    assert other.finds[0].shows[LATE.id].alpha == 0.0025


def test_a_candidate_spends_its_share_though_its_pool_is_not_fit(tmp_path: Path, flyer: Ruled):
    """The first seeds of the search do the mission, those of the confirmation do not."""
    fit = Ruled(tmp_path / "fit.txt", {LATE.id: fast})
    unfit = Ruled(tmp_path / "unfit.txt", {LATE.id: fast}, operable=lambda _situation: -0.1)

    class Turning(Ruled):
        def __call__(self, study: Study, flight: Any) -> Any:
            return (fit if flight.seed in finding.SEEN_ON else unfit)(study, flight)

    report, _ = search(tmp_path, Turning(tmp_path / "flown.txt"), budget="200flights")
    (sought,) = report.sought
    assert report.finds == ()
    assert sought.candidates >= 2
    assert sought.spent == pytest.approx(sum(0.01 * 2.0**-one for one in range(1, sought.candidates + 1)))
    assert not any(name.startswith(LATE.id) for name in unfit.flown), "a pool that is not fit is seen before the mutant"


@pytest.mark.parametrize("together", [1, 2])
def test_many_mutants_wait_for_the_baselines_and_do_not_fly_where_these_are_red(
    tmp_path: Path, flyer: Ruled, monkeypatch: pytest.MonkeyPatch, together: int
):
    monkeypatch.setattr(finds, "TOGETHER", together)
    flyer.baseline = flyer.first = lambda situation: -0.3 if situation["H"] == 1 else 0.4
    search(tmp_path, flyer, LATE, MORE, budget="70flights")
    opened = [one.situation.key for one in seek.opening(STUDY.grid, 0, partial(seek.flyable, STUDY))]
    vain = [name for name in flyer.flown if "H1" in name and name.split("/")[1] in opened and LATE.id in name]
    assert bool(vain) == (together == 2)


def test_nothing_is_found_for_the_unmutated_drone_under_other_seeds(tmp_path: Path, flyer: Ruled):
    flyer.baseline, flyer.noise = (lambda _situation: 0.05), 0.1  # it violates in a quarter of its flights
    report, _ = search(tmp_path, flyer, PLACEBO, budget="100flights")
    assert report.finds == ()
    assert {name.split("/")[0] for name in flyer.flown} == {"baseline"}
    assert any(int(name.rsplit("/", 1)[1]) >= finding.OTHER_SEEDS for name in flyer.flown)


def test_the_search_says_that_optuna_is_missing(tmp_path: Path, flyer: Ruled, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(__import__("sys").modules, "optuna", None)
    with pytest.raises(InputError, match=r"seek needs optuna: pip install 'scaloft-fi\[seek\]'"):
        search(tmp_path, flyer)
    assert not (tmp_path / "c" / STORE_NAME).exists()


@pytest.mark.parametrize("text", ["", "10", "0flights", "-5flights", "10 parsecs", "flights"])
def test_a_budget_that_is_none_is_refused(text: str):
    with pytest.raises(InputError, match=r"--budget=.* must be a number of flights such as 2000flights, or a time"):
        finding.Allowance.parse(text)


def quest(name: str) -> seek.Quest:
    mutant = realise(STUDY.matrix, name)
    return seek.Quest(mutant, seek.Proposals(STUDY.grid, lambda _situation: True, 0, mutant.id))


def test_the_mutants_of_one_parameter_are_a_family():
    found = seek.families(map(quest, ("LATE-human", "MORE-goal", "NO-human", "LESS-goal")))
    assert [[one.mutant.parameter for one in family.quests] for family in found] == [["human"] * 2, ["goal"] * 2]


def test_a_family_proposes_at_least_a_generation_and_something_for_each_mutant():
    (alone,), (many,) = (
        seek.families([quest("LATE-human")]),
        seek.families(map(quest, STUDY.roster.defaults.values()))[:1],
    )
    assert len(alone.ask()) == seek.GENERATION
    assert len(many.quests) > seek.GENERATION / seek.EACH
    assert len(many.ask()) == seek.EACH * len(many.quests)


def test_a_mutant_with_a_find_proposes_nothing():
    (family,) = seek.families(map(quest, ("LATE-human", "NO-human")))
    family.quests[0].shown_in = STUDY.grid.situations[0]
    assert [one.mutant.id for one in family.sought] == [family.quests[1].mutant.id]


def test_a_family_that_comes_no_nearer_rests_twice_as_long_each_time_and_progress_ends_that():
    (family,) = seek.families([quest("LATE-human")])
    rests = []
    for _ in range(5):
        family.rest_after(family.nearest)
        rests.append(family.pauses)
    assert rests == [1, 2, 4, seek.LONGEST_REST, seek.LONGEST_REST]
    family.rest_after([one + 0.1 for one in family.nearest])
    assert family.pauses == 0


GRID = load_grid(Path(__file__).parents[3] / "sim", "search")


def distance(situation: Situation) -> float:
    """Near with a person and at speed."""
    return 0.5 * (situation["H"] != 1) + 1.2 - dict(situation.numbers).get("Cs", 0.5)


def anything(_situation: Situation) -> bool:
    return True


def flown(seed: int, generations: int, mutant: str = "A", possible=anything) -> list[list[Situation]]:
    """The opening, then generations of eight."""
    proposals, first = seek.Proposals(GRID, possible, seed, mutant), list(seek.opening(GRID, seed, possible))
    proposals.tell([(one, distance(one.situation)) for one in first])
    told = [[one.situation for one in first]]
    for _ in range(generations):
        asked = proposals.ask(8)
        proposals.tell([(one, distance(one.situation)) for one in asked])
        told.append([one.situation for one in asked])
    return told


def test_the_first_situations_are_the_same_for_every_mutant_and_then_each_has_its_own():
    first, second = flown(0, 1, "A"), flown(0, 1, "B")
    assert len(first[0]) == seek.OPENING
    assert first[0] == second[0]
    assert first[1] != second[1]


def test_half_of_the_numbers_of_the_opening_are_at_an_end_of_their_range():
    ends = {axis.id: (axis.low, axis.high) for axis in GRID.free}
    numbers = [(axis, number) for one in flown(0, 0)[0] for axis, number in one.numbers]
    at_end = sum(min(abs(number - end) for end in ends[axis]) < 0.01 * ends[axis][1] for axis, number in numbers)
    assert 0.35 < at_end / len(numbers) < 0.65
    assert 4 < len(numbers) / seek.OPENING < 8


def test_the_same_seed_proposes_the_same_and_another_seed_others():
    assert flown(3, 2) == flown(3, 2)
    assert not {*flown(3, 0)[0]} & {*flown(4, 0)[0]}


def test_proposals_are_distinct_situations_of_the_grid_with_short_numbers():
    asked = [one for generation in flown(0, 4) for one in generation]
    assert len(set(asked)) == len(asked) == seek.OPENING + 4 * 8
    assert all(GRID.situation(one.key) == one for one in asked)
    digits = [len(f"{abs(number):g}".replace(".", "").strip("0")) for one in asked for _, number in one.numbers]
    assert sum(count > 2 for count in digits) < len(digits) / 10


def test_what_is_impossible_is_not_proposed():
    asked = [one for generation in flown(0, 3, possible=lambda one: one["T"] == 0) for one in generation]
    assert len(asked) > seek.OPENING
    assert all(one["T"] == 0 for one in asked)


def test_later_proposals_are_nearer_to_what_was_good():
    told = flown(0, 5)
    before, after = ([distance(one) for generation in part for one in generation] for part in (told[:1], told[4:]))
    assert sum(after) / len(after) < sum(before) / len(before) - 0.1


def test_what_another_proposed_is_known_and_learned_from():
    """A search that is told of good situations only by others goes where they are, and proposes none of them."""
    told, lone = seek.Proposals(GRID, anything, 0, "A"), seek.Proposals(GRID, anything, 0, "A")
    first = list(seek.opening(GRID, 0, anything))
    theirs = [one for seed in range(1, 4) for one in seek.opening(GRID, seed, anything)]
    for proposals, more in ((told, theirs), (lone, [])):
        proposals.tell([(one, distance(one.situation)) for one in (*first, *more)])
    own, alone = ([one.situation for one in proposals.ask(8)] for proposals in (told, lone))
    assert sum(map(distance, own)) < sum(map(distance, alone))
    assert told.nearest == min(distance(one.situation) for one in (*first, *theirs))
    assert not {*own} & {one.situation for one in (*first, *theirs)}


def test_draws_go_on_after_the_opening_and_end_where_no_more_are_found():
    drawn = [one.situation for one in islice(seek.draws(GRID, 0, anything), seek.OPENING + 8)]
    assert len({*drawn}) == seek.OPENING + 8
    assert drawn[: seek.OPENING] == [one.situation for one in seek.opening(GRID, 0, anything)]
    assert list(seek.draws(GRID, 0, lambda one: one in drawn[:3])) == list(islice(seek.draws(GRID, 0, anything), 3))


SEARCHES, MOST = usually(4, release=1_000), 0.01
FLIGHTS = 200
"""Budget of a search."""
PLANTED_LATE = "LATE-human@3s"


@dataclass(frozen=True)
class Planted(Whole):
    """Flies without physics; search: the number of the search, which draws its own rates."""

    search: int

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        readings, violations = [], []
        for name in ("SR1", "SR2"):
            rate = self._chance("rate", name, flight.situation.key) / 2
            own = ("flight", name, flight.situation.key, flight.subject.id, flight.seed)
            violated = self._chance("violated", *own) < rate
            rho = (-0.3 if violated else 0.3) * (0.1 + 0.9 * self._chance("rho", *own))
            readings.append(Reading(name, Kind.SAFETY, rho, 7.0 if violated else None, 1, open=False))
            violations += [Violation(name, Kind.SAFETY, 7.0, 0.0, 1.0, 1.6, "")] * violated
        readings.append(Reading("OP1", Kind.OPERABILITY, 0.5, None, 1, open=False))
        return landed(study, flight, readings, violations, flight.name, mutated=flight.mutant is not None)

    def _chance(self, *words: object) -> float:
        return key_words("planted", self.search, *words)[0] / 2**64


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return small_study(tmp_path_factory.mktemp("planted"))


def searched(study: Study, folder: Path, number: int) -> finding.SeekReport:
    allowance, late = finding.Allowance(flights=FLIGHTS), realise(study.matrix, PLANTED_LATE)
    return sought(study, [late], folder, seed=number, allowance=allowance, flyer=Planted(number))


def test_at_most_one_search_in_a_hundred_finds_something_for_a_fault_that_does_nothing(study: Study, tmp_path: Path):
    reports = []
    for number in range(SEARCHES):
        reports.append(searched(study, tmp_path / str(number), number))
        shutil.rmtree(tmp_path / str(number))
    tested = sum(report.sought[0].candidates for report in reports)
    false = sum(bool(report.finds) for report in reports)
    assert tested >= SEARCHES // 4, "the confirmation is put to the test"
    assert false <= MOST * SEARCHES


REPLICATE_LATE, REPLICATE_MORE = "LATE-human@3s", "MORE-goal@1m"
SITUATION = "T0D0H1Cs=0.9"


@pytest.fixture
def own_study(tmp_path: Path) -> Study:
    return small_study(tmp_path / "study")


@pytest.fixture
def own_flyer(tmp_path: Path) -> Ruled:
    return Ruled(tmp_path / "flown.txt", {REPLICATE_LATE: fast, REPLICATE_MORE: never})


def again(
    own_study: Study, own_flyer: Ruled, *finds: Find, progress: Progress | None = None, into: str = "c"
) -> finding.SeekReport:
    ask = {find.name: list(find.shows) for find in finds}
    return finding.replicate(
        own_study, finds, ask, own_study.folder / into, progress=progress or quiet(), flyer=own_flyer
    )


@dataclass
class Failing(Ruled):
    """Fails in the harness in so many flights of each subject."""

    left: dict[str, int] = field(default_factory=dict)

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        outcome, left = super().__call__(study, flight), self.left.get(flight.subject.id, 0)
        self.left[flight.subject.id] = left - 1
        return replace(outcome, invalid="the bench broke", readings=(), violations=()) if left > 0 else outcome


def seeds(own_flyer: Ruled, subject: str) -> set[int]:
    return {int(name.rsplit("/", 1)[1]) for name in own_flyer.flown if name.startswith(subject)}


def test_each_pair_flies_on_ten_seeds_beside_thirty_baselines_that_nothing_used(own_study: Study, own_flyer: Ruled):
    report = again(own_study, own_flyer, found(REPLICATE_LATE, SITUATION, others=(REPLICATE_MORE,)))
    assert [(one.mutant, one.holds) for one in report.replicas] == [(REPLICATE_LATE, True), (REPLICATE_MORE, False)]
    assert (
        seeds(own_flyer, REPLICATE_LATE)
        == seeds(own_flyer, REPLICATE_MORE)
        == set(range(finding.FRESH, finding.FRESH + SEEDS))
    )
    assert seeds(own_flyer, "baseline") == set(range(finding.FRESH, finding.FRESH + POOL))
    assert (report.used, report.first) == (POOL + 2 * SEEDS, finding.FRESH)


def test_the_next_replication_has_other_seeds_in_the_same_campaign_in_another_and_with_an_older_file_of_finds(
    own_study: Study, own_flyer: Ruled
):
    find = found(REPLICATE_LATE, SITUATION)
    first, second = (again(own_study, own_flyer, find), again(own_study, own_flyer, find))
    assert (first.first, second.first) == (finding.FRESH, finding.FRESH + finding.BLOCK)
    (kept,) = finding.holding([find], first.replicas)
    assert again(own_study, own_flyer, kept, into="apart/c").first == finding.FRESH + finding.BLOCK
    assert again(own_study, own_flyer, find, into="d").first == finding.FRESH + 2 * finding.BLOCK


def test_with_many_invalid_flights_a_replication_decides_nothing_and_goes_on_with_its_seeds(
    own_study: Study, own_flyer: Ruled
):
    failing = Failing(own_flyer.path, own_flyer.rules, left={"baseline": 27})
    with pytest.raises(GateError, match=r"27 of 40 flights are invalid, more than 10%: baseline/.*\(the bench broke\)"):
        again(own_study, failing, found(REPLICATE_LATE, SITUATION))
    report = again(own_study, own_flyer, found(REPLICATE_LATE, SITUATION))
    assert [(one.holds, one.why) for one in report.replicas] == [(True, "")]
    assert (report.first, report.flown) == (finding.FRESH, 27)


@pytest.mark.parametrize("subject", ["baseline", REPLICATE_LATE])
def test_an_invalid_flight_decides_nothing_about_its_find_which_stays_as_it_was(
    own_study: Study, own_flyer: Ruled, subject: str
):
    find, failing = found(REPLICATE_LATE, SITUATION), Failing(own_flyer.path, own_flyer.rules, left={subject: 4})
    report = again(own_study, failing, find)
    assert [(one.holds, one.why) for one in report.replicas] == [(None, "4 of 40 flights are invalid")]
    assert finding.holding([find], report.replicas) == (find,)
    note = f"{find.name}: {REPLICATE_LATE} stays in sim/found.yaml: 4 of 40 flights are invalid; the same command flies"
    assert f"{note} it again." in replica_table(report).notes


def test_an_interrupted_replication_goes_on_with_its_seeds(own_study: Study, own_flyer: Ruled):
    with pytest.raises(Interrupted):
        again(own_study, own_flyer, found(REPLICATE_LATE, SITUATION), progress=dying(7, Interrupted("stopped")))
    report = again(own_study, own_flyer, found(REPLICATE_LATE, SITUATION))
    assert report.first == finding.FRESH
    assert report.flown < report.used


def test_what_does_not_hold_leaves_and_the_find_takes_the_name_of_what_does(own_study: Study, own_flyer: Ruled):
    find, left = found(REPLICATE_MORE, SITUATION, others=(REPLICATE_LATE,)), found("NO-depth@3s", "T0D0H0Cs=0.9")
    finding.saver(own_study.folder / "sim", "small")([find, left])
    finding.break_saver(own_study.folder / "sim", "small")([BAR])
    report = again(own_study, own_flyer, find, left)
    kept = finding.holding([find, left], report.replicas)
    finding.keep(own_study.folder / "sim", "small", kept)
    written = read_finds(own_study.folder / "sim")
    assert [(one.name, one.mutant, list(one.shows)) for one in written.finds] == [
        (f"shows-{REPLICATE_LATE}", REPLICATE_LATE, [REPLICATE_LATE])
    ]
    assert written.breaks == (BAR,)
    told = written.finds[0].shows[REPLICATE_LATE].again
    assert (told.seed, told.violated, told.flights, told.baselines) == (finding.FRESH, SEEDS, SEEDS, POOL)
    assert told.p == pytest.approx(report.replicas[1].again.p, rel=1e-3)


def test_what_was_not_replicated_stays_and_a_name_that_is_taken_is_not_given_twice(own_study: Study, own_flyer: Ruled):
    find, other = found(REPLICATE_MORE, SITUATION, others=(REPLICATE_LATE,)), found(REPLICATE_LATE, "T0D1H1Cs=0.9")
    report = again(own_study, own_flyer, find)
    kept = finding.holding([find, other], report.replicas)
    assert [(one.name, one.mutant) for one in kept] == [
        (f"shows-{REPLICATE_LATE}", REPLICATE_LATE),
        (f"shows-{REPLICATE_MORE}", REPLICATE_LATE),
    ]
    assert kept[0] == other
