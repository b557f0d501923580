"""The stack: flies from waypoint to waypoint, turns home where it sees something near ahead, lands at home."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hopper.messages import Drive, Height, Range
from scaloft_fi import api
from scaloft_fi.api import STEP_HZ, STEP_S, TICK_HZ, Belief, Seam, messages

GRAVITY = np.array([0.0, 0.0, -9.81])
FAR_M = 100.0
LEGS = ("up", "out", "home", "down")
MIX = np.array([[1, -1, -1, 1], [1, 1, 1, 1], [1, 1, -1, -1], [1, -1, 1, -1]])  # rotors from thrust, roll, pitch, yaw


@dataclass(frozen=True)
class Settings:
    """`sim/stack.yaml`: what the stack knows of its vehicle, and the distance at which it turns home [m]."""

    mass_kg: float
    max_thrust_n: float
    stop_m: float


class Hopper(api.PlainStack):
    """Dead reckoning with fixes, a straight line to each waypoint, and a velocity and attitude controller."""

    def __init__(self, task, wire):
        self._settings, self._cross, self._speed_mps = task.settings, wire.cross, task.cruise_mps
        self._place, self._velocity, self._yaw_rad = np.array(task.home), np.zeros(3), task.yaw_rad
        self._turn = Rotation.from_euler("z", task.yaw_rad)
        self._drive = Drive(0.0, np.zeros(3), task.yaw_rad)
        self._imu = messages.Imu(0.0, np.zeros(3), -GRAVITY)
        self._route = [np.array(point) for point in ((*task.home[:2], task.altitude_m), *task.route)]
        self._leg, self._ahead_m = 0, FAR_M

    def step(self, now_s, imu):
        self._imu = imu = self._cross("gyro", now_s, imu) or self._imu
        self._turn = self._turn * Rotation.from_rotvec(imu.rate * STEP_S)
        self._velocity = self._velocity + (self._turn.apply(imu.force) + GRAVITY) * STEP_S
        self._place = self._place + self._velocity * STEP_S
        self._yaw_rad = self._turn.as_euler("ZYX")[0]
        pull = np.clip(3.0 * (self._drive.velocity - self._velocity), -3.0, 3.0) - GRAVITY
        x, y, z = self._turn.inv().apply(pull)
        turn_rad = math.remainder(self._drive.yaw_rad - self._yaw_rad, math.tau)
        rate = np.array([-0.6 * y, 0.6 * x, np.clip(2.0 * turn_rad, -0.8, 0.8)])
        rotors = MIX @ (0.25 * self._settings.mass_kg * z, *((1.4, 1.5, 1.8) * (rate - imu.rate)))
        return self._cross("rotors", now_s, messages.Thrust(np.clip(rotors, 0.0, self._settings.max_thrust_n)))

    def autopilot(self, now_s, frames):
        fix = self._cross("place", now_s, frames.fix)
        height = self._cross("height", now_s, frames["altimeter"])
        error = np.zeros(3)
        if fix is not None:
            error = fix.position - self._place + (now_s - fix.stamp_s) * self._velocity
            turn_rad = math.remainder(fix.yaw_rad - self._yaw_rad, math.tau)
            self._turn = Rotation.from_rotvec((-0.02 * error[1], 0.02 * error[0], 0.05 * turn_rad)) * self._turn
        if height is not None:
            error[2] = height.height_m - self._place[2]
        self._place, self._velocity = self._place + 0.25 * error, self._velocity + 0.4 * error
        near = self._cross("range", now_s, _nearest(self._cross("sight", now_s, frames.depth)))
        self._ahead_m = near.ahead_m if near else self._ahead_m
        self._drive = self._cross("drive", now_s, self._order(now_s)) or self._drive

    def beliefs(self, now_s):
        return np.array([*self._place, self._ahead_m, self._leg])

    def _order(self, now_s):
        """Climb, fly the legs, and land above home."""
        home = len(self._route) - 1
        while self._leg <= home and math.dist(self._place, self._route[self._leg]) < 0.2:
            self._leg += 1
        way = self._route[min(self._leg, home)] - self._place
        if self._leg > home:
            return Drive(now_s, np.array([0.8 * way[0], 0.8 * way[1], -0.4]), self._drive.yaw_rad)
        yaw_rad = math.atan2(way[1], way[0]) if math.hypot(way[0], way[1]) > 0.5 else self._drive.yaw_rad
        aligned = abs(math.remainder(yaw_rad - self._yaw_rad, math.tau)) < 0.2
        if aligned and 0 < self._leg < home and self._ahead_m < self._settings.stop_m:
            self._leg = home
        gain = min(0.8, self._speed_mps / np.linalg.norm(way)) if aligned or self._leg == 0 else 0.0
        return Drive(now_s, gain * way, yaw_rad)


def _nearest(frame):
    """The fifth nearest pixel in the middle of the picture."""
    if frame is not None:
        seen = np.sort(frame.depth[16:32, 21:43], axis=None)
        return Range(frame.stamp_s, float((*seen[seen > 0.0][:5], *[FAR_M] * 5)[4]))
    return None


api.declare_stack(
    api.Declaration(
        name="hopper",
        seams=(
            Seam("gyro", messages.Imu, STEP_HZ, "inertial sensor -> dead reckoning"),
            Seam("place", messages.Fix, TICK_HZ, "positioning -> dead reckoning", units={"position": "m"}),
            Seam("height", Height, TICK_HZ, "altimeter -> dead reckoning"),
            Seam("sight", messages.DepthFrame, TICK_HZ, "depth camera -> range", units={"depth": "m"}),
            Seam("range", Range, TICK_HZ, "range -> guidance"),
            Seam("drive", Drive, TICK_HZ, "guidance -> control", units={"velocity": "m/s"}),
            Seam("rotors", messages.Thrust, STEP_HZ, "control -> rotors", units={"rotors": "N"}),
        ),
        beliefs=(
            *(Belief(f"reckoned_{axis}_m", "m", "dead-reckoned position, world") for axis in "xyz"),
            Belief("ahead_m", "m", "range ahead; 100 where nothing is seen", FAR_M, most=FAR_M),
            Belief("leg", "", "place of the target in the mission", mark=api.Mark("leg", "flies leg {}", values=LEGS)),
        ),
        make=Hopper,
        settings=lambda: Settings,
        canaries=("drive", "gyro"),
    )
)
