from __future__ import annotations

import pytest
from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.judge.bounds import SIGHT_M, cap_of, check_caps, comparisons
from scaloft_fi.judge.stl import Formula, FormulaError, tokenize
from scaloft_fi.judge.stl.parse import parse
from scaloft_fi.sim import observer
from scaloft_fi.sim.log import signal_names
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.messages import BELIEFS


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
def test_a_threshold_where_a_signal_is_not_measured_is_refused_with_the_cap_and_what_is_allowed(
    text: str, said: str
) -> None:
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
    ],
)
def test_a_threshold_within_what_is_measured_is_let_pass(text: str) -> None:
    check_caps(text)


@pytest.mark.parametrize(
    "text",
    [
        "abs(clearance_m) < 1",
        "clearance_m < clearance_wall_m + 1",
        "clearance_m / speed_mps < 4",
        "1 / clearance_m < 1",
        "clearance_m * 0 < 1",
        "(clearance_m < 0.5) < 2",
        "clearance_m / 0 < 2",
    ],
)
def test_a_comparison_that_is_too_much_to_read_is_let_pass(text: str) -> None:
    check_caps(text)


def test_a_person_is_in_sight_as_far_as_the_observer_looks() -> None:
    assert SIGHT_M == observer.SIGHT_M


def test_every_clearance_has_a_cap_and_other_places_and_times_have_none() -> None:
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
def test_what_is_read_as_a_threshold_is_where_the_library_changes_its_mind(left: str, sign: str, right: str) -> None:
    text = f"always({left} {sign} {right})"
    for _, signal, threshold in comparisons(parse(tokenize(text))):
        assert signal == "a"
        at, below, above = Formula.parse(text.removeprefix("always"), ["a"]).robustness(
            {"a": [threshold, threshold - 1.0, threshold + 1.0]}
        )
        assert abs(at) < 1e-6
        assert below * above < 0
