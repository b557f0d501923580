"""The compiled covariance against sums of exact fractions, each term rounded once."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.stack.messages import Array
from scaloft_fi.stack.reference.estimator import MEASURED, SIZE, carried, corrected, innovation

seeds = st.integers(0, 2**32 - 1)


def _product(a: Array, b: Array) -> Array:
    """The product of two matrices by fused multiply-adds in the order of the terms."""
    out = np.zeros((len(a), b.shape[1]))
    for place in np.ndindex(out.shape):
        for x, y in zip(a[place[0]], b[:, place[1]], strict=True):
            out[place] = float(Fraction(float(x)) * Fraction(float(y)) + Fraction(float(out[place])))
    return out


def _matrices(seed: int) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    wide = rng.normal(size=(SIZE, SIZE)) * 10.0 ** rng.uniform(-4, 2, size=(SIZE, SIZE))
    return wide, rng.normal(size=(SIZE, SIZE)), np.diag(rng.uniform(0.01, 1.0, len(MEASURED)))


@settings(max_examples=5, deadline=None)
@given(seeds)
def test_a_step_turns_and_blurs_the_covariance(seed: int) -> None:
    f, p, _ = _matrices(seed)
    noise = np.diag(np.arange(1.0, SIZE + 1.0))
    assert np.array_equal(carried(f, p, noise), _product(_product(f, p), f.T) + noise)


@settings(max_examples=5, deadline=None)
@given(seeds)
def test_a_fix_takes_its_gain_off_in_josephs_form(seed: int) -> None:
    p, inverse, noise = _matrices(seed)
    inverse, z = inverse[:4, :4].copy(), inverse[5, :4].copy()
    gain, error, left = corrected(p, noise, inverse, z)
    assert np.array_equal(gain, _product(p[:, MEASURED], inverse))
    assert np.allclose(error, gain @ z, rtol=1e-12, atol=1e-12 * np.abs(gain).max())
    kept = np.eye(SIZE)
    kept[:, MEASURED] -= gain
    assert np.array_equal(left, _product(_product(kept, p), kept.T) + _product(_product(gain, noise), gain.T))


@given(seeds)
def test_an_innovation_is_as_uncertain_as_estimate_and_fix_together(seed: int) -> None:
    p, _, noise = _matrices(seed)
    assert np.array_equal(innovation(p, noise), p[np.ix_(MEASURED, MEASURED)] + noise)


def test_what_is_off_by_nothing_is_corrected_by_nothing_not_by_less() -> None:
    p, _, noise = _matrices(0)
    p[:, MEASURED] = 0.0
    _, error, _ = corrected(p, noise, -np.eye(4), np.ones(4))
    assert not np.signbit(error).any()


def test_what_is_no_number_spreads() -> None:
    f, p, _ = _matrices(0)
    p[3, 4] = np.nan
    assert np.isnan(carried(f, p, np.zeros((SIZE, SIZE)))).all()
