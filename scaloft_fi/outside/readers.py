"""Readers of records, one for each kind: CSV, ULog of PX4, MCAP, bags of ROS, logs of ArduPilot and MAVLink."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import os
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager
from dataclasses import dataclass
from functools import partial
from io import BufferedReader
from itertools import chain, islice
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from scaloft_fi.document import is_folder, lacks_room, opened, read_text
from scaloft_fi.errors import InputError, did_you_mean, needed
from scaloft_fi.outside.records import (
    CHECKSUM,
    MOST_MESSAGES,
    TIME_COLUMN,
    TIME_UNITS,
    Loss,
    Lost,
    MappedSignal,
    RecordedField,
    RecordKind,
    Series,
    Timing,
    damaged,
    lacks,
    number,
    said_by,
    steps,
    too_many,
)
from scaloft_fi.registry import in_one_line
from scaloft_fi.stack.messages import Array

DEEPEST = 8
"""Deepest field that is listed."""


@dataclass(frozen=True)
class Message:
    """A message of a record: topic, time at which it was received [ns], and what reads its content.

    The content is a mapping or an object; reading it raises what the library raises, or InputError.
    """

    topic: str
    received_ns: int
    read: Callable[[], Any]


Numbers: TypeAlias = "array[float]"
"""A growing array; a list would take four times the memory."""
Found = tuple[Mapping[MappedSignal, Series], Sequence[Loss]]
"""The series of a record, and what it lost."""
Told = tuple[Sequence[RecordedField], Sequence[Loss]]
"""What a record has, and what it lost."""


@dataclass(frozen=True)
class MessageLog:
    """An open record of messages.

    Attributes:
        topics: names of its topics.
        messages: (topics) -> their messages, as they were received; it raises what the library raises.
    """

    topics: Sequence[str]
    messages: Callable[[Sequence[str]], Iterator[Message]]


def of_messages(open_log: Callable[[Path], AbstractContextManager[MessageLog]]) -> RecordKind:
    """The kind of the records that `open_log` opens; it raises InputError for one that it cannot open."""

    def read_messages(path: Path, sources: Sequence[MappedSignal], timing: Timing) -> Found:
        losses = list[Loss]()
        with open_log(path) as log:
            asked = topics_of(path, sources, timing, log.topics)
            messages = until_cut(path, log.messages(asked), losses)
            return collect(path, messages, sources, timing), losses

    def fields_of_messages(path: Path) -> Told:
        losses = list[Loss]()
        with open_log(path) as log:
            return tallied(until_cut(path, log.messages(log.topics), losses), losses, log.topics), losses

    return RecordKind(read_messages, fields_of_messages)


def until_cut(path: Path, messages: Iterable[Message], losses: list[Loss]) -> Iterator[Message]:
    """The messages that can be read; what ends them before the end of the record is a loss.

    Raises:
        InputError: none can be read, there is no room for what one unpacks to, or a checksum says that bytes changed.
    """
    count = 0
    try:
        for count, message in enumerate(messages, 1):  # noqa: B007 - told after the loop
            yield message
    except (InputError, MemoryError):
        raise
    except Exception as error:
        if not count or lacks_room(error) or type(error).__name__ == CHECKSUM:
            raise damaged(path, error) from error
        losses.append(Loss(Lost.CUT, why=said_by(error)))


def tallied(messages: Iterable[Message], losses: list[Loss], topics: Iterable[str] = ()) -> list[RecordedField]:
    """The fields of the first message of each topic, and how many messages came when; of `topics` without any too."""
    fields = dict[str, Sequence[str]]()
    spans = dict.fromkeys(topics, (0, 0, 0))
    for message in messages:
        at_ns = message.received_ns
        count, first_ns, last_ns = spans.get(message.topic, (0, at_ns, at_ns))
        if not count:
            fields[message.topic], first_ns, last_ns = _fields(message, losses), at_ns, at_ns
        spans[message.topic] = (count + 1, min(first_ns, at_ns), max(last_ns, at_ns))
    return [
        RecordedField(topic, field, count, first_ns * 1e-9, last_ns * 1e-9) if count else RecordedField(topic, "", 0)
        for topic, (count, first_ns, last_ns) in spans.items()
        for field in fields.get(topic, ("",))
    ]


def _fields(message: Message, losses: list[Loss]) -> Sequence[str]:
    """The fields of a message; one that cannot be read is a loss."""
    try:
        return tuple(fields_of(message.read())) or ("",)
    except MemoryError:
        raise
    except Exception as error:  # noqa: BLE001 - what a library says of a message that it cannot read
        said = said_by(error).partition(": ")[2] if isinstance(error, InputError) else said_by(error)  # after the file
        losses.append(Loss(Lost.UNREAD, why=f"{message.topic}: {said}"))
        return ("",)


def topics_of(path: Path, sources: Iterable[MappedSignal], timing: Timing, there: Iterable[str]) -> tuple[str, ...]:
    """The topics that sources and timing need.

    Raises:
        InputError: a source has no topic, or the record lacks it.
    """
    known = list(there)
    for source in sources:
        if not source.topic or not source.field:
            raise InputError(f"{path}: signal {source.signal!r} must have a topic and a field, as the record has them")
        if source.topic not in known:
            raise lacks(path, source, "topic", source.topic, known)
    if timing.clock and timing.clock not in known:
        raise lacks(path, MappedSignal("time"), "topic", timing.clock, known)
    return tuple(dict.fromkeys([*(source.topic for source in sources), *filter(None, [timing.clock])]))


def collect(
    path: Path, messages: Iterable[Message], sources: Sequence[MappedSignal], timing: Timing
) -> Mapping[MappedSignal, Series]:
    """The series of each source.

    Raises:
        InputError: there are too many messages, a message lacks a field, or a value is no finite number.
    """
    found = {source: (array("d"), array("d")) for source in sources}
    by_topic: dict[str, list[tuple[MappedSignal, tuple[str | int, ...], Numbers, Numbers]]] = {}
    for source, (times, values) in found.items():
        way = steps(source.field)
        if way is None:
            raise InputError(
                f"{path}: signal {source.signal!r}: field {source.field!r} must be like pose.position.x or q[0]"
            )
        by_topic.setdefault(source.topic, []).append((source, way, times, values))
    ticks = (array("d"), array("d"))
    for count, message in enumerate(messages):
        if count >= MOST_MESSAGES:
            raise too_many(path)
        place = f"message {count + 1} ({message.topic})"
        t_s = message.received_ns * 1e-9
        asked = by_topic.get(message.topic, ())
        if not asked and message.topic != timing.clock:
            continue
        try:
            content = message.read()
        except (InputError, MemoryError):
            raise
        except Exception as error:
            raise InputError(f"{path}: {place}: the message cannot be read: {said_by(error)}") from error
        if message.topic == timing.clock:
            ticks[0].append(t_s)
            ticks[1].append(_stamp(path, place, content))
        if timing.stamped:
            t_s = _stamp(path, place, _part(content, "header") or content)
        for source, way, times, values in asked:
            times.append(t_s)
            values.append(number(path, source, place, _value(path, source, content, way)))
    return {source: _series(times, values, timing, ticks) for source, (times, values) in found.items()}


def _series(times: Numbers, values: Numbers, timing: Timing, ticks: tuple[Numbers, Numbers]) -> Series:
    """Sorted by time; a message before the first tick of the clock is left out."""
    times_s, numbers = np.array(times), np.array(values)
    if timing.clock and not timing.stamped:
        last = np.searchsorted(np.array(ticks[0]), times_s, side="right") - 1
        times_s, numbers = np.array([0.0, *ticks[1]])[last[last >= 0] + 1], numbers[last >= 0]
    return _sorted(times_s, numbers)


def _sorted(times_s: Array, values: Array) -> Series:
    order = np.argsort(times_s, kind="stable")
    return Series(times_s[order], values[order])


def _value(path: Path, source: MappedSignal, content: Any, way: Sequence[str | int]) -> Any:
    value = content
    for step in way:
        try:
            value = value[step] if isinstance(step, int) or isinstance(value, Mapping) else getattr(value, step)
        except (KeyError, AttributeError, IndexError, TypeError):
            there = fields_of(content)
            raise lacks(path, source, f"field of {source.topic!r}", source.field, there) from None
    return value


def _part(content: Any, *names: str) -> Any:
    """The first of these parts that a message, a mapping or an object, has; None without any."""
    parts = (content.get(name) if isinstance(content, Mapping) else getattr(content, name, None) for name in names)
    return next((part for part in parts if part is not None), None)


def _stamp(path: Path, place: str, content: Any) -> float:
    """The stamp, or the clock, of a message in seconds."""
    stamp = _part(content, "stamp", "timestamp", "clock")
    second, nano = _part(stamp, "sec", "secs"), _part(stamp, "nanosec", "nsec", "nsecs")
    if second is None:
        raise InputError(f"{path}: {place}: the message has no stamp; take the time at which messages were received")
    told = MappedSignal("time")
    return number(path, told, place, second) + number(path, told, place, nano or 0) * 1e-9


def fields_of(content: Any, name: str = "", depth: int = 0) -> Iterator[str]:
    """The fields of a message that are numbers, each with its parts; an array is told by its first place."""
    if depth > DEEPEST:
        return
    if isinstance(content, Mapping):
        for key, value in content.items():
            yield from fields_of(value, f"{name}.{key}" if name else str(key), depth + 1)
    elif isinstance(content, bool | int | float | np.number | np.bool_):
        yield name
    elif isinstance(content, list | tuple | np.ndarray):
        if len(content):
            yield from fields_of(content[0], f"{name}[0]", depth + 1)
    elif hasattr(content, "to_dict"):  # of pymavlink, whose `mavpackettype` is a text
        yield from fields_of(content.to_dict(), name, depth)
    elif hasattr(content, "__dict__"):
        yield from fields_of({key: value for key, value in vars(content).items() if key[:1] != "_"}, name, depth)


def _library(path: Path, name: str, needs: str) -> Any:
    """A module of a library that reads records.

    Raises:
        InputError: it is not installed.
    """
    return needed(name, f"{path}: {needs}", "records")


TABLE_BYTES = 256 << 20
"""Largest table."""
_MEASURED = re.compile(r"[-+]?\d*\.\d+(?:[eE][-+]?\d+)?")
"""A number that is no name of a column."""
SEPARATORS = ",;\t|"
"""What may stand between the cells of a table: the one that its first line has most often."""


def read_table(path: Path, sources: Sequence[MappedSignal], timing: Timing) -> Found:
    """Read the columns of a table; an empty cell says nothing new.

    Raises:
        InputError: as `RecordKind.read`; or the time goes back.
    """
    losses = list[Loss]()
    head, rows = _opened(path, losses)
    if not timing.column:
        raise InputError(
            f"{path}: a table needs the column of its time: time: {{column: NAME}} in the record's mapping"
        )
    if timing.column not in head:
        hint = did_you_mean(timing.column, head)
        raise InputError(f"{path}: the time needs the column {timing.column!r}, which the record does not have{hint}")
    for source in sources:
        if not source.column:
            raise InputError(f"{path}: signal {source.signal!r} must have a column, because the record is a table")
        if source.column not in head:
            raise lacks(path, source, "column", source.column, head)
    found = {source: (array("d"), array("d")) for source in sources}
    clock, places = head.index(timing.column), [(head.index(one.column), one, *both) for one, both in found.items()]
    told, last_s = MappedSignal("time", column=timing.column), -math.inf
    for line, row in rows:
        t_s = _parsed(path, told, line, row[clock]) * timing.unit_s
        if t_s < last_s:
            raise InputError(
                f"{path}:{line}: {timing.column}={row[clock]} must not be before the time of the line above"
            )
        last_s = t_s
        for place, source, times, values in places:
            if cell := row[place]:
                times.append(t_s)
                values.append(_parsed(path, source, line, cell))
    return {source: Series(np.array(times), np.array(values)) for source, (times, values) in found.items()}, losses


def fields_of_table(path: Path) -> Told:
    """The columns of a table; their times are those of the column that is named like one.

    Raises:
        InputError: the table cannot be read.
    """
    losses = list[Loss]()
    head, rows = _opened(path, losses)
    clock = next((place for place, name in enumerate(head) if TIME_COLUMN.fullmatch(name)), None)
    found = TIME_COLUMN.fullmatch(head[clock]) if clock is not None else None
    unit_s = TIME_UNITS[(found[1] or "s").lower()] if found else 1.0
    counts, spans = [0] * len(head), [(math.inf, -math.inf)] * len(head)
    for line, row in rows:
        t_s = _parsed(path, MappedSignal("time"), line, row[clock]) * unit_s if clock is not None else math.nan
        for place, cell in enumerate(row):
            if cell:
                counts[place] += 1
                spans[place] = (min(spans[place][0], t_s), max(spans[place][1], t_s))
    fields = [
        RecordedField("", name, count, *(span if math.isfinite(span[0]) else ()))
        for name, count, span in zip(head, counts, spans, strict=True)
    ]
    return fields, losses


def _opened(path: Path, losses: list[Loss]) -> tuple[list[str], Iterator[tuple[int, list[str]]]]:
    """The names of the columns, and each row with the number of its line.

    A last line that is short, and does not end, is cut: a loss.
    """
    text = read_text(path, TABLE_BYTES, other="latin-1").removeprefix("\ufeff")
    lines = ["\n" if line.startswith("#") else line for line in text.splitlines(keepends=True)]
    first = next((place for place, line in enumerate(lines) if line.strip()), 0)
    separator = max(SEPARATORS, key=lines[first].count) if lines else ","
    reader = csv.reader(lines[first:], delimiter=separator)
    try:
        head = [name.strip() for name in next(reader, [])]
    except csv.Error as error:
        raise InputError(f"{path}:1: not a table: {error}") from error
    if not any(head):
        raise InputError(f"{path}:1: the first line must have the names of the columns")
    seen = set[str]()
    for name in head:
        if name in seen:
            raise InputError(f"{path}:1: column {name!r} occurs twice")
        if _MEASURED.fullmatch(name):
            raise InputError(f"{path}:1: the first line must have the names of the columns, and has the number {name}")
        seen.add(name)

    def rows() -> Iterator[tuple[int, list[str]]]:
        try:
            for row in islice(reader, MOST_MESSAGES):
                if len(row) < len(head) and first + reader.line_num == len(lines) and not lines[-1].endswith("\n"):
                    losses.append(Loss(Lost.CUT, why=f"line {len(lines)} has {len(row)} of {len(head)} cells"))
                elif row:
                    if len(row) != len(head):
                        told = f"{len(row)} cells must be {len(head)}, as in the first line"
                        raise InputError(f"{path}:{first + reader.line_num}: {told}")
                    # a table with semicolons comes from where a comma stands in a number
                    yield first + reader.line_num, [c.replace(",", ".") for c in row] if separator == ";" else row
            if next(reader, None) is not None:
                raise too_many(path)
        except csv.Error as error:
            raise InputError(f"{path}:{first + reader.line_num}: not a table: {error}") from error

    return head, rows()


def _parsed(path: Path, source: MappedSignal, line: int, cell: str) -> float:
    try:
        value = float(cell if cell.isascii() and "_" not in cell else "")  # Python alone reads 1_0
    except ValueError:
        words = {"true": 1.0, "false": 0.0}
        if cell.strip().lower() not in words:
            said = f"{source.column}={cell[:40]!r} must be a number"
            raise InputError(f"{path}:{line}: signal {source.signal!r}: {said}") from None
        value = words[cell.strip().lower()]
    return value if math.isfinite(value) else number(path, source, f"line {line}", value)


TABLE = RecordKind(read_table, fields_of_table)


TIME = "timestamp"
"""Field with the time of a message [us]."""
ULOG_HEAD = 3
"""Length of the head of a message [bytes] (docs.px4.io, ULog File Format)."""


def read_ulog(path: Path, sources: Sequence[MappedSignal], timing: Timing) -> Found:
    """Read the fields of messages; their times are their own, so `timing` has no clock.

    Raises:
        InputError: as `RecordKind.read`.
    """
    sets, losses = _sets(path, list({source.topic.partition("/")[0] for source in sources}))
    topics_of(path, sources, timing, sets)
    if sum(len(one[TIME]) for one in sets.values()) > MOST_MESSAGES:
        raise too_many(path)
    return {source: _series_of_fields(path, source, sets[source.topic]) for source in sources}, losses


def fields_of_ulog(path: Path) -> Told:
    """The fields of each topic.

    Raises:
        InputError: the record cannot be read.
    """
    sets, losses = _sets(path, None)
    fields = [
        RecordedField(topic, field, len(data[TIME]), float(data[TIME].min()) * 1e-6, float(data[TIME].max()) * 1e-6)
        for topic, data in sets.items()
        for field in data
        if field != TIME and len(data[TIME])
    ]
    return fields, losses


def _series_of_fields(path: Path, source: MappedSignal, data: Mapping[str, Any]) -> Series:
    if source.field not in data:
        raise lacks(path, source, f"field of {source.topic!r}", source.field, data)
    times_s, values = np.asarray(data[TIME]) * 1e-6, np.asarray(data[source.field], dtype=np.float64)
    wrong = np.flatnonzero(~np.isfinite(values))
    if len(wrong):
        number(path, source, f"{source.topic} at {times_s[wrong[0]]:.6f} s", values[wrong[0]])
    return _sorted(times_s, values)


class _Watched:
    """An open file that tells whether its reader asks for more than there is, in the middle of a message or beyond."""

    def __init__(self, file: BufferedReader) -> None:
        self.file, self.tell, self.close, self.size = file, file.tell, file.close, os.fstat(file.fileno()).st_size
        self.short = self.beyond = False

    def seek(self, place: int, whence: int = 0) -> int:
        """Go to a place; a log names the places of what was appended to it."""
        at = self.file.seek(place, whence)
        self.beyond |= at > self.size
        return at

    def read(self, size: int) -> bytes:
        """The next bytes; a message has a head of 3 bytes, so none at all there is a regular end."""
        data = self.file.read(size)
        self.short = len(data) < size and (bool(data) or size != ULOG_HEAD)
        return data


def _sets(path: Path, names: list[str] | None) -> tuple[dict[str, Mapping[str, Any]], list[Loss]]:
    """The fields of each topic by name, and what the record lost; `names` = which messages to read, None = all.

    Raises:
        InputError: the record cannot be read, or the library is missing.
    """
    pyulog = _library(path, "pyulog", "an .ulg file needs pyulog")
    with opened(path) as file, contextlib.redirect_stdout(io.StringIO()):  # it prints what it skips
        watched = _Watched(file)
        try:
            log = pyulog.ULog(watched, names)
        except Exception as error:
            raise damaged(path, error) from error
    losses = [Loss(Lost.DROPOUT, one.timestamp * 1e-6, one.duration * 1e-3) for one in log.dropouts]
    if log.file_corruption:
        losses.append(Loss(Lost.DAMAGED, why="some bytes are no message of ULog"))
    if watched.short or watched.beyond:
        losses.append(Loss(Lost.CUT, why="the file ends in the middle of a message"))
    found = {f"{one.name}/{one.multi_id}" if one.multi_id else one.name: one.data for one in log.data_list}
    return {topic: data for topic, data in found.items() if TIME in data}, losses


ULOG = RecordKind(read_ulog, fields_of_ulog)


CHUNK_BYTES = 256 << 20
"""Largest chunk of a file, when it is unpacked."""
ENCODINGS = ("json", "cdr", "ros1")


@contextmanager
def _mcap(path: Path) -> Iterator[MessageLog]:
    """The open file.

    Raises:
        InputError: it cannot be read, or the library is missing.
    """
    mcap = _library(path, "mcap.reader", "an .mcap file needs mcap")
    with opened(path) as file:
        try:
            reader = mcap.make_reader(file, validate_crcs=True)
        except Exception as error:
            raise damaged(path, error) from error
        try:
            summary = reader.get_summary()
        except Exception:  # noqa: BLE001 - a file that its writer did not finish ends in anything
            summary = None
        if summary is None or not summary.channels:
            yield _without_summary(path, file)
            return
        if summary.statistics is not None and summary.statistics.message_count > MOST_MESSAGES:
            raise too_many(path)
        if any(chunk.uncompressed_size > CHUNK_BYTES for chunk in summary.chunk_indexes):
            raise InputError(f"{path}: a chunk of the record must have at most {CHUNK_BYTES:,} bytes")

        def messages(topics: Sequence[str]) -> Iterator[Message]:
            if not summary.chunk_indexes:  # its reader would leave out the checksum
                return _without_summary(path, file).messages(topics)
            return _messages_of_mcap(path, reader.iter_messages(topics=list(topics)))

        yield MessageLog([channel.topic for channel in summary.channels.values()], messages)


def _without_summary(path: Path, file: BufferedReader) -> MessageLog:
    """A file that its writer did not finish, or finished without a summary: it is read from its beginning."""
    stream, made = (_library(path, f"mcap.{name}", "an .mcap file needs mcap") for name in ("stream_reader", "records"))

    def found(topics: Sequence[str] | None) -> Iterator[tuple[Any, Any, Any]]:
        schemas, channels = dict[int, Any](), dict[int, Any]()
        file.seek(0)
        for record in stream.StreamReader(file, validate_crcs=True, record_size_limit=CHUNK_BYTES).records:
            if isinstance(record, made.Schema):
                schemas[record.id] = record
            elif isinstance(record, made.Channel):
                channels[record.id] = record
            elif isinstance(record, made.Message):
                channel = channels[record.channel_id]
                if topics is None or channel.topic in topics:
                    yield schemas.get(channel.schema_id), channel, record

    there = dict[str, None]()
    try:
        for _, channel, _ in found(None):
            there[channel.topic] = None
    except Exception as error:
        if not there:
            raise damaged(path, error) from error
    return MessageLog(list(there), lambda topics: _messages_of_mcap(path, found(topics)))


def _messages_of_mcap(path: Path, found: Iterable[tuple[Any, Any, Any]]) -> Iterator[Message]:
    """The messages, from the schema, channel and message of each."""
    decoders: dict[int, Any] = {}

    def read(schema: Any, channel: Any, data: bytes) -> Any:
        if channel.id not in decoders:
            decoders[channel.id] = _decoder(path, schema, channel)
        return decoders[channel.id](data)

    for schema, channel, message in found:
        yield Message(channel.topic, message.log_time, partial(read, schema, channel, message.data))


def _decoder(path: Path, schema: Any, channel: Any) -> Any:
    """What turns the bytes of a channel's messages into their content."""
    encoding = channel.message_encoding
    if encoding == "json":
        return json.loads
    if encoding not in ENCODINGS or schema is None or schema.encoding not in ("ros2msg", "ros2idl", "ros1msg"):
        raise InputError(
            f"{path}: topic {channel.topic!r} has messages in {encoding!r}, "
            "which must be json, or cdr or ros1 with a schema"
        )
    types = _library(path, "rosbags.typesys", "messages of ROS need rosbags")
    store, text = types.get_typestore(types.Stores.EMPTY), schema.data.decode()
    try:
        idl = schema.encoding == "ros2idl"
        store.register(types.get_types_from_idl(text) if idl else types.get_types_from_msg(text, schema.name))
    except Exception as error:
        raise InputError(
            f"{path}: the schema of topic {channel.topic!r} cannot be read: {in_one_line(error)}"
        ) from error
    read = store.deserialize_cdr if encoding == "cdr" else store.deserialize_ros1
    return lambda data: read(data, schema.name)


MCAP = of_messages(_mcap)


MENDED = {
    ".bag": "; `rosbag reindex` mends a bag that is cut",
    ".db3": "; `.recover` of sqlite3 mends a database that is cut",
}
"""What to do about a record that is cut and cannot be read up to there."""
MOST_FILES = 1_000
"""Most files of a record that is a folder."""


@contextmanager
def _rosbag(path: Path) -> Iterator[MessageLog]:
    """The open record.

    Raises:
        InputError: it cannot be read, or the library is missing.
    """
    bags, types = (_library(path, f"rosbags.{name}", "a bag needs rosbags") for name in ("highlevel", "typesys"))
    files = _files(path)
    with ExitStack() as stack:
        if is_folder(path) and any(file.suffix == ".mcap" for file in files):
            logs = [stack.enter_context(_mcap(file)) for file in files if file.suffix == ".mcap"]
            topics = dict.fromkeys(topic for log in logs for topic in log.topics)
            yield MessageLog(list(topics), lambda asked: chain.from_iterable(log.messages(asked) for log in logs))
            return
        try:
            store = types.get_typestore(types.Stores.LATEST)
            reader = stack.enter_context(bags.AnyReader([path], default_typestore=store))
        except Exception as error:
            remedy = MENDED.get(path.suffix.lower(), "") if path.stat().st_size else ""
            raise damaged(path, error, remedy) from error

        def messages(topics: Sequence[str]) -> Iterator[Message]:
            connections = [connection for connection in reader.connections if connection.topic in topics]
            for connection, received_ns, data in reader.messages(connections=connections) if connections else ():
                yield Message(connection.topic, received_ns, partial(read, data, connection.msgtype))

        def read(data: bytes, kind: str) -> Any:
            try:
                return reader.deserialize(data, kind)
            except KeyError:
                raise InputError(f"{path}: the record does not have the definition of {kind}") from None

        yield MessageLog(list(reader.topics), messages)


def _files(path: Path) -> list[Path]:
    """The files of a record, by length and name; what is no regular file, or too large, no library opens.

    Raises:
        InputError: there is such a file, or none at all.
    """
    files = sorted(path.iterdir(), key=lambda file: (len(file.name), file.name)) if is_folder(path) else [path]
    if is_folder(path) and (len(files) > MOST_FILES or path / "metadata.yaml" not in files):
        raise InputError(
            f"{path}: a folder must be a rosbag2: a metadata.yaml and at most {MOST_FILES} files; where its recorder "
            "did not finish it, `ros2 bag reindex` writes the metadata.yaml, or a file of it is judged by itself"
        )
    for file in files:
        with opened(file):
            pass
    return files


ROSBAG = of_messages(_rosbag)


NEEDS = "a log of ArduPilot or MAVLink needs pymavlink"
GROUND_STATIONS = 250
"""Systems from this number on are ground stations: 255 by the definition of MAVLink, 250 to 254 by custom."""


def _mavlink(path: Path, losses: list[Loss]) -> Iterator[Message]:
    """The messages of a log of ArduPilot or MAVLink.

    A further instance of a message is the topic `NAME/1`; a message of a second vehicle is the topic `NAME@2`, after
    the number of its system.

    Raises:
        InputError: it cannot be read, or the library is missing.
    """
    mavutil, flash = (_library(path, f"pymavlink.{name}", NEEDS) for name in ("mavutil", "DFReader"))
    with opened(path):
        pass
    silent = io.StringIO()  # it prints what it skips
    with contextlib.redirect_stdout(silent), contextlib.redirect_stderr(silent):
        ardupilot = path.suffix.lower() == ".bin"
        try:
            log = flash.DFReader_binary(str(path)) if ardupilot else mavutil.mavlogfile(str(path))
        except Exception as error:
            raise damaged(path, error) from error
        with closing(log):
            messages = _of_ardupilot(log, losses) if ardupilot else _of_mavlink(log, losses)
            yield from until_cut(path, messages, losses)


def _of_ardupilot(log: Any, losses: list[Loss]) -> Iterator[Message]:
    """The messages of an open log; bytes that are none are a loss, and so is a message that the file ends in."""
    end, skipped, first_s = 0, 0, None
    while (one := log.recv_match()) is not None:
        name, instance = one.get_type(), one.fmt.instance_field
        if lost := log.offset - one.fmt.len - end:
            skipped, first_s = skipped + lost, one._timestamp if first_s is None else first_s
        end = log.offset
        which = getattr(one, instance) if instance else 0
        yield Message(f"{name}/{which}" if which else name, round(one._timestamp * 1e9), partial(_same, one))
    cut = bool(log.data_map[end:].strip(b"\x00\xff"))  # whole pages are written, with such bytes at the end
    losses += _lost(skipped, first_s, cut=cut)


def _of_mavlink(log: Any, losses: list[Loss]) -> Iterator[Message]:
    """As `_of_ardupilot`."""
    end, skipped, first_s, vehicle = 0, 0, None, 0
    while (one := log.recv_match()) is not None:
        name, system, end = one.get_type(), one.get_srcSystem(), log.f.tell()
        if name == "BAD_DATA":
            skipped, first_s = skipped + len(one.get_msgbuf()), one._timestamp if first_s is None else first_s
            continue
        vehicle = vehicle or (system if system < GROUND_STATIONS else 0)
        topic = name if system in (vehicle, 0) or system >= GROUND_STATIONS else f"{name}@{system}"
        yield Message(topic, round(one._timestamp * 1e9), partial(_same, one))
    losses += _lost(skipped, first_s, cut=end < log.filesize)


def _lost(skipped: int, first_s: float | None, *, cut: bool) -> Iterator[Loss]:
    """The losses of a log in which this many bytes are no message, the first at `first_s` [s]."""
    if skipped:
        yield Loss(Lost.DAMAGED, first_s, why=f"{skipped:,} bytes are no message")
    if cut:
        yield Loss(Lost.CUT, why="the file ends in the middle of a message")


def _same(one: Any) -> Any:
    return one


def read_mavlink(path: Path, sources: Sequence[MappedSignal], timing: Timing) -> Found:
    """Read the fields of messages; their times are those of the log.

    Raises:
        InputError: as `RecordKind.read`.
    """
    losses = list[Loss]()
    found = collect(path, _mavlink(path, losses), sources, timing)
    if any(not len(series.times_s) for series in found.values()):
        topics_of(path, sources, timing, {message.topic for message in _mavlink(path, [])})
    return found, losses


def fields_of_mavlink(path: Path) -> Told:
    """The fields of each message.

    Raises:
        InputError: the record cannot be read.
    """
    losses = list[Loss]()
    return tallied(_mavlink(path, losses), losses), losses


MAVLINK = RecordKind(read_mavlink, fields_of_mavlink)
