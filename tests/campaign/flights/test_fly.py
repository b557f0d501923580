"""Facts of a flight; flights split off in real processes, without physics."""

from __future__ import annotations

import math
import os
import re
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest
from processes import alive, soon
from studies import copied, edit_in
from tiny_stack import Hop, hop

from scaloft_fi.campaign.flights.fly import CAN_FORK, Flight, Fork, as_baseline, facts, fly_log, invalid, reason_of
from scaloft_fi.campaign.processes import ATTEMPTS
from scaloft_fi.judge.outcome import Outcome, Subject
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operator import Facts
from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.registry import PLUGIN_GROUP
from scaloft_fi.sim.load import load
from scaloft_fi.sim.log import SIGNALS, DeclaredSignal, FlightLog, Side, SignalError
from scaloft_fi.sim.mine import Mine
from scaloft_fi.sim.stacks import STACKS
from scaloft_fi.study import Study

SIM = Path(__file__).parents[3] / "sim"


def of(**overrides: Any) -> Facts:
    config = load(SIM, {path.replace("__", "."): value for path, value in overrides.items()})
    return facts(config.scenario(config.grid.situation("T0O0W0D0H1")), config.stack.parameters)


def test_the_facts_are_of_the_study():
    config = load(SIM)
    scenario = config.scenario(config.grid.situation("T0O0W0D0H1"))
    found = facts(scenario, config.stack.parameters)
    assert (found.duration_s, found.sighting_s) == (scenario.nominal_s, scenario.sighting_s)
    assert found.settings == config.stack.parameters


def test_the_facts_follow_vehicle_sensors_and_mission():
    found = of(
        sensors__depth__fov_deg=75.0,
        sensors__imu__rate_sigma_radps=0.5,
        world__mission__cruise_mps=0.7,
        world__mission__slow_mps=0.1,
    )
    assert found.gyro_sigma_radps == 0.5
    assert found.view_rad == pytest.approx(math.radians(75.0))
    assert (found.cruise_mps, found.slow_mps) == (0.7, 0.1)


def test_the_wall_is_on_the_right_of_the_first_leg():
    there = of()
    assert there.wall_m == pytest.approx((1.5, 3.5), abs=0.01)
    assert there.inward == pytest.approx((-1.0, 0.0), abs=0.01)
    assert there.bearing_rad == pytest.approx(math.pi / 2, abs=0.01)


def test_the_half_width_is_half_the_width_of_the_hull():
    config = load(SIM)
    scenario = config.scenario(config.grid.situation("T0O0W0D0H0"))
    wide = replace(scenario, vehicle=replace(config.vehicle, hull_m=(0.5, 0.9, 0.1)))
    assert facts(wide, {}).half_width_m == 0.45


def test_without_a_wall_the_first_leg_gives_the_direction(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(Mine, "wall_towards", lambda *_: None)
    found = of()
    assert found.wall_m is None
    assert found.inward == (0.0, 0.0)
    assert found.bearing_rad == pytest.approx(math.pi / 2)


class Talking(Hop):
    def autopilot(self, now_s: float, frames: Any) -> None:
        super().autopilot(now_s, frames)
        sys.stdout.write("talks\n")
        sys.stdout.flush()
        os.write(1, b"beside Python\n")


@pytest.fixture
def hopping(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A study whose drone hops and talks."""
    folder = copied(tmp_path / "study")
    (folder / "sim" / "stack.yaml").write_text("name: hop\nmass_kg: 1.5\n")
    monkeypatch.setitem(STACKS._entries, "hop", hop(Talking))
    return folder


def _flown(folder: Path) -> FlightLog:
    study = Study.open(folder)
    return fly_log(study, Flight(None, study.grid.situations[0], 0))


@pytest.mark.flight
def test_what_a_stack_prints_in_a_flight_of_this_process_goes_to_the_standard_error(
    hopping: Path, capfd: pytest.CaptureFixture[str]
):
    polls = len(_flown(hopping).signals["elapsed_s"]) - 1
    assert capfd.readouterr() == ("", "talks\nbeside Python\n" * polls)


@pytest.mark.flight
@pytest.mark.parametrize(
    ("value", "said"),
    [
        (lambda state: float(state[2]), r"0\.5\d* at \d\.\d\d s, and declares a finite number of at most 0\.5 m"),
        (
            lambda state: math.nan if state[2] > 0.5 else 0.0,
            r"nan at \d\.\d\d s, and declares a finite number",
        ),
        (lambda state: str(state[2]), r"'0\.\d+', which is no number"),
    ],
)
def test_a_flight_whose_own_signal_is_not_what_it_declares_fails_in_the_harness_with_the_plugins_name(
    hopping: Path, monkeypatch: pytest.MonkeyPatch, value: Callable[[Any], Any], said: str
):
    edit_in(hopping / "sim" / "world.yaml", "\n", "\nsignals: [height_m]\n")
    height = DeclaredSignal("height_m", "m", "height", Side.TRUTH, lambda _scenario: value, most=0.5)
    monkeypatch.setitem(SIGNALS._entries, "height_m", height)
    monkeypatch.setattr("scaloft_fi.registry.plugins", lambda: (EntryPoint("odd", __name__, PLUGIN_GROUP),))
    with pytest.raises(SignalError) as refused:
        _flown(hopping)
    assert re.search(f"^plugin 'odd' of package .*: SignalError: signal height_m is {said}", reason_of(refused.value))


def test_what_never_differs_has_its_baselines_outcome_but_for_what_it_carried():
    baseline = Outcome(Subject("baseline"), "D0", 1, ending="landed", digest="d", realised=(("D", True),), track=b"t")
    subject = Subject("LATE-human@3s", "LATE", "human", "3s")
    assert as_baseline(baseline, subject, {"person": SeamCount(7, 0, None)}) == Outcome(
        subject, "D0", 1, ending="landed", carried=7, digest="d", track=b"t"
    )


forks = pytest.mark.skipif(not CAN_FORK, reason="this platform flies every flight whole")


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


@forks
def test_the_child_flies_on_with_the_state_and_its_outcome_comes_home(study: Any):
    flight, state = _flight(study), [1.0]
    (outcome,) = _split(flight, lambda: _outcome(flight, duration_s=state[0] + 1.0, track=b"x" * 1_000_000))
    assert outcome.duration_s == 2.0
    assert len(outcome.track) == 1_000_000


@forks
def test_nothing_that_the_child_does_reaches_the_trunk(study: Any):
    flight, state = _flight(study), [1.0]

    def spoil() -> Outcome:
        state[0] = 5.0
        return _outcome(flight)

    _split(flight, spoil)
    assert state == [1.0]


@forks
def test_a_child_that_dies_is_tried_again_and_then_invalid_with_the_reason(study: Any, tmp_path: Any):
    tries = tmp_path / "tries"

    def die() -> Outcome:
        with tries.open("a") as file:
            file.write("x")
        os.kill(os.getpid(), signal.SIGKILL)
        raise AssertionError

    (outcome,) = _split(_flight(study), die)
    assert outcome.invalid == "its process died: SIGKILL"
    assert len(tries.read_text()) == ATTEMPTS


@forks
def test_a_child_that_dies_once_is_flown_again_from_the_same_state(study: Any, tmp_path: Any):
    flight, mark = _flight(study), tmp_path / "was here"

    def die_once() -> Outcome:
        if not mark.exists():
            mark.touch()
            os._exit(3)
        return _outcome(flight)

    assert _split(flight, die_once) == [_outcome(flight)]


@forks
def test_a_child_that_hangs_is_ended(study: Any):
    def hang() -> Outcome:
        time.sleep(60.0)
        raise AssertionError

    (outcome,) = _split(_flight(study), hang, patience_s=0.05)
    assert outcome.invalid == "it hung: no end in 0.05 s of wall time"


@forks
def test_no_child_outlives_the_trunk(study: Any, tmp_path: Any):
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
