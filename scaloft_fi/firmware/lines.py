"""Any program as flight control: a line of JSON each physics step over UDP, and a line with the throttles back.

To port 7001, `null` where nothing arrives; `armed` is false where the motors must not turn:

    {"t_s": 1.25, "armed": true, "gyro": [0.0, 0.1, 0.0], "accelerometer": [0.0, 0.0, 9.8],
     "position": {"position": [0.0, 1.0, 1.6], "yaw_rad": 1.57},
     "order": {"roll_rad": 0.0, "pitch_rad": 0.05, "turn_radps": 0.0, "throttle": 0.6}}

and for each of the `sensors` of its settings its sample under its name.
From the program, to port 7002: `{"throttles": [0.6, 0.6, 0.6, 0.6]}`, front right, rear left, front left, rear right.
A step without an answer keeps the last one.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from scaloft_fi.firmware.kind import (
    ACCELEROMETER,
    ATTITUDE,
    BAROMETER,
    GYRO,
    MAGNETOMETER,
    POSITION,
    SUPPLY,
    FirmwareConfig,
    Samples,
)
from scaloft_fi.firmware.program import Datagram, FirmwareError, Program
from scaloft_fi.outside.border import to_plain
from scaloft_fi.stack.declaration import STEP_HZ, Seam
from scaloft_fi.stack.messages import Array

SENSED, MOTORS = 7001, 7002
READY_S = 10.0
"""It must have answered within this time after its start [s]."""


class Lines:
    """A program that speaks lines, for `FirmwareKind` and `Firmware`."""

    seams = (GYRO, ACCELEROMETER, POSITION, ATTITUDE)
    further: Mapping[str, Seam] = {"barometer": BAROMETER, "magnetometer": MAGNETOMETER, "battery": SUPPLY}

    def __init__(self, config: FirmwareConfig, study: Path, still: Samples) -> None:
        self._steps, self._throttles, self._answered = 0, np.zeros(4), False
        self._sensors = config.sensors
        self._program = Program.start(config.run(study), config.content(study), study)
        with self._program.booting("the program"):
            while not self._answered:
                self._advance(still, armed=False)
                if self._steps > READY_S * STEP_HZ:
                    raise FirmwareError(f"no line came from it within {READY_S:g} s{self._program.said()}")

    def step(self, samples: Samples) -> Array:
        """Move on by one physics step."""
        return self._advance(samples, armed=samples.armed)

    def close(self) -> None:
        """End the program."""
        self._program.close()

    def _advance(self, samples: Samples, *, armed: bool) -> Array:
        line = {
            "t_s": self._steps / STEP_HZ,
            "armed": armed,
            "gyro": None if samples.gyro is None else samples.gyro.rate.tolist(),
            "accelerometer": None if samples.accelerometer is None else samples.accelerometer.force.tolist(),
            "position": None if samples.fix is None else to_plain(samples.fix),
            "order": None if samples.order is None else to_plain(samples.order),
        }
        for name in self._sensors:
            sample = samples.arrived.get(name)
            line[name] = None if sample is None else to_plain(sample)
        self._steps += 1
        until_ns = round(self._steps * 1e9 / STEP_HZ)
        for answer in self._program.step(until_ns, [Datagram(SENSED, json.dumps(line).encode() + b"\n")]):
            if answer.port == MOTORS:
                self._throttles, self._answered = throttles_in(answer.data), True
        return self._throttles


def throttles_in(line: bytes) -> Array:
    """The throttles (4,) of a line.

    Raises:
        FirmwareError: the line is no such line, which is the program's fault.
    """
    try:
        read: Any = json.loads(line)
        throttles = np.array(read["throttles"], dtype=np.float64)
        if throttles.shape != (4,) or not np.isfinite(throttles).all():
            raise ValueError("`throttles` must be four numbers")
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise FirmwareError(f"the program sent a line that is none of throttles: {ascii(str(error))[1:100]}") from error
    return throttles
