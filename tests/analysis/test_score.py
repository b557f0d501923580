from __future__ import annotations

import json
import random

from builders import GRID, ROSTER, campaigns, flights, outcome, pool, seeded
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.coverage import coverage
from scaloft_fi.analysis.detection import Spending, Verdict
from scaloft_fi.analysis.pool import State, findings
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import Score, score
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.judge.status import Status
from scaloft_fi.verbs.score_record import score_json

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


def test_the_ratios_count_the_default_mutants_of_credible_cells() -> None:
    found = scored(*campaign())
    assert found.exercised == Ratio(2, 3)
    assert found.infected == Ratio(2, 2)
    assert found.tested == Ratio(2, 2)
    assert found.mutation_score == Ratio(1, 2)
    assert found.operability == Ratio(1, 2)
    assert [mutant.subject.id for mutant in found.mutants] == [LATE, GOAL]
    assert [mutant.subject.id for mutant in found.controls] == [CONTROL]
    assert found.placebo is not None
    assert (found.pooled, found.lacking, found.expected_false) == (True, (), 0.02)


def test_kills_are_steady_pairs_where_most_flights_of_a_detected_mutant_violate() -> None:
    late, goal = scored(*campaign()).mutants
    assert [(kill.situation, kill.requirement) for kill in late.kills] == [(key, "SR2") for key in HUMAN]
    assert (late.kill_rate, late.kill_rate_flown) == (Ratio(3, 3), Ratio(3, 5))
    assert dict(late.requirements) == {"SR2": Ratio(3, 3)}
    assert (late.verdict, late.status) == (Verdict.DETECTED, Status.REVEALED)
    assert late.first is not None
    assert (late.first.requirement, late.first.t_s, late.first.situation) == ("SR2", 12.0, HUMAN[0])
    assert (goal.verdict, goal.kills, goal.kill_rate) == (Verdict.NOT_DETECTED, (), Ratio(0, 4))
    assert goal.operability.detected
    assert dict(goal.requirements) == {"OP1": Ratio(4, 4)}


def test_a_lucky_baseline_kills_nothing() -> None:
    """With seed 0 the unmutated drone dodges the bar that nine of ten seeds strike, and a mutant strikes it there."""
    lucky = outcome(GOAL, DARK_CORNER, 0, violated={"SR1": 30.0}, struck="bar")
    found = scored(*campaign(), lucky)
    goal = found.mutants[1]
    assert (goal.status, goal.verdict, goal.kills) == (Status.REVEALED, Verdict.NOT_DETECTED, ())
    assert found.pool.states[DARK_CORNER, "SR1"] is State.RED
    assert found.mutation_score == scored(*campaign()).mutation_score


def test_a_vacuous_requirement_is_no_test() -> None:
    """Of nine situations eight have no person: SR2 8/9 must read 8/8."""
    late = scored(*campaign(), outcome(LATE, NOBODY, 1)).mutants[0]
    assert late.kill_rate == Ratio(3, 4)
    assert dict(late.requirements) == {"SR2": Ratio(3, 3)}


def test_without_a_pool_there_is_no_ratio_of_what_was_shown() -> None:
    few = [one for one in campaign() if one.mutant != BASELINE or one.seed == 0]
    found = scored(*few)
    assert not found.pooled
    assert (found.mutation_score, found.operability) == (Ratio(0, 0), Ratio(0, 0))
    assert found.lacking == (NOBODY, HUMAN[0], HUMAN[1], HUMAN[2], DARK_CORNER)
    assert {mutant.verdict for mutant in found.mutants} == {Verdict.UNDECIDED}


def test_a_control_flown_once_beside_its_baseline_lacks_no_pool() -> None:
    control = outcome("REVERSE-human", DARK_CORNER, 0, violated={"OP1": 9.0})
    alone = [outcome(situation=DARK_CORNER), control]
    quiet = [one for one in campaign() if one.mutant == BASELINE]
    assert scored(*alone).pooled
    assert scored(*quiet, *alone[1:]).lacking == scored(*alone).lacking == ()


def test_another_campaigns_baselines_make_a_pool() -> None:
    few = [one for one in campaign() if one.mutant != BASELINE or one.seed == 0]
    lent = [one for one in campaign() if one.mutant == BASELINE]
    found = score(few, ROSTER, GRID, None, lent)
    assert found.mutation_score == Ratio(1, 2)


def test_a_ladder_has_rows_of_its_own_and_moves_no_ratio() -> None:
    ladder = outcome("LATE-human@1s", HUMAN[0], violated={"SR2": 12.0})
    before, after = scored(*campaign()), scored(*campaign(), ladder)
    assert [mutant.subject.id for mutant in after.mutants] == ["LATE-human@1s", LATE, GOAL]
    assert ratios(before) == ratios(after)


def test_seeds_of_a_situation_are_one_result_and_a_kill_takes_most_of_them() -> None:
    many = [outcome(LATE, HUMAN[0], seed, violated={"SR2": 9.0} if seed < 5 else {}) for seed in range(10)]
    (late,) = scored(*pool(HUMAN[0], seeds=50), *many).mutants
    (result,) = late.results
    assert (late.detected, dict(result.violated), result.kills) == (True, {"SR2": 5}, ())
    more = [outcome(LATE, HUMAN[0], seed, violated={"SR2": 9.0} if seed < 6 else {}) for seed in range(10)]
    assert scored(*pool(HUMAN[0], seeds=50), *more).mutants[0].kills[0].violated == 6


def test_the_condition_names_the_situations_with_a_kill() -> None:
    assert scored(*campaign()).mutants[0].condition(GRID) == "human"


def ratios(found: Score) -> list[Ratio]:
    return [found.exercised, found.infected, found.tested, found.mutation_score, found.operability]


@given(st.one_of(campaigns(), seeded()), st.randoms())
@settings(deadline=None)
def test_the_score_ignores_the_order_of_outcomes(outcomes: list[Outcome], chance: random.Random) -> None:
    shuffled = chance.sample(outcomes, len(outcomes))
    one, other = score(outcomes, ROSTER, GRID), score(shuffled, ROSTER, GRID)
    assert (one.mutants, one.controls, one.placebo, ratios(one)) == (
        other.mutants,
        other.controls,
        other.placebo,
        ratios(other),
    )


@given(st.one_of(campaigns(), seeded()))
@settings(deadline=None)
def test_statuses_sum_to_flights_and_fates_to_mutants(outcomes: list[Outcome]) -> None:
    found = score(outcomes, ROSTER, GRID)
    entries = [*found.mutants, *found.controls, *([found.placebo] if found.placebo else [])]
    assert sum(count for entry in entries for _, count in entry.statuses) == sum(o.mutant != BASELINE for o in outcomes)
    assert found.fates.total() == len(found.mutants)


@given(st.one_of(campaigns(), seeded()))
@settings(deadline=None)
def test_the_detected_are_among_the_tested_and_they_among_the_infected(outcomes: list[Outcome]) -> None:
    found = score(outcomes, ROSTER, GRID)
    assert found.mutation_score.part <= found.tested.part <= found.infected.part <= found.infected.whole
    for mutant in found.mutants:
        assert not mutant.detected or mutant.tested
        assert (mutant.verdict is Verdict.NOT_TESTED) <= (not mutant.tested)
        assert mutant.kill_rate.part <= mutant.kill_rate.whole <= mutant.kill_rate_flown.whole


@given(st.one_of(campaigns(), seeded()))
@settings(deadline=None)
def test_every_kill_is_a_steady_pair_of_a_detected_mutant_that_infects_there(outcomes: list[Outcome]) -> None:
    found = score(outcomes, ROSTER, GRID)
    for mutant in (*found.mutants, *found.controls):
        assert not mutant.kills or mutant.detected
        assert not mutant.operability_kills or mutant.operability.detected
        infected = {result.situation for result in mutant.results if result.infected}
        for kill in (*mutant.kills, *mutant.operability_kills):
            assert found.pool.states[kill.situation, kill.requirement] is State.STEADY
            assert kill.situation in infected
            assert 2 * kill.violated > kill.flights
            assert kill.first.requirement == kill.requirement


@given(campaigns(), st.lists(flights(), max_size=4))
def test_an_invalid_flight_never_changes_a_score(outcomes: list[Outcome], more: list[Outcome]) -> None:
    names = {flown.name for flown in outcomes}
    failed = {
        flown.name: outcome(flown.mutant, flown.situation, flown.seed, invalid="the worker died")
        for flown in more
        if flown.name not in names
    }
    before, after = (score(listed, ROSTER, GRID) for listed in (outcomes, [*outcomes, *failed.values()]))
    assert ratios(before) == ratios(after)
    rates = {mutant.subject: (mutant.kill_rate, mutant.kill_rate_flown) for mutant in after.mutants}
    assert all(rates[m.subject] == (m.kill_rate, m.kill_rate_flown) for m in before.mutants)


@given(seeded())
@settings(deadline=None)
def test_placebo_and_controls_are_in_no_ratio(outcomes: list[Outcome]) -> None:
    flown = {one.situation for one in outcomes if one.altered and one.mutant not in (PLACEBO_ID, CONTROL)}
    without = [one for one in outcomes if one.mutant not in (PLACEBO_ID, CONTROL)]
    if flown:  # a control that infects where no mutant does asks for a pool of its own
        assert ratios(score(outcomes, ROSTER, GRID))[:3] == ratios(score(without, ROSTER, GRID))[:3]


@given(seeded())
@settings(deadline=None)
def test_the_condition_is_true_where_it_kills(outcomes: list[Outcome]) -> None:
    for mutant in score(outcomes, ROSTER, GRID).mutants:
        assert bool(mutant.condition(GRID)) == bool(mutant.killing or mutant.seen_in)


def test_the_json_has_the_keys_of_the_contract() -> None:
    outcomes = campaign()
    baselines = [(finding.situation, finding.violated) for finding in findings(outcomes, GRID)]
    plain = json.loads(json.dumps(score_json(scored(*outcomes), coverage(outcomes, GRID), baselines)))
    assert {"alpha", "ratios", "expected_false", "mutants", "pairs", "coverage", "baseline"} <= plain.keys()
    assert list(plain["ratios"]) == [
        "exercised",
        "infected",
        "tested",
        "mutation_score",
        "firm",
        "operability",
        "without_accepted",
    ]
    assert plain["ratios"]["mutation_score"] == {"part": 1, "whole": 2}
    late = plain["mutants"][0]
    assert {name: late[name] for name in ("id", "guideword", "parameter", "magnitude", "status", "verdict")} == {
        "id": LATE,
        "guideword": "LATE",
        "parameter": "human",
        "magnitude": "3s",
        "status": "revealed",
        "verdict": "detected",
    }
    assert late["p"].keys() == {"SR1", "SR2"}
    assert (late["kill_rate"], late["kill_rate_flown"]) == ({"part": 3, "whole": 3}, {"part": 3, "whole": 5})
    assert late["kills"][0] == {"situation": HUMAN[0], "requirement": "SR2", "violated": 1, "flights": 1}
    assert plain["pairs"][0] == {
        "situation": HUMAN[0],
        "requirement": "SR1",
        "kind": "safety",
        "violated": 0,
        "flights": 10,
        "open": 0,
        "triggered": 10,
        "state": "steady",
    }
    assert plain["coverage"]["situations"] == {"part": 5, "whole": 32}
    assert list(plain["coverage"]["t_way"]) == ["1", "2", "3", "4", "5"]
    assert {"situation": DARK_CORNER, "violated": ["SR1"]} in plain["baseline"]


def test_the_json_says_how_many_seeds_would_decide() -> None:
    outcomes = [*pool(*HUMAN), outcome(LATE, HUMAN[0], violated={"SR2": 9.0}), outcome(LATE, HUMAN[1])]
    (late,) = score_json(scored(*outcomes), coverage(outcomes, GRID), [])["mutants"]
    assert late["verdict"] == "undecided"
    assert late["decided_at"] == {"seeds": 1, "alpha": 0.01, "needed": 5, "anew": False}


def test_a_campaign_that_grew_is_scored_by_looks() -> None:
    outcomes = [*pool(HUMAN[0]), *(outcome(LATE, HUMAN[0], seed, violated={"SR2": 9.0}) for seed in range(3))]
    assert score(outcomes, ROSTER, GRID).mutants[0].detected
    assert not score(outcomes, ROSTER, GRID, Spending(0.01, frozenset({LATE}))).mutants[0].detected


def test_a_campaign_without_flights_scores_nothing_of_nothing() -> None:
    empty = scored()
    assert ratios(empty) == [Ratio(0, 3), *[Ratio(0, 0)] * 4]
    assert score_json(empty, coverage([], GRID), [])["ratios"]["infected"] == {"part": 0, "whole": 0}
