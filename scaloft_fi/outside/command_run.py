"""Run the command of a flight: bounded in time and output, and nothing of it is left afterwards."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from typing import IO

from scaloft_fi.errors import ScaloftError
from scaloft_fi.inert import line

TAIL_BYTES = 1 << 16
"""How much of its output is kept, from the end."""
SHOWN_LINES, SHOWN = 5, 400
"""How many of its last lines an error shows, and how many characters of them."""
GRACE_S = 2.0
"""How long it has to end when it is asked to [s, wall]."""
MOST_COUNTED = 10**12


class CommandError(ScaloftError):
    """The command failed: a failure of the harness, not of the drone."""


@dataclass(frozen=True)
class Told:
    """What the last line of the command's output says, a JSON object.

    Attributes:
        altered, carried: how many samples the fault altered, and how many its seam carried; None = not told.
        first_altered_s: time of the first altered sample [s]; None = never, or not told.
        stack_error: exception of the stack under test, after which the flight went on; "" without one.
    """

    altered: int | None = None
    carried: int | None = None
    first_altered_s: float | None = None
    stack_error: str = ""


def run_command(words: Sequence[str], env: Mapping[str, str], cwd: Path, limit_s: float) -> Told:
    """Run a command to its end; returns what its last line of output says.

    Raises:
        CommandError: it cannot be started, takes longer than `limit_s` [s, wall], or fails.
    """
    try:
        process = subprocess.Popen(
            list(words),
            cwd=cwd,
            env={**os.environ, **env},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    except (OSError, ValueError) as error:
        raise CommandError(f"the command {words[0]!r} cannot be started: {error}") from error
    assert process.stdout is not None
    tail = _Tail(process.stdout)
    try:
        code = process.wait(limit_s)
    except subprocess.TimeoutExpired:
        raise CommandError(f"the command ran longer than {limit_s:g} s; it said last: {tail.shown()}") from None
    finally:
        _end(process)
        tail.close()
    if code != 0:
        how = f"ended with exit code {code}" if code > 0 else f"died of signal {-code}"
        raise CommandError(f"the command {how}; it said last: {tail.shown()}")
    return told(tail.lines[-1] if tail.lines else "")


def told(last: str) -> Told:
    """What the last line of output says; nothing where it is no JSON object.

    Raises:
        CommandError: it is one, with a value that is not allowed.
    """
    if not last.lstrip().startswith("{"):
        return Told()
    try:
        said = json.loads(last)
    except (ValueError, RecursionError):
        return Told()
    counts = {name: said.get(name) for name in ("altered", "carried")}
    for name, count in counts.items():
        if count is not None and (
            isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= MOST_COUNTED
        ):
            raise CommandError(f"the last line says {name}={str(count)[:40]}, which must be a whole number >= 0")
    first, error = said.get("first_altered_s"), said.get("stack_error") or ""
    if first is not None and (isinstance(first, bool) or not isinstance(first, int | float) or not 0.0 <= first < 1e9):
        raise CommandError(f"the last line says first_altered_s={str(first)[:40]}, which must be a number >= 0")
    return Told(counts["altered"], counts["carried"], None if first is None else float(first), line(str(error))[:SHOWN])


class _Tail:
    """Reads the output of a process to its end, and keeps the last part."""

    def __init__(self, pipe: IO[bytes]) -> None:
        self._pipe, self._kept = pipe, b""
        self._thread = Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        with suppress(OSError, ValueError):
            while piece := os.read(self._pipe.fileno(), TAIL_BYTES):
                self._kept = (self._kept + piece)[-TAIL_BYTES:]

    def close(self) -> None:
        """Wait for the last output; the process has ended."""
        self._thread.join(GRACE_S)
        if not self._thread.is_alive():
            self._pipe.close()

    @property
    def lines(self) -> list[str]:
        """The last lines."""
        return [text for text in self._kept.decode("utf-8", "replace").splitlines() if text.strip()]

    def shown(self) -> str:
        """The last lines in one, without control characters."""
        return line(" | ".join(self.lines[-SHOWN_LINES:]))[-SHOWN:] or "nothing"


def _end(process: subprocess.Popen[bytes]) -> None:
    """End the process and all that it started in its group; may be called after its end."""
    for stop in (signal.SIGTERM, signal.SIGKILL):
        with suppress(OSError):
            os.killpg(process.pid, stop)
        with suppress(subprocess.TimeoutExpired):
            process.wait(GRACE_S)
