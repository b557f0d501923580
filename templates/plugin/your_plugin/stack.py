"""A stack: what is tested.  It gets what the sensors deliver, and orders the thrust of the four rotors."""

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from scaloft_fi.api import (
    STEP_HZ,
    STEP_S,
    TICK_HZ,
    Belief,
    Bounds,
    Declaration,
    PlainStack,
    Seam,
    Stamp,
    Vector,
    declare_stack,
    messages,
)

from your_plugin.sensors import Pose

UP = np.array([0.0, 0.0, 9.81])
REACHED_M, AHEAD_M, ALIGNED_RAD = 0.15, 0.3, 0.2
MIX = 0.25 * np.array([[1, -1, -1, 1], [1, 1, 1, 1], [1, 1, -1, -1], [1, -1, 1, -1]])
"""Rotors from thrust, roll, pitch, yaw."""


class Velocity(NamedTuple):
    """What travels on the seam `velocity`: (3,) the ordered velocity [m/s, world]."""

    stamp_s: Stamp
    velocity: Vector


@dataclass(frozen=True)
class Settings:
    """The rest of sim/stack.yaml; a value out of bounds is refused with file and line."""

    mass_kg: Annotated[float, Bounds(least=0.1, most=50.0)]
    max_thrust_n: Annotated[float, Bounds(least=0.1, most=500.0)]
    slow_within_m: Annotated[float, Bounds(least=0.0, most=50.0)]


class YourStack(PlainStack):
    """Flies straight from waypoint to waypoint, slowly once it was told of a person, and lands at the last one."""

    def __init__(self, task, wire):
        self._task, self._settings, self._cross = task, task.settings, wire.cross
        start = (*task.home[:2], task.altitude_m)
        self._route, self._next, self._slow = [np.array(point) for point in (start, *task.route)], 0, False
        self._pose = Pose(0.0, np.array(task.home, float), np.zeros(3), np.eye(3))
        self._attitude, self._turn_rad, self._order = None, 0.0, Velocity(0.0, np.zeros(3))

    def autopilot(self, now_s, frames):
        """Decide at 20 Hz where the drone is, whom it sees, how fast it flies."""
        # Every declared seam is crossed once in each tick, with None where nothing is sent: a fault may sit there.
        pose = self._cross("pose", now_s, frames["your_plugin_tracker"])
        seen = self._cross("person", now_s, frames.detections)
        if pose is not None:
            self._pose, self._attitude = pose, pose.attitude
        if seen is not None and any(one.range_m < self._settings.slow_within_m for one in seen.persons):
            self._slow = True
        self._turn_rad = self._to_turn()
        self._order = self._cross("velocity", now_s, Velocity(now_s, self._wanted())) or self._order

    def step(self, now_s, imu):
        """Turn the thrust, at 240 Hz, to where the velocity asks for it."""
        if self._attitude is None:
            return self._cross("rotors", now_s, messages.Thrust(np.zeros(4)))
        x, y, z = imu.rate * STEP_S
        self._attitude = self._attitude @ np.array([[1.0, -z, y], [z, 1.0, -x], [-y, x, 1.0]])
        pull = np.clip(2.5 * (self._order.velocity - self._pose.velocity), -3.0, 3.0) + UP
        right, left, thrust = self._attitude.T @ pull
        rate = np.array([-0.6 * left, 0.6 * right, min(0.8, max(-0.8, 2.0 * self._turn_rad))])
        orders = (self._settings.mass_kg * thrust, *(4.0 * np.array([1.4, 1.5, 1.8]) * (rate - imu.rate)))
        rotors = np.clip(MIX @ np.array(orders), 0.0, self._settings.max_thrust_n)
        return self._cross("rotors", now_s, messages.Thrust(rotors))

    def beliefs(self, now_s):
        """The values of the declared beliefs, in their order; they are logged beside the truth."""
        return np.array([*self._pose.position, float(self._slow)])

    def _way(self):
        """From here to the next waypoint; to the last one after the mission [m, world]."""
        return self._route[min(self._next, len(self._route) - 1)] - self._pose.position

    def _to_turn(self):
        """How far the next waypoint is off the heading, left positive [rad]; 0 where it is above or below."""
        ahead, aside, _ = self._pose.attitude.T @ self._way()
        return math.atan2(aside, ahead) if math.hypot(ahead, aside) > AHEAD_M else 0.0

    def _wanted(self):
        """The velocity that the mission asks for [m/s, world]; it turns first, so that the camera looks ahead."""
        while self._next < len(self._route) and np.linalg.norm(self._way()) < REACHED_M:
            self._next += 1
        way = self._way()
        if self._next == len(self._route):
            return np.array([0.8 * way[0], 0.8 * way[1], -0.4])
        if abs(self._turn_rad) > ALIGNED_RAD:
            return np.zeros(3)
        speed_mps = self._task.slow_mps if self._slow else self._task.cruise_mps
        return way * min(0.8, speed_mps / np.linalg.norm(way))


declare_stack(
    Declaration(
        name="your_plugin",
        seams=(
            Seam("pose", Pose, TICK_HZ, "tracker -> mission", units={"position": "m", "velocity": "m/s"}),
            Seam("person", messages.Detections, TICK_HZ, "person detector -> mission"),
            Seam("velocity", Velocity, TICK_HZ, "mission -> control", units={"velocity": "m/s"}),
            Seam("rotors", messages.Thrust, STEP_HZ, "control -> rotors", units={"rotors": "N"}),
        ),
        beliefs=(
            *(Belief(f"tracked_{axis}_m", "m", "position as it was told, world") for axis in "xyz"),
            Belief("slow", "", "1 from the first person that counted"),
        ),
        make=YourStack,
        settings=lambda: Settings,
        canaries=("velocity",),  # where a control proves that faults reach the drone
    )
)
