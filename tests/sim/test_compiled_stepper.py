from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.sim import flight as flight_module
from scaloft_fi.sim.flight import FlightLoop, fly, physics_server
from scaloft_fi.sim.load import load
from scaloft_fi.sim.log import Ending
from scaloft_fi.sim.stepper import CompiledStepper
from scaloft_fi.sim.vehicle import Airframe
from scaloft_fi.stack.declaration import STEPS_PER_TICK, PlainWire
from scaloft_fi.stack.messages import Imu
from scaloft_fi.stack.reference.flight_control import InnerLoop

SKIPPED = InnerLoop.seams

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
    return load(Path(__file__).parents[2] / "sim")


def flown(key, seed, wire, ticks):
    """Digests, state, estimate and controller after so many ticks, but for the thrust, which a step writes anew."""
    config = reference()
    with physics_server() as client:
        flight = FlightLoop(client, config, config.scenario(config.grid.situation(key)), seed, wire)
        for wire.now in range(ticks):
            if not flight.tick():
                break
            flight.advance()
        log = flight.log()
        estimate, controlled, orders = flight.stack.fast_path.begin()
        return (
            log.digest, log.perceived_digest, log.ending, log.struck, flight.airframe.truth,
            estimate.tobytes(), controlled[:-4].tobytes(), orders.tobytes(),
        )  # fmt: skip


@settings(max_examples=8)
@given(
    key=st.sampled_from(["T0O0W0D0H0", "T1O1W0D0H1", "T1O1W1D1H1"]),
    seed=st.integers(0, 2**31),
    ticks=st.integers(1, 160),
    heard=st.sets(st.integers(0, 159)),
    seams=st.sampled_from([SKIPPED, ("imu",), ("thrust",)]),
)
def test_a_flight_has_the_same_bits_whether_or_not_anybody_listens(key, seed, ticks, heard, seams):
    never, always, sometimes = (LeaningWire(at, seams=seams) for at in (set(), set(range(ticks)), heard))
    whole = flown(key, seed, never, ticks)
    assert flown(key, seed, always, ticks) == whole
    assert flown(key, seed, sometimes, ticks) == whole
    assert always.carried == 24 * ticks
    assert never.carried <= sometimes.carried <= always.carried


@pytest.mark.parametrize("seams", [(), ("imu",), ("thrust",), SKIPPED])
def test_a_wire_that_listens_on_a_skipped_seam_has_the_servers_steps_where_nothing_can_be_touched(monkeypatch, seams):
    """So PLACEBO, which listens on every seam, compares the server with the compiled steps."""
    counted, step = [], Airframe.step
    monkeypatch.setattr(Airframe, "step", lambda self, *rest: counted.append(rest[-1]) or step(self, *rest))
    flown("T0O0W0D0H0", 0, LeaningWire(set(range(100)), seams=seams), 100)
    whole_ticks = counted.count(STEPS_PER_TICK)
    assert whole_ticks > 50 if seams else whole_ticks == 0


def test_many_steps_at_once_are_as_many_single_ones(monkeypatch):
    whole, advance = flown("T0O0W0D0H0", 0, PlainWire(), 100), CompiledStepper.advance
    singly = lambda self, first, count: max(advance(self, step, 1) for step in range(first, first + count))  # noqa: E731
    monkeypatch.setattr(CompiledStepper, "advance", singly)
    assert flown("T0O0W0D0H0", 0, PlainWire(), 100) == whole


def test_a_fast_path_that_fails_to_begin_stops_the_rotors_as_a_step_that_raises_does(monkeypatch):
    def broken(_self):
        raise ValueError("no orders")

    monkeypatch.setattr(InnerLoop, "begin", broken)
    config = reference()
    log = fly(config, config.grid.situation("T0O0W0D0H0"), 0, PlainWire())
    assert "autopilot at" in log.stack_error
    assert log.stack_error.endswith("ValueError: no orders")
    assert log.ending is not Ending.TIMED_OUT


def test_a_stack_without_a_fast_path_flies_the_same(monkeypatch):
    whole = flown("T0O0W0D0H0", 0, PlainWire(), 60)
    monkeypatch.setattr(flight_module, "CompiledStepper", lambda *_: None)
    assert flown("T0O0W0D0H0", 0, PlainWire(), 60) == whole


@pytest.mark.parametrize("lost_s", [0.05, 0.3])
def test_what_was_lost_while_somebody_listened_is_the_same_afterwards(lost_s):
    """Rotors that stopped stay stopped, and a gap in the inertial samples is not integrated."""
    gap = set(range(100, 100 + round(20 * lost_s)))
    ends = [
        flown("T0O0W0D0H0", 0, LeaningWire(listening, (5.0, 5.0 + lost_s)), 160) for listening in (gap, set(range(160)))
    ]
    assert ends[0] == ends[1]
    assert np.isfinite(ends[0][4]).all()


CACHED = """
import numpy as np
from pathlib import Path
from scaloft_fi.sim.stepper import loop_with
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


def test_the_machine_code_of_a_loop_with_another_stacks_kernel_is_kept_for_the_next_process(tmp_path):
    script = tmp_path / "kernel_of_another.py"
    script.write_text(CACHED)
    run = [sys.executable, "-W", "ignore", str(script)]
    place = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(Path(__file__).parents[2])}
    first, second = (subprocess.run(run, env=place, capture_output=True, text=True, check=True) for _ in range(2))
    (hits, misses, speed), (more_hits, no_misses, same_speed) = (done.stdout.split() for done in (first, second))
    assert (hits, misses, more_hits, no_misses) == ("0", "1", "1", "0")
    assert speed == same_speed
