from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from experiments.bug_stacks import BUGS, Bug, StackStudy, declare
from experiments.bugs import (
    FLIGHTS,
    REFERENCE,
    SEEDS,
    Coupling,
    Published,
    campaign_of,
    coupling,
    detecting_share,
    flown,
    fly,
    mean_excess,
    names_of,
    relabelled_p,
    samples,
    tail,
    verdict,
)
from experiments.flights import Flights, outcomes, published, read
from experiments.pages import registered
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.flights.fly import fly_log
from scaloft_fi.hazop.matrix import CellStatus
from scaloft_fi.judge.outcome import BASELINE, Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[2]
PUBLISHED = ROOT / "results" / "published"
PLAN = registered("bugs")
SOUGHT = 6
"""How many of the bugs, at the end, were looked for besides: in cells whose mutant has published kills."""
NAMES = frozenset(f"s{number:02}" for number in range(24))
EIGHT = frozenset(sorted(NAMES)[:8])
BY_KEY = {bug.key: bug for bug in BUGS}


@pytest.fixture(scope="module")
def study() -> Study:
    return Study.open(ROOT)


@pytest.fixture(scope="module")
def campaign(study: Study) -> list[Outcome]:
    return outcomes(study, published())


@pytest.fixture(scope="module")
def seen(study: Study) -> Published:
    return campaign_of(study, published())


def _as_bug(campaign: list[Outcome], mutant: str) -> dict[str, Outcome]:
    """The published flights of a subject, as if they were a bug's."""
    renamed = [replace(o, subject=Subject(BASELINE)) for o in campaign if o.mutant == mutant and o.seed in SEEDS]
    return {outcome.name: outcome for outcome in renamed}


def _struck(flights: dict[str, Outcome], situations: frozenset[str]) -> dict[str, Outcome]:
    """The same flights, but all in these situations violate SR1."""
    violation = Violation("SR1", Kind.SAFETY, 1.0, 0.0, 0.0, 0.0, "wall")
    return {
        name: replace(o, violations=(violation,), digest="other") if o.situation in situations else o
        for name, o in flights.items()
    }


def test_each_bug_names_its_thread_and_a_credible_cell(study: Study) -> None:
    credible = {cell.name for cell in study.matrix if cell.status is CellStatus.CREDIBLE}
    assert len(BY_KEY) == len(BUGS) == 14
    assert {bug.cell for bug in BUGS} <= credible
    for bug in BUGS:
        number = bug.key.rsplit("-", 1)[1]
        (about,) = [stage.__doc__ for stage in vars(bug.parts).values() if hasattr(stage, "defect")]
        assert number in about
        (row,) = re.findall(rf"^\| {bug.key} \|.*$", PLAN, re.MULTILINE)
        assert f"/{number})" in row
        assert f"| {bug.cell} |" in row


def test_the_bugs_that_were_sought_are_in_cells_whose_mutant_has_kills(seen: Published) -> None:
    assert all(seen.killing(bug.cell) for bug in BUGS[-SOUGHT:])


def test_the_defect_of_a_bug_stands_in_exactly_one_stage() -> None:
    for bug in BUGS:
        stages = [getattr(bug.parts, name) for name in bug.parts.__dataclass_fields__]
        mended = [getattr(bug.mended, name) for name in bug.parts.__dataclass_fields__]
        assert [stage.defect for stage in stages if hasattr(stage, "defect")] == [True]
        assert [stage.defect for stage in mended if hasattr(stage, "defect")] == [False]


@pytest.fixture(scope="module")
def free_flight(study: Study) -> Flight:
    return Flight(None, study.grid.situation("T0O0W0D0H0"), 0)


@pytest.fixture(scope="module")
def flown_free(study: Study, free_flight: Flight) -> str:
    """Digest of the reference stack."""
    return fly_log(study, free_flight).digest


@pytest.mark.flight
@pytest.mark.parametrize("bug", BUGS, ids=lambda bug: bug.key)
def test_with_its_defect_off_a_bug_flies_as_the_reference_stack(bug: Bug, free_flight: Flight, flown_free: str) -> None:
    declare()
    assert fly_log(StackStudy(ROOT, stack_name=f"{bug.key}-mended"), free_flight).digest == flown_free


@pytest.mark.flight
def test_the_defect_changes_the_flight_where_it_is_on(study: Study) -> None:
    declare()
    flight = Flight(None, study.grid.situation("T0O0W0D0H1"), 0)
    copy = StackStudy(ROOT, stack_name="px4-11764")
    assert fly_log(copy, flight).digest != fly_log(study, flight).digest


@pytest.mark.flight
def test_kept_flights_are_not_flown_again(study: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    declare()
    path = tmp_path / "flights.jsonl.gz"
    first = fly(study, [BY_KEY["px4-11840"]], ["T0O0W0D0H1"], path, 1)
    assert set(first["px4-11840"]) == set(names_of(["T0O0W0D0H1"]))
    assert "3 flights" in capsys.readouterr().err
    again = fly(study, [BY_KEY["px4-11840"]], ["T0O0W0D0H1"], path, 1)
    assert "flights" not in capsys.readouterr().err
    assert {name: o.digest for name, o in again["px4-11840"].items()} == {
        name: o.digest for name, o in first["px4-11840"].items()
    }
    assert read(path).keys() == {"px4-11840", REFERENCE}


def test_a_bug_that_the_killing_situations_alone_detect_is_coupled() -> None:
    bug = Coupling("a", EIGHT, EIGHT)
    assert bug.excess(NAMES) == pytest.approx(1 - 8 / 24)
    assert bug.p(NAMES) == tail(24, 8, 8, 8) < 1e-5
    assert relabelled_p([bug], NAMES) == pytest.approx(1e-4)


def test_a_bug_that_every_situation_or_none_detects_says_nothing() -> None:
    for alone in (NAMES, frozenset[str]()):
        bug = Coupling("a", EIGHT, alone)
        assert bug.excess(NAMES) == 0.0
        assert bug.p(NAMES) == 1.0
        assert relabelled_p([bug], NAMES) == 1.0


def test_bugs_with_the_same_flights_have_one_vote() -> None:
    hit, miss = Coupling("a", EIGHT, EIGHT), Coupling("b", EIGHT, NAMES - EIGHT)
    twice = [replace(hit, weight=0.5), replace(hit, weight=0.5), miss]
    assert mean_excess(twice, NAMES) == pytest.approx(mean_excess([hit, miss], NAMES))
    assert relabelled_p(twice, NAMES) == relabelled_p([hit, miss], NAMES)


def test_sets_with_the_same_situations_are_relabelled_together() -> None:
    few = frozenset(sorted(EIGHT)[:4])
    alone, both = (relabelled_p([Coupling(key, EIGHT, few) for key in keys], NAMES) for keys in ("a", "ab"))
    assert alone == both


def test_a_share_of_sets_is_exact_where_there_are_few() -> None:
    assert detecting_share(lambda chosen: "s00" in chosen, EIGHT, 3, "x") == pytest.approx(3 / 8)
    drawn = detecting_share(lambda chosen: "s00" in chosen, NAMES, 8, "x")
    assert drawn == detecting_share(lambda chosen: "s00" in chosen, NAMES, 8, "x") == pytest.approx(1 / 3, abs=0.06)


def test_three_violations_in_a_situation_that_tests_detect_alone(seen: Published, campaign: list[Outcome]) -> None:
    clean, bug = _as_bug(campaign, BASELINE), BY_KEY["px4-11764"]
    chosen = frozenset(sorted(seen.killing(bug.cell))[:2])
    red = frozenset(seen.pool.flown - seen.tested)
    own = samples(_struck(clean, chosen | red).values(), clean)
    assert coupling(bug, own, seen, 1).alone == chosen


def test_flights_of_the_reference_stack_detect_nothing(seen: Published, campaign: list[Outcome]) -> None:
    clean = _as_bug(campaign, BASELINE)
    own = samples(clean.values(), clean)
    assert not any(sample.infected for sample in own.values())
    assert verdict("none", own, seen, own).verdict.words == "not tested"


def test_a_cells_own_mutant_taken_for_its_bug_is_detected_where_it_is_killed(
    seen: Published, campaign: list[Outcome]
) -> None:
    bug = BY_KEY["px4-11764"]
    own = samples(_as_bug(campaign, "NO-speedlimit").values(), _as_bug(campaign, BASELINE))
    assert coupling(bug, own, seen, 1).alone >= seen.killing(bug.cell)


def test_the_page_tells_yes_and_no_by_its_rules(seen: Published, campaign: list[Outcome]) -> None:
    clean = _as_bug(campaign, BASELINE)
    nothing: Flights = {REFERENCE: clean} | {bug.key: clean for bug in BUGS}
    page = flown(BUGS, nothing, seen)
    assert "**These bugs do not show that killing situations" in page
    assert "0 of 96 flights of the reference stack violate other requirements than the published ones." in page
    assert "Bit-identical flights: " + " and ".join(bug.key for bug in BUGS) in page
    assert page.count("no situation detects it") == sum(bool(seen.killing(bug.cell)) for bug in BUGS) == 8
    hit: Flights = {REFERENCE: clean} | {bug.key: _struck(clean, seen.killing(bug.cell)) for bug in BUGS}
    page = flown(BUGS, hit, seen)
    assert "**Yes: killing situations" in page
    assert page.count("| yes |") == 8


def test_the_plan_counts_its_flights() -> None:
    assert (len(BUGS) + 1) * len(list(names_of(str(number) for number in range(32)))) == FLIGHTS
    assert f"= {FLIGHTS:,}.\n" in PLAN


@pytest.mark.release
def test_the_published_page_is_that_of_the_published_flights(study: Study) -> None:
    page = PLAN + flown(BUGS, read(PUBLISHED / "bugs_flights.jsonl.gz"), campaign_of(study, published()))
    assert page == (PUBLISHED / "bugs.md").read_text(encoding="utf-8")
