from __future__ import annotations

import re
from dataclasses import replace

import pytest

from experiments import PUBLISHED, ROOT
from experiments.bug_stacks import BUGS, WITHOUT, Parts, StackStudy, declare
from experiments.bugs import FLIGHTS, REFERENCE, SEEDS, Published, campaign_of, flown
from experiments.flights import Flights, names_of, outcomes, published, read
from experiments.pages import registered
from scaloft_fi.campaign.flights.fly import Flight, fly_log
from scaloft_fi.hazop.matrix import CellStatus
from scaloft_fi.judge.outcome import BASELINE, Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.study import Study

pytestmark = pytest.mark.release
"""A page of the past is recomputed before a release."""

PLAN = registered("bugs")
SOUGHT = 6
"""How many of the bugs, at the end, were looked for besides: in cells whose mutant has published kills."""
BY_KEY = {bug.key: bug for bug in BUGS}


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


def test_each_bug_names_its_thread_and_a_credible_cell(study: Study):
    credible = {cell.name for cell in study.matrix if cell.status is CellStatus.CREDIBLE}
    assert len(BY_KEY) == len(BUGS) == 14
    assert {bug.cell for bug in BUGS} <= credible
    for bug in BUGS:
        number = bug.key.rsplit("-", 1)[1]
        (stage,) = {*vars(bug.parts).values()} - {*vars(Parts()).values()} - {False}  # the defect is in one stage alone
        assert number in stage.__doc__
        (row,) = re.findall(rf"^\| {bug.key} \|.*$", PLAN, re.MULTILINE)
        assert f"/{number})" in row
        assert f"| {bug.cell} |" in row


def test_the_bugs_that_were_sought_are_in_cells_whose_mutant_has_kills(seen: Published):
    assert all(seen.killing(bug.cell) for bug in BUGS[-SOUGHT:])


@pytest.mark.flight
def test_without_a_defect_the_copies_fly_as_the_reference_stack(study: Study):
    declare()
    flight = Flight(None, study.grid.situation("T0O0W0D0H0"), 0)
    own = fly_log(study, flight).digest
    assert [fly_log(StackStudy(ROOT, stack_name=name), flight).digest for name in WITHOUT] == [own] * len(WITHOUT)


@pytest.mark.flight
def test_the_defect_changes_the_flight_where_it_is_on(study: Study):
    declare()
    flight = Flight(None, study.grid.situation("T0O0W0D0H1"), 0)
    copy = StackStudy(ROOT, stack_name="px4-11764")
    assert fly_log(copy, flight).digest != fly_log(study, flight).digest


def test_the_page_tells_yes_and_no_by_its_rules(seen: Published, campaign: list[Outcome]):
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


def test_the_plan_counts_its_flights():
    assert (len(BUGS) + 1) * len(names_of([BASELINE], map(str, range(32)), SEEDS)) == FLIGHTS
    assert f"= {FLIGHTS:,}.\n" in PLAN


def test_the_published_page_is_that_of_the_published_flights(study: Study):
    page = PLAN + flown(BUGS, read(PUBLISHED / "bugs_flights.jsonl.gz"), campaign_of(study, published()))
    assert page == (PUBLISHED / "bugs.md").read_text(encoding="utf-8")
