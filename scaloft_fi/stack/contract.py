"""The contract between a stack under test and the flight loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from scaloft_fi.stack.camera import DepthCamera
from scaloft_fi.stack.fast_path import FastPath
from scaloft_fi.stack.fields import Array, Point
from scaloft_fi.stack.messages import Exposure, Imu, SensorFrames, Stamps, Thrust


@dataclass(frozen=True)
class Task:
    """The task of one flight, which a stack receives before take-off.

    Attributes:
        settings: of `sim/stack.yaml` without its `name`: built into the schema that the stack declares, else the plain
            mapping.
        camera: geometry of the depth camera.
        home: (3,) where the vehicle stands [m, world]; yaw_rad: its heading [rad].
        route: waypoints in order; the mission lands at the last one [m, world].
        altitude_m: height of flight [m].
        cruise_mps, slow_mps: cruise speed, and the speed after a person was seen [m/s].
        folder: folder of the study, for a stack with files of its own.
        situation: key of the situation, for programs outside that set up a scene of their own.
    """

    settings: Any
    camera: DepthCamera
    home: Point
    yaw_rad: float
    route: tuple[Point, ...]
    altitude_m: float
    cruise_mps: float
    slow_mps: float
    folder: str = "."
    situation: str = ""


class Stack(Protocol):
    """What the flight loop asks of a stack under test.

    At each tick (20 Hz) the loop calls `beliefs`, `stamps`, `autopilot` and `companion`, in this order, then `step`
    for each of the 12 physics steps (240 Hz) up to the next tick.  A stack receives nothing but these arguments and its
    `Task`.  It calls `Wire.cross` for each declared seam exactly once at each poll, with `None` when it sends nothing;
    depending on its declared rate a seam is polled at every tick or at every step.

    An exception in a method is a failure of the drone.  After an error of `autopilot`, `stamps` or `step` the rotors
    stop; after an error of `companion` the autopilot flies on alone.  The requirements judge what follows.

    A stack may have a method `close()`, which ends what it started, called once after the flight; and an attribute
    `complaint`, a sentence about what went wrong in the drone without an exception, "" for nothing.

    Two flights of the same subject, situation and seed call the methods with the same arguments; a stack that is
    declared deterministic answers with the same bits, so it draws no random numbers and reads no clock.
    """

    @property
    def exposure(self) -> Exposure:
        """The order in force for the colour camera."""
        ...

    @property
    def fast_path(self) -> FastPath | None:
        """`step` as a compiled kernel, used while no fault sits on its seams; None where there is none."""
        ...

    def stamps(self, now_s: float) -> Stamps:
        """The readings of the sensors' clocks at `now_s` [s]; the sensors stamp their messages with them."""
        ...

    def autopilot(self, now_s: float, frames: SensorFrames) -> None:
        """Run the part of the stack that survives a dead companion, at 20 Hz, before `companion`.

        Args:
            now_s: time since the start [s].
            frames: messages of the sensors that arrive at this tick, None for each sensor without one.
        """
        ...

    def companion(self, now_s: float, frames: SensorFrames) -> None:
        """Run the companion computer once, at 20 Hz; arguments as `autopilot`."""
        ...

    def step(self, now_s: float, imu: Imu) -> Thrust | None:
        """Run flight control once, at 240 Hz; returns None when the order was lost on the wire, which stops the rotors.

        Args:
            now_s: time since the start [s].
            imu: the inertial sample of this step.
        """
        ...

    def beliefs(self, now_s: float) -> Array:
        """(B,) values of the declared beliefs, in declared order, at `now_s` [s]."""
        ...


class PlainStack:
    """A base for stacks that leave clocks and colour camera alone and have no companion computer or fast path."""

    exposure = Exposure(0.0, 1.0, 0.0)
    fast_path = None

    def stamps(self, now_s: float) -> Stamps:
        """Return the true time."""
        return Stamps(now_s, now_s, now_s)

    def companion(self, now_s: float, frames: SensorFrames) -> None:
        """Do nothing."""
