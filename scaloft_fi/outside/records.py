"""Records of flights: where the signals stand in them (`sim/record.yaml`), and the flight logs that they yield.

A signal is sampled at 20 Hz with the last value held: a value between two messages was never measured, and a flag or a
distance to the nearest body jumps, so that a line between two values would tell of states that were not.  Signals that
a record lacks are derived from others.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.document import Item, is_folder, load, read_apart
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.marks import MOST, Bounds, Called, Choices, Either, Examples, Given, Reads, Size
from scaloft_fi.model import read, schema_of, value_of
from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.registry import Registry
from scaloft_fi.sim.log import NEVER_S, SAMPLE_HZ, Ending, FlightLog, clearance_name
from scaloft_fi.stack.declaration import unit_of
from scaloft_fi.stack.messages import Array, Point

SAID = 200
"""Most characters of what a library says that are told."""
MOST_MESSAGES = 5_000_000
"""Most messages, or rows, of a record that are read."""


class Keep(StrEnum):
    """Which value stands for the messages since the last sample."""

    LAST = "last"
    LEAST = "least"
    MOST = "most"


@dataclass(frozen=True)
class MappedSignal:
    """Where a signal comes from.

    Attributes:
        signal: name of the signal, for errors.
        column: of a table; "" where the signal stands in no table.
        topic, field: of a record with topics; a field may have parts and places, "pose.position.x", "q[0]".
        factor, offset: signal = factor x value + offset.
        constant: its value, where it stands nowhere; else None.
        unknown: its value before its first message; None = it must have one by the start of the flight.
        keep: which value stands for the messages since the last sample.
        gap_s: longest time for which its value is held [s]; None = as the mapping says.
        least: of a moment: it comes with the first message whose value is at least this.
    """

    signal: str
    column: str = ""
    topic: str = ""
    field: str = ""
    factor: float = 1.0
    offset: float = 0.0
    constant: float | None = None
    unknown: float | None = None
    keep: Keep = Keep.LAST
    gap_s: float | None = None
    least: float = 0.0


@dataclass(frozen=True)
class Timing:
    """Which time the values of a record have.

    Attributes:
        column: of a table, with the time.
        unit_s: length of the unit of that column [s].
        stamped: whether a message has the time of its header's stamp; otherwise the time at which it was received.
        clock: topic with the simulated time; a received message has the last time that was told there.
    """

    column: str = ""
    unit_s: float = 1.0
    stamped: bool = False
    clock: str = ""


@dataclass(frozen=True, eq=False)
class Series:
    """The values of a signal.  times_s: (N,) [s], never decreasing; values: (N,), each finite."""

    times_s: Array
    values: Array


def lacks(path: Path, source: MappedSignal, noun: str, name: str, there: Iterable[str]) -> InputError:
    """The error for a record without the `noun` (a column, topic or field) of a signal."""
    hint = did_you_mean(name, there)
    return InputError(
        f"{path}: signal {source.signal!r} needs the {noun} {name!r}, which the record does not have{hint}"
    )


def number(path: Path, source: MappedSignal, place: str, value: Any) -> float:
    """A value of a record as a number.

    Raises:
        InputError: it is no number, or not finite; the message names `place`.
    """
    try:
        if isinstance(value, str | bytes):
            raise TypeError
        plain = float(value)
    except (TypeError, ValueError, OverflowError):
        kind = type(value).__name__
        raise InputError(f"{path}: {place}: signal {source.signal!r} must be a number, and is of type {kind}") from None
    if not math.isfinite(plain):
        raise InputError(f"{path}: {place}: signal {source.signal!r} must be a finite number, and is {plain}")
    return plain


def too_many(path: Path) -> InputError:
    """The error for a record that is too long."""
    return InputError(f"{path}: the record must have at most {MOST_MESSAGES:,} messages or rows")


def damaged(path: Path, error: Exception, remedy: str = "") -> InputError:
    """The error for a record that its library cannot read."""
    if isinstance(error, MemoryError):
        raise error
    return InputError(f"{path}: the record cannot be read: {said_by(error)}{remedy}")


def said_by(error: Exception) -> str:
    """What a library says, in one line of at most `SAID` characters."""
    name = type(error).__name__
    said = _SAID.get(name) or " ".join(str(error).split()).rstrip(".") or name
    return said if len(said) <= SAID else f"{said[:SAID]}…"


CHECKSUM = "CRCValidationError"
_SAID = {"EndOfFile": "the file ends too early", CHECKSUM: "bytes of it have changed, as a checksum says"}
"""What errors of libraries say that say no sentence, by name."""
_PART = re.compile(r"([A-Za-z_]\w*)((?:\[\d+\])*)")


def steps(field: str) -> tuple[str | int, ...] | None:
    """The names and places on the way to a field; None where `field` is not written so.

    >>> steps("pose.covariance[3]")
    ('pose', 'covariance', 3)
    """
    way: list[str | int] = []
    for part in field.split("."):
        found = _PART.fullmatch(part)
        if found is None:
            return None
        way += [found[1], *map(int, re.findall(r"\d+", found[2]))]
    return tuple(way)


FOLDER = "folder"
"""The kind of a record that is a folder: rosbag2."""


@dataclass(frozen=True)
class RecordedField:
    """A column of a record, or a field of its messages.

    Attributes:
        topic: the topic of the messages; empty for a column.
        field: name of the column, or path of the field.
        messages: how many messages, or cells, it has.
        first_s: time of the first in the record [s]; null: there is none, or its time is not known.
        last_s: time of the last [s].
    """

    topic: str
    field: str
    messages: int
    first_s: float | None = None
    last_s: float | None = None

    @property
    def name(self) -> str:
        """The column, or the field after its topic."""
        return f"{self.topic}: {self.field}" if self.topic else self.field

    @property
    def rate_hz(self) -> float | None:
        """Messages a second."""
        if self.first_s is None or self.last_s is None or self.last_s <= self.first_s:
            return None
        return (self.messages - 1) / (self.last_s - self.first_s)


class Lost(StrEnum):
    """What a record lost."""

    CUT = "cut"
    DROPOUT = "drop-out"
    DAMAGED = "damaged"
    UNREAD = "unread"


@dataclass(frozen=True)
class Loss:
    """Something that a record lost.

    Attributes:
        kind: cut: nothing is read from then on; drop-out: its writer says that it was too slow; damaged: bytes that are
            no message are skipped; unread: the messages of a topic cannot be read.
        at_s: when [s, time of the record]: of a cut, the last message that is read; null: not known.
        lasts_s: how long [s]; null: to the end, or not known.
        why: how it is known, in words; empty for a drop-out.
    """

    kind: Lost
    at_s: float | None = None
    lasts_s: float | None = None
    why: str = ""


def placed(losses: Iterable[Loss], last_s: float | None) -> tuple[Loss, ...]:
    """The losses; a cut comes after the last message, at `last_s` [s], where there is one."""
    return tuple(replace(one, at_s=last_s) if one.kind is Lost.CUT else one for one in losses)


@dataclass(frozen=True)
class RecordKind:
    """How records of a kind are read.  Their libraries are imported by these functions.

    Attributes:
        read: (path, sources, timing) -> the series of each source, and what the record lost; raises InputError: the
            record cannot be read, is too large, or lacks a source, or a value is no finite number.
        fields: (path) -> what the record has, and what it lost; raises InputError: it cannot be read.
    """

    read: Callable[[Path, Sequence[MappedSignal], Timing], tuple[Mapping[MappedSignal, Series], Sequence[Loss]]]
    fields: Callable[[Path], tuple[Sequence[RecordedField], Sequence[Loss]]]


RECORDS = Registry[RecordKind]("kind of record")
RECORDS.promise(".csv", "scaloft_fi.outside.readers:TABLE")
RECORDS.promise(".mcap", "scaloft_fi.outside.readers:MCAP")
RECORDS.promise(".ulg", "scaloft_fi.outside.readers:ULOG")
for _suffix in (".bin", ".tlog"):
    RECORDS.promise(_suffix, "scaloft_fi.outside.readers:MAVLINK")
for _suffix in (".bag", ".db3", FOLDER):
    RECORDS.promise(_suffix, "scaloft_fi.outside.readers:ROSBAG")


def kind_of(path: Path) -> RecordKind:
    """The kind of the record at `path`.

    Raises:
        InputError: no record ends so.
    """
    ending = FOLDER if is_folder(path) else path.suffix.lower()
    if ending not in RECORDS:
        endings = sorted(name for name in RECORDS if name != FOLDER)
        hint = did_you_mean(ending, endings) if ending else f"; allowed: {', '.join(map(repr, endings))}"
        raise InputError(f"{path}: a record must end in one of the known endings, or be a folder of rosbag2{hint}")
    return RECORDS[ending]


UNITS: Mapping[str, tuple[float, float]] = {
    "mm to m": (1e-3, 0.0),
    "cm to m": (1e-2, 0.0),
    "km to m": (1e3, 0.0),
    "ft to m": (0.3048, 0.0),
    "deg to rad": (math.pi / 180.0, 0.0),
    "deg/s to rad/s": (math.pi / 180.0, 0.0),
    "km/h to m/s": (1.0 / 3.6, 0.0),
    "mm/s to m/s": (1e-3, 0.0),
    "cm/s to m/s": (1e-2, 0.0),
    "ms to s": (1e-3, 0.0),
    "us to s": (1e-6, 0.0),
    "ns to s": (1e-9, 0.0),
    "percent to share": (1e-2, 0.0),
    "degC to K": (1.0, 273.15),
}
"""Factor and offset by name of the conversion."""
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
LONGEST_HELD_S = 86_400.0
Held = Annotated[float, Bounds(least=0.0, most=LONGEST_HELD_S)]
"""How long a value may be held [s]."""
GAP_S = 5.0
"""A value is held for this long where the mapping says nothing [s]: an assumption; position and attitude come at 1 Hz
and more in any record, and after 5 s a drone at 2 m/s is 10 m away."""
LANDED = "landed"
OWN_TOPIC, OWN_TIME = "/signals", "elapsed_s"
"""Topic, and column of the time, in the records that `replay --output` writes."""


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        column: name of the column.
    """

    column: Annotated[str, Examples("east")]


@dataclass(frozen=True)
class Message:
    """A field of messages.

    Attributes:
        topic: the topic.
        field: path of the field.
    """

    topic: Annotated[str, Examples("/odom")]
    field: Annotated[str, Examples("pose.pose.position.x", "q[0]")]


@dataclass(frozen=True, kw_only=True)
class _Converted:
    """How a value becomes that of the signal.

    Attributes:
        unit: conversion to the signal's unit; not beside factor and offset.
        factor: signal = factor x value + offset.
        offset: signal = factor x value + offset.
        unknown: its value before the first message; left out: it must have one by the start.
        keep: which value stands for the messages since the last sample.
        gap_s: longest time for which its value is held [s]; left out: that of the mapping.
    """

    unit: Annotated[str, Choices(UNITS.keys())] = ""
    factor: float = 1.0
    offset: float = 0.0
    unknown: float | bool | None = None
    keep: Keep = Keep.LAST
    gap_s: Held | None = None

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a unit beside a factor or an offset, and a conversion to another unit than the signal's."""
        unit = item.get("unit")
        if unit and (item.get("factor") or item.get("offset")):
            yield InputError(f"{unit.place}: {item.name} must have a unit, or a factor and an offset, not both")
        own = unit_of(item.name)
        if unit and own and not self.unit.endswith(f" to {own}"):
            allowed = ", ".join(repr(one) for one in UNITS if one.endswith(f" to {own}")) or "factor and offset"
            yield unit.error(f"a conversion to {own}, the unit of {item.name}: {allowed}")


@dataclass(frozen=True, kw_only=True)
class SignalInColumn(_Converted, Column):
    """In a table."""


@dataclass(frozen=True, kw_only=True)
class SignalInMessage(_Converted, Message):
    """In messages."""


@dataclass(frozen=True)
class Constant:
    """Nowhere: always the same.

    Attributes:
        constant: the value.
    """

    constant: float | bool


@dataclass(frozen=True, kw_only=True)
class FromColumn(Column):
    """The first row whose value is at least `least`.

    Attributes:
        least: the least value that counts.
    """

    least: float


@dataclass(frozen=True, kw_only=True)
class FromMessage(Message):
    """The first message whose value is at least `least`.

    Attributes:
        least: the least value that counts.
    """

    least: float


@dataclass(frozen=True)
class TimeColumn:
    """A column of a table.

    Attributes:
        column: name of the column.
        unit: its unit.
    """

    column: Annotated[str, Examples("t_s")]
    unit: Annotated[str, Choices(TIME_UNITS.keys())] = "s"


@dataclass(frozen=True)
class TimeOfMessages:
    """Of the messages.

    Attributes:
        message: which time of a message counts.
    """

    message: Annotated[str, Choices({"received": "when it was received", "stamp": "the stamp in the message"})]


@dataclass(frozen=True)
class TimeOfClock:
    """A topic that tells the simulated time.

    Attributes:
        clock: the topic.
    """

    clock: Annotated[str, Examples("/clock")]


_WHERE = "{column: NAME} or {topic: NAME, field: PATH}"
_STANDS = Either("{column: NAME}, {topic: NAME, field: PATH} or {constant: NUMBER}")
_TIMES = Either("one of {column: NAME}, {message: received}, {message: stamp} and {clock: TOPIC}")


def _told(form: Any, made: Callable[[str, Any], Any]) -> Reads:
    """An entry in one of the forms of a mapping; `made` makes what is meant of its name and the form."""
    return Reads(lambda item: made(item.name, value_of(form, item)), lambda _names: schema_of(form))


def _entry(signal: str, stands: Column | Message | Constant) -> MappedSignal:
    told = dict(vars(stands))
    if unit := told.pop("unit", ""):
        told["factor"], told["offset"] = UNITS[unit]
    told |= {name: float(told[name]) for name in ("constant", "unknown") if told.get(name) is not None}
    return MappedSignal(signal, **told)


def _timing(_name: str, told: TimeColumn | TimeOfMessages | TimeOfClock) -> Timing:
    if isinstance(told, TimeColumn):
        return Timing(column=told.column, unit_s=TIME_UNITS[told.unit])
    return Timing(clock=told.clock) if isinstance(told, TimeOfClock) else Timing(stamped=told.message == "stamp")


Entry = Annotated[MappedSignal, _told(Annotated[SignalInColumn | SignalInMessage | Constant, _STANDS], _entry)]
Moment = Annotated[MappedSignal | None, _told(Annotated[FromColumn | FromMessage, Either(_WHERE)], _entry)]
Counted = Annotated[
    MappedSignal | None,
    _told(Annotated[Column | Message, Either(_WHERE)], lambda name, stands: replace(_entry(name, stands), unknown=0.0)),
]


@dataclass(frozen=True)
class RecordMap:
    """Where the signals of the requirements stand in a record of a flight.

    Attributes:
        name: where the mapping stands, for errors.
        loose: whether a record may lack signals of it.
        ours: whether the records are those of our own simulator, whose signals have caps.
        there: what the record has, where that is known already: its columns, or its fields after their topics.
        signals: where the signals stand, by name; `scaloft-fi signals` says which follow from others.
        timing: which time the values have; left out: at which messages were received.
        start: when the flight starts: at the first message of at least `least`; left out: the first of x_m, or of any
            signal where x_m is a constant.
        end: when the flight ends: at the first message of at least `least`; left out: the last of the same.
        altered: how many samples a fault has altered up to then.
        carried: how many samples the fault's seam has carried up to then.
        gap_s: longest time for which a value is held [s]; from then on the signal is unknown, up to its next message.
    """

    name: Annotated[str, Given(lambda item: item.place.rpartition(":")[0])]
    loose: Annotated[bool, Given(lambda _item: False)]
    ours: Annotated[bool, Given(lambda _item: False)]
    there: Annotated[frozenset[str] | None, Given(lambda _item: None)]
    signals: Annotated[Mapping[str, Entry], Size(0, MOST)]
    timing: Annotated[
        Timing, Called("time"), _told(Annotated[TimeColumn | TimeOfMessages | TimeOfClock, _TIMES], _timing)
    ] = Timing()
    start: Moment = None
    end: Moment = None
    altered: Counted = None
    carried: Counted = None
    gap_s: Held = GAP_S

    def within(self, there: Collection[str]) -> RecordMap:
        """The mapping without the signals that are not there, among the columns, or fields after their topics."""
        kept = {
            name: entry
            for name, entry in self.signals.items()
            if entry.constant is not None
            or (entry.column and entry.column in there)
            or f"{entry.topic}: {entry.field}" in there
        }
        return replace(self, signals=kept)


def own_map(signals: Sequence[str]) -> RecordMap:
    """The mapping of the records that `replay --output` writes: every signal by its own name."""
    entries = {name: MappedSignal(name, name, OWN_TOPIC, name) for name in signals}
    return RecordMap("the mapping of our own records", True, True, None, entries, Timing(column=OWN_TIME))


def _ready(name: str, topic: str, north_east_down: str, beside: Sequence[MappedSignal]) -> RecordMap:
    """The mapping of records with a position and a velocity north, east and down: x is east, y north, z up."""
    north, east, down, *speeds = north_east_down.split()
    fields = {"x_m": east, "y_m": north, "z_m": down, "vx_mps": speeds[1], "vy_mps": speeds[0], "vz_mps": speeds[2]}
    entries = [
        MappedSignal(signal, topic=topic, field=field, factor=-1.0 if "z" in signal else 1.0)
        for signal, field in fields.items()
    ]
    signals = {entry.signal: entry for entry in (*entries, *beside)}
    return RecordMap(f"the mapping {name}", True, False, None, signals)


def _turn(signal: str, topic: str, field: str, unit: str = "") -> MappedSignal:
    """An angle; a heading is measured from north, clockwise, and here from east, the other way round."""
    factor, _ = UNITS.get(unit, (1.0, 0.0))
    heading = signal == "yaw_rad"
    return MappedSignal(
        signal, topic=topic, field=field, factor=-factor if heading else factor, offset=math.pi / 2 * heading
    )


# PX4 begins a log on the ground, and tells of land once a second: what is not known yet is no touch-down.
_PX4 = (
    MappedSignal("attitude_x", topic="vehicle_attitude", field="q[1]"),
    MappedSignal("attitude_y", topic="vehicle_attitude", field="q[2]"),
    _turn("yaw_rad", "vehicle_local_position", "heading"),
    MappedSignal(LANDED, topic="vehicle_land_detected", field="landed", unknown=1.0, gap_s=math.inf),
)
_ARDUPILOT = tuple(_turn(f"{name.lower()}_rad", "ATT", name, "deg to rad") for name in ("Roll", "Pitch", "Yaw"))
_MAVLINK = tuple(_turn(f"{name}_rad", "ATTITUDE", name) for name in ("roll", "pitch", "yaw"))


READY: Mapping[str, tuple[RecordMap, ...]] = {
    "px4": (_ready("px4", "vehicle_local_position", "x y z vx vy vz", _PX4),),
    "ardupilot": tuple(_ready("ardupilot", ekf, "PN PE PD VN VE VD", _ARDUPILOT) for ekf in ("XKF1", "NKF1", "EKF1")),
    "mavlink": (_ready("mavlink", "LOCAL_POSITION_NED", "x y z vx vy vz", _MAVLINK),),
}
"""The ready mappings by name, of each the first whose position a record has.

Messages: PX4's `vehicle_local_position` and `vehicle_attitude` (docs.px4.io, uORB messages); ArduPilot's `XKF1` of
EKF3, `NKF1` of EKF2, `EKF1`, `ATT` (ardupilot.org, log messages); MAVLink's LOCAL_POSITION_NED, ATTITUDE (mavlink.io).
"""


def ready_map(name: str, there: Collection[str]) -> RecordMap:
    """The ready mapping `name` for a record that has the fields `there`, each after its topic."""
    fitting = (one for one in READY[name] if "x_m" in one.within(there).signals)
    return replace(next(fitting, READY[name][0]), there=frozenset(there))


def load_record_map(path: Path) -> RecordMap:
    """Read a mapping.

    Raises:
        InputError: it is no such mapping; the message names file and line.
    """
    return read(RecordMap, load(path))


PASS_M = 0.5
"""A waypoint counts as passed within this horizontal distance [m]."""
AIRBORNE_M = 0.3
"""Waypoints count only after the vehicle has been this high above the start [m]."""

Signals = Mapping[str, Array]


@dataclass(frozen=True)
class Known:
    """What is known of a flight beside its record.

    Attributes:
        surfaces: surfaces of the world.
        home: where the flight starts and ends [m, world].
        route: waypoints of the situation, home last; None where the situation is not known.
        limit_s: time limit of the flight [s]; None where it is not known.
    """

    surfaces: tuple[str, ...]
    home: tuple[float, float]
    route: tuple[Point, ...] | None = None
    limit_s: float | None = None


@dataclass(frozen=True)
class Derived:
    """A signal that follows from others.

    Attributes:
        needs: names of the others, by what is known of the flight.
        value: the signal (T,), from these and `elapsed_s`.
        given: what must be known of the situation of the flight for it; None where it is not known.
    """

    needs: Callable[[Known], tuple[str, ...]]
    value: Callable[[Signals, Any], Array]
    given: Callable[[Known], object] = lambda _: ""


def _yaw(signals: Signals, _: Known) -> Array:
    x, y, z, w = (signals[name] for name in ("qx", "qy", "qz", "qw"))
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def _clearances(known: Known) -> tuple[str, ...]:
    return tuple(map(clearance_name, known.surfaces))


def _waypoints_left(signals: Signals, known: Known) -> Array:
    assert known.route is not None
    left, passed, airborne = [], 0, False
    start_m = float(signals["z_m"][0])
    for x_m, y_m, z_m in zip(*(signals[name].tolist() for name in ("x_m", "y_m", "z_m")), strict=True):
        airborne |= z_m - start_m > AIRBORNE_M
        while airborne and passed < len(known.route):
            if math.hypot(x_m - known.route[passed][0], y_m - known.route[passed][1]) > PASS_M:
                break
            passed += 1
        left.append(float(len(known.route) - passed))
    return np.array(left)


def _tilt(x: str, y: str) -> Derived:
    """The angle between body z and the vertical, from the components x and y of the attitude quaternion [rad]."""
    return Derived(
        lambda _: (x, y),
        lambda signals, _: np.arccos(np.clip(1.0 - 2.0 * (signals[x] ** 2 + signals[y] ** 2), -1.0, 1.0)),
    )


DERIVED: Mapping[str, tuple[Derived, ...]] = {
    "remaining_s": (
        Derived(lambda _: (), lambda signals, known: known.limit_s - signals["elapsed_s"], lambda known: known.limit_s),
    ),
    "speed_mps": (
        Derived(
            lambda _: ("vx_mps", "vy_mps", "vz_mps"),
            lambda signals, _: np.sqrt(signals["vx_mps"] ** 2 + signals["vy_mps"] ** 2 + signals["vz_mps"] ** 2),
        ),
    ),
    "home_m": (
        Derived(
            lambda _: ("x_m", "y_m"),
            lambda signals, known: np.hypot(signals["x_m"] - known.home[0], signals["y_m"] - known.home[1]),
        ),
    ),
    "yaw_rad": (Derived(lambda _: ("qx", "qy", "qz", "qw"), _yaw),),
    "tilt_rad": (
        _tilt("qx", "qy"),
        _tilt("attitude_x", "attitude_y"),
        Derived(
            lambda _: ("roll_rad", "pitch_rad"),
            lambda signals, _: np.arccos(np.cos(signals["roll_rad"]) * np.cos(signals["pitch_rad"])),
        ),
    ),
    "clearance_m": (
        Derived(
            _clearances,
            lambda signals, known: np.min(np.array([signals[name] for name in _clearances(known)], np.float64), axis=0),
        ),
    ),
    "waypoints_left": (Derived(lambda _: ("x_m", "y_m", "z_m"), _waypoints_left, lambda known: known.route),),
}
"""The ways to each derived signal by name, the first that the mapping allows is taken.

The quaternion's components x and y give the tilt in any body and level frame that share the direction of z, or of -z.
"""


def derivation(mapping: RecordMap, known: Known, name: str) -> Derived | None:
    """How a signal follows from others that are mapped; None where it does not."""
    ways = (one for one in DERIVED.get(name, ()) if one.given(known) is not None)
    return next((one for one in ways if all(need in mapping.signals for need in one.needs(known))), None)


LONGEST_S = 3 * 3600.0
"""Longest flight of a record [s]."""
NEAR_S = 1e-6
"""Times that differ by less than this are equal [s]: records round them."""


def instants(path: Path, start_s: float, end_s: float) -> Array:
    """The times of the samples since the start, (T,) [s]; the last one is not before the end.

    Raises:
        InputError: the flight has no duration, or is too long.
    """
    duration_s = end_s - start_s
    if not 0.0 < duration_s <= LONGEST_S:
        told = f"the flight from {start_s:.3f} s to {end_s:.3f} s"
        raise InputError(f"{path}: {told} must last more than 0 s and at most {LONGEST_S:,.0f} s")
    count = math.ceil((duration_s - NEAR_S) * SAMPLE_HZ) + 1
    return np.arange(max(count, 2)) / SAMPLE_HZ


def sampled(path: Path, name: str, entry: MappedSignal, series: Series | None, start_s: float, at_s: Array) -> Array:
    """A signal at the times `at_s` (T,) since `start_s` [s].

    Raises:
        InputError: it has no value at the start and no `unknown`.
    """
    if series is None:
        return np.full(len(at_s), entry.constant)
    plain = (entry.factor, entry.offset) == (1.0, 0.0)
    values = series.values if plain else entry.factor * series.values + entry.offset
    until = np.searchsorted(series.times_s, start_s + at_s + NEAR_S, side="right")
    if until[0] == 0 and entry.unknown is None:
        first = f"its first message is at {series.times_s[0]:.3f} s" if len(values) else "it has no message"
        why = f"the flight starts at {start_s:.3f} s and {first}"
        raise InputError(
            f"{path}: signal {name!r} is not known at the start: {why}; give unknown: VALUE, or a later start"
        )
    held = np.concatenate([[entry.unknown or 0.0], values])[until]
    if entry.keep is Keep.LAST or not len(values):
        return held
    worst = np.minimum if entry.keep is Keep.LEAST else np.maximum
    for place in np.flatnonzero(np.diff(until, prepend=until[0])):
        held[place] = worst.reduce(values[until[place - 1] : until[place]])
    return held


def moment_s(path: Path, moment: MappedSignal, series: Series, from_s: float = -math.inf) -> float:
    """When a moment comes, at `from_s` or later [s].

    Raises:
        InputError: it never comes.
    """
    reached = np.flatnonzero((series.values >= moment.least) & (series.times_s >= from_s))
    if not len(reached):
        raise InputError(
            f"{path}: the {moment.signal} of the flight never comes: no message is at least {moment.least:g}"
        )
    return float(series.times_s[reached[0]])


PLACE = ("x_m", "y_m", "z_m")
"""Signals that every record must have: a violation has a place."""
CLEARANCE = "clearance_m"


@dataclass(frozen=True)
class Gap:
    """The longest time without a message of a signal.

    Attributes:
        signal: name of the signal.
        longest_s: how long [s].
        from_s: when it begins [s from the start of the flight].
        limit_s: how long a value is held [s]; null: for good.
    """

    signal: str
    longest_s: float
    from_s: float
    limit_s: float | None


@dataclass(frozen=True, eq=False)
class RecordedFlight:
    """A flight that a record tells of.

    Attributes:
        log: its log.
        begins_s: time of the record at which the flight begins [s].
        waits_for: the signal whose first message begins the flight; "" where x_m does, or the mapping says when.
        gaps: of each signal that was read.
        stale: (T,) by name of the signal, whether its value is older than it may be held.
        between: (T,) by name of the signal, least and greatest value of the messages since the last sample.
        losses: what the record lost.
    """

    log: FlightLog
    begins_s: float
    waits_for: str
    gaps: tuple[Gap, ...]
    stale: Mapping[str, NDArray[np.bool_]]
    between: Mapping[str, tuple[Array, ...]]
    losses: tuple[Loss, ...] = ()


def flight_log(
    path: Path,
    mapping: RecordMap,
    known: Known,
    *,
    needed: Mapping[str, str],
    wanted: Collection[str] = (),
    beliefs: Collection[str] = (),
    limited: bool = False,
) -> RecordedFlight:
    """Read a record.

    A flight begins when each signal is known, where the mapping does not say when.  Its log ends at the first contact
    (`clearance_m` at or below 0), at touch-down (`landed` rises to 1), or with the record, as the logs of our own
    flights do.

    Args:
        path: the record.
        mapping: where the signals stand in it.
        known: what is known of the flight beside it.
        needed: signals that the log must have, each with who needs it, for errors.
        wanted: signals that the log has where the record has them.
        beliefs: which signals are beliefs of the stack.
        limited: whether the log ends at the time limit too.

    Raises:
        InputError: the record cannot be read, or lacks a needed signal.
    """
    kind, whole = kind_of(path), mapping
    if mapping.loose:
        mapping = mapping.within(frozenset(names_of(path)) if mapping.there is None else mapping.there)
    position = dict.fromkeys(PLACE, "the place of a violation")
    names = _direct(path, mapping, whole, known, {**position, **needed}, wanted)
    entries = {name: mapping.signals[name] for name in names}
    beside = filter(None, (mapping.start, mapping.end, mapping.altered, mapping.carried))
    sources = dict.fromkeys(entry for entry in (*entries.values(), *beside) if entry.constant is None)
    series, losses = read_apart(path, lambda: kind.read(path, list(sources), mapping.timing))
    try:
        start_s, end_s, waits_for = _span(path, mapping, entries, series)
        end_s = min(end_s, start_s + known.limit_s) if limited and known.limit_s is not None else end_s
        at_s = instants(path, start_s, end_s)
    except InputError as error:
        cut = next((f"; the record is cut: {one.why}" for one in losses if one.kind is Lost.CUT), "")
        raise InputError(f"{error}{cut}") from error

    def of(name: str, entry: MappedSignal) -> Array:
        return sampled(path, name, entry, series.get(entry), start_s, at_s)

    signals: dict[str, Array] = {"elapsed_s": at_s} | {name: of(name, entry) for name, entry in entries.items()}
    # contacts end the log, so they are asked for always
    for name in sorted({*PLACE, *needed, *wanted, CLEARANCE} - signals.keys()):
        if way := derivation(mapping, known, name):
            signals[name] = way.value(signals, known)
    ending, last = _ending(signals)
    signals = {name: np.ascontiguousarray(values[: last + 1]) for name, values in signals.items()}
    for values in signals.values():
        values.setflags(write=False)
    at_s = at_s[: last + 1]
    told = {name: entry for name, entry in entries.items() if entry.constant is None}
    stale = {name: stale_at(entry, series[entry], mapping.gap_s, start_s + at_s) for name, entry in told.items()}
    for name in signals.keys() - stale.keys():
        way = derivation(mapping, known, name)
        ages = [stale[need] for need in way.needs(known) if need in stale] if way else []
        stale |= {name: np.logical_or.reduce(ages)} if ages else {}
    counts: dict[str, SeamCount] = {}
    if mapping.altered is not None:
        altered = of("altered", mapping.altered)[: last + 1]
        carried = altered if mapping.carried is None else of("carried", mapping.carried)[: last + 1]
        first, count = np.flatnonzero(altered > 0.0), int(altered[-1])
        first_s = float(at_s[first[0]]) if len(first) else None
        counts["record"] = SeamCount(max(int(carried[-1]), count), count, first_s)
    struck = _struck(signals, known) if ending is Ending.STRUCK else ""
    log = FlightLog(
        signals=signals,
        ending=ending,
        struck=struck,
        struck_at_s=float(signals["elapsed_s"][-1]) if ending is Ending.STRUCK else NEVER_S,
        stack_error="",
        counts=counts,
        t_max_s=known.limit_s if known.limit_s is not None else float(signals["elapsed_s"][-1]),
        beliefs=tuple(name for name in signals if name in beliefs),
    )
    gaps = tuple(_gap(name, entry, series[entry], mapping.gap_s, start_s, end_s) for name, entry in told.items())
    between = {
        name: tuple(sampled(path, name, replace(e, keep=k), series[e], start_s, at_s) for k in (Keep.LEAST, Keep.MOST))
        for name, e in told.items()
    }
    last_s = max((float(one.times_s[-1]) for one in series.values() if len(one.times_s)), default=None)
    return RecordedFlight(log, start_s, waits_for, gaps, stale, between, placed(losses, last_s))


def stale_at(entry: MappedSignal, series: Series, gap_s: float, at_s: Array) -> NDArray[np.bool_]:
    """Whether the value at each time of the record, (T,) [s], is older than it may be held."""
    place = np.searchsorted(series.times_s, at_s + NEAR_S, side="right") - 1
    limit_s = gap_s if entry.gap_s is None else entry.gap_s
    return (place >= 0) & (at_s - series.times_s[np.maximum(place, 0)] > limit_s + NEAR_S)


def _gap(name: str, entry: MappedSignal, series: Series, gap_s: float, start_s: float, end_s: float) -> Gap:
    """The longest time without a message from the start of the flight, or the first message after it, to its end."""
    inside = series.times_s[(series.times_s > start_s) & (series.times_s < end_s)]
    first_s = [start_s] if len(series.times_s) and series.times_s[0] <= start_s + NEAR_S else []
    edges = np.array([*first_s, *inside, end_s])
    lengths = np.diff(edges) if len(edges) > 1 else np.zeros(1)
    place, limit_s = int(np.argmax(lengths)), gap_s if entry.gap_s is None else entry.gap_s
    from_s = round(float(edges[place]) - start_s, 3)
    return Gap(name, round(float(lengths[place]), 3), from_s, limit_s if math.isfinite(limit_s) else None)


def lacking(mapping: RecordMap, known: Known, name: str) -> str:
    """What a mapping lacks for a signal, in words; "" when it maps the signal or the signal follows from others."""
    if name in mapping.signals or name == "elapsed_s" or derivation(mapping, known, name):
        return ""
    if name not in DERIVED:
        return f"{mapping.name} maps no signal {name!r}"
    derived = DERIVED[name][0]
    if derived.given(known) is None:
        unknown = "the situation of the flight"
        return f"{mapping.name} maps no signal {name!r}, which follows from {unknown} where that is known"
    lost = next(need for need in derived.needs(known) if need not in mapping.signals)
    return f"{mapping.name} maps neither signal {name!r} nor {lost!r}, from which it follows"


def _direct(
    path: Path,
    mapping: RecordMap,
    whole: RecordMap,
    known: Known,
    needed: Mapping[str, str],
    wanted: Collection[str],
) -> list[str]:
    """The signals to read: those of the mapping that are asked for, and those from which others follow.

    Raises:
        InputError: the mapping has none for a needed signal, or the `whole` mapping has, and the record lacks it.
    """
    for name, by in needed.items():
        if lack := lacking(mapping, known, name):
            way = derivation(whole, known, name)
            for need in (name, *(way.needs(known) if way else ())):
                if need in whole.signals and need not in mapping.signals:
                    place = whole.signals[need].column or f"{whole.signals[need].topic}: {whole.signals[need].field}"
                    told = f"{by} needs the signal {name!r}, for which {whole.name} takes {place}"
                    raise InputError(f"{path}: {told}, which the record does not have")
            near = did_you_mean(name, [one for one in (*mapping.signals, *names_of(path)) if one != name])
            raise InputError(f"{path}: {by} needs the signal {name!r}, and {lack}{near}")
    names = dict.fromkeys(name for name in (*needed, *wanted) if name in mapping.signals)
    for name in (*needed, *wanted, CLEARANCE, LANDED):
        if name in mapping.signals:
            names[name] = None
        elif way := derivation(mapping, known, name):
            names |= dict.fromkeys(way.needs(known))
    names |= dict.fromkeys(name for name in map(clearance_name, known.surfaces) if name in mapping.signals)
    return [name for name in names if name != "elapsed_s"]


def _span(
    path: Path, mapping: RecordMap, entries: Mapping[str, MappedSignal], series: Mapping[MappedSignal, Series]
) -> tuple[float, float, str]:
    """Start and end of the flight [s], and the signal whose first message it waits for.

    They are those of the messages of x_m; where that is a constant, those of all.
    """
    x = mapping.signals["x_m"]
    own = [x] if x.constant is None else [entry for entry in entries.values() if entry.constant is None]
    tracks = [series[entry].times_s for entry in own if len(series[entry].times_s)]
    if not tracks:
        raise InputError(
            f"{path}: signal {own[0].signal if own else 'x_m'!r} has no message, so the flight has no start"
        )
    start_s, end_s, waits_for = float(min(t[0] for t in tracks)), float(max(t[-1] for t in tracks)), ""
    for name, entry in entries.items() if mapping.start is None else ():
        known = entry.constant is not None or entry.unknown is not None or not len(series[entry].times_s)
        if not known and series[entry].times_s[0] > start_s + NEAR_S:
            start_s, waits_for = float(series[entry].times_s[0]), name
    if mapping.start:
        start_s = moment_s(path, mapping.start, series[mapping.start])
    if mapping.end:
        end_s = moment_s(path, mapping.end, series[mapping.end], start_s)
    return start_s, end_s, waits_for


def _ending(signals: Mapping[str, Array]) -> tuple[Ending, int]:
    """How the flight ended, and its last sample."""
    last = len(signals["elapsed_s"]) - 1
    ends = [(last + 1, Ending.TIMED_OUT)]
    if CLEARANCE in signals:
        touched = np.flatnonzero(signals[CLEARANCE] <= 0.0)
        ends += [(int(touched[0]), Ending.STRUCK)] if len(touched) else []
    if LANDED in signals:
        down = signals[LANDED] >= 0.5
        landing = np.flatnonzero(down[1:] & ~down[:-1])
        ends += [(int(landing[0]) + 1, Ending.LANDED)] if len(landing) else []
    place, ending = min(ends, key=lambda end: end[0])
    return ending, min(place, last)


def _struck(signals: Mapping[str, Array], known: Known) -> str:
    """The surface that the vehicle touches in the last sample; "" where the record does not tell."""
    there = [name for name in known.surfaces if clearance_name(name) in signals]
    nearest = min(there, key=lambda name: float(signals[clearance_name(name)][-1]), default="")
    return nearest if nearest and signals[clearance_name(nearest)][-1] <= 0.0 else ""


def fields_of(path: Path) -> tuple[Sequence[RecordedField], tuple[Loss, ...]]:
    """What a record has, and what it lost.

    Raises:
        InputError: it cannot be read.
    """
    kind = kind_of(path)
    fields, losses = read_apart(path, lambda: kind.fields(path))
    return fields, placed(losses, max((one.last_s for one in fields if one.last_s is not None), default=None))


def names_of(path: Path) -> Sequence[str]:
    """The names of what a record has: its columns, or its fields after their topics.

    Raises:
        InputError: it cannot be read.
    """
    return [one.name for one in fields_of(path)[0]]


DRAFTED = (*PLACE, "vx_mps", "vy_mps", "vz_mps", "qx", "qy", "qz", "qw", LANDED, CLEARANCE)
"""The signals of a drafted mapping."""


def draft(fields: Sequence[RecordedField], signals: Iterable[str] = ()) -> str:
    """A mapping to begin with: that of a ready one where it fits, else by names that are alike.

    A signal without such a field is a comment.

    Args:
        fields: what the record has.
        signals: of the study; each is mapped too whose very name a field has.
    """
    there = {one.name: one for one in fields}
    for name in READY:
        mapping = ready_map(name, there.keys()).within(there.keys())
        if "x_m" in mapping.signals:
            lines = [f"# as --record {name}", "signals:"]
            for signal, entry in mapping.signals.items():
                more = f", factor: {entry.factor!r}" if entry.factor != 1.0 else ""
                more += f", offset: {entry.offset!r}" if entry.offset else ""
                more += f", unknown: {entry.unknown!r}" if entry.unknown is not None else ""
                more += f", gap_s: {min(entry.gap_s, LONGEST_HELD_S)!r}" if entry.gap_s is not None else ""
                lines.append(f"  {signal}: {{{_where(entry.topic, entry.field)}{more}}}")
            return "\n".join(lines)
    lines = ["signals:"]
    paths = {one.name: re.sub(r"[/: ]+", ".", one.field.lower()) for one in fields}
    clocks = ((one, found) for one in fields if not one.topic and (found := TIME_COLUMN.fullmatch(one.field)))
    if clock := next(clocks, None):
        unit, guessed = (clock[1][1].lower(), "") if clock[1][1] else (_likely_unit(clock[0]), "  # a guess")
        lines = [f"time: {{{_where('', clock[0].field)}, unit: {unit}}}{guessed}", *lines]
    home: str | None = None
    for signal in DRAFTED:
        stem = signal.removesuffix("_mps").removesuffix("_m")
        alike = re.compile(ALIKE.get(stem[:-1], f"(?:.*\\.)?{stem}(?:_m)?").format(stem[-1]))
        fitting = [there[name] for name, path in paths.items() if alike.fullmatch(path)]
        one = next((one for one in fitting if one.topic == home), fitting[0] if fitting else None)
        if one is None:
            lines.append(f"  # {signal}: {{...}}")
        else:
            home = one.topic if home is None else home
            lines.append(f"  {signal}: {{{_where(one.topic, one.field)}}}")
    named = {one.field: one for one in reversed(fields)}
    exact = [signal for signal in signals if signal in named and signal not in (*DRAFTED, OWN_TIME)]
    lines += [f"  {signal}: {{{_where(named[signal].topic, signal)}}}" for signal in exact]
    return "\n".join(lines)


def _where(topic: str, field: str) -> str:
    """Where a signal stands, in YAML, for which the texts of JSON are texts too."""
    quoted = json.dumps(field, ensure_ascii=False)
    return f"topic: {json.dumps(topic, ensure_ascii=False)}, field: {quoted}" if topic else f"column: {quoted}"


ALIKE = {
    "": r"(?!.*(?:linear|angular|orientation|rotation|velocity|accel)[^.]*\.)(?:.*\.)?(?:p|pos|position)?_?{0}(?:_m)?",
    "v": r"(?:.*\.)?(?:linear|velocity|vel|v)[._]?{0}(?:_mps)?",
    "q": r"(?:.*\.)?(?:orientation|rotation|quaternion|quat|q)[._]?{0}",
}
"""The fields that are taken for a position, a velocity, an attitude, by the signal's name without its axis."""


def _likely_unit(clock: RecordedField) -> str:
    """The unit of a time that does not say it, and was read as seconds: the longest with a row in two seconds."""
    rate_hz = clock.rate_hz or 1.0
    return next((unit for unit, unit_s in TIME_UNITS.items() if rate_hz / unit_s >= 0.5), "s")


TIME_COLUMN = re.compile(r"(?:t|time|timestamp|elapsed)(?:_(s|ms|us|ns))?", re.IGNORECASE)
"""A column that tells the time, with its unit."""
