from __future__ import annotations

import math
import sqlite3
from contextlib import closing
from dataclasses import replace

import pytest
from builders import campaigns, outcome
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.campaign.store.record import COLUMNS, Reader, Record, to_row
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind


def _stored(row: Record) -> Record:
    """What SQLite makes of a row."""
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.execute(f"CREATE TABLE t ({', '.join(f'{name} {cell.sql}' for name, cell in COLUMNS.items())})")
        connection.execute(f"INSERT INTO t VALUES ({', '.join('?' * len(row))})", row)
        stored: Record = connection.execute("SELECT * FROM t").fetchone()
        return stored


@given(campaigns(), st.binary(max_size=40))
def test_outcomes_survive_their_rows(flown: list[Outcome], track: bytes) -> None:
    read = Reader()
    for kept in flown:
        kept = replace(kept, track=track, stack_error="it's \u26a0")
        (again,) = read([_stored(to_row(kept))], [track])
        assert again == kept
        assert hash(again) == hash(kept)
        assert all(isinstance(reading.kind, Kind) for reading in again.readings)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_survive_to_the_bit(number: float) -> None:
    kept = outcome("LATE-human@3s", violated={"SR1": number})
    kept = replace(kept, duration_s=number, infected_at_s=number)
    assert Reader()([_stored(to_row(kept))]) == [kept]


@given(campaigns())
def test_many_rows_are_read_as_each_of_them(flown: list[Outcome]) -> None:
    rows = [to_row(kept) for kept in flown]
    assert Reader()(rows) == [outcome for row in rows for outcome in Reader()([row])] == flown


def test_a_number_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        to_row(outcome(violated={"SR1": math.nan}))


def test_what_two_flights_have_in_common_is_kept_once() -> None:
    read = Reader()
    one, other = read([to_row(outcome("LATE-human@3s", seed=seed, violated={"SR2": 3.0})) for seed in (0, 1)])
    assert one.subject is other.subject
    assert all(r is s for r, s in zip(one.readings + one.violations, other.readings + other.violations, strict=True))
