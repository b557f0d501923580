from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.sim.body import Body
from scaloft_fi.sim.flight import STEPS_PER_TICK, Flight, physics_server
from scaloft_fi.sim.load import load
from scaloft_fi.sim.tight_loop import SKIPPED
from scaloft_fi.stack.messages import Imu
from scaloft_fi.stack.seam import PlainWire

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
        flight = Flight(client, config, config.scenario(config.grid.situation(key)), seed, wire)
        for wire.now in range(ticks):
            if not flight.tick():
                break
            flight.advance()
        log = flight.log()
        inner = flight.stack.inner
        return (
            log.digest, log.perceived_digest, log.ending, log.struck, flight.body.truth, inner.stamp_s, inner.heard_s,
            inner.mode, inner.estimate.tobytes(), inner.control[:-4].tobytes(),
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
    assert never.carried == 0
    assert always.carried == 24 * ticks
    assert sometimes.carried == 24 * len(heard & set(range(ticks)))


@pytest.mark.parametrize(("seams", "asked"), [((), False), (("imu",), False), (("thrust",), True), (SKIPPED, True)])
def test_who_listens_to_the_rotors_has_the_servers_steps_where_nothing_can_be_touched(monkeypatch, seams, asked):
    """So PLACEBO, which does, holds the server against what others computed without it."""
    counted, moves = [], Body.moves
    monkeypatch.setattr(Body, "moves", lambda self, *rest: counted.append(rest[-1]) or moves(self, *rest))
    flown("T0O0W0D0H0", 0, LeaningWire(set(range(100)), seams=seams), 100)
    whole_ticks = counted.count(STEPS_PER_TICK)
    assert whole_ticks > 50 if asked else whole_ticks == 0


@pytest.mark.parametrize("lost_s", [0.05, 0.3])
def test_what_was_lost_while_somebody_listened_is_the_same_afterwards(lost_s):
    """Rotors that stopped stay stopped, and a gap in the inertial samples is not integrated."""
    gap = set(range(100, 100 + round(20 * lost_s)))
    ends = [
        flown("T0O0W0D0H0", 0, LeaningWire(listening, (5.0, 5.0 + lost_s)), 160) for listening in (gap, set(range(160)))
    ]
    assert ends[0] == ends[1]
    assert np.isfinite(ends[0][4]).all()
