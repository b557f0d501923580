from __future__ import annotations

import random
import re
from collections.abc import Mapping
from fractions import Fraction

import pytest
from builders import GRID, outcome
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import fisher_exact
from statsmodels.stats.multitest import multipletests

from scaloft_fi.results.flights import baseline_pool
from scaloft_fi.results.outcome import BASELINE, PLACEBO, Outcome
from scaloft_fi.results.scoring import decision
from scaloft_fi.results.scoring.decision import LOOKS, Decided, Decision, decisions

M = "LATE-human@3s"
KEYS = [key for key, _ in GRID.points]
K, S, U = Decision.KILLED, Decision.SURVIVED, Decision.UNDECIDED


def clean(situation: str, seeds: int, red: int = 0, requirement: str = "SR1") -> list[Outcome]:
    """Baselines, the last `red` of them violating a requirement."""
    violated = {requirement: 30.0}
    return [outcome(BASELINE, situation, s, violated=violated if s >= seeds - red else {}) for s in range(seeds)]


def flown(situation: str, kills: int, flights: int, requirement: str = "SR1") -> list[Outcome]:
    """A mutant's flights, the first of them violating a requirement."""
    return [outcome(M, situation, s, violated={requirement: 20.0} if s < kills else {}) for s in range(flights)]


def judged(outcomes: list[Outcome], pool: int = 50) -> Mapping[tuple[str, str], Decided]:
    """Decisions beside a pool of clean baselines in every situation flown."""
    keys = {o.situation for o in outcomes}
    baselines = {key: clean(key, pool) for key in keys}
    paired = [b for key in keys for b in baselines[key][:12]]
    return decisions([*outcomes, *paired], baselines)


def alone(kills: int, flights: int, pool: int = 50) -> Decision:
    return judged(flown(KEYS[0], kills, flights), pool)[M, KEYS[0]].decision


def test_it_takes_what_the_documentation_says_to_be_killed() -> None:
    rows = re.findall(r"^\| (\d+) \| (.+) \| (.+) \| (.+) \|$", decision.__doc__ or "", re.MULTILINE)
    assert [int(row[0]) for row in rows] == [3, 10, 50]
    for n0, *needed in rows:
        for n, said in zip(LOOKS, needed, strict=True):
            for family, least in zip((1, 32, 64), said.split(" / "), strict=True):
                killed = [k for k in range(n + 1) if decision.fisher(k, n, 0, int(n0)) * family * 3 <= Fraction(1, 20)]
                assert str(min(killed, default="-")) == least


def test_kills_of_all_flights_are_decided_at_the_first_look_beside_a_large_pool() -> None:
    decided = judged(flown(KEYS[0], 3, 3))[M, KEYS[0]]
    assert (decided.decision, decided.requirement, decided.look) == (K, "SR1", 3)
    assert (decided.k, decided.n, decided.b, decided.n0) == (3, 3, 0, 50)
    # one situation with two safety requirements, three looks
    theirs = fisher_exact([[3, 0], [0, 50]], alternative="greater")[1]
    assert decided.p == pytest.approx(theirs * 2 * 3)


@pytest.mark.parametrize(
    ("kills", "flights", "said"),
    [(1, 1, U), (2, 2, U), (3, 3, K), (0, 3, U), (0, 5, S), (1, 5, U), (0, 10, S), (1, 10, S), (4, 10, K)],
)
def test_kills_and_flights_decide(kills: int, flights: int, said: Decision) -> None:
    assert alone(kills, flights) is said


def test_three_flights_beside_three_baselines_decide_nothing() -> None:
    assert alone(3, 3, pool=3) is U


def test_between_two_looks_nothing_changes() -> None:
    assert [alone(0, flights) for flights in range(1, 8)] == [U, U, U, U, S, S, S]


def test_a_significant_difference_below_the_floor_is_no_kill() -> None:
    key = KEYS[0]
    mutant = [outcome(M, key, s, violated={"SR1": 20.0} if s in (4, 9) else {}) for s in range(10)]
    for red, said in ((0, K), (1, U)):  # 1/5 - 1/1000 is less than 0.2
        decided = decisions([*mutant, *clean(key, 10)], {key: clean(key, 1000, red)})[M, key]
        assert (decided.decision, decided.p <= 0.05) == (said, True)


def test_what_the_baselines_violate_as_often_decides_nothing_for_a_kill() -> None:
    key = KEYS[0]
    decided = decisions([*flown(key, 5, 10), *clean(key, 10, red=5)], {key: clean(key, 10, red=5)})
    assert decided[M, key].decision is not K


def test_a_baseline_cut_short_is_no_evidence_that_it_held_the_rest() -> None:
    key = KEYS[0]
    cut = [outcome(BASELINE, key, s, violated={"SR1": 30.0}, struck="bar") for s in range(40)]
    paired = [outcome(BASELINE, key, s) for s in range(3)]
    decided = decisions([*flown(key, 3, 3, "SR2"), *paired], {key: [*paired, *cut[3:]]})
    assert (decided[M, key].n0, decided[M, key].decision) == (3, U)


def test_placebo_and_a_fault_that_never_infects_are_not_decided() -> None:
    key = KEYS[0]
    mutants = [outcome(name, key, seed, altered=0) for name in (PLACEBO, M) for seed in range(10)]
    assert decisions([*mutants, *clean(key, 10)], baseline_pool(clean(key, 10))) == {}


def test_violations_beside_red_baselines_never_speak_for_survival() -> None:
    """Its violations are more than the pool's, but each stands beside a baseline that violates the same later."""
    key = KEYS[0]
    mutant = [outcome(M, key, s, violated={"SR1": 20.0} if s < 4 else {}) for s in range(10)]
    paired = [outcome(BASELINE, key, s, violated={"SR1": 30.0} if s < 4 else {}) for s in range(10)]
    for red, said in ((2, U), (60, S)):
        assert decisions([*mutant, *paired], {key: clean(key, 100, red)})[M, key].decision is said


@st.composite
def mutants(draw: st.DrawFn) -> tuple[list[Outcome], dict[str, list[Outcome]]]:
    """A mutant's flights in some situations beside a pool with some violations."""
    chance = random.Random(draw(st.integers(0, 10_000)))
    size = draw(st.sampled_from([3, 10, 20, 50]))
    flights: list[Outcome] = []
    pool = {}
    for key in KEYS[: draw(st.integers(1, 6))]:
        red, rate = draw(st.sampled_from([0, 0, 0.1, 0.5])), draw(st.sampled_from([0, 0.1, 0.5, 0.9, 1]))
        seeds = draw(st.sampled_from([2, 3, 4, 5, 7, 10, 12]))

        def violated(rate: float) -> dict[str, float]:
            return {name: 1.0 + chance.randrange(50) for name in ("SR1", "SR2") if chance.random() < rate}

        pool[key] = [outcome(BASELINE, key, s, violated=violated(red)) for s in range(max(size, 12))]
        flights += [
            outcome(M, key, s, violated=violated(rate), altered=chance.choice([0, 5, 5, 5])) for s in range(seeds)
        ]
    return flights, pool


def both(flights: list[Outcome], pool: dict[str, list[Outcome]]) -> Mapping[tuple[str, str], Decided]:
    paired = [baseline for baselines in pool.values() for baseline in baselines]
    return decisions([*flights, *paired], pool)


@settings(deadline=None, max_examples=300)
@given(mutants(), st.randoms(use_true_random=False))
def test_a_decision_stays_whatever_flights_of_higher_seeds_are_added(
    drawn: tuple[list[Outcome], dict[str, list[Outcome]]], chance: random.Random
) -> None:
    flights, pool = drawn
    # any history of flying: each situation is as far as it is, with at least one flight
    upto = {key: chance.randint(1, 12) for key in pool}
    before = both([f for f in flights if f.seed < upto[f.situation]], pool)
    after = both(flights, pool)
    for name, decided in before.items():
        if decided.decision is not U:
            assert after[name].decision is decided.decision


@settings(deadline=None, max_examples=200)
@given(mutants())
def test_flights_that_a_decision_spares_would_not_have_changed_any(
    drawn: tuple[list[Outcome], dict[str, list[Outcome]]],
) -> None:
    flights, pool = drawn
    kept: list[Outcome] = []
    for look in LOOKS:
        said = both(kept, pool)
        going = [key for key in pool if (d := said.get((M, key))) is None or d.decision is U]
        kept += [f for f in flights if f.situation in going and f.seed < look and f not in kept]
    whole, sequential = both(flights, pool), both(kept, pool)
    assert {name: d.decision for name, d in sequential.items()} == {name: d.decision for name, d in whole.items()}


@settings(deadline=None, max_examples=200)
@given(mutants(), st.randoms(use_true_random=False))
def test_decisions_ignore_the_order_of_outcomes(
    drawn: tuple[list[Outcome], dict[str, list[Outcome]]], chance: random.Random
) -> None:
    flights, pool = drawn
    shuffled = list(flights)
    chance.shuffle(shuffled)
    assert both(flights, pool) == both(shuffled, pool)


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 1)), min_size=1, max_size=12))
def test_the_adjustment_over_the_situations_is_holms(kills: list[tuple[int, int]]) -> None:
    """With one requirement tested in each situation, at the first look, where no difference is below the floor."""
    pool, flights = {}, []
    for key, (k, red) in zip(KEYS, kills, strict=False):
        # every baseline breaks SR2, which leaves SR1 alone in the family
        pool[key] = [
            outcome(BASELINE, key, s, violated={"SR2": 9.0} | ({"SR1": 30.0} if s >= 50 - red else {}))
            for s in range(50)
        ]
        flights += [outcome(M, key, s, violated={"SR2": 9.0} | ({"SR1": 20.0} if s < k else {})) for s in range(3)]
    said = both(flights, pool)
    ps = [fisher_exact([[k, 3 - k], [red, 50 - red]], alternative="greater")[1] for k, red in kills[: len(pool)]]
    theirs = multipletests(ps, alpha=0.05 / 3, method="holm")[0]
    assert [said[M, key].decision is K for key in pool] == list(theirs)


def test_another_situation_may_take_a_kill_back() -> None:
    """The one thing that the family costs; it is documented."""
    one = flown(KEYS[0], 2, 3)
    assert judged(one, 50)[M, KEYS[0]].decision is K
    others = [flight for key in KEYS[1:20] for flight in flown(key, 0, 3)]
    assert judged([*one, *others], 50)[M, KEYS[0]].decision is U


def test_a_mutant_that_does_nothing_is_rarely_killed() -> None:
    """4 situations with 1 flight in 10 red: of 400 mutants at most the promised 5 % are killed anywhere."""
    chance = random.Random(7)
    keys, false = KEYS[:4], 0

    def flight(mutant: str, key: str, seed: int) -> Outcome:
        return outcome(mutant, key, seed, violated={"SR1": 30.0} if chance.random() < 0.1 else {})

    pool = {key: [flight(BASELINE, key, s) for s in range(50)] for key in keys}
    paired = [baseline for baselines in pool.values() for baseline in baselines[:10]]
    for _ in range(400):
        said = decisions([*paired, *(flight(M, key, s) for key in keys for s in range(10))], pool)
        false += any(d.decision is K for d in said.values())
    assert false <= 20


def test_what_is_not_flown_up_to_the_first_look_counts_in_full() -> None:
    short = [outcome(M, key, 0, altered=0) for key in KEYS[1:20]]
    whole = [outcome(M, key, seed, altered=0) for key in KEYS[1:20] for seed in range(3)]
    assert judged([*flown(KEYS[0], 2, 3), *short])[M, KEYS[0]].decision is U
    assert judged([*flown(KEYS[0], 2, 3), *whole])[M, KEYS[0]].decision is K


def test_each_look_spends_its_own_part_of_the_error_of_a_survival() -> None:
    """One kill of nine eligible flights has p = 10/512 = .020, more than a third of 5 %."""
    key, red = KEYS[0], {"SR1": 30.0, "SR2": 30.0}
    paired = [*clean(key, 9), outcome(BASELINE, key, 9, violated=red)]
    assert decisions([*flown(key, 1, 10), *paired], {key: clean(key, 50)})[M, key].decision is U
