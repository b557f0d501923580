from __future__ import annotations

import json
import random
from dataclasses import replace

from builders import GRID, ROSTER, campaigns, flights, outcome
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.results.outcome import BASELINE, PLACEBO, Outcome
from scaloft_fi.results.scoring.baseline import findings
from scaloft_fi.results.scoring.decision import Decision
from scaloft_fi.results.scoring.ratio import Ratio
from scaloft_fi.results.scoring.score import Score, score
from scaloft_fi.results.scoring.score_record import score_json
from scaloft_fi.results.situations.coverage import coverage
from scaloft_fi.results.status import Status

LATE, NO, GOAL, CONTROL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m", "REVERSE-human"
LIGHT_HUMAN, LIGHT, DARK_CORNER = "T0O0W0D0H1", "T0O0W0D0H0", "T1O0W0D1H0"


def scored(*outcomes: Outcome) -> Score:
    return score(outcomes, ROSTER, GRID)


def campaign() -> list[Outcome]:
    """Two mutants and a control: with a person, without one, and in the dark where the baseline strikes."""
    cut = {"violated": {"SR1": 30.0}, "struck": "bar"}
    return [
        outcome(BASELINE, LIGHT_HUMAN),
        outcome(BASELINE, LIGHT),
        outcome(BASELINE, DARK_CORNER, **cut),  # type: ignore[arg-type]
        outcome(LATE, LIGHT_HUMAN, violated={"SR2": 12.0}),
        outcome(LATE, LIGHT, carried=0, altered=0),
        outcome(LATE, DARK_CORNER, violated={"SR1": 20.0}, struck="wall"),
        outcome(GOAL, LIGHT_HUMAN, violated={"OP1": 60.0}),
        outcome(GOAL, LIGHT),
        outcome(CONTROL, LIGHT_HUMAN, violated={"SR1": 5.0}, struck="wall"),
        outcome(PLACEBO, LIGHT, altered=0),
    ]


def test_the_ratios_count_the_default_mutants_of_credible_cells() -> None:
    found = scored(*campaign())
    assert found.exercised == Ratio(2, 3)
    assert found.infected == Ratio(2, 2)
    assert found.mutation_score == Ratio(1, 2)
    assert found.strict_score == Ratio(1, 2)
    assert found.operability == Ratio(1, 2)
    assert [mutant.subject.id for mutant in found.mutants] == [LATE, GOAL]
    assert [mutant.subject.id for mutant in found.controls] == [CONTROL]
    assert found.placebo is not None


def test_a_mutants_kills_are_counted_of_the_eligible_and_of_the_flown_situations() -> None:
    late, goal = scored(*campaign()).mutants
    # killed in the dark too, but the baseline held nothing to its end there
    assert (late.kill_rate, late.kill_rate_flown) == (Ratio(1, 1), Ratio(2, 3))
    assert (goal.kill_rate, goal.kill_rate_flown, goal.operability) == (Ratio(0, 2), Ratio(0, 2), Ratio(1, 2))
    assert dict(late.requirements) == {"SR2": Ratio(1, 1)}
    assert dict(goal.requirements) == {"OP1": Ratio(1, 2)}
    assert (late.status, goal.status) == (Status.KILLED, Status.SURVIVED)
    assert late.earliest is not None
    assert (late.earliest.requirement, late.earliest.t_s, late.earliest.situation) == ("SR2", 12.0, LIGHT_HUMAN)


def test_a_ladder_has_rows_of_its_own_and_moves_no_ratio() -> None:
    ladder = outcome("LATE-human@1s", LIGHT_HUMAN, violated={"SR2": 12.0})
    before, after = scored(*campaign()), scored(*campaign(), ladder)
    assert [mutant.subject.id for mutant in after.mutants] == ["LATE-human@1s", LATE, GOAL]
    assert ratios(before) == ratios(after)


def test_seeds_of_a_situation_are_one_result() -> None:
    seeds = [outcome(BASELINE, LIGHT, seed) for seed in range(3)]
    kills = [outcome(LATE, LIGHT, seed, violated={"SR2": 9.0} if seed else {}) for seed in range(3)]
    (late,) = scored(*seeds, *kills).mutants
    (result,) = late.results
    assert (late.kill_rate, result.rate) == (Ratio(1, 1), Ratio(2, 3))
    assert late.decisions(Decision.UNDECIDED) == (LIGHT,)


def test_a_larger_pool_decides_what_the_campaigns_own_baselines_leave_open() -> None:
    seeds = [outcome(BASELINE, LIGHT, seed) for seed in range(50)]
    kills = [outcome(LATE, LIGHT, seed, violated={"SR2": 9.0}) for seed in range(3)]
    assert scored(*seeds[:3], *kills).mutants[0].decisions(Decision.UNDECIDED) == (LIGHT,)
    found = score([*seeds[:3], *kills], ROSTER, GRID, {LIGHT: seeds})
    assert found.mutants[0].decisions(Decision.KILLED) == (LIGHT,)


def test_the_condition_names_the_killing_situations() -> None:
    late = scored(*campaign()).mutants[0]
    assert late.killing == (LIGHT_HUMAN, DARK_CORNER)
    assert late.surviving == (LIGHT,)


def ratios(found: Score) -> list[Ratio]:
    first = [found.exercised, found.infected, found.mutation_score]
    return [*first, found.strict_score, found.decided_score, found.operability]


@given(campaigns(), st.randoms())
def test_the_score_ignores_the_order_of_outcomes(outcomes: list[Outcome], chance: random.Random) -> None:
    shuffled = list(outcomes)
    chance.shuffle(shuffled)
    assert score(outcomes, ROSTER, GRID) == score(shuffled, ROSTER, GRID)


@given(campaigns())
def test_statuses_sum_to_flights_and_fates_to_mutants(outcomes: list[Outcome]) -> None:
    found = score(outcomes, ROSTER, GRID)
    entries = [*found.mutants, *found.controls, *([found.placebo] if found.placebo else [])]
    assert sum(count for entry in entries for _, count in entry.rungs) == sum(o.mutant != BASELINE for o in outcomes)
    assert found.fates.total() == len(found.mutants)


@given(campaigns())
def test_the_killed_are_among_the_eligible_and_they_among_the_infected_and_they_among_the_flown(
    outcomes: list[Outcome],
) -> None:
    found = score(outcomes, ROSTER, GRID)
    assert found.mutation_score.part == found.strict_score.part
    assert found.decided_score.part <= found.decided_score.whole <= found.mutation_score.whole
    assert found.mutation_score.whole <= found.infected.part <= found.infected.whole == found.strict_score.whole
    for mutant in found.mutants:
        assert (mutant.status is Status.KILLED) == mutant.killed
        assert mutant.kill_rate.part <= mutant.kill_rate_flown.part
        assert mutant.kill_rate.whole <= mutant.kill_rate_flown.whole
        assert bool(mutant.killing) == (mutant.earliest is not None)


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


@given(campaigns())
def test_placebo_and_controls_are_in_no_ratio(outcomes: list[Outcome]) -> None:
    without = [flown for flown in outcomes if flown.mutant not in (PLACEBO, CONTROL)]
    assert ratios(score(outcomes, ROSTER, GRID)) == ratios(score(without, ROSTER, GRID))


@given(campaigns())
def test_the_condition_is_true_where_it_kills_and_nowhere_it_was_survived(outcomes: list[Outcome]) -> None:
    for mutant in score(outcomes, ROSTER, GRID).mutants:
        assert not set(mutant.killing) & set(mutant.surviving)
        assert bool(mutant.condition(GRID)) == bool(mutant.killing)


def test_the_json_has_the_keys_of_the_contract() -> None:
    outcomes = campaign()
    baselines = [(finding.situation, finding.violated) for finding in findings(outcomes, GRID)]
    plain = json.loads(json.dumps(score_json(scored(*outcomes), coverage(outcomes, GRID), baselines)))
    assert list(plain) == ["ratios", "mutants", "coverage", "baseline", "decided_score", "operability", "redraw"]
    assert list(plain["ratios"]) == ["exercised", "infected", "mutation_score", "strict_score"]
    assert plain["ratios"]["mutation_score"] == {
        "part": 1,
        "whole": 2,
        "interval": [0.09453120573423074, 0.9054687942657693],
    }
    assert plain["mutants"][0] == {
        "id": LATE,
        "guideword": "LATE",
        "parameter": "human",
        "magnitude": "3s",
        "status": "killed",
        "kill_rate": {"part": 1, "whole": 1},
        "kill_rate_flown": {"part": 2, "whole": 3},
        "requirements": {"SR2": {"part": 1, "whole": 1}},
        "decisions": {"killed": 0, "survived": 0, "undecided": 1, "situations": []},
    }
    assert {"situations", "draws", "t_way", "realised"} <= plain["coverage"].keys()
    assert plain["coverage"]["situations"] == {"part": 3, "whole": 32}
    assert list(plain["coverage"]["t_way"]) == ["1", "2", "3", "4", "5"]
    assert plain["baseline"] == [
        {"situation": LIGHT, "violated": []},
        {"situation": LIGHT_HUMAN, "violated": []},
        {"situation": DARK_CORNER, "violated": ["SR1"]},
    ]


def test_the_json_names_what_decided_a_situation() -> None:
    kills = [outcome(LATE, LIGHT, seed, violated={"SR2": 9.0}) for seed in range(10)]
    outcomes = [*kills, *(outcome(BASELINE, LIGHT, seed) for seed in range(10))]
    decisions = score_json(scored(*outcomes), coverage(outcomes, GRID), [])["mutants"][0]["decisions"]
    assert (decisions["killed"], decisions["survived"], decisions["undecided"]) == (1, 0, 0)
    assert decisions["situations"] == [
        {
            "situation": LIGHT,
            "decision": "killed",
            "requirement": "SR2",
            "p": 1 / 286 * 2 * 3,
            "flights": {"part": 3, "whole": 3},
            "baseline": {"part": 0, "whole": 10},
            "look": 3,
        }
    ]


def test_a_flight_cut_at_its_first_kill_enters_no_figure() -> None:
    cut = replace(outcome(LATE, LIGHT, violated={"SR2": 3.0}), truncated="first kill")
    assert scored(*campaign(), cut) == scored(*campaign())
    assert scored(cut).mutants == ()


def test_a_campaign_without_flights_scores_nothing_of_nothing() -> None:
    empty = scored()
    assert ratios(empty) == [Ratio(0, 3), *[Ratio(0, 0)] * 5]
    assert score_json(empty, coverage([], GRID), [])["ratios"]["infected"] == {"part": 0, "whole": 0, "interval": None}
