"""Records of ROS: rosbag2 (a folder, or its one .db3 file) and rosbag (.bag), read by `rosbags`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from scaloft_fi.document import is_folder, opened
from scaloft_fi.errors import InputError
from scaloft_fi.outside.records.kind import RecordKind
from scaloft_fi.outside.records.messages import Message, collect, fields_of, topics_of
from scaloft_fi.outside.records.source import Series, Source, Timing, damaged

MOST_FILES = 1_000
"""Most files of a record that is a folder."""


def read_rosbag(path: Path, sources: Sequence[Source], timing: Timing) -> Mapping[Source, Series]:
    """Read the fields of messages.

    Raises:
        InputError: as `Read`.
    """
    with _reader(path) as reader:
        topics = topics_of(path, sources, timing, reader.topics)
        return collect(path, _messages(path, reader, topics), sources, timing)


def names_in_rosbag(path: Path) -> Sequence[str]:
    """The fields of the first message of each topic.

    Raises:
        InputError: the record cannot be read.
    """
    names: list[str] = []
    with _reader(path) as reader:
        for topic in reader.topics:
            first = next(_messages(path, reader, (topic,)), None)
            names += [f"{topic}: {field}" for field in fields_of(first.content)] if first else [topic]
    return names


def _messages(path: Path, reader: Any, topics: Sequence[str]) -> Iterator[Message]:
    connections = [connection for connection in reader.connections if connection.topic in topics]
    waiting = reader.messages(connections=connections) if connections else iter(())
    while True:
        try:
            connection, received_ns, data = next(waiting)
            content = reader.deserialize(data, connection.msgtype)
        except StopIteration:
            return
        except Exception as error:
            raise damaged(path, error) from error
        yield Message(connection.topic, received_ns, content)


@contextmanager
def _reader(path: Path) -> Iterator[Any]:
    """The open record.

    Raises:
        InputError: it cannot be read, or the library is missing.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise InputError(f"{path}: a bag needs rosbags: pip install 'scaloft-fi[records]'") from error
    _check_files(path)
    with ExitStack() as stack:
        try:
            reader = stack.enter_context(AnyReader([path], default_typestore=get_typestore(Stores.LATEST)))
        except Exception as error:
            raise damaged(path, error) from error
        yield reader


def _check_files(path: Path) -> None:
    """Refuse what is no regular file, or too large, before a library opens it.

    Raises:
        InputError: there is such a file, or none at all.
    """
    if is_folder(path):
        files = sorted(path.iterdir())
        if len(files) > MOST_FILES or path / "metadata.yaml" not in files:
            raise InputError(f"{path}: a folder must be a rosbag2: a metadata.yaml and at most {MOST_FILES} files")
    else:
        files = [path]
    for file in files:
        with opened(file):
            pass


ROSBAG = RecordKind(read_rosbag, names_in_rosbag)
