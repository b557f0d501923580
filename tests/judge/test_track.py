from __future__ import annotations

import tracemalloc
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.judge.outcome import TRACK_COLUMNS, pack_track, track_values, unpack_track


@given(st.integers(1, 50))
def test_a_track_keeps_every_fourth_sample_and_the_last(samples: int) -> None:
    column = [float(i) for i in range(samples)]
    rows = unpack_track(pack_track(dict.fromkeys(TRACK_COLUMNS, column)))
    assert [row[0] for row in rows] == [*column[::4], *([column[-1]] if (samples - 1) % 4 else [])]


@given(st.lists(st.integers(-100, 100), min_size=1, max_size=50))
def test_no_sample_is_faster_or_nearer_than_what_the_track_says_of_it(values: list[int]) -> None:
    signals = {name: list(map(float, values)) for name in TRACK_COLUMNS}
    rows = [dict(zip(TRACK_COLUMNS, row, strict=True)) for row in unpack_track(pack_track(signals))]
    for i, value in enumerate(values):
        row = rows[-(-i // 4)]
        assert row["speed_mps"] >= value >= row["clearance_m"]
        assert row["person_sight_m"] <= value


def test_no_track_has_no_rows() -> None:
    assert unpack_track(b"") == []


def test_a_track_that_unpacks_to_far_more_than_its_flight_is_refused_within_little_memory() -> None:
    bomb = zlib.compress(bytes(50_000_000), 9)
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match="longer than 700 rows"):
            track_values(bomb, 700)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 1_000_000
    with pytest.raises(ValueError, match="longer than"):
        unpack_track(bomb)


@given(st.binary(max_size=60))
def test_bytes_that_are_no_track_are_an_error_of_the_value(content: bytes) -> None:
    for track in (content, zlib.compress(content)):
        try:
            rows = unpack_track(track)
        except ValueError:
            continue
        assert all(len(row) == len(TRACK_COLUMNS) for row in rows)
