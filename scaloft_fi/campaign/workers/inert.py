"""A connection to a Dask scheduler through which no bytes pass, so that Dask's client unpickles nothing.

A scheduler passes on what any client and any worker sends, and Dask's client unpickles results, exceptions and
warnings.  Every pickle travels as bytes, or in a frame of its own beside the plain part of a message.  This connection
skips these frames, and reads None in place of bytes and of what is in the frames.  It also skips a message whose plain
part is too large, without holding it in memory.
"""

from __future__ import annotations

import struct
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import msgpack  # type: ignore[import-untyped]
from distributed.comm.core import CommClosedError
from distributed.comm.registry import backends
from distributed.comm.tcp import (
    TCP,
    TLS,
    TCPBackend,
    TCPConnector,
    TLSBackend,
    TLSConnector,
    convert_stream_closed_error,
)
from tornado.iostream import IOStream, StreamClosedError

if TYPE_CHECKING:
    pass


MOST_FRAME: Final = 1 << 24
"""Greatest size of the plain part of a message; the scheduler packs the events of 10 ms into one message [bytes]."""


MOST_FRAMES: Final = 1 << 16
"""Greatest number of frames of a message."""


MOST_PARTS: Final = 1 << 19
"""Greatest number of bytes above 127 in a message: every part but a small number begins with one, and takes memory."""


_HIGH = bytes(range(128, 256))


_CHUNK = 1 << 20


_OWN_TOPICS = "scaloft-fi-"


@contextmanager
def inert_scheme(*, tls: bool, skipped: Callable[[], None]) -> Iterator[str]:
    """The scheme of addresses whose connections are inert; it is valid inside the context.

    Args:
        tls: whether the connections are encrypted.
        skipped: called for each message that is too large or no message; in a thread of the client.
    """
    scheme = f"scaloft-{uuid.uuid4().hex}"
    backends[scheme] = _InertTLSBackend(skipped) if tls else _InertTCPBackend(skipped)
    try:
        yield scheme
    finally:
        del backends[scheme]


class _Inert(TCP):
    """A connection that reads plain values."""

    def __init__(self, *args: Any, skipped: Callable[[], None], **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._skipped = skipped
        self.deserialize = False  # an error in an answer is raised as its text

    async def read(self, deserializers: object = None) -> Any:
        """The next message; an empty one for a message that was skipped.

        The bytes of a message: size of what follows, number of frames, their sizes, the frames.  The first frame is
        the message; the others are for objects that are named in it.
        """
        stream = self.stream
        if stream is None:
            raise CommClosedError
        try:
            _, count = struct.unpack("=QQ", await stream.read_bytes(16))
            if not 0 < count <= MOST_FRAMES:
                raise StreamClosedError
            first, *others = struct.unpack(f"={count}Q", await stream.read_bytes(8 * count))
            fits = first <= MOST_FRAME
            frame = await stream.read_bytes(first) if fits else b""
            await _skip(stream, sum(others) + (0 if fits else first))
        except (StreamClosedError, OSError) as error:
            self.abort()
            if isinstance(error, StreamClosedError):
                convert_stream_closed_error(self, error)
            raise CommClosedError(str(error)) from error
        except BaseException:
            self.abort()
            raise
        message = plain(frame)
        if message is None:
            self._skipped()
            return ()
        return message


class _InertTLS(_Inert, TLS):
    """The same, encrypted."""


class _InertTCPBackend(TCPBackend):
    def __init__(self, skipped: Callable[[], None]) -> None:
        self._skipped = skipped

    def get_connector(self) -> Any:
        connector = TCPConnector()
        connector.comm_class = partial(_Inert, skipped=self._skipped)  # type: ignore[assignment]
        return connector


class _InertTLSBackend(TLSBackend):
    def __init__(self, skipped: Callable[[], None]) -> None:
        self._skipped = skipped

    def get_connector(self) -> Any:
        connector = TLSConnector()
        connector.comm_class = partial(_InertTLS, skipped=self._skipped)  # type: ignore[assignment]
        return connector


async def _skip(stream: IOStream, size: int) -> None:
    while size > 0:
        size -= len(await stream.read_bytes(min(size, _CHUNK)))


def plain(frame: bytes) -> Any:
    """A message without bytes, objects of other frames and events of other topics; None for what is no message.

    >>> plain(msgpack.packb([{"op": "task-erred", "key": "k", "exception": b"a pickle"}]))
    ({'op': 'task-erred', 'key': 'k', 'exception': None},)
    """
    if len(frame) - len(frame.translate(None, _HIGH)) > MOST_PARTS:
        return None
    try:
        message = _without_bytes(msgpack.unpackb(frame, use_list=False, strict_map_key=False))
    except (ValueError, TypeError, RecursionError, msgpack.UnpackException):
        return None
    return tuple(filter(_is_ours, message)) if isinstance(message, tuple) else message


def _is_ours(message: Any) -> bool:
    """Whether it is no event that Dask's client would print or warn of."""
    if not isinstance(message, dict) or message.get("op") != "event":
        return True
    return str(message.get("topic")).startswith(_OWN_TOPICS)


def _without_bytes(value: Any) -> Any:
    if isinstance(value, dict):
        if "__Serialized__" in value or "__Pickled__" in value:  # stands for an object in another frame
            return None
        return {_without_bytes(key): _without_bytes(entry) for key, entry in value.items()}
    if isinstance(value, tuple):
        return tuple(map(_without_bytes, value))
    return value if value is None or isinstance(value, str | int | float) else None
