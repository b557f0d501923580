"""The score of a campaign, redraws of the unmutated drone, rosters and ratios."""

from __future__ import annotations

import random

import pytest
from builders import GRID, ROSTER, campaigns, outcome, pool, seeded, subject_of
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.detection import Spending, Verdict
from scaloft_fi.analysis.roster import Ratio, Roster
from scaloft_fi.analysis.score import REDRAWS, Redraw, Score, redraw, score
from scaloft_fi.hazop.matrix import Cell, CellStatus, Fault, Guideword, Magnitude, Matrix, Parameter
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
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
