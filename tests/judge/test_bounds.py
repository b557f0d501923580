from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from options import usually

from scaloft_fi.judge.requirement import (
    ANY,
    SIGHT_M,
    TRUTH,
    Ranges,
    Spans,
    bounds_of,
    cap_of,
    check_caps,
    comparisons,
    constants,
    ranges_of,
    verdict,
    within_rock,
    without,
)
from scaloft_fi.judge.stl import CHANGES, Formula, FormulaError, parse, tokenize
from scaloft_fi.sim import observer
from scaloft_fi.sim.grid import load_grid
from scaloft_fi.sim.happenings import HAPPENINGS
from scaloft_fi.sim.log import SIGNALS, TRUTH_NAMES, clearance_name, signal_names
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.messages import BELIEFS

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


@pytest.mark.parametrize(("text", "always"), [("once", False), ("historically", True)])
def test_a_window_that_begins_after_the_longest_flight_is_empty(text: str, always: bool):
    ranges = {**RANGES, "elapsed_s": ((0.0, 599.0),)}
    assert verdict(bounds_of(Formula.parse(f"{text}[600:600](other > 3)", RANGES), ranges)) is always
    assert verdict(bounds_of(Formula.parse(f"{text}[599:600](other > 3)", RANGES), ranges)) is None


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
        ("other - other > 1", False),
        ("2 * other - other - other <= 0.5", True),
        ("landed == 0.5", False),
        ("landed == 1", None),
        ("rise(x_m < -7)", False),
        ("fall(x_m < -7)", None),
        ("other > 3", None),
    ],
)
def test_a_formula_that_no_flight_can_change_is_known(text: str, always: bool | None):
    assert verdict(bounds(text)) is always


def test_a_comparison_that_is_always_the_same_is_told_as_a_user_writes_it():
    formula = Formula.parse("(x_m / 2 < 30) and ((light > 0.5) or (abs(x_m) > 7))", RANGES.keys())
    assert list(constants(formula, RANGES)) == [("x_m / 2 < 30", True), ("abs(x_m) > 7", False)]


ATOMS = st.sampled_from(
    [
        "x_m < -1",
        "light > 0.5",
        "landed >= 0.5",
        "person_sight_m / 3 <= 1",
        "abs(x_m) * light >= 1",
        "x_m + light <= 2",
        "landed == light",
        "x_m - light - x_m > 0",
    ]
)
FORMULAS = st.recursive(
    ATOMS.map("({})".format),
    lambda inner: st.one_of(
        st.builds("(not {})".format, inner),
        st.builds("({} {} {})".format, inner, st.sampled_from(["and", "or", "implies", "iff", "since"]), inner),
        st.builds(
            "({}{})".format,
            st.sampled_from(
                [
                    "historically",
                    "once",
                    "historically[0:0.1]",
                    "once[0.05:0.1]",
                    "mean[0:0.1]",
                    "always",
                    "eventually",
                    *CHANGES,
                ]
            ),
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
def test_robustness_lies_within_the_bounds(text: str, signals: dict[str, list[float]]):
    formula = Formula.parse(text, RANGES.keys())
    spans = bounds_of(formula, RANGES)
    for value in formula.robustness(signals):
        inside = any(low - 1e-9 <= value <= high + 1e-9 for low, high in spans)
        assert inside or abs(value) == 1e9, (text, value, spans)  # 1e9 stands for an infinite robustness


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("eventually(clearance_cart_m < 1)", "compares clearance_cart_m with 1 m in 'clearance_cart_m < 1', but"),
        ("clearance_m >= 1", "measured up to 1 m and reads 1 m beyond; it must be compared with less than 1 m"),
        ("x_m < 1 and 1.5 > clearance_m", "compares clearance_m with 1.5 m in '1.5 > clearance_m'"),
        ("waypoint_wall_m <= 1", "compares waypoint_wall_m with 1 m"),
        ("person_sight_m / 3 <= 2.5", "with 7.5 m in 'person_sight_m / 3 <= 2.5', but it is measured up to 6 m and"),
        ("person_sight_m > 6.1", "reads 100 m beyond; it must be compared with at most 6 m"),
        ("person_range_m < 100", "reads 100 m without a person; it must be compared with less than 100 m"),
        ("told_range_m < 100", "compares told_range_m with 100 m"),
        ("clearance_m * 2 < 2", "with 1 m in 'clearance_m * 2 < 2'"),
        ("0.5 * (clearance_m - 0.2) < 1 / 2", "with 1.2 m"),
        ("3 - clearance_m > 1 + 1", "with 1 m"),
        ("clearance_m / 0.1 <= 10", "with 1 m"),
        ("historically[0:2](clearance_m < 1)", "with 1 m"),
        ("not (clearance_m) < 1", "with 1 m"),
    ],
)
def test_a_threshold_where_a_signal_is_not_measured_is_refused_with_the_cap_and_what_is_allowed(text: str, said: str):
    with pytest.raises(FormulaError) as caught:
        check_caps(text, REFERENCE.caps)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "eventually(clearance_cart_m < 0.999)",
        "always(clearance_m > 0)",
        "person_sight_m / 3 <= 2",
        "person_sight_m <= 6",
        "waypoint_wall_m <= 0.5",
        "person_range_m < 99",
        "speed_mps / 0.25 <= 1 and elapsed_s > 100",
        "clearance_m / 2 < 0.4",
        # too much to read
        "abs(clearance_m) < 1",
        "clearance_m < clearance_wall_m + 1",
        "clearance_m / speed_mps < 4",
        "1 / clearance_m < 1",
        "clearance_m * 0 < 1",
        "(clearance_m < 0.5) < 2",
        "clearance_m / 0 < 2",
    ],
)
def test_a_threshold_within_what_is_measured_or_too_much_to_read_is_let_pass(text: str):
    check_caps(text)


def test_a_person_is_in_sight_as_far_as_the_observer_looks():
    assert SIGHT_M == observer.SIGHT_M


def test_every_clearance_has_a_cap_and_other_places_and_times_have_none():
    capped = {name for name in signal_names(("wall", "left_wall"), BELIEFS) if cap_of(name, REFERENCE.caps)}
    clearances = {"clearance_m", "clearance_wall_m", "clearance_left_wall_m"}
    assert capped == clearances | {"waypoint_wall_m", "person_sight_m", "person_range_m", "told_range_m"}


def _is_formula(text: str) -> bool:
    """Whether a text is a formula; some sums need brackets."""
    try:
        Formula.parse(text, ["a"])
    except FormulaError:
        return False
    return True


numbers = st.integers(-4, 9).map(lambda number: str(number or 5))
sums = st.recursive(
    st.one_of(numbers, st.just("a")),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(" ".join), inner.map(lambda text: f"({text})")
    ),
    max_leaves=6,
).filter(lambda text: _is_formula(f"{text} > a"))


@settings(max_examples=usually(25, release=300))
@given(sums, st.sampled_from(["<", "<=", ">", ">="]), sums)
def test_what_is_read_as_a_threshold_is_where_the_library_changes_its_mind(left: str, sign: str, right: str):
    text = f"always({left} {sign} {right})"
    for _, signal, _, threshold in comparisons(parse(tokenize(text))):
        assert signal == "a"
        at, below, above = Formula.parse(text.removeprefix("always"), ["a"]).robustness(
            {"a": [threshold, threshold - 1.0, threshold + 1.0]}
        )
        assert abs(at) < 1e-6
        assert below * above < 0


WORLD = load_grid(Path(__file__).parents[2] / "sim").world()


def test_every_range_is_of_a_signal_and_agrees_with_its_cap():
    assert TRUTH.keys() <= {*TRUTH_NAMES, *SIGNALS, *HAPPENINGS["dust"].signals}
    for name, spans in TRUTH.items():
        cap = cap_of(name)
        assert cap is None or spans[0][1] == cap.most_m, name


def test_bodies_beliefs_and_marks_have_their_ranges():
    ranges = ranges_of(WORLD, BELIEFS, [clearance_name("bar"), "mode", "nothing_known", "clearance_m"])
    assert ranges[clearance_name("bar")] == ranges["clearance_m"] == ((-float("inf"), 1.0),)
    assert ranges["mode"][0][0] == 0.0
    assert ranges["nothing_known"] == ANY


def test_the_rock_bounds_the_position_and_a_study_has_its_person():
    rock = within_rock(WORLD)
    assert -6.1 < rock["x_m"][0][0] < -5.4
    assert rock["z_m"] == (pytest.approx((0.0, 2.7)),)
    assert without(WORLD) == {}
