from __future__ import annotations

import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path

import pytest
from builders import campaigns, outcome, seeded
from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.campaign.store.origin import Origin
from scaloft_fi.campaign.store.record import Planned
from scaloft_fi.campaign.store.store import FlownFlight, Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome

M = "LATE-human@3s"
HERE = "T0O0W0D0H0"


@settings(deadline=None, max_examples=usually(25, release=60))
@given(st.one_of(campaigns(), seeded()), st.data())
def test_the_flights_that_stand_are_read_and_no_others(flown: list[Outcome], data: st.DataObject) -> None:
    stale = {str(number) for number in data.draw(st.sets(st.integers(0, len(flown))))}
    rows = [(str(number), one) for number, one in enumerate(flown)]
    with tempfile.TemporaryDirectory() as folder, Store(Path(folder) / "s.sqlite") as store:
        store.put_all(rows)
        standing = store.standing(lambda flight: flight.key not in stale)
    assert {one.name for one in standing} == {one.name for key, one in rows if key not in stale}


def test_whether_flights_stand_is_asked_once_of_what_they_were_made_from(tmp_path: Path) -> None:
    one, other = (Origin("s", "r", "c", "m", situation) for situation in ("t", "u"))
    with Store(tmp_path / "s.sqlite") as store:
        store.plan(Planned(o.key(s), M, HERE, s, origin=o) for o in (one, other) for s in (0, 1))
        for made_from in (one, other):
            for seed in (1, 0):
                store.put(made_from.key(seed), outcome(M, seed=seed, digest=made_from.situation))
        store.put("k", outcome(M, seed=7))
        numbers = {origin: number for number, origin in store.origins().items()}
        asked: list[FlownFlight] = []

        def stands(flight: FlownFlight) -> bool:
            asked.append(flight)
            return flight.origin != numbers[one]

        assert [(o.digest, o.seed) for o in store.standing(stands)] == [("u", 0), ("u", 1), (M, 7)]
        assert [flight.origin for flight in asked] == [numbers[one], numbers[other], None]
        assert store.flights()[-1] == FlownFlight("k", M, HERE, 7, None)


def test_a_store_with_a_row_that_cannot_be_read_is_closed_while_the_error_is_still_looked_at(tmp_path: Path) -> None:
    path = tmp_path / "s.sqlite"
    with Store(path) as store:
        store.put_all((str(seed), outcome(M, seed=seed)) for seed in range(3))
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("UPDATE outcomes SET digest = CAST(X'FFFE' AS TEXT) WHERE seed = 1")
        connection.commit()
    with pytest.raises(InputError, match=r"id 2: digest="), Store(path, create=False) as store:
        store.keyed()
    assert [one.name for one in tmp_path.iterdir()] == [path.name]
