"""Where the signals of a flight log stand in a record: kinds of records, sources of signals, `sim/record.yaml`."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

from scaloft_fi.document import Item, is_folder, load
from scaloft_fi.errors import Faults, InputError, did_you_mean
from scaloft_fi.marks import MOST, Called, Choices, Either, Examples, Given, Reads, Size
from scaloft_fi.model import read, schema_of, value_of
from scaloft_fi.registry import Registry
from scaloft_fi.stack.messages import Array

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


def damaged(path: Path, error: Exception) -> InputError:
    """The error for a record that its library cannot read."""
    said = " ".join(str(error).split()) or type(error).__name__
    return InputError(f"{path}: the record is damaged or incomplete: {said}")


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
class RecordKind:
    """How records of a kind are read.  Their libraries are imported by these functions.

    Attributes:
        read: (path, sources, timing) -> the series of each source; raises InputError: the record cannot be read, is too
            large, or lacks a source, or a value is no finite number.
        names: (path) -> what the record has: its columns, or its fields, each after its topic and a colon; raises
            InputError: it cannot be read.
    """

    read: Callable[[Path, Sequence[MappedSignal], Timing], Mapping[MappedSignal, Series]]
    names: Callable[[Path], Sequence[str]]


RECORDS = Registry[RecordKind]("kind of record")
RECORDS.promise(".csv", "scaloft_fi.outside.records.readers:TABLE")
RECORDS.promise(".mcap", "scaloft_fi.outside.records.readers:MCAP")
RECORDS.promise(".ulg", "scaloft_fi.outside.records.readers:ULOG")
for _ending in (".bag", ".db3", FOLDER):
    RECORDS.promise(_ending, "scaloft_fi.outside.records.readers:ROSBAG")


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
    """

    unit: Annotated[str, Choices(UNITS.keys())] = ""
    factor: float = 1.0
    offset: float = 0.0
    unknown: float | bool | None = None
    keep: Keep = Keep.LAST

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a unit beside a factor or an offset."""
        unit = item.get("unit")
        if unit and (item.get("factor") or item.get("offset")):
            yield InputError(f"{unit.place}: {item.name} must have a unit, or a factor and an offset, not both")


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
        signals: where the signals stand, by name; `scaloft-fi signals` says which follow from others.
        timing: which time the values have; left out: at which messages were received.
        start: when the flight starts: at the first message of at least `least`; left out: the first of x_m.
        end: when the flight ends: at the first message of at least `least`; left out: the last of x_m.
        altered: how many samples a fault has altered up to then.
        carried: how many samples the fault's seam has carried up to then.
    """

    name: Annotated[str, Given(lambda item: item.place.rpartition(":")[0])]
    loose: Annotated[bool, Given(lambda _item: False)]
    signals: Annotated[Mapping[str, Entry], Size(0, MOST)]
    timing: Annotated[
        Timing, Called("time"), _told(Annotated[TimeColumn | TimeOfMessages | TimeOfClock, _TIMES], _timing)
    ] = Timing()
    start: Moment = None
    end: Moment = None
    altered: Counted = None
    carried: Counted = None

    def within(self, there: Collection[str]) -> RecordMap:
        """The mapping without the signals that are not there, among the columns, or fields after their topics."""
        kept = {
            name: entry
            for name, entry in self.signals.items()
            if entry.constant is not None or entry.column in there or f"{entry.topic}: {entry.field}" in there
        }
        return replace(self, signals=kept)


def own_map(signals: Sequence[str]) -> RecordMap:
    """The mapping of the records that `replay --output` writes: every signal by its own name."""
    entries = {name: MappedSignal(name, name, OWN_TOPIC, name) for name in signals}
    return RecordMap("the mapping of our own records", True, entries, Timing(column=OWN_TIME))


def load_record_map(path: Path, signals: Sequence[str] | None = None) -> RecordMap:
    """Read a mapping.

    Args:
        path: the file.
        signals: names of the signals that it may map; None = any.

    Raises:
        InputError: it is no such mapping; the message names file and line.
    """
    document, faults, mapping = load(path), Faults(), None
    with faults.collecting():
        mapping = read(RecordMap, document)
    entries = document.mapping().get("signals")
    for name, item in (entries.mapping() if entries and isinstance(entries.value, dict) else {}).items():
        if signals is not None and name not in signals:
            hint = did_you_mean(name, signals)
            faults.add(InputError(f"{item.place}: {name!r} is no signal that this study knows{hint}"))
    faults.end()
    assert mapping is not None
    return mapping
