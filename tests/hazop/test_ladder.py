from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import Magnitude, Worse, mild_to_strong, neutral, worse
from scaloft_fi.stack.reference.declaration import REFERENCE

REFERENCE = load_matrix(Path(__file__).parents[2] / "hazop", REFERENCE.by_name)
LADDERS = [
    pytest.param(fault.magnitude, id=f"{cell.name} {fault.magnitude.unit}")
    for cell in REFERENCE
    for fault in cell.faults
    if fault.magnitude
]


@given(st.lists(st.floats(0.001, 1e6), min_size=2, max_size=6, unique=True))
def test_a_ladder_that_is_sorted_has_the_direction_it_is_written_in(numbers: list[float]) -> None:
    rising = sorted(numbers)
    assert worse(Magnitude("v", "s", tuple(rising), rising[0])) is Worse.LARGER
    assert worse(Magnitude("v", "s", tuple(rising[::-1]), rising[0])) is Worse.SMALLER
    assert mild_to_strong(Magnitude("v", "s", tuple(rising[::-1]), rising[0])) == tuple(rising[::-1])


@given(st.lists(st.floats(0.001, 1e6), min_size=2, max_size=6, unique=True), st.randoms())
def test_what_the_study_says_outweighs_the_order_of_the_ladder(numbers: list[float], random: object) -> None:
    told = Magnitude("v", "s", tuple(numbers), numbers[0], worse="smaller")
    assert mild_to_strong(told) == tuple(sorted(numbers, reverse=True))


@pytest.mark.parametrize("ladder", [("x", "y"), (2.0,), (1.0, 3.0, 2.0)])
def test_names_single_rungs_and_mixed_ladders_have_no_order(ladder: tuple[float | str, ...]) -> None:
    magnitude = Magnitude("v", "", ladder, ladder[0])
    assert worse(magnitude) is Worse.UNORDERED
    assert mild_to_strong(magnitude) == ()
    assert neutral(magnitude) is None


@pytest.mark.parametrize("magnitude", LADDERS)
def test_in_the_reference_study_the_neutral_magnitude_is_milder_than_the_ladder(magnitude: Magnitude) -> None:
    nothing, ladder = neutral(magnitude), mild_to_strong(magnitude)
    if nothing is None or not ladder:
        return
    assert nothing < ladder[0] if worse(magnitude) is Worse.LARGER else nothing > ladder[0]
