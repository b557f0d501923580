from __future__ import annotations

import tracemalloc
import zlib
from dataclasses import replace
from types import SimpleNamespace

import pytest
from builders import KINDS
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.judge.outcome import TRACK_COLUMNS, Subject, outcome_of, pack_track, track_values, unpack_track
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.judge.space import Realisation, Space
from scaloft_fi.judge.stl import Formula
from scaloft_fi.sim.log import Ending

SIGNALS = {
    "elapsed_s": [0.0, 0.05, 0.1],
    "x_m": [0.0, 1.0, 1.2],
    "y_m": [0.0, 3.0, 3.5],
    "z_m": [1.6, 1.6, 1.65],
    "speed_mps": [0.0, 0.5, 0.4],
    "clearance_m": [1.0, 0.3, -0.001],
    "light": [1.0, 1.0, 1.0],
    "person_sight_m": [100.0, 3.2, 3.0],
}
RULES = (
    Requirement("SR1", Kind.SAFETY, "always(clearance_m > 0)"),
    Requirement("FAST", Kind.OPERABILITY, "always(speed_mps < 0.45)"),
)


def log(**changed: object) -> SimpleNamespace:
    facts = {
        "signals": SIGNALS,
        "ending": Ending.STRUCK,
        "struck": "wall",
        "stack_error": "",
        "counts": {"depth": SimpleNamespace(carried=9, altered=4, first_altered_s=0.05)},
        "digest": "d",
        "perceived_digest": "p",
        "duration_s": 0.1,
    }
    return SimpleNamespace(**(facts | changed))


def test_a_log_becomes_its_readings_violations_and_counts():
    flown = outcome_of(log(), Subject("M"), "S", 3, requirements=RULES)  # type: ignore[arg-type]
    assert (flown.name, flown.ending, flown.carried, flown.altered, flown.infected_at_s) == (
        "M/S/3",
        "struck",
        9,
        4,
        0.05,
    )
    struck, fast = flown.violations
    broken = [(r.requirement, r.kind, r.violated_at_s) for r in flown.readings if r.violated]
    assert broken == [(v.requirement, v.kind, v.t_s) for v in flown.violations]  # statuses follow from these
    assert (struck.requirement, struck.t_s, struck.x, struck.y, struck.z, struck.struck) == (
        "SR1",
        0.1,
        1.2,
        3.5,
        1.65,
        "wall",
    )
    # what is struck belongs to the moment of contact
    assert (fast.t_s, fast.struck) == (0.05, "")
    assert flown.first_violation == struck


def test_the_counts_of_all_patched_seams_are_joined():
    counts = {
        "depth": SimpleNamespace(carried=9, altered=0, first_altered_s=None),
        "pose": SimpleNamespace(carried=5, altered=2, first_altered_s=0.1),
    }
    flown = outcome_of(log(counts=counts), Subject("M"), "S", 0, requirements=RULES)  # type: ignore[arg-type]
    assert (flown.carried, flown.altered, flown.infected_at_s) == (14, 2, 0.1)


def test_a_log_with_a_sample_that_is_no_number_is_refused():
    broken = SIGNALS | {"clearance_m": [1.0, float("nan"), 1.0]}
    with pytest.raises(ValueError, match="clearance_m is nan at sample 1"):
        outcome_of(log(signals=broken), Subject("M"), "S", 0, requirements=RULES)  # type: ignore[arg-type]


def test_a_value_came_true_by_its_predicate_and_a_benign_one_when_no_other_did():
    space = Space(("D", "T"), (("0", "1"), ("0", "1", "2")), (("light", "dark"), ("none", "left", "right")), ())
    points = {"D0T0": ("0", "0"), "D1T1": ("1", "1"), "D0T2": ("0", "2")}
    space = replace(space, points=tuple(points.items()))
    dark = Formula.parse("always(light < 0.5)", SIGNALS)
    left, right = (Formula.parse(f"eventually({text})", SIGNALS) for text in ("x_m < -1", "x_m > 1.1"))
    realisation = Realisation(space, ((None, dark), (None, left, right)))
    assert realisation.of("D0T0", SIGNALS) == (("D", True), ("T", False))
    assert realisation.of("D1T1", SIGNALS) == (("D", False), ("T", False))
    assert realisation.of("D0T2", SIGNALS) == (("D", True), ("T", True))


def test_the_kinds_of_the_builders_are_those_of_the_study():
    assert [kind.value for kind in KINDS.values()] == ["safety", "safety", "reported", "operability"]


@given(st.integers(1, 50))
def test_a_track_keeps_every_fourth_sample_and_the_last(samples: int):
    column = [float(i) for i in range(samples)]
    rows = unpack_track(pack_track(dict.fromkeys(TRACK_COLUMNS, column)))
    assert [row[0] for row in rows] == [*column[::4], *([column[-1]] if (samples - 1) % 4 else [])]


@given(st.lists(st.integers(-100, 100), min_size=1, max_size=50))
def test_no_sample_is_faster_or_nearer_than_what_the_track_says_of_it(values: list[int]):
    signals = {name: list(map(float, values)) for name in TRACK_COLUMNS}
    rows = [dict(zip(TRACK_COLUMNS, row, strict=True)) for row in unpack_track(pack_track(signals))]
    for i, value in enumerate(values):
        row = rows[-(-i // 4)]
        assert row["speed_mps"] >= value >= row["clearance_m"]
        assert row["person_sight_m"] <= value


def test_no_track_has_no_rows():
    assert unpack_track(b"") == []


def test_a_track_that_unpacks_to_far_more_than_its_flight_is_refused_within_little_memory():
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
def test_bytes_that_are_no_track_are_an_error_of_the_value(content: bytes):
    for track in (content, zlib.compress(content)):
        try:
            rows = unpack_track(track)
        except ValueError:
            continue
        assert all(len(row) == len(TRACK_COLUMNS) for row in rows)
