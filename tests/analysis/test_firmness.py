from __future__ import annotations

import pytest
from builders import pool
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.detection import Firmness, Sample, Spending, adjusted, firmness
from scaloft_fi.analysis.pool import Pool
from scaloft_fi.judge.requirement import Kind

M = "LATE-human@3s"
KEYS = [f"T{t}O{o}W{w}D0H1" for t in range(2) for o in range(2) for w in range(2)]
GREEN = Pool.of(pool(*KEYS))


def flown(key: str, violating: str) -> Sample:
    """`x` violates SR2; the seeds are 0, 1, ..."""
    violated = tuple(("SR2",) if flight == "x" else () for flight in violating)
    return Sample(key, violated, infected=True, seeds=tuple(range(len(violating))))


def firm(samples: list[Sample], beside: Pool = GREEN, spending: Spending | None = None) -> Firmness:
    return firmness(M, samples, beside, spending or Spending(), Kind.SAFETY)


def test_a_fault_that_violates_with_each_seed_in_three_situations_is_firm() -> None:
    assert firm([flown(key, "xxx") for key in KEYS[:3]]) is Firmness.FIRM


def test_a_fault_that_one_seed_alone_shows_hangs_on_it() -> None:
    assert firm([flown(key, "x..") for key in KEYS]) is Firmness.HANGS


def test_three_seeds_in_one_situation_are_too_few_to_say_because_two_could_not_be_detected() -> None:
    assert firm([flown(KEYS[0], "xxx")]) is Firmness.TOO_FEW


def test_a_fault_with_one_seed_is_judged_by_the_pool_alone_and_the_word_says_so() -> None:
    found = firm([flown(key, "x") for key in KEYS[:4]])
    assert (found, found.firm, found.words) == (Firmness.FIRM_BY_POOL, True, "firm by the pool alone")


def test_a_verdict_may_hang_on_a_seed_of_the_pool() -> None:
    """One of ten violates in a situation: without another seed chance explains the same violations more easily."""
    first, *others = KEYS[:3]
    beside = Pool.of([*pool(*others), *pool(first, red=1, violated={"SR2": 9.0})])
    samples = [flown(key, "x") for key in (first, *others)]
    p = [min(adjusted(samples, beside, ("SR1", "SR2"), seed).values()) for seed in (None, *range(10))]
    assert max(p[1:]) > p[0]
    assert firm(samples, beside, Spending((p[0] + max(p[1:])) / 2)) is Firmness.HANGS


def test_the_gate_and_the_states_of_pairs_stay_those_of_the_whole_pool() -> None:
    """One of ten violates: nine flights would allow none, and the situation would contribute nothing."""
    red = Pool.of(pool(*KEYS, red=1, violated={"SR2": 9.0}))
    samples = [flown(key, "xxx") for key in KEYS]
    assert firm(samples, red) is Firmness.FIRM
    assert min(adjusted(samples, red, ("SR1", "SR2"), 9).values()) < 1e-6


def test_a_mutant_that_grew_is_judged_at_its_looks_without_the_seed() -> None:
    grown = Spending(0.01, frozenset({M}))
    assert firm([flown(key, "xxx") for key in KEYS[:4]], spending=grown) is Firmness.FIRM
    assert firm([flown(key, "x..") for key in KEYS[:4]], spending=grown) is Firmness.HANGS


@given(st.lists(st.text("x.", min_size=3, max_size=3), min_size=8, max_size=8))
def test_more_violations_never_make_a_firm_verdict_less_firm(flights: list[str]) -> None:
    samples = [flown(key, own) for key, own in zip(KEYS, flights, strict=True)]
    more = [flown(key, "x" + own[1:]) for key, own in zip(KEYS, flights, strict=True)]
    if firm(samples).firm:
        assert firm(more).firm


@pytest.mark.parametrize("firmness", Firmness)
def test_only_the_two_firm_words_count_as_firm(firmness: Firmness) -> None:
    assert firmness.firm == firmness.words.startswith("firm")
