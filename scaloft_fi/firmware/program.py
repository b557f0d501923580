"""A firmware's program: started with `turns.c` in front of its C library, and moved on step by step.

The library makes the program's threads take turns, its clock move by granted steps, and its network a Unix socket in
the flight's private folder: the same datagrams and grants give the same answers, and no port of the machine is used.
"""

from __future__ import annotations

import os
import shutil
import socket
import struct
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from scaloft_fi.document import digest, read_bytes
from scaloft_fi.outside.border import BorderError
from scaloft_fi.outside.exchange import KILLED, Command, FlightFolder, Processes

TURNS = Path(__file__).with_name("turns.c")
"""The source of the library."""
VARIABLE = "SCALOFT_TURNS"
"""The environment variable with the path of the socket."""
ANSWER_S, ENDS_S = 60.0, 1.0
"""How long the program may take for one answer, and to end, before the harness gives up [s, wall]."""
_LARGEST = 1 << 18


class Datagram(NamedTuple):
    """A port of the program's network, and bytes that go there."""

    port: int
    data: bytes


class FirmwareError(RuntimeError):
    """The firmware ended or answers no more: a fault of the drone."""


def kept(place: str, make: Callable[[Path], None]) -> Path:
    """A file in the user's folder of caches that is made once; its place names what it depends on.

    Args:
        place: path below that folder.
        make: writes the file at a path; processes that make it at the same time do not meet.
    """
    path = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser() / "scaloft-fi" / place
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        own = path.with_name(f"{path.name}.{os.getpid()}")
        make(own)
        own.replace(path)
    return path


def library() -> Path:
    """The compiled library, made once a machine with the system's compiler, by content.

    Raises:
        BorderError: there is no compiler, or it refuses the source.
    """
    return kept(f"turns/{digest(TURNS)[:32]}.so", _compile)


def _compile(path: Path) -> None:
    compiler = shutil.which("cc")
    if compiler is None:
        raise BorderError("a firmware needs a C compiler, `cc`, on this machine; install one, such as the package gcc")
    command = [compiler, "-O2", "-shared", "-fPIC", "-o", str(path), str(TURNS), "-ldl", "-lpthread"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise BorderError(f"{compiler} cannot compile {TURNS}: {done.stderr.strip()[:300]}")


@dataclass(eq=False)
class Program:
    """A firmware's program under way.

    Attributes:
        folder: private to the flight; the program runs there.
        now_ns: its time so far [ns].
    """

    folder: Path
    now_ns: int
    _flight: FlightFolder
    _processes: Processes
    _channel: socket.socket
    _listener: socket.socket | None
    _until_ns: int = 0
    _sent: bytes = b""

    @classmethod
    def start(
        cls, run: Sequence[str], files: Mapping[str, bytes], study: Path, elsewhere: Sequence[Path] = ()
    ) -> Program:
        """Start the program in a private folder.

        Until it sends a first datagram it may replace itself, as a script does with `exec`.  Its time begins anew then,
        and what was sent until then is sent again.

        Args:
            run: program and arguments.
            files: content of the files of that folder by name.
            study: folder of the study.
            elsewhere: files that the program makes outside of that folder; none of them is left.

        Raises:
            BorderError: the library or the program cannot be started.
        """
        with ExitStack() as undo:
            flight = undo.enter_context(closing(FlightFolder(elsewhere)))
            home = flight.path / "home"
            home.mkdir()
            for name, content in files.items():
                (home / name).parent.mkdir(parents=True, exist_ok=True)
                (home / name).write_bytes(content)
            listener = undo.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET))
            listener.bind(str(flight.path / "turns"))
            listener.listen(1)
            environment = {"LD_PRELOAD": str(library()), VARIABLE: str(flight.path / "turns")}
            command = Command(tuple(run), environment, str(home))
            processes = Processes([command], study, {}, flight.path, flight.lifeline)
            undo.callback(processes.stop)
            processes.start()
            listener.settimeout(0.05)
            if (channel := _connected(listener, processes)) is None:
                said = processes.last_lines()
                raise BorderError(
                    f"the firmware never came up: {processes.ended() or 'no answer'}; its last lines: {said}"
                )
            undo.pop_all()
        made = cls(home, 0, flight, processes, channel, listener)
        with made.booting("the firmware"):
            made._answer()
        return made

    def step(self, until_ns: int, datagrams: Sequence[Datagram]) -> list[Datagram]:
        """Hand datagrams over and let the program run until a time [ns]; what it sent meanwhile, in order.

        Raises:
            FirmwareError: the program ended: a fault of the drone.
            BorderError: the program hangs, or somebody killed it.
        """
        packed = b"".join(struct.pack("<HH", one.port, len(one.data)) + one.data for one in datagrams)
        self._until_ns, self._sent = until_ns, self._sent + packed if self._listener else b""
        return self._asked(packed)

    def _asked(self, packed: bytes) -> list[Datagram]:
        with suppress(OSError):  # it has ended; `_answer` says how
            self._channel.send(struct.pack("<Q", self._until_ns - self.now_ns) + packed)
        return self._answer()

    def _answer(self) -> list[Datagram]:
        try:
            message = self._channel.recv(_LARGEST)
        except TimeoutError:
            raise BorderError(f"the firmware has not answered for {ANSWER_S:g} s{self.said()}") from None
        except OSError:
            message = b""
        if not message and self._listener and (channel := _connected(self._listener, self._processes)):
            self._channel.close()
            self._channel = channel
            self._answer()
            return self._asked(self._sent)
        if not message:
            ended = self._processes.ended(within_s=ENDS_S) or "it closed its socket"
            raise (BorderError if self._processes.how == KILLED else FirmwareError)(f"{ended}{self.said()}")
        (self.now_ns,) = struct.unpack_from("<Q", message)
        found, at = [], 8
        while at < len(message):
            port, length = struct.unpack_from("<HH", message, at)
            found.append(Datagram(port, message[at + 4 : at + 4 + length]))
            at += 4 + length
        if found:
            self._stop_listening()
        return found

    def _stop_listening(self) -> None:
        if self._listener:
            self._listener.close()
        self._listener = None

    @contextmanager
    def booting(self, name: str) -> Iterator[None]:
        """The time before the flight, in which no fault acts: what goes wrong is the harness's, and the program ends.

        Raises:
            BorderError: the firmware was not ready.
        """
        try:
            yield
        except FirmwareError as error:
            self.close()
            raise BorderError(f"{name} never was ready for the flight: {error}") from error
        except BaseException:
            self.close()
            raise

    def file(self, name: str) -> bytes:
        """Content of a file that the program has written; empty for none."""
        path = self.folder / name
        return read_bytes(path) if path.is_file() else b""

    def said(self) -> str:
        """The last lines of the program, for a sentence."""
        lines = self._processes.last_lines()
        return f"; its last lines: {lines}" if lines else ""

    def close(self) -> None:
        """End the program and remove its folder; may be called twice."""
        self._channel.close()
        self._stop_listening()
        self._processes.stop()
        self._flight.close()


def _connected(listener: socket.socket, processes: Processes) -> socket.socket | None:
    """The connection that the program opens next; None where it ends, or opens none in time."""
    due_s = time.monotonic() + ANSWER_S
    while True:
        with suppress(TimeoutError):
            channel, _ = listener.accept()
            channel.settimeout(ANSWER_S)
            return channel
        if processes.ended() or time.monotonic() > due_s:
            return None
