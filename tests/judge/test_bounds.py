from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.judge.bounds import ANY, Ranges, Spans, bounds_of, constants, verdict
from scaloft_fi.judge.stl import Formula

RANGES: Ranges = {
    "x_m": ((-6.0, 2.0),),
    "speed_mps": ((0.0, math.inf),),
    "light": ((0.0, 1.0),),
    "landed": ((0.0, 0.0), (1.0, 1.0)),
    "person_sight_m": ((0.0, 6.0), (100.0, 100.0)),
    "other": ANY,
}


def bounds(text: str) -> Spans:
    return bounds_of(Formula.parse(text, RANGES.keys()), RANGES)


@pytest.mark.parametrize(
    ("text", "always"),
    [
        ("x_m < -7", False),
        ("x_m < -1", None),
        ("eventually(x_m < 9)", True),
        ("always(light <= 0.05)", None),
        ("speed_mps >= 0", True),
        ("speed_mps / 0.25 <= 1", None),
        ("person_sight_m / 3 <= 40", True),
        ("(person_sight_m > 7) and (person_sight_m < 99)", None),  # each may be true, and spans know no two signals
        ("person_sight_m - 50 >= 60", False),
        ("landed >= 0.5", None),
        ("landed > 1.5", False),
        ("abs(x_m) < 7", True),
        ("x_m * x_m < 40", True),
        ("not (x_m < -7)", True),
        ("(x_m < -7) or (light > 2)", False),
        ("(x_m < -7) implies (other > 3)", True),
        ("historically[0:2](light <= 1)", True),
        ("once[0:2](light > 2)", False),
        ("once[1:2](light <= 1)", None),  # nothing is within such a window at the start of a flight
        ("(light <= 1) since (light > 2)", False),
        ("sqrt(speed_mps) >= 0", True),
        ("other > 3", None),
    ],
)
def test_a_formula_that_no_flight_can_change_is_known(text: str, always: bool | None) -> None:
    assert verdict(bounds(text)) is always


def test_a_comparison_that_is_always_the_same_is_told_as_a_user_writes_it() -> None:
    formula = Formula.parse("(x_m / 2 < 30) and ((light > 0.5) or (abs(x_m) > 7))", RANGES.keys())
    assert list(constants(formula, RANGES)) == [("x_m / 2 < 30", True), ("abs(x_m) > 7", False)]


ATOMS = st.sampled_from(
    ["x_m < -1", "light > 0.5", "landed >= 0.5", "person_sight_m / 3 <= 1", "abs(x_m) * light >= 1", "x_m + light <= 2"]
)
FORMULAS = st.recursive(
    ATOMS.map("({})".format),
    lambda inner: st.one_of(
        st.builds("(not {})".format, inner),
        st.builds("({} {} {})".format, inner, st.sampled_from(["and", "or", "implies", "iff", "since"]), inner),
        st.builds(
            "({}{})".format,
            st.sampled_from(["historically", "once", "historically[0:0.1]", "once[0.05:0.1]", "always", "eventually"]),
            inner,
        ),
    ),
    max_leaves=4,
)


@st.composite
def samples(draw: st.DrawFn) -> dict[str, list[float]]:
    """Three samples of each signal within its range."""

    def column(spans: Spans) -> list[float]:
        within = st.one_of(*(st.floats(max(low, -1e3), min(high, 1e3)) for low, high in spans))
        return draw(st.lists(within, min_size=3, max_size=3))

    return {name: column(spans) for name, spans in RANGES.items()}


@given(text=FORMULAS, signals=samples())
def test_robustness_lies_within_the_bounds(text: str, signals: dict[str, list[float]]) -> None:
    formula = Formula.parse(text, RANGES.keys())
    spans = bounds_of(formula, RANGES)
    for value in formula.robustness(signals):
        inside = any(low - 1e-9 <= value <= high + 1e-9 for low, high in spans)
        assert inside or abs(value) == 1e9, (text, value, spans)  # 1e9 stands for an infinite robustness
