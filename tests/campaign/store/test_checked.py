from __future__ import annotations

import zlib
from array import array
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from scaloft_fi.campaign.store.record import COLUMNS, MOST_TRACK_BYTES, checked, to_row
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading

TRACK = zlib.compress(array("f", range(14)).tobytes())
OUTCOME = Outcome(
    Subject("LATE-human@3s", "LATE", "human", "3s"),
    "T0",
    3,
    ending="landed",
    readings=(Reading("SR1", Kind.SAFETY, 0.5, None, 1, False), Reading("OP1", Kind.OPERABILITY, -0.5, 2.0, 1, False)),
    violations=(Violation("OP1", Kind.OPERABILITY, 2.0, 0.0, 1.0, 1.5, ""),),
    carried=7,
    altered=2,
    infected_at_s=1.5,
    duration_s=60.0,
    digest="0" * 64,
    perceived_digest="1" * 64,
    realised=(("T", True),),
    track=TRACK,
)
INVALID = Outcome(Subject("baseline"), "T0", 3, invalid="its worker process died")
BAD = {
    "mutant": (None, 1, "a\0b", ["a"]),
    "situation": (None, 7),
    "struck": ("\x1b[31mwall", "x" * 300, None),
    "seed": (-1, 1.0, True, "1", 1 << 63, None),
    "ending": ("", "flew away", None),
    "invalid": (None, 0),
    "carried": (-1, 1.5, None),
    "infected_at_s": ("1", float("nan"), float("inf"), True, 10**400),
    "duration_s": (None, float("nan"), -1.0, "60"),
    "digest": ("", "0" * 63, "0" * 65, "G" * 64, "0" * 64 + "\n", None),
    "perceived_digest": ("", "nonsense"),
    "stack_error": (None,),
    "readings": (
        "x",
        "1",
        "null",
        "[]",
        '["SR1", "safety", NaN, null, 1, false]',
        '["SR1", "safety", 1e999, null, 1, false]',
        '["SR1", "other", 0.5, null, 1, false]',
        '["SR1", "safety", "0.5", null, 1, false]',
        '["SR1", "safety", 0.5, null, 1, 0]',
        '["SR1", ["safety"], 0.5, null, 1, false]',
        "[" * 100_000,
        "9" * 5000,
        "\n",
        "\n".join(['["SR1", "safety", 0.5, null, 1, false]'] * 1001),
    ),
    "violations": ('["SR1", "safety", 0.5, Infinity, 0, 0, ""]', '["SR1", "safety", 0.5, 0, 0, 0, null]'),
    "realised": ('["T", 1]', '[["T"], true]'),
}


@pytest.mark.parametrize("outcome", [OUTCOME, INVALID], ids=["valid", "invalid"])
def test_an_outcome_comes_back_as_it_was(outcome: Outcome) -> None:
    assert checked(list(to_row(outcome)), outcome.track) == outcome


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in BAD.items() for value in values])
def test_a_wrong_value_is_refused_with_the_name_of_its_column(name: str, value: Any) -> None:
    row = dict(zip(COLUMNS, to_row(OUTCOME), strict=True)) | {name: value}
    with pytest.raises(ValueError, match=name):
        checked(list(row.values()), TRACK)


def test_what_is_taken_from_another_machine_can_be_read_from_the_store(tmp_path: Path) -> None:
    evil = dict(zip(COLUMNS, to_row(OUTCOME), strict=True)) | {"stack_error": "\x1b[31mdown\u202e"}
    with Store(tmp_path / "c.sqlite") as store:
        store.put("key", checked(list(evil.values()), TRACK))
    with Store(tmp_path / "c.sqlite", create=False) as store:
        assert store.get("key") == replace(OUTCOME, stack_error="\x1b[31mdown\u202e")


@pytest.mark.parametrize(
    "track",
    [
        b"no track",
        TRACK[:-1],
        TRACK + b"more",
        zlib.compress(b"\0" * 27),
        zlib.compress(array("f", [float("nan")] * 7).tobytes()),
        zlib.compress(b"\0" * (MOST_TRACK_BYTES + 28)),
    ],
)
def test_a_wrong_track_is_refused(track: bytes) -> None:
    with pytest.raises(ValueError, match="track"):
        checked(list(to_row(OUTCOME)), track)


@given(st.recursive(st.none() | st.integers() | st.text() | st.floats(), lambda inner: st.lists(inner, max_size=20)))
@example([None] * (len(COLUMNS) - 1))
def test_no_other_values_are_an_outcome(row: Any) -> None:
    assume(not (isinstance(row, list) and len(row) == len(COLUMNS)))
    with pytest.raises(ValueError, match="an outcome is a list"):
        checked(row, b"")


@given(st.lists(st.none() | st.booleans() | st.integers() | st.text() | st.floats(), min_size=19, max_size=19))
def test_any_row_gives_an_outcome_or_a_value_error(row: list[Any]) -> None:
    assert len(COLUMNS) == 19
    try:
        outcome = checked(row, b"")
    except ValueError:
        return
    assert to_row(outcome) == tuple(row)
