from __future__ import annotations

from typing import Any

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.campaign.workers.inert import MOST_PARTS, inert_scheme, plain

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats(allow_nan=False) | st.text() | st.binary(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text() | st.binary(), inner),
    max_leaves=20,
)


def _holds_bytes(value: Any) -> bool:
    if isinstance(value, dict):
        return any(map(_holds_bytes, (*value, *value.values())))
    return isinstance(value, bytes) or (isinstance(value, tuple) and any(map(_holds_bytes, value)))


@given(VALUES)
def test_no_bytes_pass(value: Any) -> None:
    assert not _holds_bytes(plain(msgpack.packb(value)))


@given(st.binary())
def test_no_frame_raises(frame: bytes) -> None:
    assert not _holds_bytes(plain(frame))


@pytest.mark.parametrize(
    "frame",
    [b"", b"\xc1", b"\x91" * 100_000, b"\xdd\xff\xff\xff\xff", msgpack.packb(1) * 2, b"\x81\x90\xc0" * 2, b"\xa1\xff"],
)
def test_what_is_no_message_is_none(frame: bytes) -> None:
    assert plain(frame) is None


def test_a_message_of_too_many_parts_is_none() -> None:
    for count in (MOST_PARTS - 5, MOST_PARTS + 1):
        message = plain(b"\xdd" + count.to_bytes(4, "big") + b"\x80" * count)
        assert (message is None) == (count > MOST_PARTS)


def test_plain_values_pass_and_objects_of_other_frames_do_not() -> None:
    message = [{"op": "key-in-memory", "key": "k", "type": b"pickle"}, {"a": [1, 0.5, "x", True, None]}]
    assert plain(msgpack.packb(message)) == (
        {"op": "key-in-memory", "key": "k", "type": None},
        {"a": (1, 0.5, "x", True, None)},
    )
    objects = {"x": {"__Serialized__": 1}, "y": {"__Pickled__": 2}, "z": msgpack.ExtType(5, b"1"), "e": {"__Enum__": 1}}
    assert plain(msgpack.packb(objects)) == {"x": None, "y": None, "z": (5, None), "e": {"__Enum__": 1}}


def test_events_for_dasks_own_handlers_do_not_pass() -> None:
    events = [{"op": "event", "topic": topic, "event": (0, 1)} for topic in ("print", "warn", None, "scaloft-fi-1")]
    assert [event["topic"] for event in plain(msgpack.packb(events))] == ["scaloft-fi-1"]


def test_a_scheme_ends_with_its_run() -> None:
    from distributed.comm.registry import backends

    before = dict(backends)
    with inert_scheme(tls=False, skipped=lambda: None) as scheme:
        assert scheme in backends
    assert backends == before
