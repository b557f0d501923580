"""Fly one flight in PyBullet's window, in real time."""

from __future__ import annotations

import os
import sys
import time

from scaloft_fi.campaign.flights.fly import wire_of
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.errors import InputError
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.stack.declaration import TICK_S
from scaloft_fi.study import Study

DISTANCE_M, TURN_DEG, TILT_DEG = 3.0, 15.0, -60.0
"""Position of the window's camera relative to the vehicle: steeply above and slightly behind (the roof is invisible
from outside)."""


def fly_in_window(study: Study, flight: Flight) -> FlightLog:
    """Fly in a window; returns the log.

    Raises:
        InputError: there is no display.
    """
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise InputError("--gui needs a display, and there is none (DISPLAY is not set); without it a map is drawn")
    import pybullet

    from scaloft_fi.sim import flight as flying

    client = pybullet.connect(pybullet.GUI)
    if client < 0:
        raise InputError("--gui: PyBullet could not open a window on this display")
    pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, physicsClientId=client)
    try:
        wire = wire_of(study, flight)
        under_way = flying.FlightLoop(client, study.sim, study.scenario(flight.situation), flight.seed, wire)
        due_s = time.monotonic()
        while under_way.tick():
            follow = under_way.airframe.state[:3].tolist()
            pybullet.resetDebugVisualizerCamera(DISTANCE_M, TURN_DEG, TILT_DEG, follow, physicsClientId=client)
            under_way.advance()
            due_s += TICK_S
            time.sleep(max(0.0, due_s - time.monotonic()))
        return under_way.log()
    finally:
        pybullet.disconnect(physicsClientId=client)
