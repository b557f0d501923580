from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from scaloft_fi.sim.situation import Distribution, Shape


def of_scipy(own: Distribution) -> object:
    low, width = own.low, own.high - own.low
    match own.shape:
        case Shape.UNIFORM:
            return stats.uniform(low, width)
        case Shape.LOG_UNIFORM:
            return stats.loguniform(low, own.high)
        case Shape.TRIANGULAR:
            return stats.triang((own.centre - low) / width, low, width)
        case Shape.NORMAL:
            ends = ((low - own.centre) / own.sd, (own.high - own.centre) / own.sd)
            return stats.truncnorm(*ends, own.centre, own.sd)


@st.composite
def distributions(draw: st.DrawFn) -> Distribution:
    shape = draw(st.sampled_from(list(Shape)))
    low = draw(st.floats(0.01 if shape is Shape.LOG_UNIFORM else -50, 50))
    width = draw(st.floats(0.1, 100))
    centre = low + width * draw(st.floats(0, 1) if shape is Shape.TRIANGULAR else st.floats(-0.5, 1.5))
    return Distribution(shape, low, low + width, centre, width * draw(st.floats(0.2, 5)))


@given(distributions(), st.floats(0, 1))
def test_quantiles_are_those_of_scipy(own: Distribution, share: float) -> None:
    assert own.quantile(share) == pytest.approx(of_scipy(own).ppf(share), rel=1e-6, abs=1e-6 * (own.high - own.low))  # type: ignore[attr-defined]
    assert own.low <= own.quantile(share) <= own.high


@given(distributions())
def test_the_quantiles_of_nothing_and_everything_are_the_ends(own: Distribution) -> None:
    assert (own.quantile(0.0), own.quantile(1.0)) == (own.low, own.high)
