"""Flights split off in real processes, without physics."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from typing import Any

import pytest
from processes import alive, soon

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.flights.fly import invalid
from scaloft_fi.campaign.flights.fork import CAN_FORK, Fork
from scaloft_fi.campaign.processes import ATTEMPTS
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.mutant import Mutant

pytestmark = pytest.mark.skipif(not CAN_FORK, reason="this platform flies every flight whole")


def _flight(study: Any, name: str = "LATE-human@3s") -> Flight:
    return Flight(Mutant(name, "LATE", "human", "3s", 0.0, "velcmd", "delay"), study.grid[0], 0)


def _split(flight: Flight, in_child: Callable[[], Outcome], patience_s: float = 60.0) -> list[Outcome]:
    """What comes home of `flight` when the child does `in_child`."""
    home: list[Outcome] = []
    fork = Fork(home.append, invalid, patience_s)
    if fork(flight):
        try:
            outcome = in_child()
        except BaseException as error:
            fork.end(invalid(flight, repr(error)))
            raise
        fork.end(outcome)
    assert fork.taken is None
    return home


def _outcome(flight: Flight, **values: Any) -> Outcome:
    return Outcome(flight.subject, flight.situation.key, flight.seed, ending="landed", **values)


def test_the_child_flies_on_with_the_state_and_its_outcome_comes_home(study: Any) -> None:
    flight, state = _flight(study), [1.0]
    (outcome,) = _split(flight, lambda: _outcome(flight, duration_s=state[0] + 1.0, track=b"x" * 1_000_000))
    assert outcome.duration_s == 2.0
    assert len(outcome.track) == 1_000_000


def test_nothing_that_the_child_does_reaches_the_trunk(study: Any) -> None:
    flight, state = _flight(study), [1.0]

    def spoil() -> Outcome:
        state[0] = 5.0
        return _outcome(flight)

    _split(flight, spoil)
    assert state == [1.0]


def test_a_child_that_dies_is_tried_again_and_then_invalid_with_the_reason(study: Any, tmp_path: Any) -> None:
    tries = tmp_path / "tries"

    def die() -> Outcome:
        with tries.open("a") as file:
            file.write("x")
        os.kill(os.getpid(), signal.SIGKILL)
        raise AssertionError

    (outcome,) = _split(_flight(study), die)
    assert outcome.invalid == "its process died: SIGKILL"
    assert len(tries.read_text()) == ATTEMPTS


def test_a_child_that_dies_once_is_flown_again_from_the_same_state(study: Any, tmp_path: Any) -> None:
    flight, mark = _flight(study), tmp_path / "was here"

    def die_once() -> Outcome:
        if not mark.exists():
            mark.touch()
            os._exit(3)
        return _outcome(flight)

    assert _split(flight, die_once) == [_outcome(flight)]


def test_a_child_that_hangs_is_ended(study: Any) -> None:
    def hang() -> Outcome:
        time.sleep(60.0)
        raise AssertionError

    (outcome,) = _split(_flight(study), hang, patience_s=0.05)
    assert outcome.invalid == "it hung: no end in 0.05 s of wall time"


def test_no_child_outlives_the_trunk(study: Any, tmp_path: Any) -> None:
    number = tmp_path / "number"
    trunk = os.fork()
    if not trunk:

        def wait() -> Outcome:
            number.write_text(str(os.getpid()))
            time.sleep(60.0)
            os._exit(0)

        _split(_flight(study), wait)
        os._exit(0)
    assert soon(lambda: number.exists() and bool(number.read_text()))
    os.kill(trunk, signal.SIGKILL)
    os.waitpid(trunk, 0)
    assert soon(lambda: not alive(int(number.read_text())))
