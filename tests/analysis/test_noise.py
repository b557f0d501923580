"""How far flights of one situation and seed lie apart, of a stack that is not deterministic."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from builders import outcome

from scaloft_fi.analysis.detection import noise_of
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome


def flown(mutant: str, seed: int, rho: float, situation: str = "T0O0W0D0H0") -> Outcome:
    made = outcome(mutant, situation, seed)
    return replace(made, readings=tuple(replace(reading, rho=rho) for reading in made.readings))


def test_the_stack_alone_is_measured_by_pairs_and_the_seeds_by_baselines() -> None:
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


def test_situations_do_not_add_to_the_spread_between_seeds() -> None:
    flights = [flown(BASELINE, seed, rho, key) for key, rho in (("A", 0.1), ("B", 5.0)) for seed in (0, 1)]
    assert [one.seeds for one in noise_of(flights)] == [0.0, 0.0, 0.0]


def test_a_pair_of_two_verdicts_is_counted_and_what_measures_nothing_is_left_out() -> None:
    flights = [outcome(BASELINE, seed=0), outcome(PLACEBO_ID, seed=0, violated={"SR2": 7.0})]
    flights += [outcome(BASELINE, seed=1, vacuous=["SR2"]), outcome(PLACEBO_ID, seed=1)]
    noise = {one.requirement: one for one in noise_of(flights)}
    assert noise["SR2"].apart == 1
    assert noise["SR2"].pairs == 1
    assert noise["SR1"].pairs == 2


def test_without_placebo_the_stack_alone_is_not_measured_and_invalid_flights_say_nothing() -> None:
    flights = [outcome(BASELINE, seed=0), outcome(PLACEBO_ID, seed=0, invalid="its process died")]
    assert [(one.pairs, one.stack, one.seeds) for one in noise_of(flights)] == [(0, None, None)] * 3
    assert noise_of([outcome(PLACEBO_ID)]) == ()
