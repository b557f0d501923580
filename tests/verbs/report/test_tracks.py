"""Tracks come out of the page as they went in, to half a quantum."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.judge.outcome import TRACK_COLUMNS
from scaloft_fi.sim.log import FAR_M
from scaloft_fi.verbs.report.flights import FAR, coded, quantised, quantum, shared, thinned

values = st.floats(-150, 150, width=32)
rows = st.lists(st.tuples(*[values] * len(TRACK_COLUMNS)), min_size=1, max_size=12)
wholes = st.lists(st.tuples(*[st.integers(-FAR, FAR)] * 3), min_size=1, max_size=12)


@given(rows, st.integers(1, 3))
def test_a_value_comes_back_to_half_a_quantum_or_as_nothing_to_measure(
    track: list[tuple[float, ...]], coarse: int
) -> None:
    for row, whole in zip(track, quantised(track, TRACK_COLUMNS, coarse).tolist(), strict=True):
        for name, value, number in zip(TRACK_COLUMNS, row, whole, strict=True):
            if name in ("clearance_m", "person_sight_m") and value >= FAR_M:
                assert number == FAR
            else:
                assert abs(number * quantum(name, coarse) - value) <= quantum(name, coarse) / 2 + 1e-9


def test_what_is_no_number_is_nothing_to_measure() -> None:
    assert quantised([(math.nan,), (math.inf,)], ("speed_mps",)).tolist() == [[FAR], [FAR]]


@given(wholes, st.data())
def test_two_planes_of_bytes_hold_the_rows_after_the_shared_ones(
    track: list[tuple[int, ...]], data: st.DataObject
) -> None:
    whole = np.array(track, dtype=np.int32)
    same = data.draw(st.integers(0, len(track)))
    code = coded(whole, same)
    own = len(track) - same
    assert len(code) == 2 * 3 * own
    back = []
    for column in range(3):
        value = track[same - 1][column] if same else 0
        for row in range(own):
            low, high = code[column * own + row], code[3 * own + column * own + row]
            word = low + 256 * high
            value = (value + (word >> 1 ^ -(word & 1)) + 32768) % 65536 - 32768
            back.append((row, column, value))
    assert back == [(row, column, track[same + row][column]) for column in range(3) for row in range(own)]


@given(wholes, wholes)
def test_shared_counts_the_rows_before_the_first_that_differs(
    one: list[tuple[int, ...]], other: list[tuple[int, ...]]
) -> None:
    common = 0
    while common < min(len(one), len(other)) and one[common] == other[common]:
        common += 1
    assert shared(np.array(one, dtype=np.int32), np.array(other, dtype=np.int32)) == common


@given(rows, st.integers(1, 5))
def test_a_thinned_track_keeps_its_ends_and_its_extremes(track: list[tuple[float, ...]], every: int) -> None:
    kept = thinned(track, every)
    assert kept[0] == track[0]
    assert kept[-1][0] == track[-1][0]
    fastest, nearest = TRACK_COLUMNS.index("speed_mps"), TRACK_COLUMNS.index("clearance_m")
    assert max(row[fastest] for row in kept) == max(row[fastest] for row in track)
    assert min(row[nearest] for row in kept) == min(row[nearest] for row in track)
