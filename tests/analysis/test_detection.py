"""Pairs, verdicts, how firm they are, and the noise of a stack that is not deterministic."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from itertools import product
from math import comb

import pytest
from builders import outcome, pool
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.stats import fisher_exact

from scaloft_fi.analysis.detection import (
    LOOKS,
    Detection,
    Firmness,
    Pair,
    Pool,
    Sample,
    Spending,
    State,
    Stratum,
    Verdict,
    detect,
    firmness,
    noise_of,
    p_value,
    reaches,
    significant,
)
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.judge.requirement import Kind


@pytest.mark.parametrize(
    ("flights", "violated", "open_", "triggered", "state"),
    [
        (9, 0, 0, 9, State.UNKNOWN),
        (10, 0, 0, 4, State.VACUOUS),
        (10, 0, 0, 5, State.STEADY),
        (10, 0, 2, 10, State.OPEN),
        (10, 0, 1, 10, State.STEADY),
        (10, 1, 0, 10, State.STEADY),
        (10, 1, 1, 10, State.UNSTEADY),
        (10, 2, 0, 10, State.UNSTEADY),
        (10, 5, 0, 10, State.UNSTEADY),
        (10, 6, 0, 10, State.RED),
        (50, 46, 0, 50, State.RED),
        (50, 5, 0, 50, State.STEADY),
        (50, 6, 0, 50, State.UNSTEADY),
    ],
)
def test_a_pair_has_the_first_state_that_fits(flights: int, violated: int, open_: int, triggered: int, state: State):
    pair = Pair("T0O0W0D0H0", "SR1", Kind.SAFETY, flights, violated, open_, triggered)
    assert pair.state is state
    assert pair.tests == (state in (State.STEADY, State.UNSTEADY, State.RED))


M = "LATE-human@3s"
KEYS = [f"T{t}O{o}W{w}D0H1" for t in range(2) for o in range(2) for w in range(2)]
GREEN = Pool.of(pool(*KEYS))
ONCE, GROWN = Spending(), Spending(0.01, frozenset({M}))


def seen(key: str, violating: int, flights: int = 1, name: str = "SR2", *, infected: bool = True) -> Sample:
    """The first `violating` flights violate a requirement."""
    return Sample(key, tuple((name,) if i < violating else () for i in range(flights)), infected)


def safety(samples: list[Sample], found: Pool = GREEN, spending: Spending = ONCE) -> Detection:
    return detect(M, samples, found, spending, Kind.SAFETY)


def test_a_fault_that_violates_in_three_situations_with_one_seed_is_detected():
    found = safety([seen(key, 1) for key in KEYS[:3]])
    assert (found.verdict, found.by, found.seeds, found.share) == (Verdict.DETECTED, ("SR2",), 1, 0.01)
    assert found.p["SR2"] == pytest.approx(2 / 11**3)


def test_what_was_seen_but_not_often_enough_is_undecided_and_says_how_many_seeds_would_decide():
    found = safety([seen(KEYS[0], 1), seen(KEYS[1], 0)])
    assert (found.verdict, found.by) == (Verdict.UNDECIDED, ())
    # at three seeds a look has a quarter of alpha: 3 of 3 in one situation have p = 0.0070, 5 of 5 0.0007
    assert (found.needed, found.anew) == (5, False)


def test_a_fault_put_to_the_test_without_a_trace_is_not_detected_once_a_trace_could_have_decided():
    assert safety([seen(key, 0) for key in KEYS]).verdict is Verdict.NOT_DETECTED
    too_few = safety([seen(key, 0) for key in KEYS[:2]])
    assert (too_few.verdict, too_few.needed) == (Verdict.UNDECIDED, 3)
    between_looks = [seen(key, 0, 2) for key in KEYS[:2]]  # only the look at one seed was reached
    assert safety(between_looks, spending=GROWN).verdict is Verdict.UNDECIDED
    assert safety(between_looks).verdict is Verdict.NOT_DETECTED


def test_without_a_pool_nothing_is_decided():
    few = Pool.of(pool(*KEYS, seeds=9))
    found = safety([seen(key, 3, 3) for key in KEYS], few)
    assert (found.verdict, found.needed) == (Verdict.UNDECIDED, None)


def test_a_campaign_that_grew_spends_a_quarter_of_alpha_at_each_look():
    three = [seen(KEYS[0], 3, 3)]
    assert safety(three).verdict is Verdict.DETECTED
    grown = safety(three, spending=GROWN)
    assert (grown.verdict, grown.share) == (Verdict.UNDECIDED, 0.0025)
    assert safety([seen(KEYS[0], 5, 5)], spending=GROWN).verdict is Verdict.DETECTED


def test_what_a_look_detected_stays_detected_whatever_is_flown_later():
    samples = [seen(key, 1, 10) for key in KEYS]
    found = safety(samples, spending=GROWN)
    assert (found.verdict, found.seeds) == (Verdict.DETECTED, 1)


flights = st.lists(st.sampled_from([(), ("SR1",), ("SR2",), ("SR1", "SR2")]), min_size=1, max_size=10).map(tuple)


@given(st.lists(flights, min_size=1, max_size=8), st.lists(st.booleans(), min_size=8, max_size=8))
def test_seeds_flown_later_take_back_no_detection_of_a_campaign_with_looks(
    flown: list[tuple[tuple[str, ...], ...]], acts: list[bool]
):
    samples = [Sample(key, own, infected) for key, own, infected in zip(KEYS, flown, acts, strict=False)]
    earlier = [
        safety([sample.at(look) for sample in samples], spending=GROWN).detected
        for look in LOOKS
        if look <= max(len(own) for own in flown)
    ]
    assert not any(earlier) or safety(samples, spending=GROWN).detected


def sample(key: str, violating: str) -> Sample:
    """`x` violates SR2; the seeds are 0, 1, ..."""
    violated = tuple(("SR2",) if flight == "x" else () for flight in violating)
    return Sample(key, violated, infected=True, seeds=tuple(range(len(violating))))


def firm(samples: list[Sample], spending: Spending | None = None) -> Firmness:
    return firmness(M, samples, GREEN, spending or Spending(), Kind.SAFETY)


def test_a_mutant_that_grew_is_judged_at_its_looks_without_the_seed():
    grown = Spending(0.01, frozenset({M}))
    assert firm([sample(key, "xxx") for key in KEYS[:4]], grown) is Firmness.FIRM
    assert firm([sample(key, "x..") for key in KEYS[:4]], grown) is Firmness.HANGS


@given(st.lists(st.text("x.", min_size=3, max_size=3), min_size=8, max_size=8))
def test_more_violations_never_make_a_firm_verdict_less_firm(flights: list[str]):
    samples = [sample(key, own) for key, own in zip(KEYS, flights, strict=True)]
    more = [sample(key, "x" + own[1:]) for key, own in zip(KEYS, flights, strict=True)]
    if firm(samples).firm:
        assert firm(more).firm


@pytest.mark.parametrize("firmness", Firmness)
def test_only_the_two_firm_words_count_as_firm(firmness: Firmness):
    assert firmness.firm == firmness.words.startswith("firm")


def flown(mutant: str, seed: int, rho: float, situation: str = "T0O0W0D0H0") -> Outcome:
    made = outcome(mutant, situation, seed)
    return replace(made, readings=tuple(replace(reading, rho=rho) for reading in made.readings))


def test_the_stack_alone_is_measured_by_pairs_and_the_seeds_by_baselines():
    flights = [
        flown(BASELINE, 0, 0.30), flown(PLACEBO_ID, 0, 0.32),
        flown(BASELINE, 1, 0.50), flown(PLACEBO_ID, 1, 0.46),
        flown(PLACEBO_ID, 2, 9.0),  # without a baseline of its seed
    ]  # fmt: skip
    noise = {one.requirement: one for one in noise_of(flights)}
    assert list(noise) == ["SR1", "SR2", "OP1"]  # what is only reported has no noise line
    assert noise["SR1"].pairs == 2
    assert noise["SR1"].stack == pytest.approx(math.sqrt((0.02**2 + 0.04**2) / 2 / 2))
    assert noise["SR1"].seeds == pytest.approx(math.sqrt(0.1**2 + 0.1**2))
    assert noise["SR1"].apart == 0


def test_situations_do_not_add_to_the_spread_between_seeds():
    flights = [flown(BASELINE, seed, rho, key) for key, rho in (("A", 0.1), ("B", 5.0)) for seed in (0, 1)]
    assert [one.seeds for one in noise_of(flights)] == [0.0, 0.0, 0.0]


def test_a_pair_of_two_verdicts_is_counted_and_what_measures_nothing_is_left_out():
    flights = [outcome(BASELINE, seed=0), outcome(PLACEBO_ID, seed=0, violated={"SR2": 7.0})]
    flights += [outcome(BASELINE, seed=1, vacuous=["SR2"]), outcome(PLACEBO_ID, seed=1)]
    noise = {one.requirement: one for one in noise_of(flights)}
    assert noise["SR2"].apart == 1
    assert noise["SR2"].pairs == 1
    assert noise["SR1"].pairs == 2


def test_without_placebo_the_stack_alone_is_not_measured_and_invalid_flights_say_nothing():
    flights = [outcome(BASELINE, seed=0), outcome(PLACEBO_ID, seed=0, invalid="its process died")]
    assert [(one.pairs, one.stack, one.seeds) for one in noise_of(flights)] == [(0, None, None)] * 3
    assert noise_of([outcome(PLACEBO_ID)]) == ()


@st.composite
def strata(draw: st.DrawFn) -> Stratum:
    n, m = draw(st.integers(1, 4)), draw(st.integers(1, 12))
    return Stratum(draw(st.integers(0, n)), n, draw(st.integers(0, m)), m)


def by_enumeration(listed: list[Stratum]) -> float:
    """Every way in which the violations may fall on subject and pool, weighed by how often it occurs."""

    def gain(k: int, b: int, m: int) -> int:
        return k if 10 * b <= m else 0

    observed = sum(gain(k, b, m) for k, _, b, m, _ in listed)
    ways = [
        [
            (gain(i, k + b - i, m), comb(n, i) * comb(m, k + b - i) / comb(n + m, k + b))
            for i in range(min(n, k + b) + 1)
        ]
        for k, n, b, m, _ in listed
    ]
    total = 0.0
    for chosen in product(*ways):
        chance = 1.0
        for _, weight in chosen:
            chance *= weight
        total += chance * (sum(one for one, _ in chosen) >= observed)
    return total


@given(st.lists(strata(), max_size=4))
def test_p_is_the_share_of_all_tables_with_at_least_the_observed_sum(listed: list[Stratum]):
    assert p_value(listed) == pytest.approx(by_enumeration(listed), rel=1e-9)


@given(st.integers(1, 10), st.integers(0, 10), st.integers(10, 60))
def test_of_one_situation_with_a_green_pool_it_is_fishers_exact_test(n: int, k: int, m: int):
    k = min(k, n)
    expected = fisher_exact([[k, n - k], [0, m]], alternative="greater").pvalue
    assert p_value([Stratum(k, n, 0, m)]) == pytest.approx(expected, rel=1e-9)


@given(st.lists(strata(), max_size=6), st.randoms())
def test_the_order_of_the_situations_changes_nothing(listed: list[Stratum], chance: random.Random):
    assert p_value(chance.sample(listed, len(listed))) == p_value(listed)


@given(st.lists(strata(), max_size=4), st.integers(1, 5), st.integers(1, 50))
def test_a_situation_without_a_violation_changes_nothing(listed: list[Stratum], n: int, m: int):
    assert p_value([*listed, Stratum(0, n, 0, m)]) == p_value(listed)


def test_a_red_pool_and_a_lucky_one_contribute_nothing():
    # nine of ten baselines violate, and the tenth does not: three of three flights of the mutant prove nothing
    assert p_value([Stratum(3, 3, 9, 10)]) == 1.0
    assert p_value([Stratum(3, 3, 2, 10)]) == 1.0
    assert p_value([Stratum(3, 3, 1, 10)]) < 0.02


def test_one_seed_needs_three_situations_and_three_seeds_need_one():
    assert 2 * p_value([Stratum(1, 1, 0, 10)] * 2) == pytest.approx(0.0165, abs=5e-5)
    assert 2 * p_value([Stratum(1, 1, 0, 10)] * 3) < 0.01
    assert 2 * p_value([Stratum(3, 3, 0, 10)]) == pytest.approx(0.0070, abs=5e-5)


@given(st.lists(strata(), max_size=6), st.integers(1, 6), st.floats(1e-6, 0.5))
@example([Stratum(9, 10, 0, 20)] * 6, 3, 0.01)
def test_what_is_significant_is_what_p_says_whether_or_not_the_bound_decides(
    listed: list[Stratum], tests: int, share: float
):
    assert significant(listed, tests, share) == reaches(min(1.0, tests * p_value(listed)), share)


@pytest.mark.parametrize("wrong", [Stratum(2, 1, 0, 10), Stratum(-1, 1, 0, 10), Stratum(0, 1, 11, 10)])
def test_what_is_no_count_is_refused(wrong: Stratum):
    with pytest.raises(ValueError, match="no stratum"):
        p_value([wrong])
