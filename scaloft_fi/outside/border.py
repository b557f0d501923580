"""A border carries samples between a flight and the processes outside, topic by topic, as plain values or mapped.

Frames: world = x east, y north, z up [m]; body = x forward, y left, z up.
"""

from __future__ import annotations

import base64
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple, Protocol, get_args, get_origin, get_type_hints

import numpy as np

from scaloft_fi.marks import Choices
from scaloft_fi.output import line as inert
from scaloft_fi.registry import Registry
from scaloft_fi.sim.flight import StackError
from scaloft_fi.stack.declaration import STEP_HZ, TICK_HZ
from scaloft_fi.stack.messages import (
    Battery,
    Bumper,
    DepthFrame,
    Detections,
    Imu,
    Point,
    Stamp,
    Vector,
    field_names,
    image_fields,
)
from scaloft_fi.stack.reference.messages import PoseEstimate, SpeedLimit

NOTHING: Mapping[str, Any] = MappingProxyType({})


class BorderError(StackError):
    """The border, or what the processes outside need before take-off, is missing: a failure of the harness."""

    exit_code = 4


@dataclass(frozen=True)
class Topic:
    """One topic of a border, over which the samples of one seam go.

    Attributes:
        seam: name of the seam.
        name: of the topic, as the border spells it: "/odom".
        message: type of the seam's samples, a named tuple.
        outward: whether samples go to the processes outside; otherwise they come from there.
        type: type of the border's messages, such as "nav_msgs/msg/Odometry"; "" = the border's usual one for `message`.
        frame: frame of the border's messages: the frame id of those that go out, "world" or "body" for those that come.
        qos: quality of service as the border names it, such as {"reliability": "best_effort", "depth": 1}.
        fields: field of the border's message by path, "linear.x", to that of the sample, "velocity.x"; empty = the
            border's usual mapping.  A number may be multiplied: "velocity.x * 1000".
        awaited: whether the flight waits before take-off until the topic has its other end.
    """

    seam: str
    name: str
    message: type
    outward: bool
    type: str = ""
    frame: str = ""
    qos: Mapping[str, Any] = field(default_factory=dict)
    fields: Mapping[str, str] = field(default_factory=dict)
    awaited: bool = True


@dataclass(frozen=True)
class Arrival:
    """What came over a topic since the last tick, the newest message last.

    Attributes:
        sample: the newest sound sample; None without any.
        count: number of messages that came.
        refused: why a message was refused, a sentence about the first such message; "" if none was.
    """

    sample: Any | None = None
    count: int = 0
    refused: str = ""


class Border(Protocol):
    """Carries samples between one flight and its processes.  It is used in one process, which flies one flight.

    Whatever comes in is untrusted: sizes and numbers of messages are bounded, nothing is unpickled, and a message that
    does not fit, or has a number that is not finite, is refused with a sentence.  Listeners bind to loopback.
    """

    @property
    def environment(self) -> Mapping[str, str]:
        """What the processes need in their environment to find this border, and no other one on this machine."""
        ...

    def open(self) -> None:
        """Open the topics.

        Raises:
            BorderError: a library or a type of message is missing; the sentence says what to install.
        """
        ...

    def lacking(self) -> str:
        """What is not there yet on the other side, in words; "" when every awaited topic has its other end."""
        ...

    def send(self, seam: str, t_s: float, sample: Any) -> None:
        """Send a sample of an outward seam at the simulated time `t_s` [s]."""
        ...

    def clock(self, t_s: float) -> None:
        """Tell the processes the simulated time [s]; the last message of a tick."""
        ...

    def wait(self, seam: str, within_s: float) -> bool:
        """Wait until a message of an inward seam comes, at most `within_s` of wall time [s]; whether one came.

        A message counts that came after the last call of `clock`.
        """
        ...

    def take(self, seam: str) -> Arrival:
        """What came over an inward seam since the last call."""
        ...

    def close(self) -> None:
        """Close the topics; may be called twice."""
        ...


class BorderKind(Protocol):
    """A kind of border, usually its class."""

    def __call__(self, topics: Sequence[Topic], folder: Path, /) -> Border:
        """A border, not open yet; `folder` is empty and private to the flight."""
        ...

    def misfit(self, topic: Topic, /) -> str:
        """What of a topic's settings it cannot carry, in words; "" if all of it.  It needs no other software."""
        ...

    def need(self) -> None:
        """Look for the software that it needs, without importing it.

        Raises:
            InputError: something is missing; the sentence says how to get it.
        """
        ...


BORDERS = Registry[BorderKind]("border")
BorderName = Annotated[
    str, Choices(BORDERS.keys, elsewhere=(("ros1", "scaloft-fi example ros1 && pip install ./ros1"),))
]
BORDERS.promise("lines", "scaloft_fi.outside.lines:LinesBorder")
BORDERS.promise("ros2", "scaloft_fi.outside.ros2:Ros2Border")


AHEAD_S = 0.1
"""A message may be stamped this much later than the flight's clock [s]."""
SAID = 300
"""Most characters of a sentence on a refused message."""


@dataclass
class Inbox:
    """What came since it was last taken.

    Attributes:
        topic: the topic.
        sample: the newest sound sample.
        count: number of messages.
        refused: about the first refused message.
        fresh: whether a sound one came since the last clock.
    """

    topic: Topic
    sample: Any | None = None
    count: int = 0
    refused: str = ""
    fresh: bool = False

    def refuse(self, reason: str) -> None:
        """Note why a message was refused, if it is the first one."""
        self.refused = self.refused or f"{self.topic.name}: {inert(reason)[:SAID]}"

    def take(self) -> Arrival:
        """What came, and an empty box."""
        arrival = Arrival(self.sample, self.count, self.refused)
        self.sample, self.count, self.refused = None, 0, ""
        return arrival


@dataclass(eq=False)
class TopicsBorder:
    """What borders share that hear messages when they are asked to: a box for each inward topic.

    Attributes:
        topics: the topics.
        folder: empty, private to the flight.
        clock_s: the time that was told last [s].
    """

    topics: Sequence[Topic]
    folder: Path
    clock_s: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        self._outward = {topic.seam: topic for topic in self.topics if topic.outward}
        self._inbox = {topic.seam: Inbox(topic) for topic in self.topics if not topic.outward}

    def _hear(self, within_s: float) -> bool:
        """Take what has come into the boxes; wait for it at most so long [s, wall].  Whether more can come."""
        raise NotImplementedError

    def _begin_tick(self, t_s: float) -> None:
        """What comes from now on answers the tick of this time [s]."""
        self.clock_s = t_s
        for box in self._inbox.values():
            box.fresh = False

    def _check_stamp(self, name: str, stamp_s: float) -> None:
        if stamp_s > self.clock_s + AHEAD_S:
            raise MisfitError(f"{name} is later than the clock, {self.clock_s:g}")

    def wait(self, seam: str, within_s: float) -> bool:
        """Wait for a message; a refused one is none."""
        box, due_s = self._inbox[seam], time.monotonic() + within_s
        more = self._hear(0.0)
        while more and not box.fresh and (left_s := due_s - time.monotonic()) > 0.0:
            more = self._hear(left_s)
        return box.fresh

    def take(self, seam: str) -> Arrival:
        """What came, the newest sample last."""
        self._hear(0.0)
        return self._inbox[seam].take()


AXES = {"x": 0, "y": 1, "z": 2}


class Mapped(NamedTuple):
    """A path of the sample, and what its number is multiplied by in the border's message."""

    path: tuple[str, ...]
    factor: float = 1.0


def mapped(text: str) -> Mapped:
    """Read `velocity.x` or `velocity.x * 1000`.

    >>> mapped("velocity.x * 1000")
    Mapped(path=('velocity', 'x'), factor=1000.0)

    Raises:
        ValueError: the factor is no number, or zero.
    """
    path, _, factor = text.partition("*")
    number = float(factor) if factor else 1.0
    if not number or number != number:
        raise ValueError(f"{text!r}: the factor must be a number other than zero")
    return Mapped(tuple(path.strip().split(".")), number)


def given(plain: Any, fields: Mapping[str, str]) -> Any:
    """The border's message for the plain values of a sample; without fields they are the message.

    >>> given({"velocity": [1.0, 2.0, 3.0]}, {"linear.x": "velocity.x * 100"})
    {'linear': {'x': 100.0}}
    """
    if not fields:
        return plain
    message: dict[str, Any] = {}
    for theirs, ours in fields.items():
        way, factor = mapped(ours)
        value = plain
        for key in way:
            value = value[AXES[key]] if isinstance(value, list) else value[key]
        _put(message, theirs, value if factor == 1.0 else value * factor)
    return message


def _put(message: dict[str, Any], path: str, value: Any) -> None:
    *parents, last = path.split(".")
    for parent in parents:
        message = message.setdefault(parent, {})
    message[last] = value


def taken(message: Any, fields: Mapping[str, str]) -> Any:
    """The plain values of a sample for a message of the border.

    >>> taken({"linear": {"x": 100.0}}, {"linear.x": "velocity.x * 100"})
    {'velocity': [1.0, 0.0, 0.0]}

    Raises:
        MisfitError: the message lacks a field.
    """
    if not fields:
        return message
    plain: dict[str, Any] = {}
    for theirs, ours in fields.items():
        way, factor = mapped(ours)
        value = message
        for key in theirs.split("."):
            if not isinstance(value, dict) or key not in value:
                raise MisfitError(f"{theirs} is missing")
            value = value[key]
        if factor != 1.0:
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise MisfitError(f"{theirs} must be a number")
            try:
                value = value / factor
            except OverflowError:
                raise MisfitError(f"{theirs} is too large") from None
        if way[-1] in AXES and len(way) == 2:
            plain.setdefault(way[0], [0.0, 0.0, 0.0])[AXES[way[-1]]] = value
        else:
            plain[way[0]] = value
    return plain


def picked(message: object, paths: Iterable[str]) -> Any:
    """The attributes of a message that stand at these paths, as nested mappings; what is missing is left out.

    >>> from types import SimpleNamespace
    >>> picked(SimpleNamespace(linear=SimpleNamespace(x=1.0, y=2.0)), ["linear.x", "angular.z"])
    {'linear': {'x': 1.0}}
    """
    plain: dict[str, Any] = {}
    for path in paths:
        value: Any = message
        for key in path.split("."):
            value = getattr(value, key, None)
        if value is not None:
            _put(plain, path, value)
    return plain


SIDE = 4096
"""Greatest height and width of an image."""
LARGEST = 1 << 1023
"""Greatest whole number that is read as a number with a point."""
LONGEST = 1_000
"""Greatest length of a tuple, and of a text."""


class MisfitError(ValueError):
    """A value does not fit its field; the message names the field."""


def to_plain(sample: Any) -> Any:
    """The plain values of a sample: named tuples are mappings, vectors are lists, images packed little-endian doubles.

    >>> from scaloft_fi.stack.messages import Bumper
    >>> to_plain(Bumper(1.5, hull=True, gear=False))
    {'stamp_s': 1.5, 'hull': True, 'gear': False}
    """
    if hasattr(sample, "_fields"):
        images = image_fields(type(sample))
        return {name: (_packed if name in images else to_plain)(getattr(sample, name)) for name in sample._fields}
    if isinstance(sample, np.ndarray):
        return sample.tolist()
    if isinstance(sample, tuple):
        return [to_plain(entry) for entry in sample]
    return sample


def _packed(image: Any) -> dict[str, Any]:
    height, width = image.shape
    data = base64.b64encode(np.ascontiguousarray(image, dtype="<f8").tobytes()).decode("ascii")
    return {"height": height, "width": width, "data": data}


def from_plain(message: type, value: Any, name: str = "data") -> Any:
    """The sample of a message type that plain values stand for.

    Raises:
        MisfitError: a field is missing, unknown, of another type, not finite or too large.
    """
    if not isinstance(value, dict):
        raise MisfitError(f"{name} must be a mapping")
    hints = get_type_hints(message)
    images = image_fields(message)
    unknown = sorted(str(key) for key in value.keys() - hints.keys())
    if unknown:
        raise MisfitError(f"{name}.{unknown[0]} is no field of {message.__name__}: {', '.join(hints)}")
    made = {}
    for key in field_names(message):
        path = f"{name}.{key}"
        if key not in value:
            if key in getattr(message, "_field_defaults", ()):
                continue
            raise MisfitError(f"{path} is missing")
        made[key] = (_image if key in images else _value)(hints[key], value[key], path)
    return message(**made)


_PLAIN: Mapping[type, tuple[str, Callable[[Any], bool]]] = {
    int: ("a whole number", lambda value: abs(value) <= 1 << 53),
    bool: ("true or false", lambda _: True),
    str: (f"a text of at most {LONGEST} characters", lambda value: len(value) <= LONGEST),
}
"""What plain values of a type must be, in words, and whether one is so."""


def _value(hint: Any, value: Any, path: str) -> Any:
    if hint is float:
        return _number(value, path)
    if hint in _PLAIN:
        must, sound = _PLAIN[hint]
        if type(value) is not hint or not sound(value):
            raise MisfitError(f"{path} must be {must}")
        return value
    if hint == Point:
        return tuple(_numbers(value, path, 3))
    if get_origin(hint) is tuple:
        if not isinstance(value, list) or len(value) > LONGEST:
            raise MisfitError(f"{path} must be a list of at most {LONGEST}")
        return tuple(from_plain(get_args(hint)[0], entry, f"{path}[{place}]") for place, entry in enumerate(value))
    return np.array(_numbers(value, path, 4 if path.endswith("attitude") else 3))


def _number(value: Any, path: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise MisfitError(f"{path} must be a number")
    if (isinstance(value, int) and abs(value) > LARGEST) or not math.isfinite(value):
        raise MisfitError(f"{path}={value!r:.20} must be finite")
    return float(value)


def _numbers(value: Any, path: str, count: int) -> list[float]:
    if not isinstance(value, list) or len(value) != count:
        raise MisfitError(f"{path} must be a list of {count} numbers")
    return [_number(entry, f"{path}[{place}]") for place, entry in enumerate(value)]


def _image(_hint: Any, value: Any, path: str) -> Any:
    packed = isinstance(value, dict) and value.keys() == {"height", "width", "data"}
    if not packed or not all(isinstance(value[side], int) and 0 < value[side] <= SIDE for side in ("height", "width")):
        raise MisfitError(f"{path} must have height, width (at most {SIDE}) and data")
    shape = value["height"], value["width"]
    try:
        data = base64.b64decode(value["data"], validate=True)
        image = np.frombuffer(data, dtype="<f8").reshape(shape).astype(np.float64)
    except (ValueError, TypeError) as error:
        raise MisfitError(f"{path}.data must be {shape[0] * shape[1]} packed numbers: {error}") from error
    if not np.isfinite(image).all():
        raise MisfitError(f"{path}.data must be finite")
    return image


class CameraInfo(NamedTuple):
    """Geometry of the depth camera, with each image.  fx, fy: focal lengths; cx, cy: optical centre [pixel]."""

    stamp_s: Stamp
    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float


class Motion(NamedTuple):
    """A velocity command.  velocity: (3,) [m/s, in the frame of the topic]; turn_radps: rate of turn, left positive."""

    velocity: Vector
    turn_radps: float


class Goal(NamedTuple):
    """The place to fly to [m, world]."""

    point: Point


class Land(NamedTuple):
    """The order to land here and now."""

    stamp_s: Stamp


@dataclass(frozen=True)
class Port:
    """What a seam of a stage outside may carry.

    Attributes:
        message: type of the sample.
        outward: whether the simulator offers it; otherwise it takes it.
        meaning: in words.
        rate_hz: how often it is polled [Hz].
        units: of the fields whose name does not end in their unit.
    """

    message: type
    outward: bool
    meaning: str
    rate_hz: float = TICK_HZ
    units: Mapping[str, str] = field(default_factory=dict)


PORTS: Mapping[str, Port] = {
    "odometry": Port(
        PoseEstimate, True, "pose and velocity by the autopilot's estimate", TICK_HZ,
        {"position": "m", "velocity": "m/s"},
    ),
    "depth": Port(DepthFrame, True, "depth image", TICK_HZ, {"depth": "m"}),
    "camera_info": Port(CameraInfo, True, "geometry of the depth camera, with each image"),
    "inertial": Port(Imu, True, "angular rate and specific force", STEP_HZ, {"rate": "rad/s", "force": "m/s2"}),
    "detections": Port(Detections, True, "persons in a picture, if there are any"),
    "battery": Port(Battery, True, "charge and voltage"),
    "contacts": Port(Bumper, True, "whether hull and landing gear touch something"),
    "velocity": Port(Motion, False, "velocity command to flight control", TICK_HZ, {"velocity": "m/s"}),
    "goal": Port(Goal, False, "place to fly to, for our planner", TICK_HZ, {"point": "m"}),
    "speed_limit": Port(SpeedLimit, False, "speed limit of our planner"),
    "land": Port(Land, False, "order to land"),
}  # fmt: skip
"""All ports by name."""
