"""Run the command of a flight: bounded in time and output, and nothing of it is left afterwards."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.console import line
from scaloft_fi.document import is_file, read_bytes
from scaloft_fi.errors import ScaloftError
from scaloft_fi.outside.processes import Command, Processes

MOST_OUTPUT = 1 << 20
"""Largest end of its output that is read."""
LOOK_S = 0.002
"""How often a running command is looked at [s, wall]."""
DONE = "ended with code 0"
_HOW = re.compile(r"(ended with code -?\d+|was ended by \w+|cannot be started: .*)$")
SHOWN_LINES, SHOWN = 5, 400
"""How many of its last lines an error shows, and how many characters of them."""
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


def run_command(
    words: Sequence[str],
    env: Mapping[str, str],
    cwd: Path,
    limit_s: float,
    folder: Path,
    attend: Callable[[], None] | None = None,
) -> Told:
    """Run a command to its end; returns what its last line of output says.

    Args:
        words: program and arguments.
        env: environment variables beside ours.
        cwd: where it runs.
        limit_s: longest time that it may take [s, wall].
        folder: empty folder for the end of its output.
        attend: called again and again while it runs.

    Raises:
        BorderError: it cannot be started, or its guard has died.
        CommandError: it takes longer, or fails.
    """
    processes = Processes([Command(tuple(words), env)], cwd, {}, folder)
    due_s, how = time.monotonic() + limit_s, ""
    try:
        processes.start()
        while not (how := processes.ended()) and time.monotonic() < due_s:
            if attend is not None:
                attend()
            time.sleep(LOOK_S)
    finally:
        processes.stop()
    said = processes.last_lines(SHOWN_LINES)[-SHOWN:] or "nothing"
    if not how:
        raise CommandError(f"the command ran longer than {limit_s:g} s; it said last: {said}")
    if not how.endswith(DONE):
        ended = _HOW.search(how)
        raise CommandError(f"the command {ended[0] if ended else how}; it said last: {said}")
    lines = [text for text in _output(folder).decode("utf-8", "replace").splitlines() if text.strip()]
    return told(lines[-1] if lines else "")


def _output(folder: Path) -> bytes:
    """The end of the command's output, of which the older part may be missing."""
    paths = [path for path in (folder / "output.old", folder / "output") if is_file(path)]
    return b"".join(read_bytes(path, MOST_OUTPUT) for path in paths)


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
