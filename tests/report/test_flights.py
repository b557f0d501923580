"""The packs of flights: every flight once, tracks shared, less of them by a rule that is said."""

from __future__ import annotations

import zlib
from array import array

import pytest
from papers import column
from reading import unpacked

from scaloft_fi.report.evidence import Evidence
from scaloft_fi.report.flights import DETAILS, Detail, columns, packs, rows_of
from scaloft_fi.results.outcome import BASELINE, PLACEBO
from scaloft_fi.results.track import unpack_track

NAMES = ("SR1", "SR2", "SR2-literal", "OP1")


def _read(evidence: Evidence, detail: Detail) -> dict[str, list[dict[str, object]]]:
    quanta = [entry["quantum"] for entry in columns(detail)]
    return {key: unpacked(pack, quanta) for key, pack in packs(evidence.outcomes, NAMES, detail).items()}


def test_every_flight_but_placebo_is_there_once(evidence: Evidence) -> None:
    found = [(f["mutant"], key, f["seed"]) for key, flights in _read(evidence, DETAILS[0]).items() for f in flights]
    assert sorted(found) == sorted((o.mutant, o.situation, o.seed) for o in evidence.outcomes if o.mutant != PLACEBO)


def test_a_track_of_the_page_is_the_flights_to_half_a_step(evidence: Evidence) -> None:
    read = _read(evidence, DETAILS[0])
    for outcome in evidence.outcomes:
        if outcome.mutant == PLACEBO or not outcome.track:
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
            elif detail.seeds == 1 and flight["seed"] == 1 and flight["mutant"] == "MORE-goal@0.6m":
                assert flight["rows"] is None


def test_a_flight_that_failed_says_why_and_has_no_track(evidence: Evidence) -> None:
    broken = [f for flights in _read(evidence, DETAILS[0]).values() for f in flights if f["invalid"]]
    assert [(f["status"], f["invalid"], f["rows"]) for f in broken] == [("invalid", "the worker died", None)]


def test_a_track_with_other_columns_is_no_track(evidence: Evidence) -> None:
    rows = unpack_track(evidence.outcomes[0].track)
    values = array("f", [value for row in rows for value in row[:5]])
    assert rows_of(evidence.outcomes[0].track) == rows
    assert rows_of(zlib.compress(values.tobytes())) == []
    assert rows_of(zlib.compress(values[:-1].tobytes())) == []
