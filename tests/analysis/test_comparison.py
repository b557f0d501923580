"""Two campaigns held against each other: what is lost, what is gained, what the flights leave open."""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping

import pytest
from builders import CLASSED, GRID, ROSTER, outcome, pool, seeded
from hypothesis import given

from scaloft_fi.analysis.comparison import Agreement, Change, ComparedCampaigns, Flown, compared
from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.roster import Ratio, Roster
from scaloft_fi.analysis.score import score_of
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import rulings_of

LATE, NO, GOAL = ROSTER.defaults.values()
KEYS = [key for key, _ in GRID.points[:6]]


def held_against(first: Iterable[Outcome], second: Iterable[Outcome], roster: Roster = ROSTER) -> ComparedCampaigns:
    def flown(name: str, outcomes: Iterable[Outcome]) -> Flown:
        rulings = rulings_of(outcomes)
        return Flown(name, rulings, score_of(rulings, roster, GRID, Spending(0.01)))

    return compared(flown("old", first), flown("new", second), roster, GRID)


def campaign(rates: Mapping[str, float], chance: random.Random, seeds: int = 3) -> list[Outcome]:
    """Three mutants that violate SR1 at these rates, each in six situations, beside a pool without a violation."""
    flights = pool(*KEYS)
    for mutant, rate in rates.items():
        for key in KEYS:
            for seed in range(seeds):
                violated = {"SR1": 9.0} if chance.random() < rate else {}
                flights.append(outcome(mutant, key, seed, violated=violated, digest=f"{mutant} {chance.random()}"))
    return flights


@given(seeded(), seeded())
def test_no_p_is_below_the_least_and_what_is_lost_could_be_lost(first: list[Outcome], second: list[Outcome]):
    told = held_against(first, second)
    assert all(mutant.least_p <= min(mutant.lost_p, mutant.gained_p) * (1 + 1e-9) for mutant in told.mutants)
    assert len(told.lost) <= told.could_be_lost.part <= told.could_be_lost.whole
    assert len(told.gained) <= told.could_be_gained.part <= told.could_be_gained.whole


@given(seeded())
def test_a_campaign_loses_and_gains_nothing_against_itself(flights: list[Outcome]):
    told = held_against(flights, flights)
    assert {mutant.change for mutant in told.mutants} <= {Change.SAME}
    assert told.agreement.same.part == told.agreement.same.whole
    assert (told.only_first, told.only_second) == ((), ())


def test_a_fault_that_the_second_campaign_no_longer_shows_is_lost_and_gained_the_other_way_round():
    shown = campaign({LATE: 1.0, NO: 1.0, GOAL: 0.0}, random.Random(0))
    planted = campaign({LATE: 1.0, NO: 0.0, GOAL: 0.0}, random.Random(1))
    there, back = held_against(shown, planted), held_against(planted, shown)
    assert (there.lost, there.gained, there.unsure) == ((NO,), (), ())
    assert (back.lost, back.gained, back.unsure) == ((), (NO,), ())
    (lost,) = (mutant for mutant in there.mutants if mutant.id == NO)
    assert (lost.requirement, lost.first_violated, lost.second_violated) == ("SR1", Ratio(18, 18), Ratio(0, 18))
    assert lost.lost_p < 1e-6 < lost.gained_p


def test_a_fault_that_both_flights_would_allow_is_unsure_and_never_lost():
    shown = campaign({LATE: 1.0, NO: 1.0, GOAL: 1.0}, random.Random(0))
    flights = campaign({LATE: 0.0, NO: 1.0, GOAL: 1.0}, random.Random(1), seeds=1)
    fewer = [one for one in flights if one.mutant != LATE or one.situation == KEYS[0]]
    told = held_against(shown, fewer)
    assert (told.lost, told.unsure) == ((), (LATE,))


def test_a_difference_that_one_fault_alone_would_show_is_unsure_among_three():
    keys = KEYS[:2]
    shown = [*pool(*KEYS), *(outcome(LATE, key, s, violated={"SR1": 9.0}) for key in keys for s in range(3))]
    harmless = [*pool(*KEYS), *(outcome(LATE, key, s) for key in keys for s in range(3))]
    others = [outcome(mutant, key, s) for mutant in (NO, GOAL) for key in keys for s in range(3)]
    assert held_against(shown, harmless).lost == (LATE,)
    among = held_against([*shown, *others], [*harmless, *others])
    assert (among.lost, among.unsure) == ((), (LATE,))
    assert min(mutant.lost_p for mutant in among.mutants) == pytest.approx(3 * 2 / 20**2)
    assert [mutant.least_p for mutant in among.mutants] == pytest.approx([3 * 2 / 20**2] * 3)
    assert (among.could_be_lost, among.could_be_gained) == (Ratio(0, 1), Ratio(0, 0))


def test_a_verdict_that_hangs_on_a_seed_is_not_lost_and_the_halves_of_its_seeds_disagree():
    keys = [key for key, _ in GRID.points[:12]]
    shown = [
        *pool(*keys),
        *(outcome(LATE, k, s, violated={"SR1": 9.0} if s == 0 else {}) for k in keys for s in (0, 1)),
    ]
    harmless = [*pool(*keys), *(outcome(LATE, key, s) for key in keys for s in (0, 1))]
    told = held_against(shown, harmless)
    (mutant,) = told.mutants
    assert mutant.lost_p < 0.01
    assert (told.lost, told.unsure) == ((), (LATE,))
    assert told.first_halves == Agreement(Ratio(0, 1), 0.0)


def test_what_is_not_put_to_the_test_in_the_second_campaign_is_not_lost():
    shown = campaign({LATE: 1.0}, random.Random(0))
    silent = [*pool(*KEYS), *(outcome(LATE, key, seed, altered=0) for key in KEYS for seed in range(3))]
    assert held_against(shown, silent).lost == ()


def test_a_situation_that_is_steady_in_one_campaign_alone_compares_nothing():
    shown = campaign({LATE: 1.0}, random.Random(0))
    red = [*pool(*KEYS, red=9, violated={"SR1": 9.0}), *(outcome(LATE, key, seed) for key in KEYS for seed in range(3))]
    (mutant,) = held_against(shown, red).mutants
    assert (mutant.situations, mutant.lost_p, mutant.change) == (6, 1.0, Change.UNSURE)
    assert mutant.requirement == "SR2"


def test_redraws_of_one_campaign_lose_and_gain_in_at_most_one_pair_of_a_hundred():
    pairs = []
    for number in range(100):
        chance = random.Random(number)
        rates = {mutant: chance.choice([0.0, 0.1, 0.3, 0.5, 0.9]) for mutant in (LATE, NO, GOAL)}
        pairs.append(held_against(campaign(rates, chance), campaign(rates, chance)))
    assert sum(bool(told.lost) for told in pairs) <= 1
    assert sum(bool(told.gained) for told in pairs) <= 1
    assert any(told.unsure for told in pairs)


def test_the_worst_class_of_severity_stands_first():
    flights = campaign({LATE: 1.0, NO: 1.0, GOAL: 1.0}, random.Random(0))
    assert [mutant.id for mutant in held_against(flights, flights, CLASSED).mutants] == [GOAL, NO, LATE]


def test_mutants_of_one_campaign_alone_are_named_and_not_compared():
    told = held_against(
        campaign({LATE: 1.0, NO: 1.0}, random.Random(0)), campaign({NO: 1.0, GOAL: 1.0}, random.Random(0))
    )
    assert ([mutant.id for mutant in told.mutants], told.only_first, told.only_second) == ([NO], (LATE,), (GOAL,))


def test_halves_of_the_seeds_agree_as_far_as_the_flights_do():
    steady, one_seed = (
        campaign({LATE: 1.0, NO: 0.0}, random.Random(0), seeds=4),
        campaign({LATE: 1.0}, random.Random(0), 1),
    )
    told = held_against(steady, one_seed)
    assert told.first_halves == Agreement(Ratio(2, 2), 1.0)
    assert told.second_halves is None


def test_kappa_is_unknown_where_chance_alone_agrees():
    assert Agreement.of([(True, True)] * 3).kappa is None
    assert Agreement.of([]) == Agreement(Ratio(0, 0), None)


def test_of_requirements_that_differ_alike_the_one_that_is_violated_is_named():
    flights = [*pool(*KEYS), *(outcome(LATE, key, seed, violated={"SR2": 9.0}) for key in KEYS for seed in range(3))]
    (mutant,) = held_against(flights, flights).mutants
    assert (mutant.requirement, mutant.first_violated) == ("SR2", Ratio(18, 18))


def test_a_mutant_that_counts_in_neither_campaign_any_more_stands_in_a_list_too():
    rates = {"LATE-human@1s": 1.0, "LATE-human@5s": 1.0, NO: 1.0}
    told = held_against(
        campaign(rates, random.Random(0)), campaign({LATE: 1.0, "LATE-human@5s": 1.0}, random.Random(0))
    )
    assert (told.only_first, told.only_second) == ((NO, "LATE-human@1s"), (LATE,))
    assert (told.mutants, told.uncounted) == ((), ("LATE-human@5s",))
