"""What can be killed: the processes that bear a mark in their environment, whatever session they are in."""

from __future__ import annotations

import os
import random
import secrets
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

MARK = "SCALOFT_BENCHMARK_KILL"
GRACE_S = 5.0
"""Greatest time from the end of a run to the end of its processes [s, wall]."""


class Marked:
    """A program and every process that it starts.

    Args:
        words: the program and its arguments.
        folder: where it runs.
        environment: beside that of this process.
        output: where it writes; None for nowhere.
    """

    def __init__(
        self,
        words: Sequence[str],
        folder: Path,
        environment: Mapping[str, str] | None = None,
        output: IO[bytes] | None = None,
    ) -> None:
        self._mark = secrets.token_hex(8)
        self.process = subprocess.Popen(
            words,
            cwd=folder,
            env={**os.environ, **(environment or {}), MARK: self._mark},
            stdout=output or subprocess.DEVNULL,
            stderr=output,
            start_new_session=True,
        )

    def alive(self) -> set[int]:
        """The processes that have not ended (proc(5): the state follows the name in brackets)."""
        found, mark = set(), f"{MARK}={self._mark}".encode()
        for path in Path("/proc").glob("[0-9]*"):
            try:
                if mark in (path / "environ").read_bytes().split(b"\0"):
                    state, *_ = (path / "stat").read_text().rpartition(")")[2].split()
                    found |= {int(path.name)} if state not in "ZX" else set()
            except OSError:  # it has just ended
                continue
        return found

    def kill(self, draw: random.Random) -> str:
        """Kill the session of the program, or one of all processes; returns which."""
        if draw.random() < 0.5:
            os.killpg(self.process.pid, signal.SIGKILL)
            return "all"
        victim = draw.choice(sorted(self.alive()) or [self.process.pid])
        name = self._name(victim)
        try:
            os.kill(victim, signal.SIGKILL)
        except ProcessLookupError:  # it has just ended by itself
            return ""
        return name

    def outlived(self) -> int:
        """End the processes that still run after `GRACE_S`; returns their number."""
        until_s = time.monotonic() + GRACE_S
        while (left := self.alive()) and time.monotonic() < until_s:
            time.sleep(0.05)
        for process in left:
            os.kill(process, signal.SIGKILL)
        return len(left)

    def _name(self, process: int) -> str:
        if process == self.process.pid:
            return "first"
        try:
            words = Path(f"/proc/{process}/cmdline").read_text().split("\0")
        except OSError:
            return "other"
        programs = {"guard.py": "guard", STAGE: Path(STAGE).stem}
        return next((programs[Path(word).name] for word in words if Path(word).name in programs), "other")


STAGE = "over_lines.py"
"""The program of the stage outside, in the study of `--outside`."""
