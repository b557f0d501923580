"""What a stack under test declares, and its contract with the flight loop.

A stack without a fast path has the attribute `fast_path = None`, and every step is its Python `step`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol, TypeVar

import numpy as np

from scaloft_fi.stack import messages
from scaloft_fi.stack.messages import Array, DepthCamera, Exposure, Imu, Point, SensorFrames, Stamps, Thrust

STEP_HZ, TICK_HZ = 240.0, 20.0
STEP_S, TICK_S = 1.0 / STEP_HZ, 1.0 / TICK_HZ
STEPS_PER_TICK = 12


S = TypeVar("S")


class ConfigError(ValueError):
    """Settings of a stack do not fit together; `path` names the setting, such as `stack.mission.goal_radius_m`."""

    def __init__(self, path: str, complaint: str) -> None:
        super().__init__(f"{path}: {complaint}")
        self.path = path
        self.complaint = complaint


class Wire(Protocol):
    """Carries samples over the seams."""

    def listens(self, seam: str) -> bool:
        """Whether the wire counts or changes samples of `seam`; a fast path may skip only other seams."""
        ...

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Carry `sample` (None = nothing is sent at this tick) over `seam`; returns what arrives."""
        ...


class PlainWire:
    """Delivers every sample unchanged."""

    def listens(self, seam: str) -> bool:
        """Return False for every seam."""
        return False

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Return `sample`."""
        return sample


_WRITTEN = {"mps": "m/s", "mps2": "m/s2", "radps": "rad/s", "hz": "Hz", "n": "N", "v": "V", "ev": "EV", "hpa": "hPa"}
_UNITS = {**{unit: unit for unit in ("s", "m", "rad", "deg")}, **_WRITTEN}


def unit_of(name: str) -> str:
    """The unit that the name of a signal, a field or an argument ends in; "" for none.

    >>> unit_of("person_x_m"), unit_of("haze_per_m"), unit_of("landed")
    ('m', '1/m', '')
    """
    if name.endswith("_per_m"):
        return "1/m"
    return _UNITS.get(name.rpartition("_")[2], "") if "_" in name else ""


def _whole(sample: Any) -> Any:
    return sample


@dataclass(frozen=True)
class Seam:
    """One place where a fault can be patched in.

    Attributes:
        name: unique name.
        message: type of the sample.
        rate_hz: how often the seam is polled [Hz].
        edge: from which stage to which.
        effect: the part of a sample that its consumer acts on; two samples differ only where this part does.
        units: of the fields whose name does not end in their unit; "" for a plain number.

    Raises:
        ValueError: `units` names no field, or the rate is not positive.
    """

    name: str
    message: type
    rate_hz: float
    edge: str
    effect: Callable[[Any], Any] = _whole
    units: Mapping[str, str] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        unknown = [name for name in self.units if name not in messages.field_names(self.message)]
        if unknown:
            raise ValueError(f"seam {self.name!r}: {self.message.__name__} has no field {unknown[0]!r}")
        if not self.rate_hz > 0.0:
            raise ValueError(f"seam {self.name!r}: rate_hz={self.rate_hz:g} must be positive")

    def unit(self, field: str) -> str:
        """The unit of a field: declared, else the ending of its name, else "" for a plain number."""
        return self.units.get(field, unit_of(field))

    @property
    def number_units(self) -> Mapping[str, str]:
        """The unit of each field of numbers."""
        return {name: self.unit(name) for name in messages.number_fields(self.message)}

    def differ(self, original: Any, delivered: Any) -> bool:
        """Whether the consumer acts on something else than the producer sent."""
        if original is delivered:
            return False
        if original is None or delivered is None:
            return True
        return not _equal(self.effect(original), self.effect(delivered))


def _equal(a: Any, b: Any) -> bool:
    if a is b:
        return True
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(_equal, a, b))
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return _equal_arrays(np.asarray(a), np.asarray(b))
    return bool(a == b)


def _equal_arrays(a: np.ndarray[Any, Any], b: np.ndarray[Any, Any]) -> bool:
    """`numpy.array_equal(a, b, equal_nan=True)` in half the time."""
    if a.shape != b.shape:
        return False
    if a.size <= _FEW:
        return all(map(_same, a.ravel().tolist(), b.ravel().tolist()))
    return bool((a == b).all() or _same(a, b).all())


def _same(a: Any, b: Any) -> Any:
    """Whether two numbers, or each pair of those in two arrays, are equal or both NaN."""
    return (a == b) | ((a != a) & (b != b))


_FEW = 16
"""Arrays of at most this size are compared number by number, which is faster."""


@dataclass(frozen=True)
class Mark:
    """When a belief puts a mark into the recording of a flight, and on its map.

    Attributes:
        kind: one word for marks of this kind; a fault may strike at it, as at `#recoil`.
        text: label of the mark; `{}` stands for the value's name.
        first: whether only the first occurrence is marked.
        values: names of the values 0, 1, ...; with them each change is marked, without them each rise above 0.5.
        colour: on the map; "" keeps it off the map.
    """

    kind: str
    text: str
    first: bool = False
    values: tuple[str, ...] = ()
    colour: str = "#1d4ed8"


@dataclass(frozen=True)
class Belief:
    """A number that a stack believes.

    Attributes:
        name: unique among the signals of the log; requirements may speak of it.
        unit: "" for a plain number.
        meaning: of the number, in words.
        unknown: its value while the stack does not know it; NaN for a number that the stack always knows.
        mark: when the map of a flight shows a mark; None for never.
        most: its greatest value; a formula that compares it with a greater number is refused.
    """

    name: str
    unit: str
    meaning: str
    unknown: float = math.nan
    mark: Mark | None = None
    most: float = math.inf


@dataclass(frozen=True, eq=False)
class Instant:
    """A moment of a flight that violates a requirement, at the violation or before it.

    Attributes:
        signals: (T,) ground truth and beliefs by name, at 20 Hz from the start to this moment.
        sample: newest sample that the claim's seam delivered; None without one.
        place: (3,) centre of the vehicle when it violates the requirement [m, world].
        struck: name of what it strikes then; "" for nothing.
    """

    signals: Mapping[str, Array]
    sample: Any
    place: Point
    struck: str


@dataclass(frozen=True)
class Claim:
    """What a stage believes of the world; it decides no flight and no verdict, and tells who was wrong before one.

    Attributes:
        stage: the stage and what it believes, in a few words.
        unit: of the error.
        within: greatest error of a belief that is right [unit].
        error: how far the belief is from the truth [unit]; 0 where it says nothing.
        about: signals of the ground truth; the claim matters to a requirement that speaks of one of them, and to every
            requirement when there are none.
        seam: whose newest sample `error` needs; "" for none.

    Raises:
        ValueError: `within` is not positive.
    """

    stage: str
    unit: str
    within: float
    error: Callable[[Instant], float]
    about: tuple[str, ...] = ()
    seam: str = ""

    def __post_init__(self) -> None:
        if not self.within > 0.0:
            raise ValueError(f"claim {self.stage!r}: within={self.within:g} must be positive")


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
        sensors: names of the sensors of `sim/sensors.yaml`.
        throttle_exponent: curve of the vehicle's speed controllers, for a firmware that orders throttles.
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
    sensors: tuple[str, ...] = ()
    throttle_exponent: float = 2.0


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


Numbers = tuple[Array, ...]
"""One-dimensional arrays, any number of them, that the kernel of a stack reads and writes."""

Kernel = Callable[[float, float, Array, Array, Numbers], Array]
"""A function under `stack.kernel.jit` with the arguments

    now_s: time of the step, its number divided by `STEP_HZ` [s].
    stamp_s: stamp of the inertial sample, the step's number times `STEP_S` [s].
    rate, force: (3,) of the inertial sample [rad/s, m/s2, body].
    numbers: what `FastPath.begin` returned.

which returns the thrust of each rotor (4,) [N].  It must have the bits of the stack's `step`.
"""


class FastPath(Protocol):
    """A stack's `step`, compiled.  The flight loop calls `begin`, the kernel for each step up to a tick, and `end`.

    What `begin` raises stops the rotors, like what `step` raises; the kernel and `end` must not raise.
    """

    @property
    def seams(self) -> tuple[str, ...]:
        """The seams that the kernel skips: the flight loop uses it only where the wire listens on none of them."""
        ...

    @property
    def kernel(self) -> Kernel:
        """The compiled step, the same function at every call."""
        ...

    def begin(self) -> Numbers:
        """Prepare for steps by the kernel; returns the kernel's numbers, equally many arrays at every call."""
        ...

    def end(self) -> None:
        """Take the result of the steps over from the numbers, as if `step` had been called."""
        ...


@dataclass(frozen=True)
class Declaration:
    """A stack under test, as the framework knows it.

    Attributes:
        name: by which `sim/stack.yaml` names the stack.
        seams: where faults can be patched in; each sample of a seam crosses `Wire.cross`.
        beliefs: the numbers that `Stack.beliefs` returns, in order.
        make: makes the stack, ready for take-off.  It imports heavy modules itself, because verbs that do not fly read
            the declaration too.
        settings: returns the model that the rest of `sim/stack.yaml` is read into, a frozen dataclass or named tuple
            (`scaloft_fi.model`); None hands the plain mapping over.
        canaries: seams that carry samples in every situation, the one nearest to the rotors first.  `run --mutant`
            flies a control there, to prove that faults reach the drone.
        operators: modules that declare operators of this stack's own; imported when a study names the stack.
        deterministic: whether two flights of the same subject, situation and seed have the same bits.
        forks: whether a flight may be forked in mid-air.  A stack with threads or other processes cannot: each of its
            flights has a process of its own.
        shape: the declaration that follows from the settings, of a stack whose seams are data; it may raise
            `ConfigError`.
        rehearse: makes a stack for the trial flight before the first flight, without threads or other processes; None =
            `make`.
        files: paths, from the folder of the study, of files outside `sim/` whose content decides a flight.
        version: of the programs that fly, in words; "" where all of them are ours.
        forms: returns the models that the settings may have, where an editor has to know more than one.
        kernels: calls kernels that take long to compile, with values like those of a flight: where no machine code is
            kept yet, a second process compiles them meanwhile.

    Raises:
        ValueError: a name is taken twice, or a canary is no seam.
    """

    name: str
    seams: tuple[Seam, ...]
    beliefs: tuple[Belief, ...]
    make: Callable[[Task, Wire], Stack]
    settings: Callable[[], type] | None = None
    canaries: tuple[str, ...] = ()
    operators: tuple[str, ...] = ()
    deterministic: bool = True
    forks: bool = True
    shape: Callable[[Any], Declaration] | None = None
    rehearse: Callable[[Task, Wire], Stack] | None = None
    files: tuple[str, ...] = ()
    version: str = ""
    forms: Callable[[], tuple[type, ...]] | None = None
    kernels: Callable[[Task], None] | None = None

    def __post_init__(self) -> None:
        for noun, names in (("seam", [s.name for s in self.seams]), ("belief", [b.name for b in self.beliefs])):
            twice = [name for place, name in enumerate(names) if name in names[:place]]
            if twice:
                raise ValueError(f"stack {self.name!r} declares {noun} {twice[0]!r} twice")
        lost = [name for name in self.canaries if name not in self.by_name]
        if lost:
            raise ValueError(f"stack {self.name!r} has no seam {lost[0]!r} for a canary")

    @property
    def title(self) -> str:
        """Name and version, in words."""
        return f"{self.name}, {self.version}" if self.version else self.name

    @property
    def rehearsed(self) -> Declaration:
        """The declaration for the trial flight."""
        return replace(self, make=self.rehearse) if self.rehearse else self

    @cached_property
    def by_name(self) -> Mapping[str, Seam]:
        """The seams by name."""
        return {seam.name: seam for seam in self.seams}

    @property
    def caps(self) -> Mapping[str, float]:
        """The greatest value of each belief, where one is declared."""
        return {belief.name: belief.most for belief in self.beliefs if math.isfinite(belief.most)}

    @property
    def belief_names(self) -> tuple[str, ...]:
        """Names of the beliefs, in order."""
        return tuple(belief.name for belief in self.beliefs)
