"""The processes of one flight, below a guard that ends them with the flight."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from scaloft_fi.console import line as inert
from scaloft_fi.outside import guard
from scaloft_fi.outside.border import BorderError

START_S, STOP_S = 10.0, 5.0
"""Greatest time in which the guard starts, and in which it ends everything [s, wall]."""
LINE = 300
"""Most characters of a line of output in a sentence."""


@dataclass(frozen=True)
class Command:
    """A program that runs during a flight.

    Attributes:
        run: program and arguments; `{python}` is this interpreter, `{study}` the folder of the study.
        env: environment variables beside those of this process and of the border.
        folder: where it runs, in the folder of the study.
    """

    run: tuple[str, ...]
    env: Mapping[str, str] = field(default_factory=dict)
    folder: str = "."


class Processes:
    """The processes of one flight.

    The process that uses them flies this flight only: orphans that a killed guard leaves are adopted by it, and `stop`
    ends whatever it has below it.

    Args:
        commands: what to start, in order, without a shell.
        study: folder of the study.
        environment: what the border adds to their environment.
        folder: private to the flight; the end of their output is kept there.

    Attributes:
        killed: whether the first of them that has ended was ended by SIGKILL.
    """

    def __init__(self, commands: Sequence[Command], study: Path, environment: Mapping[str, str], folder: Path) -> None:
        self._commands, self._study, self._output = commands, study.absolute(), folder / "output"
        self._environment = environment
        self._guard: subprocess.Popen[bytes] | None = None
        self._news = b""
        self._ended = ""
        self.killed = False
        self._spared: frozenset[int] = frozenset()

    def start(self) -> None:
        """Start all of them.

        Raises:
            BorderError: one cannot be started; the sentence names it.  Or their guard has died.
        """
        guard.prctl(guard.PR_SET_CHILD_SUBREAPER, 1)
        self._spared = frozenset(guard.descendants(os.getpid()))
        order = {"commands": [self._order(command) for command in self._commands], "output": str(self._output)}
        self._guard = subprocess.Popen(
            [sys.executable, "-I", "-S", guard.__file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        assert self._guard.stdin is not None
        with suppress(OSError):  # the guard has just died; the next lines say so
            self._guard.stdin.write(json.dumps(order).encode() + b"\n")
            self._guard.stdin.flush()
        due_s = time.monotonic() + START_S
        while not self._ended and b"started" not in self._news and time.monotonic() < due_s:
            self._listen(0.05)
        if self._ended or b"started" not in self._news:
            raise BorderError(self._ended or f"the guard of the processes did not start within {START_S:g} s")

    def _order(self, command: Command) -> Mapping[str, object]:
        def replaced(text: str) -> str:
            return text.replace("{python}", sys.executable).replace("{study}", str(self._study))

        env = {name: replaced(text) for name, text in command.env.items()}
        return {
            "run": [replaced(text) for text in command.run],
            "env": {**os.environ, **self._environment, **env},
            "folder": str(self._study / command.folder),
        }

    def ended(self, within_s: float = 0.0) -> str:
        """A sentence on the first of them that has ended; "" while all run.

        Args:
            within_s: how long to wait for an end [s, wall].

        Raises:
            BorderError: their guard has died, which is no fault of theirs.
        """
        if not self._ended and self._guard is not None:
            self._listen(within_s)
        return self._ended

    def _listen(self, wait_s: float) -> None:
        """Read what the guard tells."""
        assert self._guard is not None
        assert self._guard.stdout is not None
        while select.select([self._guard.stdout], [], [], wait_s)[0]:
            text = os.read(self._guard.stdout.fileno(), guard.CHUNK)
            if not text and not self._ended:
                raise BorderError(f"the guard of the processes ended; their last lines: {self.last_lines() or 'none'}")
            if not text:
                return
            self._news += text
            wait_s = 0.0
        *whole, rest = self._news.split(b"\n")
        for line in whole:
            what, number, detail = line.decode(errors="replace").split(" ", 2)
            if what in ("failed", "ended") and not self._ended:
                self._ended = f"{self._name(int(number))} {_how(what, detail)}"
                self.killed = what == "ended" and int(detail) == -signal.SIGKILL
        self._news = b"\n".join([line for line in whole if line.startswith(b"started")] + [rest])

    def _name(self, number: int) -> str:
        """The program: that of an interpreter is its first argument."""
        program, *arguments = self._commands[number].run
        if program == "{python}" or Path(program).name.startswith("python"):
            program = next((one for one in arguments if not one.startswith("-")), program)
        return inert(Path(program).name)[:LINE]

    def last_lines(self, count: int = 5) -> str:
        """The last lines that they wrote, made inert and joined by " / "; "" for none."""
        text = b""
        for path in (self._output.with_name(f"{self._output.name}.old"), self._output):
            with suppress(OSError):
                text += path.read_bytes()
        lines = [line.strip() for line in text.decode(errors="replace").splitlines() if line.strip()]
        return " / ".join(inert(line)[:LINE] for line in lines[-count:])

    def stop(self) -> None:
        """End them: SIGINT, SIGTERM, SIGKILL in turn, half a second apart; nothing is left.  May be called twice."""
        if self._guard is None:
            return
        ending, self._guard = self._guard, None
        for pipe in (ending.stdin, ending.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        try:
            ending.wait(STOP_S)
        except subprocess.TimeoutExpired:
            ending.kill()
            ending.wait()
        guard.kill_below(os.getpid(), self._spared)


def _how(what: str, detail: str) -> str:
    """How a process ended.

    >>> _how("ended", "-9"), _how("ended", "3"), _how("failed", "No such file or directory")
    ('was ended by SIGKILL', 'ended with code 3', 'cannot be started: No such file or directory')
    """
    if what == "failed":
        return f"cannot be started: {detail}"
    code = int(detail)
    return f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"
