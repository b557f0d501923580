"""The search for what breaks the unmutated drone, by a drone whose robustness and beliefs follow a rule."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from finding import Ruled, breached, everywhere, number, small_study
from running import PowerError, dying, quiet

from scaloft_fi.analysis.detection import LEAST
from scaloft_fi.analysis.seeking import WORST, Breach
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.seeking.breaks import seek_breaks
from scaloft_fi.campaign.seeking.finds import SEEN_ON, Allowance, SeekReport
from scaloft_fi.campaign.seeking.seek import GENERATION, OPENING, Proposal, Proposals
from scaloft_fi.errors import ScaloftError
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.sim.grid import Break
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import Study


def robustness(situation: Situation) -> float:
    """Violated where a person is, with speed or in the dark."""
    if situation["H"] != 1:
        return 0.5
    return -0.2 if situation["D"] == 1 else 0.8 - number(situation, "Cs", 0.5)


def ways(study: Study, flight: Flight, violations: Sequence[Violation]) -> tuple[Breach, ...]:
    """In the dark the person is missed; with speed no belief is wrong; missions that turn fail on another leg."""
    leg = ("home to corner", "corner to end")[flight.situation["T"]]
    return breached(violations, "person detection" if flight.situation["D"] == 1 else "", leg)


Search = Callable[..., tuple[SeekReport, list[Break]]]


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return small_study(tmp_path_factory.mktemp("study"))


@pytest.fixture(scope="module")
def search(study: Study) -> Search:
    def searching(folder: Path, flyer: Any, *, seed: int = 0, **more: Any) -> tuple[SeekReport, list[Break]]:
        saved: list[Break] = []

        def save(breaks: Sequence[Break]) -> None:
            saved[:] = breaks

        report = seek_breaks(
            study,
            folder / "c",
            RunOptions(jobs=more.get("jobs", 1)),
            seed=seed,
            allowance=Allowance.parse(more.get("budget", "150flights")),
            progress=more.get("progress", quiet()),
            save=save,
            flyer=flyer,
            recall=more.get("recall", ways),
        )
        return report, saved

    return searching


@dataclass(frozen=True)
class Whole:
    """A search that nothing disturbed."""

    report: SeekReport
    saved: list[Break]
    flown: list[str]


@pytest.fixture(scope="module")
def whole(search: Search, tmp_path_factory: pytest.TempPathFactory) -> Whole:
    folder = tmp_path_factory.mktemp("whole")
    flyer = Ruled(folder / "flown.txt", baseline=robustness)
    report, saved = search(folder, flyer)
    return Whole(report, saved, flyer.flown)


@pytest.fixture
def flyer(tmp_path: Path) -> Ruled:
    return Ruled(tmp_path / "flown.txt", baseline=robustness)


def test_every_way_is_found_once_shrunk_and_told_in_words(whole: Whole):
    assert tuple(whole.saved) == whole.report.breaks
    found = {one.name: one for one in whole.saved}
    assert len(found) == len(whole.saved)
    assert {(one.leg, one.belief): (one.situation, one.words) for one in whole.saved if one.belief} == {
        ("home to corner", "person detection"): ("T0D1H1", ("dark", "human")),
        ("corner to end", "person detection"): ("T1D1H1", ("corner", "dark", "human")),
    }
    for leg, key in (("home_to_corner", "T0D0H1Cs="), ("corner_to_end", "T1D0H1Cs=")):
        assert found[f"breaks-SR2-person-{leg}-near_corner-no_belief"].situation.startswith(key)
    dark = found["breaks-SR2-person-home_to_corner-near_corner-person_detection"]
    assert (dark.requirement, dark.struck, dark.near, dark.error, dark.unit) == ("SR2", "person", "corner", 1.5, "m")
    assert (dark.violated, dark.flights, dark.alike) == (10, 10, 10)
    assert (dark.flight, dark.t_s, dark.seed) == (0, 7.0, 0)


def test_it_is_confirmed_on_seeds_that_the_search_never_flew(whole: Whole):
    assert {name.split("/")[0] for name in whole.flown} == {"baseline"}
    assert {int(name.rsplit("/", 1)[1]) for name in whole.flown} == {*SEEN_ON, *range(10)}
    confirming = {name.split("/")[1] for name in whole.flown if int(name.rsplit("/", 1)[1]) < 10}
    assert confirming >= {one.situation for one in whole.saved}


def test_what_was_found_repels_the_search(
    search: Search, tmp_path: Path, flyer: Ruled, monkeypatch: pytest.MonkeyPatch
):
    told: dict[str, dict[Situation, float]] = {}
    guided: list[Situation] = []

    class Spied(Proposals):
        def __init__(self, *arguments: Any) -> None:
            super().__init__(*arguments)
            self.told = told.setdefault(arguments[3], {})

        def ask(self, count: int) -> list[Proposal]:
            asked = super().ask(count)
            if self.told is told["baseline SR2"]:
                guided.extend(one.situation for one in asked)
            return asked

        def tell(self, distances: Sequence[tuple[Proposal, float]]) -> None:
            super().tell(distances)
            self.told.update((one.situation, distance) for one, distance in distances)

    def red(situation: Situation) -> bool:
        return situation["D"] == 1 and situation["T"] == 0

    monkeypatch.setattr("scaloft_fi.campaign.seeking.breaks.Proposals", Spied)
    flyer.baseline = lambda one: -0.2 if red(one) else 0.1 if one["T"] == 1 and one["H"] == 1 else 0.5
    report, _ = search(tmp_path, flyer)
    assert len(report.breaks) == 1
    assert list(told) == ["baseline SR1", "baseline SR2"]
    assert {(red(one), distance == WORST) for one, distance in told["baseline SR2"].items()} == {
        (True, True),
        (False, False),
    }
    assert len(told["baseline SR2"]) == report.situations > OPENING
    assert len(guided) >= 2 * GENERATION
    assert sum(map(red, guided)) <= len(guided) / 8  # a quarter of the grid is red


def test_what_most_fresh_seeds_do_not_violate_is_no_find(search: Search, tmp_path: Path, flyer: Ruled):
    flyer.baseline, flyer.noise = (lambda _situation: 0.05), 0.1  # it violates in a quarter of its flights
    report, _ = search(tmp_path, flyer, budget="80flights")
    assert report.broken > 0
    assert report.breaks == ()


@pytest.mark.parametrize(("reds", "violated"), [(5, None), (6, 6), (10, 10)])
def test_more_than_half_of_the_fresh_seeds_must_violate(
    search: Search, tmp_path: Path, reds: int, violated: int | None
):
    class Lucky(Ruled):
        def __call__(self, study: Study, flight: Flight) -> Outcome:
            red = flight.seed in SEEN_ON or flight.seed < reds
            return Ruled(self.path, baseline=lambda _: -0.2 if red else 0.4)(study, flight)

    lucky = Lucky(tmp_path / "flown.txt")
    report, _ = search(tmp_path, lucky, budget="50flights", recall=lambda _study, _flight, told: breached(told))
    assert [one.violated for one in report.breaks] == ([] if violated is None else [violated])


@pytest.mark.parametrize(("same", "found"), [(2, False), (3, True)])
def test_three_of_the_fresh_seeds_must_do_so_in_the_same_way(
    search: Search, tmp_path: Path, flyer: Ruled, same: int, found: bool
):
    def by_seed(_study: Study, flight: Flight, violations: Sequence[Violation]) -> tuple[Breach, ...]:
        usual = flight.seed in SEEN_ON or flight.seed >= LEAST - same
        return breached(violations, "person" if usual else f"{flight.seed}")

    flyer.baseline = everywhere
    report, _ = search(tmp_path, flyer, budget="60flights", recall=by_seed)
    told = [(one.belief, one.violated, one.alike, one.flight) for one in report.breaks]
    assert told == ([("person", 10, same, 7)] if found else [])


def test_shrinking_keeps_the_signature(search: Search, tmp_path: Path, flyer: Ruled):
    def by_speed(_study: Study, flight: Flight, violations: Sequence[Violation]) -> tuple[Breach, ...]:
        return breached(violations, "velocity" if number(flight.situation, "Cs", 0.5) >= 0.8 else "person")

    flyer.baseline = everywhere
    report, _ = search(tmp_path, flyer, budget="100flights", recall=by_speed)
    found = {one.belief: one.situation for one in report.breaks}
    assert found["person"] == "T0D0H0"
    assert found["velocity"].startswith("T0D0H0Cs=")
    assert 0.8 <= float(found["velocity"].partition("=")[2]) < 0.95


def test_the_same_seed_makes_the_same_finds_whatever_the_jobs(
    whole: Whole, search: Search, tmp_path: Path, flyer: Ruled
):
    assert search(tmp_path / "b", flyer, jobs=3)[0] == whole.report
    assert search(tmp_path / "d", flyer, seed=1)[0].breaks != whole.report.breaks


def test_a_search_that_dies_goes_on_where_it_stopped(whole: Whole, search: Search, tmp_path: Path, flyer: Ruled):
    with pytest.raises(PowerError):
        search(tmp_path, flyer, progress=dying(60))
    resumed, saved = search(tmp_path, flyer)
    assert resumed.breaks == whole.report.breaks == tuple(saved)
    assert resumed.used == whole.report.used
    assert resumed.flown < whole.report.flown
    assert sorted(set(flyer.flown)) == sorted(whole.flown)


def test_flights_that_are_flown_again_are_of_the_budget(search: Search, tmp_path: Path, flyer: Ruled):
    report, _ = search(tmp_path, flyer, budget="60flights")
    assert report.spent
    assert report.used == report.flown + report.again <= 60
    assert report.again > 0


def test_a_flight_that_cannot_be_flown_again_says_nothing(search: Search, tmp_path: Path, flyer: Ruled):
    def failing(study: Study, flight: Flight, violations: Sequence[Violation]) -> tuple[Breach, ...]:
        raise MemoryError

    report, _ = search(tmp_path, flyer, budget="40flights", recall=failing)
    assert report.broken > 0
    assert report.breaks == ()


def test_a_claim_that_fails_ends_the_search(search: Search, tmp_path: Path, flyer: Ruled):
    def wrong(study: Study, flight: Flight, violations: Sequence[Violation]) -> tuple[Breach, ...]:
        raise ScaloftError("claim 'map': error=nan must be a finite number")

    with pytest.raises(ScaloftError, match="claim 'map'"):
        search(tmp_path, flyer, budget="40flights", recall=wrong)
