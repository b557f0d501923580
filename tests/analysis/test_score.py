"""The score of a campaign, redraws of the unmutated drone, rosters and ratios."""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import product

import pytest
from builders import GRID, RANGED, ROSTER, campaigns, drawn, outcome, pool, seeded, subject_of
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.detection import Spending, Verdict
from scaloft_fi.analysis.kill_matrix import order
from scaloft_fi.analysis.roster import Ratio, Roster
from scaloft_fi.analysis.score import REDRAWS, Redraw, Score, admits, condition, cover, redraw, score
from scaloft_fi.hazop.matrix import Cell, CellStatus, Fault, Guideword, Magnitude, Matrix, Parameter
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Status
from scaloft_fi.views.output import plain

LATE, NO, GOAL, CONTROL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m", "REVERSE-human"
HUMAN = ["T0O0W0D0H1", "T0O1W0D0H1", "T1O0W0D0H1"]
NOBODY, DARK_CORNER = "T0O0W0D0H0", "T1O0W0D1H0"


def scored(*outcomes: Outcome) -> Score:
    return score(outcomes, ROSTER, GRID)


def campaign() -> list[Outcome]:
    """Two mutants and a control: with a person, without one, and in the dark where the unmutated drone strikes."""
    return [
        *pool(*HUMAN),
        *pool(NOBODY, vacuous=("SR2",)),
        *pool(DARK_CORNER, red=9, violated={"SR1": 30.0}, struck="bar"),
        *(outcome(LATE, key, violated={"SR2": 12.0}) for key in HUMAN),
        outcome(LATE, NOBODY, carried=0, altered=0),
        outcome(LATE, DARK_CORNER, violated={"SR1": 20.0}, struck="wall"),
        *(outcome(GOAL, key, violated={"OP1": 60.0}) for key in (*HUMAN, NOBODY)),
        *(outcome(CONTROL, key, violated={"SR1": 5.0}, struck="wall") for key in HUMAN),
        outcome(PLACEBO_ID, NOBODY, altered=0),
    ]


def test_kills_are_steady_pairs_where_most_flights_of_a_detected_mutant_violate():
    late, goal = scored(*campaign()).mutants
    assert [(kill.situation, kill.requirement) for kill in late.kills] == [(key, "SR2") for key in HUMAN]
    assert (late.kill_rate, late.kill_rate_flown) == (Ratio(3, 3), Ratio(3, 5))
    assert dict(late.requirements) == {"SR2": Ratio(3, 3)}
    assert (late.verdict, late.status) == (Verdict.DETECTED, Status.REVEALED)
    assert (late.first.requirement, late.first.t_s, late.first.situation) == ("SR2", 12.0, HUMAN[0])
    assert (goal.verdict, goal.kills, goal.kill_rate) == (Verdict.NOT_DETECTED, (), Ratio(0, 4))
    assert goal.operability.detected
    assert dict(goal.requirements) == {"OP1": Ratio(4, 4)}


def test_another_campaigns_baselines_make_a_pool():
    few = [one for one in campaign() if one.mutant != BASELINE or one.seed == 0]
    lent = [one for one in campaign() if one.mutant == BASELINE]
    found = score(few, ROSTER, GRID, None, lent)
    assert found.mutation_score == Ratio(1, 2)


def test_without_a_requirement_of_operability_its_ratio_is_of_none():
    outcomes = [*pool(*HUMAN), *(outcome(LATE, key, violated={"SR2": 12.0}) for key in HUMAN)]
    assert scored(*outcomes).operability == Ratio(0, 1)
    safe = [replace(one, readings=tuple(r for r in one.readings if r.requirement != "OP1")) for one in outcomes]
    assert (scored(*safe).mutation_score, str(scored(*safe).operability)) == (Ratio(1, 1), "0/0 = n/a")


def ratios(found: Score) -> list[Ratio]:
    return [found.exercised, found.infected, found.tested, found.mutation_score, found.operability]


@given(st.one_of(campaigns(), seeded()), st.randoms())
def test_the_score_ignores_the_order_of_outcomes(outcomes: list[Outcome], chance: random.Random):
    shuffled = chance.sample(outcomes, len(outcomes))
    one, other = score(outcomes, ROSTER, GRID), score(shuffled, ROSTER, GRID)
    assert (one.mutants, one.controls, one.placebo, ratios(one)) == (
        other.mutants,
        other.controls,
        other.placebo,
        ratios(other),
    )


@given(st.one_of(campaigns(), seeded()))
def test_statuses_sum_to_flights_and_fates_to_mutants(outcomes: list[Outcome]):
    found = score(outcomes, ROSTER, GRID)
    entries = [*found.mutants, *found.controls, *([found.placebo] if found.placebo else [])]
    assert sum(count for entry in entries for _, count in entry.statuses) == sum(o.mutant != BASELINE for o in outcomes)


@given(seeded())
def test_the_condition_is_true_where_it_kills(outcomes: list[Outcome]):
    for mutant in score(outcomes, ROSTER, GRID).mutants:
        assert bool(mutant.condition(GRID)) == bool(mutant.killing or mutant.seen_in)


def test_a_campaign_that_grew_is_scored_by_looks():
    outcomes = [*pool(HUMAN[0]), *(outcome(LATE, HUMAN[0], seed, violated={"SR2": 9.0}) for seed in range(3))]
    assert score(outcomes, ROSTER, GRID).mutants[0].detected
    assert not score(outcomes, ROSTER, GRID, Spending(0.01, frozenset({LATE}))).mutants[0].detected


KEYS = ["T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H0", "T0O0W0D1H1"]


def test_a_drone_that_never_violates_is_never_called_detected():
    assert redraw(pool(*KEYS, seeds=20), 3, 0.01) == Redraw(3, Ratio(0, REDRAWS), Ratio(0, REDRAWS))


def test_there_are_no_redraws_below_twenty_flights_or_without_ten_to_spare():
    assert redraw(pool(*KEYS, seeds=19), 1, 0.01) == Redraw()
    assert redraw(pool(*KEYS, seeds=20), 11, 0.01) == Redraw()
    assert redraw([], 1, 0.01) == Redraw()
    uneven = [*pool(KEYS[0], seeds=30), *pool(KEYS[1], seeds=15)]
    assert redraw(uneven, 1, 0.01) == Redraw()
    # a situation without any pool is left out, as it is where no mutant infects
    assert redraw([*pool(KEYS[0], seeds=30), *pool(KEYS[1], seeds=1)], 1, 0.01).safety == Ratio(0, REDRAWS)


def test_seeds_that_violate_everywhere_at_once_are_called_detected_as_often_as_they_are_drawn_alone():
    """Two seeds of forty violate in all four situations: a redraw of one of them beside ten green ones is detected."""
    flights = [
        outcome(BASELINE, key, seed, violated={"SR1": 9.0} if seed < 2 else {}) for key in KEYS for seed in range(40)
    ]
    found = redraw(flights, 1, 0.01, redraws=1000)
    assert 25 <= found.safety.part <= 75  # 2 of 40, as the other is seldom among the ten
    assert found.operability.part == 0
    assert redraw(flights, 1, 0.01, redraws=1000) == found


def test_a_roster_takes_the_default_of_each_credible_cell_from_the_matrix():
    fault = Fault("person", "delay", magnitude=Magnitude("delay_s", "s", (1.0, 3.0), 3.0))
    cells = {
        ("LATE", "human"): Cell("LATE", "human", CellStatus.CREDIBLE, faults=(fault,)),
        ("NO", "human"): Cell("NO", "human", CellStatus.CREDIBLE, faults=(Fault("person", "drop"),)),
        ("REVERSE", "human"): Cell("REVERSE", "human", CellStatus.CONTROL, faults=(Fault("person", "invert"),)),
        ("EARLY", "human"): Cell("EARLY", "human", CellStatus.NOT_MEANINGFUL, reason="none"),
    }
    words = tuple(Guideword(word, word, "") for word, _ in cells)
    roster = Roster.of(Matrix(words, (Parameter("human", "", "", "", ""),), cells), ["LATE-human@1s", "LATE-human@3s"])
    assert roster.defaults == {"LATE-human": "LATE-human@3s", "NO-human": "NO-human"}
    assert roster.controls == {"REVERSE-human"}
    assert roster.counts(subject_of("LATE-human@3s"))
    assert not roster.counts(subject_of("LATE-human@1s"))
    assert roster.is_control(subject_of("REVERSE-human"))


def test_a_magnitude_off_the_ladder_stands_after_those_of_its_cell():
    ids = ["MORE-goal@0.6m", "LATE-human@9s", "LATE-human@1s", "baseline"]
    assert sorted(ids, key=ROSTER.rank) == ["baseline", "LATE-human@1s", "LATE-human@9s", "MORE-goal@0.6m"]


@given(st.integers(0, 100), st.integers(1, 100))
def test_a_ratio_prints_part_whole_and_share(part: int, whole: int):
    part = min(part, whole)
    assert str(Ratio(part, whole)) == f"{part}/{whole} = {100 * part / whole:.0f} %"
    assert plain(Ratio(part, whole)) == {"part": part, "whole": whole}


def test_nothing_of_nothing_is_not_a_number():
    assert (str(Ratio(0, 0)), Ratio(0, 0).value) == ("0/0 = n/a", None)


@pytest.mark.parametrize(("part", "whole"), [(2, 1), (-1, 3)])
def test_what_is_no_share_is_refused(part: int, whole: int):
    with pytest.raises(ValueError, match="no share"):
        Ratio(part, whole)


CONDITION_KEYS = [key for key, _ in GRID.points]
THREE = Space(
    axes=("light", "floor"),
    values=(("0", "1", "2"), ("0", "1")),
    words=(("bright", "dim", "dark"), ("dry", "wet")),
    points=tuple((f"L{a}F{b}", (a, b)) for a, b in product("012", "01")),
)


def where(**fixed: str) -> list[str]:
    return [key for key, point in GRID.points if all(point[GRID.axes.index(a)] == v for a, v in fixed.items())]


def but(keys: list[str]) -> list[str]:
    return [key for key in CONDITION_KEYS if key not in keys]


def test_a_block_of_the_grid_is_the_axes_that_are_fixed_in_it():
    killing = where(D="0", H="1")
    assert condition(GRID, killing, but(killing)) == "human & light"


def test_nothing_is_said_of_a_mutant_that_is_killed_nowhere():
    assert condition(GRID, [], CONDITION_KEYS) == ""


def test_everywhere_is_everywhere():
    assert condition(GRID, CONDITION_KEYS, []) == "everywhere"
    assert condition(GRID, CONDITION_KEYS[:1], []) == "wherever tested"


def test_two_blocks_are_joined():
    killing = sorted({*where(H="1"), *where(T="1", O="1")})
    assert condition(GRID, killing, but(killing)) == "human or (obstacle & corner)"


def test_where_nothing_is_known_the_condition_may_fall_either_way():
    # light with a person is killed, light without survives; of the dark nothing is known
    assert condition(GRID, where(D="0", H="1"), where(D="0", H="0")) == "human"


def test_a_point_is_all_its_values():
    assert condition(GRID, ["T0O0W0D0H1"], but(["T0O0W0D0H1"])) == "human & light & wide & clear & straight"


def test_an_axis_of_three_values_names_those_that_kill():
    keys = [key for key, _ in THREE.points]
    dim_or_dark = [key for key in keys if key[1] in "12"]
    assert condition(THREE, dim_or_dark, [key for key in keys if key not in dim_or_dark]) == "dim or dark"
    assert condition(THREE, ["L2F1"], [key for key in keys if key != "L2F1"]) == "wet & dark"


def test_a_condition_names_no_value_in_which_nothing_was_killed():
    assert condition(THREE, ["L1F0"], ["L0F0", "L0F1"]) == "dim", "of the dark nothing is known"


def test_a_situation_cannot_both_kill_and_be_survived():
    with pytest.raises(ValueError, match="both killing and surviving"):
        condition(GRID, CONDITION_KEYS[:2], CONDITION_KEYS[1:3])


def with_fate(fates: list[str], wanted: str) -> list[str]:
    return [key for key, fate in zip(CONDITION_KEYS, fates, strict=True) if fate == wanted]


split = st.lists(st.sampled_from(["kill", "survive", "unknown"]), min_size=32, max_size=32)


@given(split)
def test_the_condition_covers_every_kill_and_no_survivor(fates: list[str]):
    killing, surviving = with_fate(fates, "kill"), with_fate(fates, "survive")
    terms = cover(GRID, killing, surviving)
    covered = {key for key, point in GRID.points if any(admits(term, point) for term in terms)}
    assert set(killing) <= covered
    assert not covered & set(surviving)
    assert len(terms) <= max(1, len(killing))


@given(split)
def test_no_term_of_the_condition_could_be_left_out_or_widened(fates: list[str]):
    killing, surviving = with_fate(fates, "kill"), with_fate(fates, "survive")
    terms = cover(GRID, killing, surviving)
    for term in terms:
        others = [other for other in terms if other != term]
        assert any(not any(admits(other, GRID.point[key]) for other in others) for key in killing)
        for axis, values in enumerate(GRID.values):
            wider = (*term[:axis], frozenset(values), *term[axis + 1 :])
            assert wider == term or any(admits(wider, GRID.point[key]) for key in surviving)


@given(split)
def test_the_way_for_large_grids_finds_what_the_way_for_small_ones_finds(fates: list[str]):
    killing, surviving = with_fate(fates, "kill"), with_fate(fates, "survive")
    with pytest.MonkeyPatch.context() as patch:
        found = cover(GRID, killing, surviving)
        patch.setattr("scaloft_fi.analysis.score.MOST_BOXES", 0)
        assert cover(GRID, killing, surviving) == found


def test_ten_axes_of_three_values_are_answered_at_once():
    values = tuple("abc")
    points = tuple(("".join(p), p) for p in product(values, repeat=10))
    wide = Space(tuple("qrstuvwxyz"), (values,) * 10, (values,) * 10, points)
    flown = [key for key, _ in points[::97]]
    killing = [key for key in flown if key[3] == "b" and key[7] == "c"]
    assert condition(wide, killing, [key for key in flown if key not in killing]) == "c & b"


def test_many_axes_of_many_values_are_still_answered():
    values = tuple("abcd")
    points = tuple(("".join(p), p) for p in product(values, repeat=5))
    wide = Space(tuple("vwxyz"), (values,) * 5, (values,) * 5, points)
    keys = [key for key, _ in points]
    assert condition(wide, [k for k in keys if k[0] == "a"], [k for k in keys if k[0] != "a"]) == "a"


def test_numbers_of_a_bin_count_as_the_bin_and_one_kill_as_a_kill():
    killing = [drawn(key, 0.5) for key, point in GRID.points if point[4] == "1"]
    surviving = [drawn(key, 0.9) for key, _ in GRID.points]
    assert condition(RANGED, killing, surviving) == "human"
    assert condition(RANGED, [drawn(key, 0.1) for key, _ in GRID.points], surviving) == "everywhere"
    assert order(RANGED, killing, surviving) == 1
