from __future__ import annotations

import json
from dataclasses import replace

import pytest
from builders import GRID, ROSTER, campaigns, outcome
from hypothesis import given, settings

from scaloft_fi.results.kills.background import Background, backgrounds
from scaloft_fi.results.kills.kill_matrix import kill_matrix
from scaloft_fi.results.kills.survivors import Next, Rung, Survivor, survivors
from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.scoring.score import score
from scaloft_fi.results.track import TRACK_COLUMNS, pack_track
from scaloft_fi.study import Study

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
HUMAN, NOBODY, DARK = "T0O0W0D0H1", "T0O0W0D0H0", "T1O0W0D1H0"
STRONGER = "LATE-human@5s"
LATE_FAULT = Background("person", ("SR2",), stronger=(STRONGER,), laddered=True)


def rho(flight: Outcome, **values: float) -> Outcome:
    """The flight with other robustness."""
    return replace(flight, readings=tuple(replace(r, rho=values.get(r.requirement, r.rho)) for r in flight.readings))


def vacuous(flight: Outcome, requirement: str) -> Outcome:
    return replace(
        flight,
        readings=tuple(replace(r, triggered=0) if r.requirement == requirement else r for r in flight.readings),
    )


def along(flight: Outcome, x_m: float) -> Outcome:
    """The flight on a straight way north, from half of it on `x_m` east of the corridor's middle."""
    signals = {name: [0.0] * 400 for name in TRACK_COLUMNS}
    signals |= {
        "elapsed_s": [i / 20 for i in range(400)],
        "x_m": [0.0] * 200 + [x_m] * 200,
        "y_m": [i / 40 for i in range(400)],
    }
    return replace(flight, track=pack_track(signals))


def told(flights: list[Outcome], background: Background = LATE_FAULT, mutant: str = LATE) -> Survivor:
    known = dict.fromkeys([flight.mutant for flight in flights], Background("other"))
    found = survivors(
        flights,
        kill_matrix(score(flights, ROSTER, GRID), ROSTER, GRID),
        {**known, mutant: background},
        {"SR1": "m", "SR2": "share of the limit"},
    )
    return next(survivor for survivor in found if survivor.mutant == mutant)


BASELINES = [outcome(BASELINE, HUMAN), outcome(BASELINE, NOBODY)]


def test_a_killed_mutant_is_no_survivor() -> None:
    flights = [*BASELINES, outcome(LATE, HUMAN, violated={"SR2": 9.0})]
    assert survivors(flights, kill_matrix(score(flights, ROSTER, GRID), ROSTER, GRID), {LATE: LATE_FAULT}) == ()


def test_a_mutant_of_which_no_flight_counts_is_to_be_flown_again() -> None:
    found = told([*BASELINES, outcome(LATE, HUMAN, invalid="the worker died")])
    assert (found.rung, found.next) == (Rung.HARNESS, Next.REPEAT)


def test_what_was_declared_beforehand_is_told_with_its_reason() -> None:
    background = replace(LATE_FAULT, expected="the mission is too short")
    found = told([*BASELINES, outcome(LATE, HUMAN, altered=0)], background)
    assert (found.rung, found.next) == (Rung.INFECT, Next.EXPECTED)
    assert "the mission is too short" in found.why


def test_what_was_declared_and_infects_all_the_same_is_judged_as_any_other() -> None:
    found = told([*BASELINES, outcome(LATE, HUMAN)], replace(LATE_FAULT, expected="the mission is too short"))
    assert found.next is not Next.EXPECTED


def test_a_seam_that_carries_elsewhere_names_the_situation_to_fly() -> None:
    flights = [*BASELINES, outcome(LATE, NOBODY, carried=0, altered=0), outcome(NO, HUMAN)]
    listed = survivors(
        flights,
        kill_matrix(score(flights, ROSTER, GRID), ROSTER, GRID),
        {LATE: LATE_FAULT, NO: Background("person", ("SR2",))},
    )
    found = next(survivor for survivor in listed if survivor.mutant == LATE)
    assert (found.rung, found.next) == (Rung.REACH, Next.SITUATION)
    assert f"fly {HUMAN}." in found.why


def test_a_seam_that_carries_nowhere_says_how_much_of_the_grid_is_left() -> None:
    found = told([*BASELINES, outcome(LATE, NOBODY, carried=0, altered=0)])
    assert "31 situations of the grid were not flown" in found.why
    whole = [f for key in GRID.point for f in (outcome(BASELINE, key), outcome(LATE, key, carried=0, altered=0))]
    assert "no situation of the grid does: add one" in told(whole).why


def test_a_fault_that_changes_nothing_asks_for_a_situation_unless_a_stronger_one_does() -> None:
    weak = [*BASELINES, outcome(LATE, HUMAN, altered=0), outcome(LATE, NOBODY, carried=0, altered=0)]
    found = told(weak)
    assert (found.rung, found.next) == (Rung.INFECT, Next.SITUATION)
    assert "carries samples in human," in found.why
    found = told([*weak, outcome(STRONGER, HUMAN)])
    assert found.next is Next.MAGNITUDE
    assert STRONGER in found.why


def test_a_masked_fault_asks_for_a_larger_one_and_at_the_ladders_end_for_a_situation() -> None:
    masked = [*BASELINES, outcome(LATE, HUMAN, digest="clean")]
    assert (told(masked).rung, told(masked).next) == (Rung.PROPAGATE, Next.MAGNITUDE)
    assert "`scaloft-fi margin LATE-human`" in told(masked).why
    assert told(masked, replace(LATE_FAULT, stronger=())).next is Next.SITUATION


def test_where_the_baseline_holds_nothing_a_fault_cannot_show() -> None:
    red = outcome(BASELINE, DARK, violated={"SR1": 30.0}, struck="bar")
    lit = [f for key in (NOBODY, HUMAN, "T1O0W0D0H0") for f in (outcome(BASELINE, key), outcome(LATE, key, altered=0))]
    found = told([red, outcome(LATE, DARK), *lit])
    assert (found.rung, found.next) == (Rung.REVEAL, Next.SITUATION)
    assert "holds no safety requirement to its end: dark" in found.why


def test_broken_operability_asks_for_an_oracle_where_safety_is_at_risk() -> None:
    flights = [*BASELINES, outcome(LATE, HUMAN, violated={"OP1": 60.0}), outcome(LATE, NOBODY)]
    found = told(flights)
    assert (found.rung, found.next) == (Rung.REVEAL, Next.ORACLE)
    assert "breaks OP1 in 1 of 2 eligible situations" in found.why
    assert told(flights, replace(LATE_FAULT, at_risk=("OP1",))).next is Next.OPERABILITY


def test_a_requirement_that_nothing_triggers_where_the_fault_infects_asks_for_a_situation() -> None:
    flights = [vacuous(outcome(BASELINE, NOBODY), "SR2"), outcome(BASELINE, HUMAN), outcome(LATE, NOBODY)]
    found = told(flights)
    assert found.next is Next.SITUATION
    assert "SR2, which the cell puts at risk, is vacuous wherever it infects (triggered: human)" in found.why


def test_a_requirement_that_no_baseline_holds_asks_for_a_situation() -> None:
    found = told([outcome(BASELINE, HUMAN, violated={"SR2": 5.0}), outcome(LATE, HUMAN)])
    assert found.next is Next.SITUATION
    assert "is held by no baseline where it infects" in found.why


def test_a_near_miss_says_how_far_the_margin_fell() -> None:
    flights = [rho(BASELINES[0], SR1=0.31), BASELINES[1], rho(outcome(LATE, HUMAN), SR1=0.12), outcome(LATE, NOBODY)]
    found = told(flights)
    assert found.next is Next.MAGNITUDE
    assert f"Near miss: SR1 fell from 0.31 to 0.12 m in {HUMAN} (61 % of the margin)." in found.why
    assert found.loss is not None
    assert found.loss.share == pytest.approx(0.19 / 0.31)
    assert told(flights, replace(LATE_FAULT, stronger=())).next is Next.SITUATION


def test_far_off_its_path_with_whole_margins_asks_for_an_oracle() -> None:
    clean = [along(BASELINES[0], 0.0), BASELINES[1]]
    found = told([*clean, along(outcome(LATE, HUMAN), 0.6)])
    assert found.next is Next.ORACLE
    assert found.off_path_m == pytest.approx(0.6)
    near = told([*clean, along(outcome(LATE, HUMAN), 0.3)])
    assert near.next is Next.MAGNITUDE
    assert "at most 0.30 m off its path. No margin fell." in near.why


@settings(deadline=None, max_examples=60)
@given(campaigns())
def test_every_mutant_is_killed_or_told_once_in_the_order_of_the_rungs(outcomes: list[Outcome]) -> None:
    matrix = kill_matrix(score(outcomes, ROSTER, GRID), ROSTER, GRID)
    found = survivors(outcomes, matrix, {row.id: LATE_FAULT for row in matrix.mutants})
    assert sorted([*matrix.kills, *(s.mutant for s in found)]) == sorted(row.id for row in matrix.mutants)
    places = [list(Rung).index(survivor.rung) for survivor in found]
    assert places == sorted(places)
    assert all(survivor.why[0].isupper() and survivor.why.endswith(".") for survivor in found)
    json.dumps([survivor.to_json() for survivor in found], allow_nan=False)


def test_the_background_is_what_the_matrix_says() -> None:
    matrix = Study.open().matrix
    found = backgrounds(matrix, [LATE, "NO-speedlimit", "LESS-collision@0.5x", "AFTER-speedlimit"])
    assert found[LATE] == Background("person", ("SR2",), "", ("LATE-human@5s",), laddered=True)
    assert found["NO-speedlimit"].stronger == ()
    assert not found["NO-speedlimit"].laddered
    assert found["LESS-collision@0.5x"].stronger == ("LESS-collision@0.25x",)
    assert "never releases" in found["AFTER-speedlimit"].expected
