"""The page of the missing requirements: made from what was found, registered before, and flown again in a sample."""

from __future__ import annotations

import json

import pytest

from experiments import PUBLISHED, ROOT
from experiments.missing_requirements import NAME, REDRAWS, SEEDS, SITUATIONS, results
from experiments.pages import registered
from scaloft_fi.campaign.flights.fly import Flight, fly_log
from scaloft_fi.judge.requirement import Kind, Requirement, judge
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study
from scaloft_fi.verbs.propose import drawn

TOLD = json.loads((PUBLISHED / f"{NAME}.json").read_bytes())


def test_the_page_is_made_from_what_was_found_behind_its_registered_plan():
    page = (PUBLISHED / f"{NAME}.md").read_text()
    assert page == registered(NAME) + results(Study.open(ROOT), 1, PUBLISHED)


def test_every_survivor_and_every_redraw_is_reported_once_and_no_redraw_is_confirmed():
    named = {
        part: [*(one["mutant"] for one in told["proposals"]), *told["same"], *told["none"]]
        for part, told in TOLD.items()
    }
    assert {part: (len(ids), len(set(ids))) for part, ids in named.items()} == {
        "survivors": (64, 64),
        "redraws": (REDRAWS, REDRAWS),
    }
    assert not any(one["confirmed"] for one in TOLD["redraws"]["proposals"])
    assert all(one["p"] <= 0.01 for one in TOLD["survivors"]["proposals"] if one["confirmed"])
    assert {one["shown"]["whole"] for one in TOLD["survivors"]["proposals"]} == {SEEDS * SITUATIONS}


@pytest.mark.release
@pytest.mark.flight
def test_fresh_flights_violate_a_proposal_as_published_and_the_unmutated_drone_holds_it():
    study = Study.open(ROOT)
    told = next(one for one in TOLD["survivors"]["proposals"] if one["shown"]["part"] == SEEDS * SITUATIONS)
    proposal = Requirement("proposal", Kind.REPORTED, told["formula"], told["trigger"], unit=told["unit"])
    keys = [situation.key for situation in study.grid.situations]
    key = drawn(told["mutant"], keys, SITUATIONS)[0]
    for mutant, violated in ((realise(study.matrix, told["mutant"]), True), (None, False)):
        log = fly_log(study, Flight(mutant, study.grid.situation(key), 50))
        assert judge(proposal, log).violated is violated
