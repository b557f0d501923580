"""ArduPilot's SITL with its JSON backend: it asks for each frame, and estimates from what the frame says.

The program sends its servos to port 9002 and waits for the sensors in JSON; MAVLink goes over port 5760.  Frames are
north, east, down in the study's x, -y, -z.  One `position` gives GPS, barometer and the rest.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from scaloft_fi.firmware.kind import (
    ACCELEROMETER,
    GYRO,
    POSITION,
    SUPPLY,
    VELOCITY,
    FirmwareConfig,
    Samples,
    VelocityOrder,
)
from scaloft_fi.firmware.mavlink import ARM, SET_MODE, TAKE_OFF, News, Talk
from scaloft_fi.firmware.program import Datagram, FirmwareError, Program
from scaloft_fi.stack.declaration import STEP_HZ, Seam
from scaloft_fi.stack.messages import Array

FRAME, CONSOLE = 9002, 5760
"""Ports: servos and sensors, MAVLink."""
FRAMES_PER_STEP = 2
"""Its simulation must be faster than its loop, which runs at each physics step."""
BOOT_S, ARMED_S = 58.0, 62.0
"""Its filter uses the position; it is armed [s from power on]."""
GUIDED, LAND = 4, 9
SETTINGS = (
    f"SIM_RATE_HZ {FRAMES_PER_STEP * STEP_HZ:g}", f"SCHED_LOOP_RATE {STEP_HZ:g}", "FS_THR_ENABLE 0", "FS_GCS_ENABLE 0",
    "LOG_BACKEND_TYPE 0", "SIM_BARO_RND 0", "DISARM_DELAY 0",
)  # fmt: skip
"""Parameters of every study's ArduPilot, after the study's own: the rates of the frames, no remote control."""
VOLTAGE = "SIM_BATT_VOLTAGE"
"""The parameter that is the battery's voltage for its monitor."""
MEASURED = ("BATT_MONITOR 3", f"{VOLTAGE} 16.8")
"""Where a study's ArduPilot gets the battery: what it measures before the first sample."""
OWN = "scaloft.parm"


class Ardupilot:
    """ArduPilot under way, for `FirmwareKind` and `Firmware`."""

    seams = (GYRO, ACCELEROMETER, POSITION, VELOCITY)
    further: Mapping[str, Seam] = {"battery": SUPPLY}

    def __init__(self, config: FirmwareConfig, study: Path, still: Samples) -> None:
        lines = (*SETTINGS, *(MEASURED if config.sensors else ()))
        files = {**config.content(study), OWN: "".join(f"{line}\n" for line in lines).encode()}
        program, *more = config.run(study)
        run = (program, "--model", "JSON:127.0.0.1", "--speedup", "1", "-I0", "--defaults", ",".join(files), *more)
        self._frames, self._talk, self._news = 0, Talk(), News()
        self._airborne = self._landing = False
        self._position, self._gyro, self._accelerometer = np.zeros(3), still.gyro, still.accelerometer
        self._program = Program.start(run, files, study)
        with self._program.booting("ArduPilot"):
            while self._now_s < ARMED_S:
                self._advance(still, self._boot_orders())
            if not self._news.armed:
                raise FirmwareError(f"not armed: {self._news.text or 'it says nothing'}{self._program.said()}")

    @property
    def _now_s(self) -> float:
        return self._frames / (STEP_HZ * FRAMES_PER_STEP)

    def _boot_orders(self) -> bytes:
        if self._frames % round(STEP_HZ * FRAMES_PER_STEP):
            return b""
        orders = self._talk.heartbeat()
        if self._now_s >= BOOT_S and not self._news.armed:
            orders += self._talk.command(SET_MODE, 1.0, GUIDED) + self._talk.command(ARM, 1.0)
        return orders

    def step(self, samples: Samples) -> Array:
        """Move on by one physics step."""
        orders = b""
        if self._frames % round(STEP_HZ * FRAMES_PER_STEP) == 0:
            orders += self._talk.heartbeat()
        if not self._airborne:
            orders += self._talk.command(TAKE_OFF, *[0.0] * 6, samples.altitude_m)
            self._airborne = True
        if samples.mode == "land" and not self._landing:
            orders += self._talk.command(SET_MODE, 1.0, LAND)
            self._landing = True
        elif isinstance(samples.order, VelocityOrder) and samples.mode not in ("takeoff", "land", "level"):
            orders += self._talk.velocity(samples.order)
        battery = samples.arrived.get("battery")
        if battery is not None:
            orders += self._talk.parameter(VOLTAGE, battery.voltage_v)
        if not samples.armed:
            orders += self._talk.command(ARM, 0.0, 21196.0)
        return self._advance(samples, orders)

    def close(self) -> None:
        """End the program."""
        self._program.close()

    def _advance(self, samples: Samples, orders: bytes) -> Array:
        for frame in range(FRAMES_PER_STEP):
            if samples.fix is not None and frame == 0:
                self._position = samples.fix.position
            datagrams = [Datagram(CONSOLE, orders)] if orders and frame == 0 else []
            datagrams.append(Datagram(FRAME, self._packet(samples)))
            self._frames += 1
            until_ns = round(self._frames * 1e9 / (STEP_HZ * FRAMES_PER_STEP))
            for answer in self._program.step(until_ns, datagrams):
                if answer.port == FRAME and len(answer.data) >= 16:
                    pulses_us = struct.unpack_from("<4H", answer.data, 8)
                    self._news.throttles = np.clip((np.array(pulses_us) - 1000.0) / 1000.0, 0.0, 1.0)
                elif answer.port == CONSOLE:
                    for number, payload in self._talk.heard(answer.data):
                        self._news.take(number, payload)
        return self._news.throttles

    def _packet(self, samples: Samples) -> bytes:
        """The frame of the sensors, of a lost sample the last that came; its parser refuses blanks."""
        gyro = self._gyro = samples.gyro or self._gyro
        accelerometer = self._accelerometer = samples.accelerometer or self._accelerometer
        x, y, z, w = samples.attitude.tolist()
        assert gyro is not None
        assert accelerometer is not None
        frame = {
            "timestamp": self._now_s,
            "imu": {"gyro": _down(gyro.rate), "accel_body": _down(accelerometer.force)},
            "position": _down(self._position),
            "velocity": _down(samples.velocity),
            "quaternion": [w, x, -y, -z],
            "no_time_sync": 1,
        }
        return b"\n" + json.dumps(frame, separators=(",", ":")).encode() + b"\n"


def _down(vector: Array) -> list[float]:
    """A vector of x forward, y left, z up in the axes x forward, y right, z down."""
    x, y, z = vector.tolist()
    return [x, -y, -z]
