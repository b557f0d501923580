"""The distance of a situation from showing a fault."""

from __future__ import annotations

from dataclasses import replace

import pytest
from builders import outcome

from scaloft_fi.analysis.seeking import BEYOND, ROOM, WORST, breaking, distance, is_of_use, shown_by
from scaloft_fi.judge.outcome import Outcome


def readings(flown: Outcome, **rhos: float) -> Outcome:
    """The outcome with these robustnesses; what is not named is at 0.3."""
    return replace(flown, readings=tuple(replace(r, rho=rhos.get(r.requirement, 0.3)) for r in flown.readings))


def test_the_least_share_of_the_baselines_robustness_that_the_mutant_keeps_counts():
    mutant = readings(outcome("LATE-human@3s"), SR1=0.2, SR2=0.06)
    assert distance(mutant, readings(outcome())) == pytest.approx(0.2)
    assert distance(readings(outcome("LATE-human@3s")), readings(outcome())) == 1.0
    assert shown_by(mutant, readings(outcome())) == ()


def test_a_violation_shows_the_fault():
    mutant = readings(outcome("LATE-human@3s"), SR2=-0.2)
    assert distance(mutant, readings(outcome())) == pytest.approx(-2 / 3)
    assert shown_by(mutant, readings(outcome())) == ("SR2",)


@pytest.mark.parametrize("rho", [0.019, 0.0, -0.3, -9.0])
def test_a_baseline_without_room_moves_the_situation_away(rho):
    mutant, baseline = readings(outcome("LATE-human@3s"), SR2=-0.2), readings(outcome(), SR2=rho)
    assert distance(mutant, baseline) == 1.0  # by SR1, which the mutant holds as the baseline does
    without = [replace(one, readings=one.readings[1:]) for one in (mutant, baseline)]
    assert distance(*without) == pytest.approx(min(BEYOND, WORST + ROOM - rho))
    assert shown_by(mutant, readings(outcome(), SR2=rho)) == ()


def test_operability_and_reported_requirements_do_not_count():
    mutant = readings(outcome("LATE-human@3s"), **{"OP1": -1.0, "SR2-literal": -1.0})
    assert distance(mutant, readings(outcome())) == 1.0


def test_what_says_nothing_is_farthest():
    baseline, mutant = outcome(), readings(outcome("LATE-human@3s"), SR1=-0.2, SR2=-0.2)
    assert distance(None, baseline) == distance(mutant, None) == WORST
    assert distance(replace(mutant, altered=0), baseline) == WORST
    assert distance(replace(mutant, invalid="the worker died"), baseline) == WORST
    assert distance(mutant, outcome(violated={"SR1": 3.0}, struck="wall", vacuous=("SR2",))) > 0.0


def test_beside_a_baseline_without_room_no_mutant_need_be_flown():
    assert is_of_use(readings(outcome()))
    assert is_of_use(readings(outcome(), SR1=-0.3))
    assert not is_of_use(readings(outcome(), SR1=0.01, SR2=-0.3))
    assert not is_of_use(None)
    assert distance(None, readings(outcome(), SR1=0.01, SR2=-0.3)) == pytest.approx(WORST + 0.01)


def test_the_robustness_of_the_unmutated_drone_counts_requirement_by_requirement():
    baseline = readings(outcome(), SR1=0.2, SR2=-0.05)
    assert (breaking(baseline, "SR1"), breaking(baseline, "SR2")) == (0.2, -0.05)
    assert breaking(readings(outcome(), SR2=-9.0), "SR2") == -WORST
    untested = (None, replace(outcome(), invalid="the worker died"), outcome(vacuous=("SR2",)))
    assert [breaking(one, "SR2") for one in untested] == [WORST] * 3
