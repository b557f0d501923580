from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.judge.track import TRACK_COLUMNS, pack_track, unpack_track


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
