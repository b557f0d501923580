"""Steps outside the physics server have the bits of steps inside, whoever listens, and are left to it where not."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pybullet
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.sim import flight
from scaloft_fi.sim.build import VEHICLE_GROUP, WORLD_GROUP, physics_server, set_up
from scaloft_fi.sim.flight import BLOCK, CompiledStepper, FlightLoop, StackError, fly
from scaloft_fi.sim.load import load
from scaloft_fi.sim.log import Ending
from scaloft_fi.sim.vehicle import KEPT_RATES, Airframe, attitude_of, free_step
from scaloft_fi.stack.declaration import STEPS_PER_TICK, PlainWire
from scaloft_fi.stack.messages import Imu, Thrust
from scaloft_fi.stack.reference.flight_control import FlightControl
from tests.sim.conftest import SIM

SKIPPED = FlightControl.seams
BENIGN = "T0O0W0D0H0"

pytestmark = pytest.mark.flight


class LeaningWire(PlainWire):
    """Listens in some ticks only; changes nothing, or loses the inertial samples of a while."""

    def __init__(self, ticks, lost_s=(0.0, 0.0), seams=SKIPPED):
        self.ticks, self.lost_s, self.seams, self.now, self.carried = ticks, lost_s, seams, 0, 0

    def listens(self, seam):
        return seam in self.seams and self.now in self.ticks

    def cross(self, seam, t_s, sample):
        self.carried += seam in SKIPPED
        return None if isinstance(sample, Imu) and self.lost_s[0] <= t_s < self.lost_s[1] else sample


@cache
def reference():
    return load(SIM)


def flown(wire, ticks, key=BENIGN, seed=0):
    """Digests, state, estimate and controller after so many ticks, but for the thrust, which a step writes anew."""
    config = reference()
    with physics_server() as client:
        loop = FlightLoop(client, config, config.scenario(config.grid.situation(key)), seed, wire)
        for wire.now in range(ticks):
            if not loop.tick():
                break
            loop.advance()
        log = loop.log()
        estimate, controlled = loop.stack.fast_path.begin()
        facts = log.digest, log.perceived_digest, log.ending, log.struck, loop.airframe.truth
        return (*facts, estimate.tobytes(), controlled[:-4].tobytes())


@settings(max_examples=8)
@given(
    key=st.sampled_from([BENIGN, "T1O1W0D0H1", "T1O1W1D1H1"]),
    seed=st.integers(0, 2**31),
    ticks=st.integers(1, 160),
    heard=st.sets(st.integers(0, 159)),
    seams=st.sampled_from([SKIPPED, ("imu",), ("thrust",)]),
)
def test_a_flight_has_the_same_bits_whether_or_not_anybody_listens(key, seed, ticks, heard, seams):
    never, always, sometimes = (LeaningWire(at, seams=seams) for at in (set(), set(range(ticks)), heard))
    whole = flown(never, ticks, key, seed)
    assert flown(always, ticks, key, seed) == whole
    assert flown(sometimes, ticks, key, seed) == whole
    assert always.carried == 24 * ticks
    assert never.carried <= sometimes.carried <= always.carried


@pytest.mark.parametrize("seams", [(), ("imu",), ("thrust",), SKIPPED])
def test_a_wire_that_listens_on_a_skipped_seam_has_the_servers_steps_where_nothing_can_be_touched(monkeypatch, seams):
    """So PLACEBO, which listens on every seam, compares the server with the compiled steps."""
    counted, step = [], Airframe.step
    monkeypatch.setattr(Airframe, "step", lambda self, *rest: counted.append(rest[-1]) or step(self, *rest))
    flown(LeaningWire(set(range(100)), seams=seams), 100)
    whole_ticks = counted.count(STEPS_PER_TICK)
    assert whole_ticks > 50 if seams else whole_ticks == 0


def test_many_steps_at_once_are_as_many_single_ones_and_a_stack_without_a_fast_path_flies_the_same(monkeypatch):
    whole, advance = flown(PlainWire(), 100), CompiledStepper.advance
    singly = lambda self, first, count: max(advance(self, step, 1) for step in range(first, first + count))  # noqa: E731
    monkeypatch.setattr(CompiledStepper, "advance", singly)
    assert flown(PlainWire(), 100) == whole
    monkeypatch.setattr(flight, "CompiledStepper", lambda *_: None)
    assert flown(PlainWire(), 100) == whole


def test_a_fast_path_that_fails_to_begin_stops_the_rotors_as_a_step_that_raises_does(monkeypatch):
    def broken(_self):
        raise ValueError("no orders")

    monkeypatch.setattr(FlightControl, "begin", broken)
    log = fly(reference(), reference().grid.situation(BENIGN), 0, PlainWire())
    assert "autopilot at" in log.stack_error
    assert log.stack_error.endswith("ValueError: no orders")
    assert log.ending is not Ending.TIMED_OUT


def test_orders_for_three_rotors_are_read_by_no_compiled_step(monkeypatch):
    step = FlightControl.step

    def cut(self, *rest):
        return Thrust(step(self, *rest).rotors[:3])

    monkeypatch.setattr(FlightControl, "step", cut)
    with pytest.raises(StackError, match=r"`step` returns the thrust of rotors of shape \(3,\), which must be \(4,\)"):
        flown(LeaningWire(set(range(100)), seams=("thrust",)), 100)


@pytest.mark.parametrize("lost_s", [0.05, 0.3])
def test_what_was_lost_while_somebody_listened_is_the_same_afterwards(lost_s):
    """Rotors that stopped stay stopped, and a gap in the inertial samples is not integrated."""
    gap = set(range(100, 100 + round(20 * lost_s)))
    ends = [flown(LeaningWire(listening, (5.0, 5.0 + lost_s)), 160) for listening in (gap, set(range(160)))]
    assert ends[0] == ends[1]
    assert np.isfinite(ends[0][4]).all()


CACHED = """
import numpy as np
from pathlib import Path
from scaloft_fi.sim.flight import loop_with
from scaloft_fi.stack.kernel import jit

@jit
def kernel(now_s, stamp_s, rate, force, numbers):
    numbers[0][0] += rate[2]
    return numbers[0][1:5]

loop = loop_with(kernel)
airframe, inverse = np.zeros(46), np.array([0.0, 0.0, 0.0, 1.0])
airframe[6], airframe[23:26], inertia = 1.0, (1.0, 1.0, 5.0), np.array([1.0, 1.0, 1.0, 1.0, 1.0])
numbers = (np.array([0.0, 2.0, 2.0, 2.0, 2.0]),)
noise, sensor = np.zeros((24, 6)), np.zeros(21)
loop(noise, 0, 0, 24, sensor, airframe, inverse, inertia, numbers)
print(sum(loop.stats.cache_hits.values()), sum(loop.stats.cache_misses.values()), airframe[9].hex())
"""


@pytest.mark.release
def test_the_machine_code_of_a_loop_with_another_stacks_kernel_is_kept_for_the_next_process(tmp_path):
    script = tmp_path / "kernel_of_another.py"
    script.write_text(CACHED)
    run = [sys.executable, "-W", "ignore", str(script)]
    place = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(Path(__file__).parents[2])}
    first, second = (subprocess.run(run, env=place, capture_output=True, text=True, check=True) for _ in range(2))
    (hits, misses, speed), (more_hits, no_misses, same_speed) = (done.stdout.split() for done in (first, second))
    assert (hits, misses, more_hits, no_misses) == ("0", "1", "1", "0")
    assert speed == same_speed


@pytest.fixture(scope="module")
def server():
    with physics_server() as client:
        set_up(client)
        yield client


def thrown(client, yaw_rad, pushes, computed):
    """A block under `pushes` (T, 6); the bits of its state after each step, those `computed` outside the server."""
    airframe = Airframe(client, BLOCK, (0.1, -0.2, 5.0), yaw_rad)
    states = []
    for step, push in enumerate(pushes):
        airframe.pushed[:] = push
        if computed[step]:
            square = free_step(airframe.state, airframe.inverse_attitude(), airframe.pushed, airframe.inertia)
            airframe.update_server()
        else:
            square = airframe.step(lambda _step: None, step, 1)
        states.append((airframe.state.tobytes(), airframe.truth, square))
    pybullet.removeBody(airframe.number, physicsClientId=client)
    return states


@given(
    yaw_rad=st.floats(-4.0, 4.0),
    seed=st.integers(0, 2**31),
    size=st.sampled_from([0.0, 1e-6, 0.1, 10.0, 1e5]),
    computed=st.lists(st.booleans(), min_size=1, max_size=60),
)
def test_a_step_outside_the_server_has_the_bits_of_one_inside(server, yaw_rad, seed, size, computed):
    pushes = size * np.random.default_rng(seed).normal(0.0, (1, 1, 1, 0.05, 0.05, 0.05), (len(computed), 6))
    inside = thrown(server, yaw_rad, pushes, [False] * len(computed))
    assert thrown(server, yaw_rad, pushes, computed) == inside
    assert thrown(server, yaw_rad, pushes, [True] * len(computed)) == inside


def test_speeds_end_where_the_server_ends_them(server):
    pushes = np.tile([1e6, -1e6, 0.0, 1e3, 0.0, -1e3], (20, 1))
    inside = thrown(server, 0.3, pushes, [False] * 20)
    assert thrown(server, 0.3, pushes, [True] * 20) == inside
    assert max(inside[-1][1][7:10]) == 100.0


def test_the_hidden_attitude_is_known_through_touches_too(server):
    """A block that falls on a slab, bounces and tumbles, longer than rates are kept."""
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[9.0, 9.0, 0.5], physicsClientId=server)
    slab = pybullet.createMultiBody(0.0, shape, physicsClientId=server)
    pybullet.setCollisionFilterGroupMask(slab, -1, WORLD_GROUP, VEHICLE_GROUP, physicsClientId=server)
    airframe = Airframe(server, BLOCK, (0.0, 0.0, 0.9), 0.4)
    touched, told = 0, np.empty(4)
    for step in range(KEPT_RATES + 100):
        airframe.pushed[:] = 0.0, 0.0, 0.0, 0.05 * (step < 90), 0.02, 0.0
        airframe.step(lambda _step: None, step, 1)
        touched += bool(pybullet.getContactPoints(airframe.number, slab, physicsClientId=server))
        if step % 50 == 0:
            attitude_of(airframe.inverse_attitude(), told)
            assert told.tobytes() == airframe.state[3:7].tobytes(), step
    assert touched > 100
    for number in (airframe.number, slab):
        pybullet.removeBody(number, physicsClientId=server)


def test_it_agrees_with_the_server_here_and_another_arithmetic_is_noticed(monkeypatch):
    def rounded(state, turned, pushed, inertia):
        free_step(state, turned, pushed, inertia)
        state[0] = np.nextafter(state[0], np.inf)

    assert flight.agrees()
    monkeypatch.setattr(flight, "free_step", rounded)
    assert not flight.agrees.__wrapped__()


def test_without_agreement_a_flight_is_the_servers_and_the_same(monkeypatch):
    asked, digests = [], set()
    for answer in (True, False):
        monkeypatch.setattr(flight, "agrees", lambda answer=answer: asked.append(answer) or answer)
        log = fly(reference(), reference().grid.situation(BENIGN), 1, PlainWire())
        digests.add((log.digest, log.perceived_digest))
    assert len(digests) == 1
    assert set(asked) == {True, False}
