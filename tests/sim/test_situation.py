"""Keys, predicates, ranges with their bins, and distributions beside scipy's."""

from __future__ import annotations

import re

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import stats
from studies import item_of

from scaloft_fi.errors import InputError
from scaloft_fi.judge.stl import Formula
from scaloft_fi.model import read
from scaloft_fi.sim.log import signal_names
from scaloft_fi.sim.situation import Drawn, Range, Shape, Situation, cut, number_text
from scaloft_fi.stack.reference.messages import BELIEFS


def test_a_key_is_made_of_axes_and_values():
    situation = Situation.of({"T": 1, "Li": 12})
    assert situation.key == str(situation) == "T1Li12"
    assert situation["Li"] == 12


def test_every_predicate_is_a_formula_over_the_log_and_the_benign_one_denies_all_others(config):
    names, axis = signal_names(config.world.surfaces, BELIEFS), config.grid.axes[0]
    assert [axis.predicate(place) for place in (1, 0)] == ["eventually(x_m < -1)", "(not (eventually(x_m < -1)))"]
    for axis in config.grid.axes:
        for value in axis.values:
            assert set(Formula.parse(axis.predicate(value.id), names).names) <= set(names)


@given(
    st.dictionaries(st.from_regex(r"[A-Z][a-z]{0,3}", fullmatch=True), st.integers(0, 99), min_size=1, max_size=5),
    st.lists(st.floats(-1e12, 1e12).map(lambda number: float(number_text(number))), min_size=5, max_size=5),
    st.integers(0, 31),
)
def test_a_key_with_drawn_numbers_names_its_situation(levels, numbers, some):
    drawn = {axis: numbers[place] for place, axis in enumerate(levels) if some >> place & 1}
    situation = Situation.of(levels, drawn)
    assert Situation.parse(situation.key) == situation
    assert dict(situation.numbers) == drawn
    assert situation.point == Situation.of(levels)
    assert re.fullmatch(r"[A-Za-z0-9.=-]+", situation.key)  # plain in shells, globs, file names, CSV and web addresses


@pytest.mark.parametrize(
    "text", ["", "t0", "T", "T0=", "T0=x", "T0=1e", "T0T1", "T0 ", "T0=1+2", "T0=--1", "T0=1e999", "T\u0663", "T0\n"]
)
def test_a_text_that_is_no_key_names_no_situation(text):
    assert Situation.parse(text) is None


def of_scipy(own):
    low, width = own.low, own.high - own.low
    match own.shape:
        case Shape.UNIFORM:
            return stats.uniform(low, width)
        case Shape.LOG_UNIFORM:
            return stats.loguniform(low, own.high)
        case Shape.TRIANGULAR:
            return stats.triang((own.mode - low) / width, low, width)
        case Shape.NORMAL:
            ends = ((low - own.mean) / own.sd, (own.high - own.mean) / own.sd)
            return stats.truncnorm(*ends, own.mean, own.sd)


@st.composite
def distributions(draw):
    shape = draw(st.sampled_from(list(Shape)))
    low = draw(st.floats(0.01 if shape is Shape.LOG_UNIFORM else -50, 50))
    width = draw(st.floats(0.1, 100))
    mean, mode = low + width * draw(st.floats(-0.5, 1.5)), low + width * draw(st.floats(0, 1))
    sd, item = width * draw(st.floats(0.2, 5)), item_of("world.light", "set")
    return Drawn("world.light", low, low + width, "m", low, shape, mean=mean, sd=sd, mode=mode, item=item)


@given(distributions(), st.floats(0, 1))
def test_quantiles_are_those_of_scipy_and_of_nothing_and_everything_the_ends(own, share):
    assert own.quantile(share) == pytest.approx(of_scipy(own).ppf(share), rel=1e-6, abs=1e-6 * (own.high - own.low))
    assert own.low <= own.quantile(share) <= own.high
    assert (own.quantile(0.0), own.quantile(1.0)) == (own.low, own.high)


@st.composite
def ranges(draw):
    shapes = {"uniform": {}, "log-uniform": {}, "normal": {"mean": 2.0, "sd": 40.0}, "triangular": {"mode": 0.0}}
    shape = draw(st.sampled_from(list(shapes)))
    low = float(number_text(draw(st.floats(0.001 if shape == "log-uniform" else -1000, 1000))))
    high = float(number_text(low + draw(st.floats(0.5, 100)) * (1 + abs(low) / 10)))
    benign = min(max(float(number_text(low + draw(st.floats(0, 1)) * (high - low))), low), high)
    own = shapes[shape] | ({"mode": benign} if shape == "triangular" else {})
    ends = {"set": "light", "from": low, "to": high, "unit": "m", "bins": draw(st.integers(2, 6)), "benign": benign}
    try:
        return read(Range, item_of({**ends, **own, "distribution": shape}, "range"))
    except InputError as error:
        assume("equal at 4" not in str(error) and "distribution in the range" not in str(error))
        raise


SHARES = st.floats(0, 1, exclude_max=True)


@given(ranges(), SHARES, SHARES)
def test_a_drawn_number_lies_in_its_bin_and_is_the_number_that_is_written(own, at, share):
    bin_ = own.ids[int(at * len(own.ids))]
    number = own.draw(bin_, share)
    assert own.bin(number) == own.bin(own.middle(bin_)) == bin_
    assert float(number_text(number)) == number


@given(ranges())
def test_bins_have_equal_probability_and_ids_count_from_the_benign_bin_then_upwards(own):
    bins = len(own.ids)
    assert list(own.edges) == [float(number_text(own.quantile(place / bins))) for place in range(bins + 1)]
    middles = [own.quantile((place + 0.5) / bins) for place in range(bins)]
    assert [own.draw(bin_, 0.5) for bin_ in own.ids] == pytest.approx(middles, rel=1.1e-3)
    assert (own.bin(own.benign), own.middle(0)) == (0, own.benign)
    assert [id_ for id_ in own.ids if id_] == list(range(1, bins))
    found = [own.bin(number) for number in (own.edges[0], own.edges[-1], own.edges[-1] * 2 + 1e4)]
    assert found == [own.ids[0], own.ids[-1], None]


@given(st.floats(-1e6, 1e6))
def test_a_number_is_cut_to_the_next_written_one_below(number):
    below = cut(number)
    assert float(number_text(below)) == below <= number
    assert number - below <= max(abs(number) * 1.001e-3, 1e-300)
