from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from items import item_of
from ranges import CRUISE, with_range

from scaloft_fi.errors import InputError
from scaloft_fi.model import read
from scaloft_fi.sim.load import load
from scaloft_fi.sim.situation import Range, cut, number_text


@st.composite
def ranges(draw: st.DrawFn) -> Range:
    own = draw(
        st.sampled_from(
            [
                {"distribution": "uniform"},
                {"distribution": "log-uniform"},
                {"distribution": "normal", "mean": 2.0, "sd": 40.0},
                {"distribution": "triangular"},
            ]
        )
    )
    low = draw(st.floats(0.001 if own["distribution"] == "log-uniform" else -1000, 1000))
    low = float(number_text(low))
    high = float(number_text(low + draw(st.floats(0.5, 100)) * (1 + abs(low) / 10)))
    share = draw(st.floats(0, 1))
    benign = min(max(float(number_text(low + share * (high - low))), low), high)
    mode = {"mode": benign} if own["distribution"] == "triangular" else {}
    ends = {"set": "light", "from": low, "to": high, "unit": "m", "bins": draw(st.integers(2, 6)), "benign": benign}
    try:
        return read(Range, item_of({**ends, **own, **mode}, "range"))
    except InputError as error:
        assume("equal at 4" not in str(error) and "distribution in the range" not in str(error))
        raise


SHARES = st.floats(0, 1, exclude_max=True)


@given(ranges(), SHARES, SHARES)
def test_a_drawn_number_lies_in_its_bin_and_is_the_number_that_is_written(own: Range, at: float, share: float) -> None:
    bin_ = own.ids[int(at * len(own.ids))]
    number = own.draw(bin_, share)
    assert own.bin(number) == bin_
    assert float(number_text(number)) == number
    assert own.bin(own.middle(bin_)) == bin_


@given(ranges())
def test_bins_have_equal_probability(own: Range) -> None:
    bins = len(own.ids)
    for place, edge in enumerate(own.edges):
        exact = own.distribution.quantile(place / bins)
        assert edge == float(number_text(exact))
    draws = [own.draw(bin_, 0.5) for bin_ in own.ids]
    for place, number in enumerate(draws):
        exact = own.distribution.quantile((place + 0.5) / bins)
        assert number == pytest.approx(exact, rel=1.1e-3)


@given(ranges())
def test_ids_count_from_the_benign_bin_then_upwards(own: Range) -> None:
    assert own.bin(own.benign) == 0
    assert own.middle(0) == own.benign
    assert [id_ for id_ in own.ids if id_] == list(range(1, len(own.ids)))
    assert own.bin(own.edges[0]) == own.ids[0]
    assert own.bin(own.edges[-1]) == own.ids[-1]
    assert own.bin(own.edges[-1] * 2 + 1e4) is None


@given(st.floats(-1e6, 1e6))
def test_a_number_is_cut_to_the_next_written_one_below(number: float) -> None:
    below = cut(number)
    assert below <= number
    assert float(number_text(below)) == below
    assert number - below <= max(abs(number) * 1.001e-3, 1e-300)


BAD = [
    ("from: 0.4", "from: 1.4", "to=1.2 must be > 1.4, which is 'from'"),
    ("from: 0.4", "from: 1.2", "to=1.2 must be > 1.2"),
    ("from: 0.4", "from: .nan", "from=nan must be a number"),
    ("to: 1.2", "to: .inf", "to=inf must be a finite number"),
    ("to: 1.2", "to: 1.23456", "to=1.23456 must be a number with at most 4 significant digits, such as 1.235"),
    ("bins: 4", "bins: 0", "bins=0 must be a whole number >= 2"),
    ("bins: 4", "bins: 1", "bins=1 must be a whole number >= 2"),
    ("bins: 4", "bins: 1000000000", "bins=1000000000 must be a whole number >= 2 and <= 100"),
    ("bins: 4", "bins: 2.5", "bins=2.5 must be a whole number"),
    ("to: 1.2", "to: 0.4003", "bins=4 must be less: two ends of bins are equal at 4 significant digits"),
    ("benign: 0.5", "benign: 0.3", "benign=0.3 must be 0.4 to 1.2, within the range"),
    ("distribution: uniform", "distribution: unifrom", "distribution='unifrom' is not known; did you mean 'uniform'?"),
    ("distribution: uniform", "distribution: uniform\n      mode: 0.5", "unknown key 'mode' in range"),
    ("distribution: uniform", "distribution: triangular\n      mode: 2", "mode=2 must be >= 0.4 and <= 1.2"),
    ("distribution: uniform", "distribution: normal\n      mean: 1\n      sd: 0", "sd=0 must be > 0"),
    ("distribution: uniform", "distribution: normal\n      mean: 1", "range lacks the key 'sd'"),
    (
        "distribution: uniform",
        "distribution: normal\n      mean: 9\n      sd: 0.1",
        "mean=9 must be nearer: sd=0.1 leaves less than 1e-06 of the distribution in the range",
    ),
    (
        "from: 0.4\n      to: 1.2\n      unit: m/s\n      distribution: uniform",
        "from: -1\n      to: 1.2\n      unit: m/s\n      distribution: log-uniform",
        "from=-1 must be > 0, because the distribution is log-uniform",
    ),
    ("      unit: m/s\n", "", "range lacks the key 'unit'"),
    ("set: mission.cruise_mps", "set: mission.cruise_mp", "did you mean 'world.mission.cruise_mps'?"),
    ("set: mission.cruise_mps", "set: bodies.bar.position", "position=0.5 must be a list"),
    ("set: mission.cruise_mps", "set: bodies.bar.role", "role=0.5 is not known"),
    ("set: mission.cruise_mps", "set: stack.planner.range_m", "belongs to the stack under test"),
    ("from: 0.4", "from: 0", "cruise_mps=0.0 must be"),
    (
        "set: mission.cruise_mps\n      from: 0.4\n      to: 1.2",
        "set: bodies.bar.reflectivity\n      from: 0.4\n      to: 1.05",
        "reflectivity=1.05 must be",
    ),
    ("set: mission.cruise_mps\n      from: 0.4", "set: vehicle.mass_kg\n      from: 0", "mass_kg=0.0 must be >= 1e-06"),
    ("    realised: eventually(speed_mps >= 0.8 * number)\n", "", "C lacks the key 'realised': a formula"),
    (
        "      distribution: uniform\n",
        "",
        "range lacks the key 'distribution': how the number is distributed: uniform, log-uniform",
    ),
    (
        "    realised:",
        "    values: [{id: 0, title: a}]\n    realised:",
        "C={...} must be an axis with either 'values' or 'range'",
    ),
]


@pytest.mark.parametrize(("old", "new", "sentence"), BAD)
def test_ranges_that_cannot_be_are_refused_with_their_line(study: Path, old: str, new: str, sentence: str) -> None:
    assert old in CRUISE
    with pytest.raises(InputError) as error:
        load(with_range(study, CRUISE.replace(old, new)))
    assert sentence in str(error.value)
    assert "situations.yaml:" in str(error.value)
    assert "\n" not in str(error.value)
