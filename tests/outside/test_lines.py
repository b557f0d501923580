from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scaloft_fi.outside.border import BorderError, Land, Motion, Topic
from scaloft_fi.outside.client import VARIABLE, Connection, connect
from scaloft_fi.outside.lines import LONGEST_LINE, MOST_PROCESSES, LinesBorder
from scaloft_fi.stack.messages import Bumper

TOPICS = (Topic("touch", "/touch", Bumper, outward=True), Topic("drive", "/cmd_vel", Motion, outward=False))
STILL = {"velocity": [0.0, 0.0, 0.0], "turn_radps": 0.0}


@pytest.fixture
def border(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[LinesBorder]:
    opened = LinesBorder(TOPICS, tmp_path)
    opened.open()
    for name, value in opened.environment.items():
        monkeypatch.setenv(name, value)
    yield opened
    opened.close()


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


def test_the_border_lacks_a_process_until_one_has_named_each_topic(border: LinesBorder) -> None:
    assert border.lacking() == "no process has connected that publishes /cmd_vel"
    silent = connect()
    assert border.lacking() == "no process has connected that publishes /cmd_vel"
    talking = connect(publishes=["/cmd_vel"])
    assert [border.lacking() for _ in range(3)][-1] == ""
    silent.close()
    talking.close()


def test_the_border_lacks_no_topic_that_is_not_awaited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    border = LinesBorder((*TOPICS, Topic("land", "/land", Land, outward=False, awaited=False)), tmp_path)
    border.open()
    monkeypatch.setenv(VARIABLE, border.environment[VARIABLE])
    connection = connect(publishes=["/cmd_vel"])
    assert [border.lacking() for _ in range(2)][-1] == ""
    connection.close()
    border.close()


def test_samples_go_out_in_order_and_the_clock_is_last(border: LinesBorder, other: Connection) -> None:
    border.send("touch", 1.25, Bumper(1.25, hull=True, gear=False))
    border.clock(1.25)
    messages = iter(other)
    assert next(messages) == {
        "topic": "/touch",
        "t_s": 1.25,
        "data": {"stamp_s": 1.25, "hull": True, "gear": False},
    }
    assert next(messages) == {"clock": 1.25}


def test_an_answer_counts_from_the_clock_on(border: LinesBorder, other: Connection) -> None:
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
) -> None:
    raw(other, line)
    other.send("/cmd_vel", STILL)
    arrival = arrived(border)
    assert why in arrival.refused
    assert arrival.sample is not None


def test_of_a_flood_the_newest_sample_counts_and_no_tick_reads_without_end(
    border: LinesBorder, other: Connection
) -> None:
    border.clock(0.0)
    for number in range(1_000):
        other.send("/cmd_vel", STILL | {"turn_radps": number})
        if number % 100 == 0:
            border.wait("drive", 0.0)
    for _ in range(100):
        border._receive(0.0)
    arrival = border.take("drive")
    assert arrival.count == 1_000
    assert arrival.sample.turn_radps == 999


def test_a_line_without_end_ends_the_connection(border: LinesBorder, other: Connection) -> None:
    other._socket.setblocking(False)
    sent = 0
    while sent < 2 * LONGEST_LINE:
        try:
            sent += other._socket.send(b"x" * 65_536)
        except BlockingIOError:
            border._receive(0.0)
        except BrokenPipeError:
            break
    border._receive(0.0)
    assert "a line of more than 1,048,576 bytes" in border.take("drive").refused
    assert border.lacking().startswith("no process has connected")


def test_a_bounded_number_of_processes_may_connect(border: LinesBorder) -> None:
    many = [connect() for _ in range(MOST_PROCESSES)]
    for _ in range(MOST_PROCESSES + 1):
        border.lacking()
    one_more = connect()
    border.lacking()
    assert len(border._peers) == MOST_PROCESSES
    for connection in (*many, one_more):
        connection.close()


def test_a_process_that_ends_is_forgotten(border: LinesBorder, other: Connection) -> None:
    other.close()
    border.clock(0.05)
    border.clock(0.1)
    assert not border.wait("drive", 0.5)
    assert border.lacking().startswith("no process has connected")


def test_two_borders_do_not_hear_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    borders = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        borders.append(LinesBorder(TOPICS, tmp_path / name))
        borders[-1].open()
    monkeypatch.setenv(VARIABLE, borders[0].environment[VARIABLE])
    connection = connect(publishes=["/cmd_vel"])
    connection.send("/cmd_vel", STILL)
    assert borders[0].wait("drive", 0.2)
    assert not borders[1].wait("drive", 0.02)
    connection.close()
    for border in borders:
        border.close()


def test_a_socket_that_cannot_be_opened_is_named(tmp_path: Path) -> None:
    with pytest.raises(BorderError, match="the socket cannot be opened"):
        LinesBorder(TOPICS, tmp_path / "nowhere").open()
