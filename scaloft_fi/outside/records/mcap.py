"""Records in MCAP, with messages of ROS 2 (CDR), of ROS 1, or as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from scaloft_fi.document import opened
from scaloft_fi.errors import InputError
from scaloft_fi.outside.records.kind import RecordKind
from scaloft_fi.outside.records.messages import Message, collect, fields_of, topics_of
from scaloft_fi.outside.records.source import MOST_MESSAGES, Series, Source, Timing, damaged, too_many
from scaloft_fi.registry import in_one_line

CHUNK_BYTES = 256 << 20
"""Largest chunk of a file, when it is unpacked."""
ENCODINGS = ("json", "cdr", "ros1")


def read_mcap(path: Path, sources: Sequence[Source], timing: Timing) -> Mapping[Source, Series]:
    """Read the fields of messages.

    Raises:
        InputError: as `Read`.
    """
    with _reader(path) as (reader, topics):
        asked = topics_of(path, sources, timing, topics)
        return collect(path, _messages(path, reader, asked), sources, timing)


def names_in_mcap(path: Path) -> Sequence[str]:
    """The fields of the first message of each topic.

    Raises:
        InputError: the record cannot be read.
    """
    names: list[str] = []
    with _reader(path) as (reader, topics):
        for topic in topics:
            first = next(_messages(path, reader, (topic,)), None)
            names += [f"{topic}: {field}" for field in fields_of(first.content)] if first else [topic]
    return names


@contextmanager
def _reader(path: Path) -> Iterator[tuple[Any, list[str]]]:
    """The open file and its topics.

    Raises:
        InputError: it cannot be read, or the library is missing.
    """
    try:
        from mcap.reader import make_reader
    except ImportError as error:
        raise InputError(f"{path}: an .mcap file needs mcap: pip install 'scaloft-fi[records]'") from error
    with opened(path) as file:
        try:
            reader = make_reader(file)
            summary = reader.get_summary()
        except Exception as error:
            raise damaged(path, error) from error
        if summary is None or (summary.statistics is None and not summary.channels):
            raise InputError(f"{path}: the record is incomplete: it has no summary, so its writer did not finish it")
        if summary.statistics is not None and summary.statistics.message_count > MOST_MESSAGES:
            raise too_many(path)
        if any(chunk.uncompressed_size > CHUNK_BYTES for chunk in summary.chunk_indexes):
            raise InputError(f"{path}: a chunk of the record must have at most {CHUNK_BYTES:,} bytes")
        yield reader, [channel.topic for channel in summary.channels.values()]


def _messages(path: Path, reader: Any, topics: Sequence[str]) -> Iterator[Message]:
    waiting, decoders = reader.iter_messages(topics=list(topics)), dict[int, Any]()
    while True:
        try:
            schema, channel, message = next(waiting)
            if channel.id not in decoders:
                decoders[channel.id] = _decoder(path, schema, channel)
            content = decoders[channel.id](message.data)
        except StopIteration:
            return
        except InputError:
            raise
        except Exception as error:
            raise damaged(path, error) from error
        yield Message(channel.topic, message.log_time, content)


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
    try:
        from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
    except ImportError as error:
        raise InputError(f"{path}: messages of ROS need rosbags: pip install 'scaloft-fi[records]'") from error
    store, text = get_typestore(Stores.EMPTY), schema.data.decode()
    try:
        store.register(
            get_types_from_idl(text) if schema.encoding == "ros2idl" else get_types_from_msg(text, schema.name)
        )
    except Exception as error:
        raise InputError(
            f"{path}: the schema of topic {channel.topic!r} cannot be read: {in_one_line(error)}"
        ) from error
    if encoding == "cdr":
        return lambda data: store.deserialize_cdr(data, schema.name)
    return lambda data: store.deserialize_ros1(data, schema.name)


MCAP = RecordKind(read_mcap, names_in_mcap)
