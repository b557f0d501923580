from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pytest
from builders import GRID, outcome

from experiments import PUBLISHED, ROOT, more_goal
from experiments.flights import Beside, Varied, flights_of, shared
from experiments.flights import flown as flown_beside
from experiments.more_goal import ARMS, AS_IT_IS, FLIGHTS, MUTANTS, NAMES, NOT_TURNING, STRICT, Arm, flown
from experiments.pages import registered
from scaloft_fi.analysis.detection import ALPHA, Stratum, p_value
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

pytestmark = pytest.mark.release
"""A page of the past is recomputed before a release."""

CORNER = "T1O0W0D0H0"
Told = Mapping[tuple[Arm, str, str], dict[str, float]]
"""Violations by arm, subject and situation."""


def campaign(told: Told) -> dict[str, dict[str, Outcome]]:
    flights: dict[str, dict[str, Outcome]] = {}
    for arm in ARMS:
        for name in NAMES:
            subject, key, seed = name.split("/")
            violated = told.get((arm, subject, key), {})
            made = outcome(subject, key, int(seed), violated=violated, struck="wall" if "SR1" in violated else "")
            flights.setdefault(arm.name, {})[name] = replace(made, track=b"", perceived_digest="")
    return flights


def page(told: Told) -> str:
    return flown(campaign(told), {f"baseline/{CORNER}/0": "clean", f"baseline/{CORNER}/1": "another"}, GRID)


@pytest.fixture(scope="module")
def striking() -> str:
    """Without turning first at 0.5 m/s MORE-goal@1m strikes the wall in the corner, and a baseline violates SR2."""
    told = {
        (NOT_TURNING, "MORE-goal@1m", CORNER): {"SR1": 28.0},
        (NOT_TURNING, BASELINE, "T1O1W0D0H1"): {"SR2": 30.0},
        (ARMS[2], BASELINE, "T1O1W0D0H1"): {"SR1": 31.0},
    }
    return page(told)


def test_the_arms_are_the_ladder_with_and_without_turning_first_at_three_speeds():
    ladder = [mutant.id for mutant in Study.open(ROOT).catalogue if mutant.cell == "MORE-goal"]
    assert list(MUTANTS) == ladder
    assert FLIGHTS == 2 * 3 * (len(ladder) + 1) * 16 * 10 == 4800
    plan = registered("more_goal")
    assert f"= {FLIGHTS:,};" in plan
    assert f"{ALPHA:g} / {len(ARMS) * len(MUTANTS)} = {STRICT:.2g}:" in plan
    assert len(set(NAMES)) * len(ARMS) == FLIGHTS


def test_the_plan_tells_the_least_numbers_of_violations_that_show_a_fault():
    for situations, violated in ((1, 9), (2, 6), (6, 2)):
        p, less = (2 * p_value([Stratum(k, 10, 0, 10)] * situations) for k in (violated, violated - 1))
        assert p <= STRICT < less


def test_a_magnitude_that_strikes_in_one_situation_is_shown_and_masked_at_that_speed_only(striking: str):
    shown = "- MORE-goal@1m is shown by SR1 in *not turning first, 0.5 m/s*, as the paper saw it (p = 1.1e-05; firm)."
    assert shown in striking
    assert striking.count("is shown by") == 1
    assert "- At 0.5 m/s turning first masks MORE-goal@1m." in striking
    assert "- At 1 m/s turning first is not shown to mask any magnitude." in striking


def test_a_magnitude_that_is_detected_with_turning_first_too_is_not_masked():
    told = {(arm, "MORE-goal@1m", CORNER): {"SR1": 28.0} for arm in (AS_IT_IS, NOT_TURNING)}
    text = page(told)
    assert text.count("MORE-goal@1m is shown by SR1") == 2
    assert "- At 0.5 m/s turning first is not shown to mask any magnitude." in text


def test_without_a_violation_nothing_is_shown_and_the_baselines_permit_the_change():
    text = page({})
    assert "- MORE-goal is shown in no arm." in text
    assert "SR1 160 against 160, SR2 160 against 160, OP1 160 against 160 of 160: the clean baselines justify" in text


def test_one_requirement_that_fewer_baselines_hold_keeps_the_stack(striking: str):
    assert "SR1 160 against 160, SR2 150 against 160, OP1 160 against 160 of 160: the stack stays as it is." in striking


def test_no_rule_is_decided_while_a_flight_is_missing_or_invalid():
    flights = campaign({})
    name, own = next(iter(flights[AS_IT_IS.name].items()))
    flights[AS_IT_IS.name][name] = replace(own, invalid="it hung")
    for unfinished in (flown(flights, {}, GRID), flown({}, {}, GRID)):
        assert "no rule is decided" in unfinished
        assert "the stack stays" not in unfinished
        assert "no arm" not in unfinished


@pytest.mark.flight
def test_flights_that_share_a_baseline_with_changed_numbers_have_the_digests_of_whole_flights():
    arm = Arm(turns_first=False, cruise_mps=1.2)
    study = Varied(ROOT, overrides=arm.overrides)
    mutants = {name: realise(study.matrix, name) for name in MUTANTS}
    names = [f"{subject}/T0O0W0D0H0/0" for subject in (BASELINE, "MORE-goal@1m", "MORE-goal@3m")]
    found = {o.name: o.digest for o in shared(study, flights_of(study, mutants, names), 1)}
    whole = flown_beside(Beside(ROOT, dict(arm.overrides), "T0O0W0D0H0", 0, ("MORE-goal@1m", "MORE-goal@3m")))
    assert found == {o.name: log.digest for o, log in whole}
    assert len(set(found.values())) == 3


def test_the_published_page_is_that_of_the_published_flights():
    made = more_goal.results(Study.open(ROOT), 1, PUBLISHED)
    assert registered("more_goal") + made == (PUBLISHED / "more_goal.md").read_text()
