"""Where the signals of a flight log stand in a record: kinds of records, sources of signals, `sim/record.yaml`."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import Any, Protocol

from scaloft_fi.document import LARGEST, MOST, Item, is_folder, load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.registry import Registry
from scaloft_fi.stack.messages import Array

MOST_MESSAGES = 5_000_000
"""Most messages, or rows, of a record that are read."""


@dataclass(frozen=True)
class Source:
    """Where a signal stands.

    Attributes:
        signal: name of the signal, for errors.
        column: of a table; "" where the signal stands in no table.
        topic, field: of a record with topics; a field may have parts and places, "pose.position.x", "q[0]".
    """

    signal: str
    column: str = ""
    topic: str = ""
    field: str = ""


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


def lacks(path: Path, source: Source, noun: str, name: str, there: Iterable[str]) -> InputError:
    """The error for a record without the `noun` (a column, topic or field) of a signal."""
    hint = did_you_mean(name, there)
    return InputError(
        f"{path}: signal {source.signal!r} needs the {noun} {name!r}, which the record does not have{hint}"
    )


def number(path: Path, source: Source, place: str, value: Any) -> float:
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


class Read(Protocol):
    """Reads a record."""

    def __call__(self, path: Path, sources: Sequence[Source], timing: Timing) -> Mapping[Source, Series]:
        """The series of each source.

        Raises:
            InputError: the record cannot be read, is too large, or lacks a source; or a value is no finite number.
        """
        ...


class Names(Protocol):
    """Lists what a record has."""

    def __call__(self, path: Path) -> Sequence[str]:
        """Its columns, or its fields, each after its topic and a colon.

        Raises:
            InputError: the record cannot be read.
        """
        ...


@dataclass(frozen=True)
class RecordKind:
    """How records of a kind are read.  Their libraries are imported by these functions."""

    read: Read
    names: Names


RECORDS = Registry[RecordKind]("kind of record")
RECORDS.promise(".csv", "scaloft_fi.outside.records.readers:TABLE")
RECORDS.promise(".mcap", "scaloft_fi.outside.records.readers:MCAP")
RECORDS.promise(".ulg", "scaloft_fi.outside.records.readers:ULOG")
RECORDS.promise(".bag", "scaloft_fi.outside.records.readers:ROSBAG")
RECORDS.promise(".db3", "scaloft_fi.outside.records.readers:ROSBAG")
RECORDS.promise(FOLDER, "scaloft_fi.outside.records.readers:ROSBAG")


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


class Keep(StrEnum):
    """Which value stands for the messages since the last sample."""

    LAST = "last"
    LEAST = "least"
    MOST = "most"


@dataclass(frozen=True)
class Entry:
    """Where a signal comes from.

    Attributes:
        source: where it stands; None for a constant.
        factor, offset: signal = factor x value + offset.
        constant: its value, where it stands nowhere.
        unknown: its value before its first message; None = it must have one by the start of the flight.
        keep: which value stands for the messages since the last sample.
    """

    source: Source | None
    factor: float = 1.0
    offset: float = 0.0
    constant: float = 0.0
    unknown: float | None = None
    keep: Keep = Keep.LAST


@dataclass(frozen=True)
class Moment:
    """The first message whose value is at least `least`."""

    entry: Entry
    least: float


@dataclass(frozen=True)
class RecordMap:
    """Where the signals of a flight log stand in a record.

    Attributes:
        name: where the mapping stands, for errors.
        timing: which time the values have.
        signals: entry by name of the signal.
        start, end: when the flight starts and ends; None = at the first and the last message of `x_m`.
        altered, carried: how many samples a fault has altered, and how many its seam has carried, up to then.
        loose: whether a record may lack signals of it.
    """

    name: str
    timing: Timing
    signals: Mapping[str, Entry] = field(default_factory=dict)
    start: Moment | None = None
    end: Moment | None = None
    altered: Entry | None = None
    carried: Entry | None = None
    loose: bool = False

    def within(self, there: Collection[str]) -> RecordMap:
        """The mapping without the signals that are not there, among the columns, or fields after their topics."""

        def stands(source: Source | None) -> bool:
            return source is None or source.column in there or f"{source.topic}: {source.field}" in there

        return replace(self, signals={name: entry for name, entry in self.signals.items() if stands(entry.source)})


def own_map(signals: Sequence[str]) -> RecordMap:
    """The mapping of the records that `replay --output` writes: every signal by its own name."""
    entries = {name: Entry(Source(name, column=name, topic=OWN_TOPIC, field=name)) for name in signals}
    return RecordMap("the mapping of our own records", Timing(column=OWN_TIME), entries, loose=True)


def load_record_map(path: Path, signals: Sequence[str] | None = None) -> RecordMap:
    """Read a mapping.

    Args:
        path: the file.
        signals: names of the signals that it may map; None = any.

    Raises:
        InputError: it is no such mapping; the message names file and line.
    """
    document = load(path)
    entries = document.need("signals").mapping(most=MOST)
    for name, item in entries.items():
        if signals is not None and name not in signals:
            hint = did_you_mean(name, signals)
            raise InputError(f"{item.place}: {name!r} is no signal that this study knows{hint}")
    found = RecordMap(
        name=str(path),
        timing=_timing(document.get("time")),
        signals={name: _entry(name, item) for name, item in entries.items()},
        start=_moment("start", document.get("start")),
        end=_moment("end", document.get("end")),
        altered=_counted("altered", document.get("altered")),
        carried=_counted("carried", document.get("carried")),
    )
    document.close()
    return found


def _timing(item: Item | None) -> Timing:
    """`{column: t_s, unit: ms}`, `{message: received}` (the default), `{message: stamp}` or `{clock: /clock}`."""
    if item is None:
        return Timing()
    ways = [way for way in ("column", "message", "clock") if item.get(way)]
    if len(ways) != 1:
        raise item.error("one of {column: NAME}, {message: received}, {message: stamp} and {clock: TOPIC}")
    column, message, clock = item.get("column"), item.get("message"), item.get("clock")
    unit = item.get("unit") if column else None
    timing = Timing(
        column=column.text() if column else "",
        unit_s=TIME_UNITS[unit.choice(list(TIME_UNITS))] if unit else 1.0,
        stamped=message is not None and message.choice(("received", "stamp")) == "stamp",
        clock=clock.text() if clock else "",
    )
    item.close()
    return timing


def _entry(name: str, item: Item) -> Entry:
    if constant := item.get("constant"):
        entry = Entry(None, constant=_plain(constant))
        item.close()
        return entry
    source = _source(name, item)
    unit, factor, offset = item.get("unit"), item.get("factor"), item.get("offset")
    if unit and (factor or offset):
        raise InputError(f"{unit.place}: {name} must have a unit, or a factor and an offset, not both")
    by, plus = UNITS[unit.choice(list(UNITS))] if unit else (1.0, 0.0)
    unknown, keep = item.get("unknown"), item.get("keep")
    entry = Entry(
        source,
        factor=factor.number() if factor else by,
        offset=offset.number() if offset else plus,
        unknown=_plain(unknown) if unknown else None,
        keep=Keep(keep.choice(list(Keep))) if keep else Keep.LAST,
    )
    item.close()
    return entry


def _source(name: str, item: Item) -> Source:
    column, topic, fields = item.get("column"), item.get("topic"), item.get("field")
    if column and (topic or fields):
        raise InputError(f"{item.place}: {name} must have a column, or a topic and a field, not both")
    if column:
        return Source(name, column=column.text())
    if not topic and not fields:
        raise item.error("{column: NAME}, {topic: NAME, field: PATH} or {constant: NUMBER}")
    return Source(name, topic=item.need("topic").text(), field=item.need("field").text())


def _moment(name: str, item: Item | None) -> Moment | None:
    if item is None:
        return None
    least = item.need("least").number()
    moment = Moment(Entry(_source(name, item)), least)
    item.close()
    return moment


def _counted(name: str, item: Item | None) -> Entry | None:
    if item is None:
        return None
    entry = Entry(_source(name, item), unknown=0.0)
    item.close()
    return entry


def _plain(item: Item) -> float:
    """A number, or a truth value."""
    return float(item.value) if isinstance(item.value, bool) else item.number(least=-LARGEST, most=LARGEST)
