"""The border `lines`: JSON lines over a Unix socket in the flight's private folder; it needs no other software.

To every process, one line a message, the clock last in a tick:

    {"topic": "/odom", "t_s": 1.25, "data": {"stamp_s": 1.25, "position": [0.1, 0.2, 1.6], ...}}
    {"clock": 1.25}

From a process, first the topics that it will send, then its messages:

    {"publishes": ["/cmd_vel"]}
    {"topic": "/cmd_vel", "data": {"velocity": [0.5, 0.0, 0.0], "turn_radps": 0.0}}
    {"topic": "/cmd_vel", "stamp_s": 1.25, "data": ...}     a stamp later than the clock is refused

The fields are those of `border.py`, which says how each is written, or those of the topic's own mapping.
"""

from __future__ import annotations

import json
import select
import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from scaloft_fi.output import line as inert
from scaloft_fi.outside.border import (
    Arrival,
    BorderError,
    MisfitError,
    Topic,
    TopicsBorder,
    from_plain,
    given,
    taken,
    to_plain,
)
from scaloft_fi.outside.client import VARIABLE

LONGEST_LINE = 1 << 20
"""Most bytes of a line."""
MOST_READ = 4 << 20
"""Most bytes that are read of one process in a tick."""
MOST_PROCESSES = 16
STALL_S = 10.0
"""How long a process may leave its messages unread before it counts as gone [s, wall]."""


def plain_of(topic: Topic, sample: Any) -> Any:
    """What stands in a line for a sample."""
    return given(to_plain(sample), topic.fields)


def sample_of(topic: Topic, data: Any, _clock_s: float) -> Any:
    """The sample that a line has; raises MisfitError."""
    return from_plain(topic.message, taken(data, topic.fields))


@dataclass(frozen=True)
class Codec:
    """How samples stand in lines.

    Attributes:
        written: (topic, sample) -> what stands in the line.
        read: (topic, what stands in the line, clock [s]) -> sample; raises MisfitError.
    """

    written: Callable[[Topic, Any], Any] = plain_of
    read: Callable[[Topic, Any, float], Any] = sample_of


@dataclass(eq=False)
class _Peer:
    """A process that has connected."""

    socket: socket.socket
    rest: bytes = b""
    publishes: frozenset[str] = frozenset()
    read: int = 0


@dataclass(eq=False)
class LinesBorder(TopicsBorder):
    """A border over a Unix socket."""

    codec: Codec = field(default_factory=Codec)
    _peers: list[_Peer] = field(default_factory=list)
    _listener: socket.socket | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._by_name = {topic.name: self._inbox[topic.seam] for topic in self.topics if not topic.outward}
        self._strange = self._gone = ""

    @staticmethod
    def misfit(topic: Topic) -> str:
        """What of a topic's settings JSON lines cannot carry; "" if all of it."""
        unused = [name for name, value in (("type", topic.type), ("qos", topic.qos)) if value]
        return f"{unused[0]} is nothing that border=lines has" if unused else ""

    @staticmethod
    def need() -> None:
        """It needs no other software."""

    @property
    def _path(self) -> Path:
        return self.folder / "border"

    @property
    def environment(self) -> Mapping[str, str]:
        """The path of the socket."""
        return {VARIABLE: str(self._path)}

    def open(self) -> None:
        """Listen.

        Raises:
            BorderError: the socket cannot be opened.
        """
        listener = socket.socket(socket.AF_UNIX)
        try:
            listener.bind(str(self._path))
            listener.listen(MOST_PROCESSES)
        except OSError as error:
            listener.close()
            raise BorderError(f"{self._path}: the socket cannot be opened: {error.strerror or error}") from error
        listener.setblocking(False)
        self._listener = listener

    def lacking(self) -> str:
        """The inward topics that no connected process has named; with none, whether any process is connected."""
        named = self.named()
        missing = [box.topic.name for box in self._inbox.values() if box.topic.awaited and box.topic.name not in named]
        if missing:
            return f"no process has connected that publishes {', '.join(missing)}{self._gone}"
        return "" if self._peers else "no process has connected"

    def named(self) -> frozenset[str]:
        """The topics that connected processes have named."""
        self._hear(0.0)
        return frozenset(topic for peer in self._peers for topic in peer.publishes)

    @property
    def connected(self) -> bool:
        """Whether a process is connected, as far as was heard."""
        return bool(self._peers)

    def send(self, seam: str, t_s: float, sample: Any) -> None:
        """Send a sample to every process."""
        topic = self._outward[seam]
        self._write({"topic": topic.name, "t_s": t_s, "data": self.codec.written(topic, sample)})

    def clock(self, t_s: float) -> None:
        """Tell the time to every process."""
        self._begin_tick(t_s)
        for peer in self._peers:
            peer.read = 0
        self._write({"clock": t_s})

    def take(self, seam: str) -> Arrival:
        """What came, the newest sample last; where none was refused, a strange line is."""
        arrival, strange, self._strange = super().take(seam), self._strange, ""
        return replace(arrival, refused=arrival.refused or strange)

    def close(self) -> None:
        """Close the socket."""
        for peer in self._peers:
            peer.socket.close()
        self._peers.clear()
        if self._listener is not None:
            self._listener.close()
            self._listener = None

    def _write(self, message: Any) -> None:
        line = json.dumps(message).encode() + b"\n"
        for peer in tuple(self._peers):
            try:
                peer.socket.sendall(line)
            except TimeoutError:
                self._forget(peer, f"left its messages unread for {STALL_S:g} s")
            except OSError:
                self._forget(peer)

    def _forget(self, peer: _Peer, why: str = "closed its end of the socket") -> None:
        self._gone = f"; one that did {why}" if peer.publishes else self._gone
        peer.socket.close()
        self._peers.remove(peer)

    def _hear(self, within_s: float) -> bool:
        """Read what has come; whether a process is connected."""
        if self._listener is None:
            return False
        readable = [peer for peer in self._peers if peer.read < MOST_READ]
        ready = select.select([self._listener, *(peer.socket for peer in readable)], [], [], within_s)[0]
        if self._listener in ready:
            self._accept()
        for peer in readable:
            if peer.socket in ready:
                for line in self._lines(peer):
                    self._deliver(peer, line)
        return bool(self._peers)

    def _accept(self) -> None:
        assert self._listener is not None
        with suppress(OSError):
            connected, _ = self._listener.accept()
            if len(self._peers) >= MOST_PROCESSES:
                connected.close()
                return
            connected.settimeout(STALL_S)
            self._peers.append(_Peer(connected))

    def _lines(self, peer: _Peer) -> Iterator[bytes]:
        try:
            text = peer.socket.recv(1 << 16)
        except OSError:
            text = b""
        if not text:
            self._forget(peer)
            return
        peer.read += len(text)
        *whole, peer.rest = (peer.rest + text).split(b"\n")
        if len(peer.rest) > LONGEST_LINE:
            self._strange = self._strange or f"a line of more than {LONGEST_LINE:,} bytes"
            self._forget(peer, "wrote a line that is too long")
        yield from whole

    def _deliver(self, peer: _Peer, line: bytes) -> None:
        try:
            message = _json(line)
            if "publishes" in message:
                names = message["publishes"]
                peer.publishes = frozenset(map(str, names)) if isinstance(names, list) else frozenset()
                return
            name = message.get("topic")
            if not isinstance(name, str) or name not in self._by_name:
                raise MisfitError(f"topic={inert(repr(name))[:100]} is none of {', '.join(self._by_name)}")
        except MisfitError as error:
            self._strange = self._strange or str(error)
            return
        box = self._by_name[name]
        box.count += 1
        try:
            stamp_s = message.get("stamp_s", 0.0)
            self._check_stamp(f"stamp_s={stamp_s!r}", stamp_s)
            box.sample = self.codec.read(box.topic, message.get("data"), self.clock_s)
        except (MisfitError, TypeError) as error:
            box.refuse(str(error))
            return
        box.fresh = True


def _json(line: bytes) -> dict[str, Any]:
    """A message.

    Raises:
        MisfitError: the line is no JSON mapping.
    """
    try:
        message = json.loads(line, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise MisfitError(f"a line is not JSON: {inert(str(error))[:200]}") from error
    if not isinstance(message, dict):
        raise MisfitError("a line must be a mapping")
    return message


def _refuse(constant: str) -> float:
    raise MisfitError(f"{constant} is no number of JSON")
