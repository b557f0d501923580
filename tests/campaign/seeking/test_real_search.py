"""A search in PyBullet: the flights of the paper's situations have the paper's digests, a search flies, and recalls."""

from __future__ import annotations

from pathlib import Path

import pytest
from finding import sought
from processes import ROOT

from scaloft_fi.campaign.flights.fly import Flight, fly_log, judged
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.seeking.breaks import ListeningWire, recalled
from scaloft_fi.campaign.seeking.finds import Allowance
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.sim.flight import fly
from scaloft_fi.study import Study

pytestmark = pytest.mark.flight


def test_the_search_grid_flies_the_papers_situations_bit_for_bit():
    fly, digests = Physics(), set()
    for study in (Study.open(ROOT), Study.open(ROOT, "search")):
        mutant = realise(study.matrix, "LATE-human")
        outcome = fly(study, Flight(mutant, study.grid.situation("T0O0W0D0H1"), 0))
        digests.add((outcome.digest, outcome.perceived_digest, outcome.altered))
    assert len(digests) == 1


@pytest.mark.release
def test_a_short_search_flies_what_its_budget_allows_and_resumes(tmp_path: Path):
    study = Study.open(ROOT, "search")
    mutants = [realise(study.matrix, "LATE-depth")]

    def search(budget: str) -> tuple[int, int]:
        report = sought(study, mutants, tmp_path / "c", allowance=Allowance.parse(budget))
        return report.used, report.flown

    used, flown = search("20flights")
    assert 0 < used == flown <= 20
    assert search("20flights") == (used, 0)


STUDY = Study.open(Path(__file__).parents[3])


def test_a_listener_changes_no_bit_and_hears_the_seams_that_it_asked_for():
    situation = STUDY.grid.situation("T0O0W0D0H0")
    wire = ListeningWire(["map", "velcmd", "imu"])
    heard = fly(STUDY.sim, situation, 0, wire)
    plain = fly_log(STUDY, Flight(None, situation, 0))
    assert (heard.digest, heard.perceived_digest) == (plain.digest, plain.perceived_digest)
    assert set(wire.kept) == {"map", "velcmd", "imu"}
    assert all(wire.kept.values())


def test_the_bar_is_struck_in_the_dark_because_the_map_lacks_it_and_the_person_is_missed():
    Physics().prepare(STUDY, lambda _: None)
    flight = Flight(None, STUDY.grid.situation("T1O0W0D1H1"), 0)
    outcome = judged(STUDY, flight, fly_log(STUDY, flight))
    violations = [one for one in outcome.violations if one.kind is Kind.SAFETY]
    fast, bar = recalled(STUDY, flight, violations)
    assert fast.signature.name == "breaks-SR2-nothing-home_to_corner-near_home-person_detection"
    assert bar.signature.name == "breaks-SR1-bar-corner_to_end-obstacle_map"
    assert fast.error > 1.5
    assert 0.2 < bar.error <= 1.0
    assert [one.t_s for one in (fast, bar)] == sorted(violation.t_s for violation in violations)
