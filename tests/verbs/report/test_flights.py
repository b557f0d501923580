"""The packs of flights: every flight once, tracks to half a quantum, less of them by a rule that is said."""

from __future__ import annotations

import math
import zlib
from array import array
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from papers import column
from reading import unpacked

from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, TRACK_COLUMNS, Outcome, unpack_track
from scaloft_fi.sim.log import FAR_M
from scaloft_fi.verbs.report.analyses import Evidence
from scaloft_fi.verbs.report.flights import (
    DETAILS,
    FAR,
    Detail,
    coded,
    columns,
    packs,
    quantised,
    quantum,
    record,
    rows_of,
    shared,
    thinned,
)

NAMES = ("SR1", "SR2", "SR2-literal", "OP1")


def _read(evidence: Evidence, detail: Detail) -> dict[str, list[dict[str, object]]]:
    quanta = [entry["quantum"] for entry in columns(detail)]
    return {key: unpacked(pack, quanta) for key, pack in packs(evidence.outcomes, NAMES, detail).texts.items()}


def test_every_flight_but_placebo_is_there_once(evidence: Evidence) -> None:
    found = [(f["mutant"], key, f["seed"]) for key, flights in _read(evidence, DETAILS[0]).items() for f in flights]
    assert sorted(found) == sorted((o.mutant, o.situation, o.seed) for o in evidence.outcomes if o.mutant != PLACEBO_ID)


def test_a_track_of_the_page_is_the_flights_to_half_a_step(evidence: Evidence) -> None:
    read = _read(evidence, DETAILS[0])
    for outcome in evidence.outcomes[::7]:
        if outcome.mutant == PLACEBO_ID or not outcome.track:
            continue
        (flight,) = (f for f in read[outcome.situation] if (f["mutant"], f["seed"]) == (outcome.mutant, outcome.seed))
        rows = unpack_track(outcome.track)
        assert len(flight["rows"]) == len(rows)  # type: ignore[arg-type]
        for ours, theirs in zip(flight["rows"], rows, strict=True):  # type: ignore[call-overload]
            assert ours[0] == pytest.approx(theirs[0], abs=0.026)
            assert ours[column("x_m")] == pytest.approx(theirs[column("x_m")], abs=0.0051)
            assert ours[column("speed_mps")] == pytest.approx(theirs[column("speed_mps")], abs=0.0051)


def test_flights_that_equal_their_baseline_share_its_track(evidence: Evidence) -> None:
    for flights in _read(evidence, DETAILS[0]).values():
        clean = {f["seed"]: f["track"] for f in flights if f["mutant"] == BASELINE}
        same = [f for f in flights if f["mutant"] == "NO-depth@3s"]
        assert same
        assert all(f["track"] == clean[f["seed"]] for f in same)


@pytest.mark.parametrize("detail", DETAILS)
def test_less_detail_leaves_every_flight_and_every_baselines_track(evidence: Evidence, detail: Detail) -> None:
    for flights in _read(evidence, detail).values():
        for flight in flights:
            if flight["mutant"] == BASELINE:
                assert flight["rows"] is not None
            elif detail.seeds == 1 and flight["seed"] == 1 and flight["mutant"] == "LESS-goal@0.05m":
                assert flight["rows"] is None


def test_the_page_says_of_which_flights_it_has_tracks(evidence: Evidence) -> None:
    def says(outcomes: Iterable[Outcome], detail: Detail = DETAILS[0]) -> str:
        return packs(outcomes, NAMES, detail).says

    def only(kept: Callable[[Outcome], bool]) -> list[Outcome]:
        # a digest of its own, as the page shares tracks of equal flights
        own = [replace(o, digest=o.name) for o in evidence.outcomes]
        return [o if kept(o) else replace(o, track=b"") for o in own]

    assert says(evidence.outcomes) == "Tracks: every flight, 5 Hz, in steps of 0.01 m and 0.01 m/s."
    assert says(only(lambda _: False)) == "Tracks: of no flight; `replay` flies each again."
    published = says(only(lambda o: o.seed < (5 if o.mutant == BASELINE else 1)))
    counts, every, none, *_ = published.split(".  ")
    valid = [o for o in evidence.outcomes if o.mutant != PLACEBO_ID and not o.invalid]
    with_track = sum(o.seed < (5 if o.mutant == BASELINE else 1) for o in valid)
    assert counts == f"Tracks: {with_track} of {len(valid)} flights, 5 Hz, in steps of 0.01 m and 0.01 m/s"
    assert every == "Every flight of the unmutated drone with seeds 0-4, mutants with seed 0"
    assert none == "None of the unmutated drone with seeds 5-9, mutants with seeds 1-2"
    part = says(only(lambda o: o.situation.endswith("H1")), DETAILS[3])
    assert "Some of the unmutated drone with seeds 0-9, mutants with seed 0" in part
    assert "None of mutants with seeds 1-2" in part


def test_a_flight_that_failed_says_why_and_has_no_track(evidence: Evidence) -> None:
    broken = [f for flights in _read(evidence, DETAILS[0]).values() for f in flights if f["invalid"]]
    assert [(f["status"], f["invalid"], f["rows"]) for f in broken] == [("invalid", "the worker died", None)]


def test_a_track_with_other_columns_is_no_track(evidence: Evidence) -> None:
    rows = unpack_track(evidence.outcomes[0].track)
    values = array("f", [value for row in rows for value in row[:5]])
    assert rows_of(evidence.outcomes[0].track) == rows
    for damaged in (values, values[:-1]):
        with pytest.raises(ValueError, match="damaged"):
            rows_of(zlib.compress(damaged.tobytes()))


def test_a_reading_that_tests_nothing_has_no_robustness(evidence: Evidence) -> None:
    flown = next(outcome for outcome in evidence.outcomes if outcome.mutant == BASELINE and not outcome.struck)
    idle = replace(flown, readings=tuple(replace(r, rho=24.0, triggered=0) for r in flown.readings[:1]))
    told = record(idle, None, NAMES)["readings"]
    assert told == [[None, None, "vacuous", 0], None, None, None]


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
    for place in range(3):
        value = track[same - 1][place] if same else 0
        for row in range(own):
            low, high = code[place * own + row], code[3 * own + place * own + row]
            word = low + 256 * high
            value = (value + (word >> 1 ^ -(word & 1)) + 32768) % 65536 - 32768
            back.append((row, place, value))
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
