"""The exchange of one flight with its stages outside: processes, border, and one round over the seams at each tick."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from shutil import rmtree
from typing import Any

from scaloft_fi.outside.border import BORDERS, Border, BorderError
from scaloft_fi.outside.ports import PORTS
from scaloft_fi.outside.processes import Processes
from scaloft_fi.outside.settings import OutsideConfig
from scaloft_fi.stack.declaration import Wire

ENDS_S = 0.3
"""How long a process that answers no more may take to end, before it counts as hung [s, wall]."""
CHECK_S = 0.02
"""Time between two looks at whether the processes have come up [s, wall]."""


class OutsideError(RuntimeError):
    """The stages outside ended or answer no more: a fault of the drone."""


@dataclass
class Exchange:
    """Carries samples between a flight and its stages outside.

    A process that ends, or a stack that leaves `silent_ticks` in a row without an answer, raises `OutsideError` at that
    tick.  A message that is refused is dropped, and the first such message is the flight's complaint.

    Attributes:
        config: the settings.
        wire: carries every sample over its seam.
        border, processes: to the other side, and what runs there.
        folder: private to the flight, removed at the end.
        complaint: what was wrong with the first refused message; "" while none was.
    """

    config: OutsideConfig
    wire: Wire
    border: Border
    processes: Processes
    folder: Path
    complaint: str = ""
    _silent: int = 0
    _began_s: float | None = None
    _out: tuple[tuple[str, str], ...] = field(init=False)
    _in: tuple[tuple[str, str], ...] = field(init=False)

    def __post_init__(self) -> None:
        seams = [(name, seam.carries) for name, seam in self.config.seams.items()]
        self._out = tuple((name, port) for name, port in seams if PORTS[port].outward and port != "inertial")
        self._in = tuple((name, port) for name, port in seams if not PORTS[port].outward)

    @classmethod
    def begin(cls, config: OutsideConfig, wire: Wire, study: Path, words: Mapping[str, str]) -> Exchange:
        """Open the border, start the processes and wait until they have come up.

        Args:
            config: the settings.
            wire: carries the samples.
            study: folder of the study.
            words: what the words in braces in `run` and `env` stand for.

        Raises:
            BorderError: they did not come up.
        """
        topics = [seam.as_topic(name) for name, seam in config.seams.items()]
        commands = [process.command(words) for process in config.processes]
        with ExitStack() as undo:
            folder = Path(tempfile.mkdtemp(prefix="scaloft-"))
            undo.callback(rmtree, folder, ignore_errors=True)
            border = BORDERS[config.border](topics, folder)
            undo.callback(border.close)
            border.open()
            processes = Processes(commands, study, border.environment, folder)
            undo.callback(processes.stop)
            processes.start()
            exchange = cls(config, wire, border, processes, folder)
            exchange._await_others()
            undo.pop_all()
        return exchange

    def _await_others(self) -> None:
        due_s = time.monotonic() + self.config.ready_s
        while lacking := self.border.lacking():
            ended = self.processes.ended()
            if ended or time.monotonic() > due_s:
                reason = ended or f"not within {self.config.ready_s:g} s: {lacking}"
                raise BorderError(f"the stages outside never came up: {reason}{self._said()}")
            time.sleep(CHECK_S)

    def tick(self, now_s: float, offered: Mapping[str, Any]) -> Mapping[str, Any]:
        """One round: send what is offered, tell the time, wait for the answer, take what came.

        Args:
            now_s: time since the start [s].
            offered: sample by outward port; a port without a sample sends nothing.

        Returns:
            Sample by inward port; None where nothing came.

        Raises:
            OutsideError: the stages outside ended or hang.
            BorderError: the border, or the guard of the processes, has died, or a process was killed with SIGKILL,
                which comes from the machine or a person, never from the drone.
        """
        for name, port in self._out:
            self.send(name, now_s, offered.get(port))
        self.border.clock(now_s)
        self._keep_pace(now_s)
        self._await_answer(now_s)
        taken = {}
        for name, port in self._in:
            arrival = self.border.take(name)
            if arrival.refused:
                self._complain(f"{now_s:.3f} s: {arrival.refused}")
            taken[port] = self.wire.cross(name, now_s, arrival.sample)
        if ended := self.processes.ended():
            raise (BorderError if self.processes.killed else OutsideError)(f"{ended}{self._said()}")
        return taken

    def send(self, seam: str, now_s: float, sample: Any) -> None:
        """Carry a sample over an outward seam and send what arrives."""
        delivered = self.wire.cross(seam, now_s, sample)
        if delivered is not None:
            self.border.send(seam, now_s, delivered)

    def _keep_pace(self, now_s: float) -> None:
        """Let simulated time run no faster than the pace; the first tick sets the beginning."""
        if not self.config.pace:
            return
        if self._began_s is None:
            self._began_s = time.monotonic() - now_s / self.config.pace
        left_s = self._began_s + now_s / self.config.pace - time.monotonic()
        if left_s > 0.0:
            time.sleep(left_s)

    def _await_answer(self, now_s: float) -> None:
        if not self.config.answer:
            return
        if self.border.wait(self.config.answer, self.config.answer_s):
            self._silent = 0
            return
        self._silent += 1
        if self._silent >= self.config.silent_ticks and not self.processes.ended(within_s=ENDS_S):
            topic = self.config.seams[self.config.answer].topic
            waited = f"{self._silent} ticks in a row, for {self.config.answer_s:g} s each"
            before = f"; before that, {self.complaint}" if self.complaint else self._said()
            raise OutsideError(f"no answer on {topic} for {waited}{before}")

    def _complain(self, sentence: str) -> None:
        self.complaint = self.complaint or f"outside at {sentence}{self._said()}"

    def _said(self) -> str:
        lines = self.processes.last_lines()
        return f"; its last lines: {lines}" if lines else ""

    def close(self) -> None:
        """End the processes and close the border; may be called twice."""
        self.processes.stop()
        self.border.close()
        rmtree(self.folder, ignore_errors=True)
