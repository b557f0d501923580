"""Betaflight's SITL: sensors and sticks as UDP packets, an attitude loop of its own below sticks in ANGLE mode.

Packets, little-endian (`sitl.h` of Betaflight 4.6): to port 9003 time [s], gyro [rad/s], specific force [m/s2],
attitude w, x, y, z, velocity, position, pressure [Pa]; to 9004 time, 16 channels [us]; from 9002 four motors 0..1.
A stock build takes its attitude from the packet, so a fault of the gyro does not reach its attitude; one that is built
with `USE_IMU_CALC` estimates it from gyro and accelerometer.
"""

from __future__ import annotations

import hashlib
import math
import struct
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from scaloft_fi.document import digest, read_bytes
from scaloft_fi.errors import InputError
from scaloft_fi.firmware.kind import ACCELEROMETER, ATTITUDE, GYRO, AttitudeOrder, FirmwareConfig, Samples
from scaloft_fi.firmware.program import TURNS, Datagram, FirmwareError, Program, kept
from scaloft_fi.outside.border import BorderError
from scaloft_fi.stack.declaration import STEP_HZ, Seam
from scaloft_fi.stack.messages import Array

STATE, STICKS, MOTORS, LINE = 9003, 9004, 9002, 5761
"""Ports: sensors, sticks, motors, and the command line."""
QUIET_S, BOOT_S, ARMED_S = 1.5, 8.0, 9.0
"""No sticks before: a receiver that starts later stays in its fail-safe.  Then gyro and grace are done; then it is
armed [s from power on]."""
LEAST_THROTTLE = 0.02
"""An armed motor idles above this."""
MIDDLE_US, HALF_US = 1500, 500
STICK_RAD, STICK_RADPS = math.radians(45.0), math.radians(200.0)
"""What a stick at its end asks for; `SETTINGS` say the same to the firmware."""
SETTINGS = (
    "aux 0 0 0 1700 2100 0 0",  # ARM on the first switch
    "aux 1 1 1 1700 2100 0 0",  # ANGLE on the second
    "set angle_limit = 45",
    "set small_angle = 180",
    "set rates_type = BETAFLIGHT",
    *(f"set {axis}_{name} = {value}" for axis in ("roll", "pitch", "yaw") for name, value in
      (("rc_rate", 100), ("srate", 0), ("expo", 0))),
    "set rc_smoothing = OFF",
)  # fmt: skip
"""What every study's Betaflight is told, before the study's own lines."""
LINE_S = 0.05
"""How long a line of the command line may take [s]."""
EEPROM = "eeprom.bin"


class Betaflight:
    """Betaflight under way, for `FirmwareKind` and `Firmware`."""

    seams = (GYRO, ACCELEROMETER, ATTITUDE)
    further: Mapping[str, Seam] = {}

    def __init__(self, config: FirmwareConfig, study: Path, still: Samples) -> None:
        self._steps, self._order = 0, AttitudeOrder(0.0, 0.0, 0.0, 0.0, 0.0)
        self._sensors = b""
        self._program = Program.start(config.run(study), {EEPROM: eeprom(config, study, still)}, study)
        try:
            throttles = np.zeros(4)
            while self._now_s < ARMED_S:
                throttles = self._advance(still, armed=self._now_s >= BOOT_S)
            if throttles.min() < LEAST_THROTTLE:
                raise BorderError(
                    f"Betaflight is not armed {ARMED_S - BOOT_S:g} s after it was told{self._program.said()}"
                )
        except FirmwareError as error:
            raise BorderError(f"Betaflight ended before the flight: {error}") from error
        finally:
            if self._now_s < ARMED_S or throttles.min() < LEAST_THROTTLE:
                self.close()

    @property
    def _now_s(self) -> float:
        return self._steps / STEP_HZ

    def step(self, samples: Samples) -> Array:
        """Move on by one physics step."""
        return self._advance(samples, armed=samples.armed)

    def close(self) -> None:
        """End the program."""
        self._program.close()

    def _advance(self, samples: Samples, *, armed: bool) -> Array:
        datagrams = [Datagram(STATE, state_packet(self._now_s, samples))]
        if isinstance(samples.order, AttitudeOrder):
            self._order = samples.order
        if self._now_s >= QUIET_S:
            datagrams.append(Datagram(STICKS, stick_packet(self._now_s, self._order, armed=armed)))
        self._steps += 1
        answers = self._program.step(round(self._steps * 1e9 / STEP_HZ), datagrams)
        motors = [answer.data for answer in answers if answer.port == MOTORS]
        return np.array(struct.unpack("<4f", motors[-1])) if motors else np.zeros(4)


def state_packet(now_s: float, samples: Samples) -> bytes:
    """The packet of the sensors; its axes are x forward, y right, z down, and its force has the other sign."""
    rate = samples.gyro.rate if samples.gyro else np.zeros(3)
    force = samples.accelerometer.force if samples.accelerometer else np.zeros(3)
    x, y, z, w = samples.attitude
    numbers = (now_s, rate[0], -rate[1], -rate[2], *(-force), w, x, -y, -z, *np.zeros(6), 101_325.0)
    return struct.pack("<18d", *numbers)


def stick_packet(now_s: float, order: AttitudeOrder, *, armed: bool) -> bytes:
    """The packet of the sticks: roll, pitch, throttle, yaw, then the switches for ARM and ANGLE."""
    sticks = (order.roll_rad / STICK_RAD, order.pitch_rad / STICK_RAD, -order.turn_radps / STICK_RADPS)
    roll, pitch, yaw = (MIDDLE_US + HALF_US * min(1.0, max(-1.0, stick)) for stick in sticks)
    throttle = 2 * HALF_US * (1.0 + min(1.0, max(0.0, order.throttle)))
    switch = 2000 if armed else 1000
    channels = (roll, pitch, throttle, yaw, switch, 2000)
    return struct.pack("<d16H", now_s, *(round(us) for us in channels), *[MIDDLE_US] * 10)


def eeprom(config: FirmwareConfig, study: Path, still: Samples) -> bytes:
    """The memory of a Betaflight that was told `SETTINGS` and the study's lines, made once a machine by content.

    Raises:
        BorderError: the firmware did not save them.
        InputError: a file of parameters cannot be read, or has a line that the command line refuses.
    """
    texts = [text.decode("utf-8", "replace") for text in config.content(study).values()]
    own = [line.strip() for text in texts for line in text.splitlines() if line.strip() and line.strip()[0] != "#"]
    lines = (*SETTINGS, *own)
    mark = hashlib.sha256("\n".join((config.mark(study), *lines, digest(TURNS))).encode()).hexdigest()
    return read_bytes(kept(f"betaflight/{mark[:32]}", lambda path: _save(path, config, study, still, lines)))


def _save(path: Path, config: FirmwareConfig, study: Path, still: Samples, lines: Sequence[str]) -> None:
    """Tell a Betaflight these lines, and keep the memory that it saves at `path`."""
    program, steps = Program.start(config.run(study), {}, study), 0

    def told(line: bytes, for_s: float) -> str:
        nonlocal steps
        heard, datagrams = b"", [Datagram(LINE, line)] if line else []
        for _ in range(round(for_s * STEP_HZ)):
            datagrams.append(Datagram(STATE, state_packet(steps / STEP_HZ, still)))
            steps += 1
            answers = program.step(round(steps * 1e9 / STEP_HZ), datagrams)
            heard += b"".join(answer.data for answer in answers if answer.port == LINE)
            datagrams = []
        return heard.decode("utf-8", "replace")

    try:
        told(b"", QUIET_S)
        told(b"#", 0.5)
        for line in lines:
            if "###ERROR" in (heard := told(f"{line}\n".encode(), LINE_S)):
                said = " ".join(heard.partition("###ERROR")[2].split())[:100]
                raise InputError(f"{', '.join(config.parameters) or 'Betaflight'}: {line!r} is refused: {said}")
        with suppress(FirmwareError):  # `save` ends it
            told(b"save\n", 10.0)
        content = program.file(EEPROM)
    except FirmwareError as error:
        raise BorderError(f"Betaflight ended before it was told its settings: {error}") from error
    finally:
        program.close()
    if not content:
        raise BorderError("Betaflight did not save its settings")
    path.write_bytes(content)
