from __future__ import annotations

from dataclasses import replace

import pytest
from builders import pool
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.detection import LOOKS, Detection, Sample, Spending, Verdict, adjusted, detect
from scaloft_fi.analysis.pool import Pool
from scaloft_fi.judge.requirement import Kind

M = "LATE-human@3s"
KEYS = [f"T{t}O{o}W{w}D0H1" for t in range(2) for o in range(2) for w in range(2)]
GREEN = Pool.of(pool(*KEYS))
ONCE, GROWN = Spending(), Spending(0.01, frozenset({M}))


def seen(key: str, violating: int, flights: int = 1, name: str = "SR2", *, infected: bool = True) -> Sample:
    """The first `violating` flights violate a requirement."""
    return Sample(key, tuple((name,) if i < violating else () for i in range(flights)), infected)


def safety(samples: list[Sample], found: Pool = GREEN, spending: Spending = ONCE) -> Detection:
    return detect(M, samples, found, spending, Kind.SAFETY)


def test_a_fault_that_violates_in_three_situations_with_one_seed_is_detected() -> None:
    found = safety([seen(key, 1) for key in KEYS[:3]])
    assert (found.verdict, found.by, found.seeds, found.share) == (Verdict.DETECTED, ("SR2",), 1, 0.01)
    assert found.p["SR2"] == pytest.approx(2 / 11**3)


def test_what_was_seen_but_not_often_enough_is_undecided_and_says_how_many_seeds_would_decide() -> None:
    found = safety([seen(KEYS[0], 1), seen(KEYS[1], 0)])
    assert (found.verdict, found.by) == (Verdict.UNDECIDED, ())
    # at three seeds a look has a quarter of alpha: 3 of 3 in one situation have p = 0.0070, 5 of 5 0.0007
    assert (found.needed, found.anew) == (5, False)


def test_a_fault_put_to_the_test_without_a_trace_is_not_detected_once_a_trace_could_have_decided() -> None:
    assert safety([seen(key, 0) for key in KEYS]).verdict is Verdict.NOT_DETECTED
    too_few = safety([seen(key, 0) for key in KEYS[:2]])
    assert (too_few.verdict, too_few.needed) == (Verdict.UNDECIDED, 3)


def test_a_fault_that_infects_nowhere_is_not_tested() -> None:
    assert safety([seen(key, 0, infected=False) for key in KEYS]).verdict is Verdict.NOT_TESTED
    assert safety([]).verdict is Verdict.NOT_TESTED


@pytest.mark.parametrize(
    "baselines",
    [
        pool(*KEYS, red=10, violated={"SR1": 30.0}, struck="bar"),
        pool(*KEYS, red=3, violated={"SR1": 9.0, "SR2": 9.0}),
        pool(*KEYS, red=10, violated={"SR1": 9.0, "SR2": 9.0}),
    ],
)
def test_a_red_unsteady_or_open_pair_detects_nothing(baselines: list[object]) -> None:
    found = Pool.of(baselines)  # type: ignore[arg-type]
    everything = [Sample(key, (("SR1", "SR2"),) * 3, infected=True) for key in KEYS]
    assert safety(everything, found).verdict is Verdict.NOT_TESTED


def test_a_vacuous_pair_detects_nothing() -> None:
    found = Pool.of(pool(*KEYS, vacuous=("SR2",)))
    p = adjusted([seen(key, 3, 3) for key in KEYS], found, ("SR1", "SR2"))
    assert p == {"SR1": 1.0, "SR2": 1.0}


def test_without_a_pool_nothing_is_decided() -> None:
    few = Pool.of(pool(*KEYS, seeds=9))
    found = safety([seen(key, 3, 3) for key in KEYS], few)
    assert (found.verdict, found.needed) == (Verdict.UNDECIDED, None)


def test_holm_multiplies_the_least_p_by_the_requirements_and_never_orders_them_otherwise() -> None:
    samples = [Sample(key, (("SR1", "SR2") if i < 2 else ("SR2",),), infected=True) for i, key in enumerate(KEYS[:3])]
    p = adjusted(samples, GREEN, ("SR1", "SR2"))
    assert p["SR2"] == pytest.approx(2 / 11**3)
    assert p["SR1"] == pytest.approx(1 / 11**2)


def test_a_campaign_that_grew_spends_a_quarter_of_alpha_at_each_look() -> None:
    three = [seen(KEYS[0], 3, 3)]
    assert safety(three).verdict is Verdict.DETECTED
    grown = safety(three, spending=GROWN)
    assert (grown.verdict, grown.share) == (Verdict.UNDECIDED, 0.0025)
    assert safety([seen(KEYS[0], 5, 5)], spending=GROWN).verdict is Verdict.DETECTED


def test_what_a_look_detected_stays_detected_whatever_is_flown_later() -> None:
    samples = [seen(key, 1, 10) for key in KEYS]
    found = safety(samples, spending=GROWN)
    assert (found.verdict, found.seeds) == (Verdict.DETECTED, 1)


flights = st.lists(st.sampled_from([(), ("SR1",), ("SR2",), ("SR1", "SR2")]), min_size=1, max_size=10).map(tuple)


@given(st.lists(flights, min_size=1, max_size=8), st.lists(st.booleans(), min_size=8, max_size=8))
def test_seeds_flown_later_take_back_no_detection_of_a_campaign_with_looks(
    flown: list[tuple[tuple[str, ...], ...]], acts: list[bool]
) -> None:
    samples = [Sample(key, own, infected) for key, own, infected in zip(KEYS, flown, acts, strict=False)]
    earlier = [
        safety([sample.at(look) for sample in samples], spending=GROWN).detected
        for look in LOOKS
        if look <= max(len(own) for own in flown)
    ]
    assert not any(earlier) or safety(samples, spending=GROWN).detected


@given(st.lists(flights, min_size=1, max_size=8))
def test_a_situation_added_without_a_violation_takes_back_no_detection(
    flown: list[tuple[tuple[str, ...], ...]],
) -> None:
    samples = [Sample(key, own, infected=True) for key, own in zip(KEYS, flown, strict=False)]
    quiet = [Sample(key, ((),), infected=True) for key in KEYS[len(samples) :]]
    assert safety(samples).p == safety([*samples, *quiet]).p


@given(st.lists(flights, min_size=1, max_size=8))
def test_the_verdict_by_operability_hears_operability_requirements_alone(
    flown: list[tuple[tuple[str, ...], ...]],
) -> None:
    samples = [Sample(key, own, infected=True) for key, own in zip(KEYS, flown, strict=False)]
    found = detect(M, samples, GREEN, ONCE, Kind.OPERABILITY)
    assert not found.detected
    assert found.p == {"OP1": 1.0}
    late = [replace(sample, violated=tuple(("OP1",) for _ in sample.violated)) for sample in samples]
    assert detect(M, late, GREEN, ONCE, Kind.OPERABILITY).p["OP1"] < 0.1
