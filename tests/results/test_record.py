from __future__ import annotations

import json
from dataclasses import replace

from builders import flights
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.record import from_json, to_json
from scaloft_fi.results.requirement import Kind


@given(flights(), st.binary(max_size=40))
def test_an_outcome_survives_json(flown: Outcome, track: bytes) -> None:
    kept = replace(flown, track=track)
    again = from_json(json.loads(json.dumps(to_json(kept), allow_nan=False)))
    assert again == kept
    assert hash(again) == hash(kept)
    assert all(isinstance(reading.kind, Kind) for reading in again.readings)


@given(flights())
def test_a_key_of_a_later_version_is_ignored(flown: Outcome) -> None:
    assert from_json(to_json(flown) | {"weather": "dry"}) == flown
