"""What a firmware is to a flight: its settings, its seams, and what a kind of firmware has to do."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple, Protocol

from scaloft_fi.document import read_bytes
from scaloft_fi.marks import Bounds, Choices, Examples
from scaloft_fi.registry import Registry
from scaloft_fi.stack.declaration import STEP_HZ, TICK_HZ, Seam
from scaloft_fi.stack.messages import Array, Fix, Stamp, Vector


class Gyro(NamedTuple):
    """Sample of the firmware's gyro.  rate: (3,) angular rate [rad/s, body]."""

    stamp_s: Stamp
    rate: Vector


class Accelerometer(NamedTuple):
    """Sample of the firmware's accelerometer.  force: (3,) specific force [m/s2, body]."""

    stamp_s: Stamp
    force: Vector


class Motors(NamedTuple):
    """Order to the speed controllers: the throttle of each motor, 0..1, in the order of the rotors."""

    front_right: float
    rear_left: float
    front_left: float
    rear_right: float


class AttitudeOrder(NamedTuple):
    """What the outer loop asks of a firmware that holds attitudes.

    Tilts about body x forward (right side down) and body y left (nose down) [rad], turn rate about body z up [rad/s],
    throttle 0..1.
    """

    stamp_s: Stamp
    roll_rad: float
    pitch_rad: float
    turn_radps: float
    throttle: float


class VelocityOrder(NamedTuple):
    """What the outer loop asks of a firmware that flies velocities.  velocity: (3,) [m/s, world]; yaw_rad: heading."""

    stamp_s: Stamp
    velocity: Vector
    yaw_rad: float


@dataclass(frozen=True)
class Samples:
    """What a firmware gets at a physics step; None where nothing arrives.

    Attributes:
        gyro, accelerometer: of this step.
        fix: newest position fix, at the step at which it arrives.
        order: newest order of the outer loop.
        attitude: (4,) estimate of our drone, quaternion x, y, z, w, body to world.
        velocity: (3,) its estimate [m/s, world].
        altitude_m: the height of flight [m].
        mode: of flight control, one of `messages.MODES`; "stopped": the motors must not turn.
    """

    gyro: Gyro | None
    accelerometer: Accelerometer | None
    fix: Fix | None
    order: AttitudeOrder | VelocityOrder | None
    attitude: Array
    velocity: Array
    altitude_m: float
    mode: str

    @property
    def armed(self) -> bool:
        """Whether the motors may turn."""
        return self.mode != "stopped"


ATTITUDE = Seam("order", AttitudeOrder, STEP_HZ, "outer loop -> firmware")
VELOCITY = Seam("order", VelocityOrder, TICK_HZ, "outer loop -> firmware", units={"velocity": "m/s"})
MOTORS = Seam("motors", Motors, STEP_HZ, "firmware -> speed controllers")
GYRO = Seam("gyro", Gyro, STEP_HZ, "gyro -> firmware", units={"rate": "rad/s"})
ACCELEROMETER = Seam("accelerometer", Accelerometer, STEP_HZ, "accelerometer -> firmware", units={"force": "m/s2"})
POSITION = Seam("position", Fix, TICK_HZ, "positioning -> firmware", units={"position": "m"})


class Firmware(Protocol):
    """A firmware under way, armed on the ground when it is made."""

    def step(self, samples: Samples) -> Array:
        """Move the firmware on by one physics step; the throttle of each motor (4,), 0..1, in the order of the rotors.

        Raises:
            FirmwareError: the firmware ended.
        """
        ...

    def close(self) -> None:
        """End the program; may be called twice."""
        ...


class FirmwareKind(Protocol):
    """A kind of firmware, usually its class."""

    __module__: str
    seams: tuple[Seam, ...]
    """What it takes of sensors and outer loop."""

    def __call__(self, config: FirmwareConfig, study: Path, still: Samples, /) -> Firmware:
        """Start the program and bring it to where it is armed on the ground, before the flight begins.

        Args:
            config: the settings.
            study: folder of the study.
            still: what the vehicle's sensors say as it stands.

        Raises:
            BorderError: it did not get there; the sentence has its last lines.
        """
        ...


KINDS = Registry[FirmwareKind]("kind of firmware")
KINDS.promise("betaflight", "scaloft_fi.firmware.betaflight:Betaflight")
KINDS.promise("ardupilot", "scaloft_fi.firmware.ardupilot:Ardupilot")
KINDS.promise("px4", "scaloft_fi.firmware.px4:Px4")
KINDS.promise("lines", "scaloft_fi.firmware.lines:Lines")


@dataclass(frozen=True)
class FirmwareConfig:
    """Settings of a firmware.

    Attributes:
        kind: of firmware.
        program: path of the program, from the folder of the study.
        parameters: files of the study with the firmware's own parameters, in the form that its kind reads.
        arguments: further arguments of the program.
        version: of the program, in words, for logs and exports.
        throttle_exponent: curve of the speed controllers: a rotor's thrust is its greatest times its throttle to this
            power; 2: the throttle sets the rotor's speed, with whose square the thrust grows.
        tilt_rad: greatest tilt that is ordered [rad].
        turn_radps: greatest turn rate that is ordered [rad/s].
    """

    kind: Annotated[str, Choices(KINDS.keys)]
    program: Annotated[str, Examples("/opt/betaflight/betaflight_SITL")]
    version: str
    parameters: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()
    throttle_exponent: Annotated[float, Bounds(least=1.0, most=3.0)] = 2.0
    tilt_rad: Annotated[float, Bounds(above=0.0, most=math.pi / 4)] = 0.6
    turn_radps: Annotated[float, Bounds(above=0.0, most=10.0)] = 2.0

    def run(self, study: Path) -> tuple[str, ...]:
        """Program and arguments."""
        return (str((study / Path(self.program).expanduser()).absolute()), *self.arguments)

    def content(self, study: Path) -> Mapping[str, bytes]:
        """The files of parameters by name.

        Raises:
            InputError: one cannot be read.
        """
        return {name: read_bytes(study / name) for name in self.parameters}

    def mark(self, study: Path) -> str:
        """A digest of program and parameters.

        Raises:
            InputError: one cannot be read.
        """
        parts = [read_bytes(Path(self.run(study)[0])), *self.content(study).values()]
        return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()
