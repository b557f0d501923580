"""The flight log: its signals and events, recorded during the flight and judged afterwards; optional signals.

A plugin declares a signal with one decorated function, in a module that its entry point in the group
`scaloft_fi.plugins` names:

    @signal("tilt_deg", "deg", "angle between body z and the vertical")
    def tilt(scenario):
        return lambda state: math.degrees(math.acos(1.0 - 2.0 * (state[3] ** 2 + state[4] ** 2)))

A study that lists the signal under `signals` in `world.yaml` has it in its flight logs.  Requirements and predicates of
the study may use it, and the digest of a flight covers it.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.errors import DeclaredError
from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.registry import Registry
from scaloft_fi.stack.declaration import Belief

Array = NDArray[np.float64]
Maker = Callable[[Any], "Measure"]
"""Called with the `sim.load.Scenario` of the flight: situation, world, route, camera."""
Measure = Callable[[Array], float]
"""Called at 20 Hz with the true state (13,) of the vehicle in the layout of `sim.vehicle`; returns the value."""


class Side(StrEnum):
    """Whether a signal is ground truth or a belief of the stack."""

    TRUTH = "truth"
    PERCEIVED = "perceived"


@dataclass(frozen=True)
class Signal:
    """One column of the log.  unit: "" for a dimensionless number."""

    name: str
    unit: str
    meaning: str
    side: Side


class SignalError(DeclaredError):
    """A signal is not what it declares, so the flight cannot be judged."""


@dataclass(frozen=True)
class DeclaredSignal(Signal):
    """A signal that a study can choose.

    Attributes:
        make: makes the measure of a flight from its scenario; called once before the flight.
        most: greatest value; a formula may not compare the signal with a greater number.
    """

    make: Maker
    most: float

    def measure(self, scenario: Any) -> Measure:
        """The measure of a flight; it raises a `SignalError` where it has no number."""
        made = self.make(scenario)

        def measured(state: Array) -> float:
            value = made(state)
            if not isinstance(value, float) and np.asarray(value).dtype.kind not in "biuf":
                raise self._wrong(f"{value!r}, which is no number")
            return value

        return measured

    def hold(self, values: Array) -> None:
        """Hold the samples (T,) of a flight against what is declared.

        Raises:
            SignalError: one is not finite, or greater than `most`.
        """
        beyond = np.flatnonzero(~(np.isfinite(values) & (values <= self.most)))
        if beyond.size:
            most = f" of at most {self.most:g} {self.unit}".rstrip() if math.isfinite(self.most) else ""
            at = f"{values[beyond[0]]:g} at {beyond[0] / SAMPLE_HZ:.2f} s"
            raise self._wrong(f"{at}, and declares a finite number{most}")

    def _wrong(self, what: str) -> SignalError:
        return SignalError(f"signal {self.name} is {what}", self.make.__module__)


SIGNALS = Registry[DeclaredSignal]("signal")


def signal(name: str, unit: str, meaning: str, *, most: float = math.inf) -> Callable[[Maker], Maker]:
    """Declare the decorated function (scenario) -> measure as the signal `name`.

    Raises:
        ValueError: the name is taken.
    """

    def declare(make: Maker) -> Maker:
        SIGNALS.declare(name, DeclaredSignal(name, unit, meaning, Side.TRUTH, make, most))
        return make

    return declare


@signal("mass_kg", "kg", "mass of the vehicle, payload included")
def _mass_kg(scenario: Any) -> Measure:
    mass_kg: float = scenario.vehicle.mass_kg
    return lambda _state: mass_kg


@signal("takeoff_charge", "", "state of charge of the battery at take-off, 0..1", most=1.0)
def _takeoff_charge(scenario: Any) -> Measure:
    charge: float = scenario.sensors.battery.charge
    return lambda _state: charge


SAMPLE_HZ = 20.0
FAR_M = 100.0
"""Value of a distance to something absent [m]."""
CLEARANCE_CAP_M = 1.0
"""Greatest measured clearance [m]."""
TOUCH_M = -0.001
"""Greatest clearance during a contact [m]."""


_TRUTH = """
    elapsed_s          | s   | time since the start
    remaining_s        | s   | time left until the time limit
    x_m                | m   | position of the vehicle's centre, world
    y_m                | m   | position, world
    z_m                | m   | position, world
    vx_mps             | m/s | velocity, world
    vy_mps             | m/s | velocity, world
    vz_mps             | m/s | velocity, world
    qx                 |     | attitude quaternion, body to world
    qy                 |     | attitude quaternion
    qz                 |     | attitude quaternion
    qw                 |     | attitude quaternion
    yaw_rad            | rad | heading, world
    speed_mps          | m/s | greatest speed since the last sample
    clearance_m        | m   | least of the clearances below; at most -0.001 after any contact since the last sample
    person_range_m     | m   | from the vehicle's centre to the nearest person's surface; 100 without one
    person_sight_m     | m   | the same where a free straight line exists; 100 otherwise
    waypoints_left     |     | waypoints of the route, home last, not yet passed within 0.5 m in order
    home_m             | m   | level distance from home
    landed             |     | 1 from the first excused touch of the ground after take-off
    light              |     | brightness of visible light, 0..1
    obstacle_pixels    |     | pixels of obstacles in the range of the depth camera
    waypoint_wall_m    | m   | hull to wall while within 0.5 m of a waypoint other than home; 100 otherwise
"""
_ROWS = (map(str.strip, line.split("|")) for line in _TRUTH.strip().splitlines())
TRUTH = tuple(Signal(name, unit, meaning, Side.TRUTH) for name, unit, meaning in _ROWS)
TRUTH_NAMES = tuple(signal.name for signal in TRUTH)


def clearance_name(surface: str) -> str:
    """The signal of the clearance to one surface.

    >>> clearance_name("wall")
    'clearance_wall_m'
    """
    return f"clearance_{surface}_m"


def truth_signals(surfaces: Iterable[str], declared: Iterable[str] = ()) -> tuple[Signal, ...]:
    """The signals of the ground truth.

    Args:
        surfaces: surfaces of the world (`World.surfaces`); each has a clearance.
        declared: names of the optional signals that the world lists (`World.signals`).
    """
    told = "hull to {}, at most 1; 1 where it is not there or excused"
    clearances = (Signal(clearance_name(name), "m", told.format(name), Side.TRUTH) for name in surfaces)
    return (*TRUTH, *clearances, *(SIGNALS[name] for name in declared))


def signal_names(surfaces: Iterable[str], beliefs: Iterable[Belief], declared: Iterable[str] = ()) -> tuple[str, ...]:
    """The signal names of a flight log: ground truth, then beliefs; see `truth_signals` and `belief_signals`."""
    return tuple(signal.name for signal in (*truth_signals(surfaces, declared), *belief_signals(beliefs)))


def belief_signals(beliefs: Iterable[Belief]) -> tuple[Signal, ...]:
    """The signals of a stack's beliefs."""
    return tuple(Signal(belief.name, belief.unit, belief.meaning, Side.PERCEIVED) for belief in beliefs)


class Ending(StrEnum):
    """How a flight ended; not a verdict."""

    LANDED = "landed"
    STRUCK = "struck"
    TIMED_OUT = "timed_out"

    @property
    def cut_short(self) -> bool:
        """Whether the flight ended early, so that a requirement without violation stays open."""
        return self is Ending.STRUCK

    @property
    def sentence(self) -> str:
        """The ending in words."""
        words = "touched down", "struck something", "was still flying at the time limit"
        return words[list(Ending).index(self)]


@dataclass(frozen=True)
class Event:
    """An event that the map marks: time [s], kind, text; colour of the mark, where a belief has one."""

    t_s: float
    kind: str
    text: str
    colour: str = ""


class Recorder:
    """Collects rows of numbers for columns with fixed names."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._rows = np.empty((256, len(self.names)))
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, row: Sequence[float] | Array) -> None:
        """Append one sample; its values are in the order of the names."""
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[self._count] = row
        self._count += 1

    def signals(self) -> dict[str, Array]:
        """Each column (T,) by name."""
        columns = np.ascontiguousarray(self._rows[: self._count].T)
        columns.setflags(write=False)
        return dict(zip(self.names, columns, strict=True))


@dataclass(frozen=True, eq=False)
class FlightLog:
    """One flight.

    Attributes:
        signals: (T,) values by signal name, sampled at 20 Hz; the last sample is the end of the flight.
        ending: how the flight ended.
        struck: name of the body of the first collision; "" without one.  Excused contacts are no collisions.
        struck_at_s: time of the collision [s]; NaN without one.
        stack_error: exception of the stack under test; "" without one.
        counts: counts of the wire by seam.
        events: events in order of time.
        t_max_s: time limit of the situation [s].
        beliefs: names of the signals that are beliefs of the stack; the others are ground truth.
    """

    signals: Mapping[str, Array]
    ending: Ending
    struck: str
    struck_at_s: float
    stack_error: str
    counts: Mapping[str, SeamCount]
    t_max_s: float
    events: tuple[Event, ...] = field(default=())
    beliefs: tuple[str, ...] = ()

    @property
    def duration_s(self) -> float:
        """Time of the last sample [s]."""
        return float(self.signals["elapsed_s"][-1])

    @cached_property
    def digest(self) -> str:
        """SHA-256 over the ground truth: names and bits of its signals, ending, and body struck."""
        names = sorted(set(self.signals) - set(self.beliefs))
        return _digest(self.signals, names, (self.ending, self.struck))

    @cached_property
    def perceived_digest(self) -> str:
        """SHA-256 over the beliefs of the stack and its exception."""
        return _digest(self.signals, sorted(self.beliefs), (self.stack_error,))

    def at(self, t_s: float) -> int:
        """Index of the last sample at or before `t_s`."""
        return max(0, int(np.searchsorted(self.signals["elapsed_s"], t_s + 1e-9, side="right")) - 1)


def _digest(signals: Mapping[str, Array], names: Iterable[str], words: Iterable[str]) -> str:
    whole = hashlib.sha256()
    for name in names:
        values = np.ascontiguousarray(signals[name], dtype="<f8")
        whole.update(f"{name} {len(values)}\n".encode())
        whole.update(values.tobytes())
    whole.update("\n".join(words).encode())
    return whole.hexdigest()


NEVER_S = math.nan
"""Time of an event that did not happen."""
