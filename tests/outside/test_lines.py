"""Samples as plain values, and the border `lines`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from scaloft_fi.outside.border import (
    PORTS,
    BorderError,
    CameraInfo,
    Goal,
    Land,
    MisfitError,
    Motion,
    Topic,
    from_plain,
    taken,
    to_plain,
)
from scaloft_fi.outside.border import given as mapped_out
from scaloft_fi.outside.client import VARIABLE, Connection, connect
from scaloft_fi.outside.lines import LONGEST_LINE, MOST_PROCESSES, LinesBorder
from scaloft_fi.stack.messages import Battery, Bumper, DepthFrame, Detections, Imu, Person
from scaloft_fi.stack.reference.messages import PoseEstimate, SpeedLimit

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
VECTORS = arrays(np.float64, 3, elements=NUMBERS)
WORDS = st.text(max_size=20)
SAMPLES = {
    Imu: st.builds(Imu, NUMBERS, VECTORS, VECTORS),
    DepthFrame: st.builds(DepthFrame, NUMBERS, arrays(np.float64, (3, 4), elements=NUMBERS)),
    Detections: st.builds(
        Detections, NUMBERS, st.lists(st.builds(Person, WORDS, NUMBERS, NUMBERS, NUMBERS), max_size=3).map(tuple)
    ),
    Battery: st.builds(Battery, NUMBERS, NUMBERS, NUMBERS, st.integers(0, 12)),
    Bumper: st.builds(Bumper, NUMBERS, st.booleans(), st.booleans()),
    PoseEstimate: st.builds(PoseEstimate, NUMBERS, VECTORS, VECTORS, NUMBERS, arrays(np.float64, 4, elements=NUMBERS)),
    CameraInfo: st.builds(
        CameraInfo, NUMBERS, st.integers(1, 640), st.integers(1, 480), NUMBERS, NUMBERS, NUMBERS, NUMBERS
    ),
    Motion: st.builds(Motion, VECTORS, NUMBERS),
    Goal: st.builds(Goal, st.tuples(NUMBERS, NUMBERS, NUMBERS)),
    SpeedLimit: st.builds(SpeedLimit, NUMBERS, NUMBERS, WORDS),
    Land: st.builds(Land, NUMBERS),
}
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


def same(one: Any, other: Any) -> bool:
    """Whether two samples have the same bits."""
    return all(np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b for a, b in zip(one, other, strict=True))


def test_every_port_has_samples_here():
    assert {port.message for port in PORTS.values()} == SAMPLES.keys()


@pytest.mark.parametrize("message", SAMPLES)
@given(data=st.data())
@settings(max_examples=10, deadline=None)
def test_a_sample_comes_back_bit_for_bit(message, data):
    sample = data.draw(SAMPLES[message])
    again = from_plain(message, json.loads(json.dumps(to_plain(sample))))
    assert type(again) is message
    assert same(sample, again)


@pytest.mark.parametrize("message", SAMPLES)
@given(value=JSON, field=st.integers(0, 6))
@settings(max_examples=20, deadline=None)
def test_whatever_json_holds_is_a_sample_or_refused_by_name(message, value, field):
    names = list(message._fields)
    plain = {name: [0.0, 0.0, 0.0] for name in names} | {names[field % len(names)]: value}
    for candidate in (value, plain):
        try:
            sample = from_plain(message, candidate)
        except MisfitError as error:
            named = str(error).startswith("data")
        else:
            named = type(sample) is message
        assert named


def test_a_refusal_names_the_field():
    with pytest.raises(MisfitError, match=r"data.turn_radps=nan must be finite"):
        from_plain(Motion, {"velocity": [0, 0, 0], "turn_radps": float("nan")})
    with pytest.raises(MisfitError, match=r"data.velocity must be a list of 3 numbers"):
        from_plain(Motion, {"velocity": [0, 0], "turn_radps": 0})
    with pytest.raises(MisfitError, match=r"data.speed is no field of Motion: velocity, turn_radps"):
        from_plain(Motion, {"velocity": [0, 0, 0], "turn_radps": 0, "speed": 1})
    with pytest.raises(MisfitError, match=r"data.depth must have height"):
        from_plain(DepthFrame, {"stamp_s": 0, "depth": {"height": 10**9, "width": 10**9, "data": ""}})


def test_fields_are_mapped_there_and_back_with_their_factor():
    fields = {"twist.linear.x": "velocity.x * 100", "twist.linear.y": "velocity.y", "rate": "turn_radps"}
    plain = {"velocity": [1.5, 2.0, 0.0], "turn_radps": 0.25}
    message = mapped_out(plain, fields)
    assert message == {"twist": {"linear": {"x": 150.0, "y": 2.0}}, "rate": 0.25}
    assert taken(message, fields) == plain
    with pytest.raises(MisfitError, match="rate is missing"):
        taken({"twist": message["twist"]}, fields)
    with pytest.raises(MisfitError, match=r"twist.linear.x must be a number"):
        taken({"twist": {"linear": {"x": "fast", "y": 0}}, "rate": 0}, fields)


TOPICS = (Topic("touch", "/touch", Bumper, outward=True), Topic("drive", "/cmd_vel", Motion, outward=False))
STILL = {"velocity": [0.0, 0.0, 0.0], "turn_radps": 0.0}


@contextmanager
def opened(folder: Path, *more: Topic) -> Iterator[LinesBorder]:
    """A border over the topics and `more`, which processes find."""
    border = LinesBorder((*TOPICS, *more), folder)
    with closing(border), pytest.MonkeyPatch.context() as patch:
        border.open()
        patch.setenv(VARIABLE, border.environment[VARIABLE])
        yield border


@pytest.fixture
def border(tmp_path: Path) -> Iterator[LinesBorder]:
    with opened(tmp_path) as border:
        yield border


@pytest.fixture
def other(border: LinesBorder) -> Iterator[Connection]:
    connection = connect(publishes=["/cmd_vel"])
    assert border.lacking() == "" or border.lacking() == ""
    yield connection
    connection.close()


def raw(connection: Connection, line: bytes) -> None:
    connection._socket.sendall(line + b"\n")


def arrived(border: LinesBorder) -> Any:
    border.wait("drive", 0.2)
    return border.take("drive")


def test_the_border_lacks_a_process_until_one_has_named_each_topic(border: LinesBorder):
    assert border.lacking() == "no process has connected that publishes /cmd_vel"
    silent = connect()
    assert border.lacking() == "no process has connected that publishes /cmd_vel"
    talking = connect(publishes=["/cmd_vel"])
    assert [border.lacking() for _ in range(3)][-1] == ""
    silent.close()
    talking.close()


def test_the_border_lacks_no_topic_that_is_not_awaited(tmp_path: Path):
    with opened(tmp_path, Topic("land", "/land", Land, outward=False, awaited=False)) as border:
        connection = connect(publishes=["/cmd_vel"])
        assert [border.lacking() for _ in range(2)][-1] == ""
        connection.close()


def test_samples_go_out_in_order_and_the_clock_is_last(border: LinesBorder, other: Connection):
    border.send("touch", 1.25, Bumper(1.25, hull=True, gear=False))
    border.clock(1.25)
    messages = iter(other)
    assert next(messages) == {"topic": "/touch", "t_s": 1.25, "data": {"stamp_s": 1.25, "hull": True, "gear": False}}
    assert next(messages) == {"clock": 1.25}


def test_an_answer_counts_from_the_clock_on(border: LinesBorder, other: Connection):
    other.send("/cmd_vel", STILL)
    assert border.wait("drive", 0.2)
    border.clock(0.05)
    assert not border.wait("drive", 0.02)
    other.send("/cmd_vel", STILL | {"turn_radps": 0.5})
    assert border.wait("drive", 0.2)
    arrival = border.take("drive")
    assert (arrival.count, arrival.refused) == (2, "")
    assert arrival.sample.turn_radps == 0.5
    np.testing.assert_array_equal(arrival.sample.velocity, np.zeros(3))
    assert border.take("drive").sample is None


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (b"{", "a line is not JSON"),
        (b"[1]", "a line must be a mapping"),
        (b"[" * 100_000, "a line is not JSON"),
        (b'{"topic": "/cmd_vel", "data": {"velocity": [NaN, 0, 0], "turn_radps": 0}}', "NaN is no number of JSON"),
        (b'{"topic": "/cmd_vel", "data": {"velocity": [1e999, 0, 0], "turn_radps": 0}}', "must be finite"),
        (b'{"topic": "/cmd_val", "data": {}}', "topic='/cmd_val' is none of /cmd_vel"),
        (b'{"topic": "/cmd_vel", "data": {"velocity": "fast"}}', "data.velocity must be a list of 3 numbers"),
        (b'{"topic": "/cmd_vel"}', "data must be a mapping"),
        (b'{"topic": "/cmd_vel", "stamp_s": 9, "data": {}}', "stamp_s=9 is later than the clock, 0"),
        (b'{"topic": "/cmd_vel", "stamp_s": "now", "data": {}}', "/cmd_vel: "),
        (b"\xff\xfe", "a line is not JSON"),
    ],
)
def test_a_message_that_does_not_fit_is_refused_and_the_next_one_counts(
    border: LinesBorder, other: Connection, line: bytes, why: str
):
    raw(other, line)
    other.send("/cmd_vel", STILL)
    arrival = arrived(border)
    assert why in arrival.refused
    assert arrival.sample is not None


def test_of_a_flood_the_newest_sample_counts_and_no_tick_reads_without_end(border: LinesBorder, other: Connection):
    border.clock(0.0)
    for number in range(1_000):
        other.send("/cmd_vel", STILL | {"turn_radps": number})
        if number % 100 == 0:
            border.wait("drive", 0.0)
    for _ in range(100):
        border._hear(0.0)
    arrival = border.take("drive")
    assert arrival.count == 1_000
    assert arrival.sample.turn_radps == 999


def test_a_line_without_end_ends_the_connection(border: LinesBorder, other: Connection):
    other._socket.setblocking(False)
    sent = 0
    while sent < 2 * LONGEST_LINE:
        try:
            sent += other._socket.send(b"x" * 65_536)
        except BlockingIOError:
            border._hear(0.0)
        except BrokenPipeError:
            break
    border._hear(0.0)
    assert "a line of more than 1,048,576 bytes" in border.take("drive").refused
    assert border.lacking().startswith("no process has connected")


def test_a_bounded_number_of_processes_may_connect(border: LinesBorder):
    many = [connect() for _ in range(MOST_PROCESSES)]
    for _ in range(MOST_PROCESSES + 1):
        border.lacking()
    one_more = connect()
    border.lacking()
    assert len(border._peers) == MOST_PROCESSES
    for connection in (*many, one_more):
        connection.close()


def test_a_process_that_ends_is_forgotten(border: LinesBorder, other: Connection):
    other.close()
    border.clock(0.05)
    border.clock(0.1)
    assert not border.wait("drive", 0.5)
    gone = "no process has connected that publishes /cmd_vel; one that did closed its end of the socket"
    assert border.lacking() == gone


def test_two_borders_do_not_hear_each_other(border: LinesBorder, tmp_path: Path):
    (tmp_path / "second").mkdir()
    with opened(tmp_path / "second") as second:
        connection = connect(publishes=["/cmd_vel"])
        connection.send("/cmd_vel", STILL)
        assert second.wait("drive", 0.2)
        assert not border.wait("drive", 0.02)
        connection.close()


def test_a_socket_that_cannot_be_opened_is_named(tmp_path: Path):
    with pytest.raises(BorderError, match="the socket cannot be opened"):
        LinesBorder(TOPICS, tmp_path / "nowhere").open()
