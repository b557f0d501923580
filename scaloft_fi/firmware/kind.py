"""What a firmware is to a flight: its settings, its seams, and what a kind of firmware has to do."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Protocol

from scaloft_fi.document import Item, read_bytes
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.marks import Bounds, Choices, Examples
from scaloft_fi.registry import Registry
from scaloft_fi.stack.declaration import STEP_HZ, TICK_HZ, Seam
from scaloft_fi.stack.messages import Array, Battery, Fix, MagneticField, Pressure, Stamp, Vector


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
        order: newest order of the outer loop.
        attitude: (4,) estimate of our drone, quaternion x, y, z, w, body to world.
        velocity: (3,) its estimate [m/s, world].
        altitude_m: the height of flight [m].
        mode: of flight control, one of `messages.MODES`; "stopped": the motors must not turn.
        arrived: what the 20 Hz sensors delivered for this step, by the sensor's name.
    """

    gyro: Gyro | None
    accelerometer: Accelerometer | None
    order: AttitudeOrder | VelocityOrder | None
    attitude: Array
    velocity: Array
    altitude_m: float
    mode: str
    arrived: Mapping[str, Any] = field(default_factory=dict)

    @property
    def fix(self) -> Fix | None:
        """The position fix, at the step at which it arrives."""
        return self.arrived.get("positioning")

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
BAROMETER = Seam("barometer", Pressure, TICK_HZ, "barometer -> firmware")
MAGNETOMETER = Seam("magnetometer", MagneticField, TICK_HZ, "magnetometer -> firmware", units={"field": "uT"})
SUPPLY = Seam("supply", Battery, TICK_HZ, "battery -> firmware")


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
    further: Mapping[str, Seam]
    """What it takes of the study's other sensors where `sensors` of its settings names them, by the sensor's name."""

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
        sensors: further sensors of the study that the firmware gets, as far as its kind takes them.
        version: of the program, in words, for logs and exports.
        tilt_rad: greatest tilt that is ordered [rad].
        turn_radps: greatest turn rate that is ordered [rad/s].
    """

    kind: Annotated[str, Choices(KINDS.keys)]
    program: Annotated[str, Examples("/opt/betaflight/betaflight_SITL")]
    version: str
    parameters: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()
    tilt_rad: Annotated[float, Bounds(above=0.0, most=math.pi / 4)] = 0.6
    turn_radps: Annotated[float, Bounds(above=0.0, most=10.0)] = 2.0

    @property
    def seams(self) -> tuple[Seam, ...]:
        """What the firmware takes, but for its motors."""
        return (*KINDS[self.kind].seams, *(KINDS[self.kind].further[name] for name in self.sensors))

    @property
    def seams_by_sensor(self) -> Mapping[str, Seam]:
        """The seam of each 20 Hz sensor that the firmware gets, by the sensor's name."""
        fixes = {"positioning": POSITION} if POSITION in KINDS[self.kind].seams else {}
        return {**fixes, **{name: KINDS[self.kind].further[name] for name in self.sensors}}

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a sensor that the kind does not take."""
        known = KINDS[self.kind].further if self.kind in KINDS else {}
        for number, name in enumerate(self.sensors):
            if name not in known:
                place = item.need("sensors").items()[number]
                takes = f"one of {', '.join(known)}" if known else "left out: it takes none"
                yield place.error(f"a sensor that {self.kind} takes: {takes}{did_you_mean(name, known)}")

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
