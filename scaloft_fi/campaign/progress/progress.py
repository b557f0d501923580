"""What a person sees while flights are flown: how many, how fast, how much longer.  Nothing here enters a result."""

from __future__ import annotations

import math
import shutil
import sys
import time
from collections.abc import Callable
from typing import TextIO

LIVE_EVERY_S = 0.5
LINE_EVERY_S = 10.0
BAR_WIDTH = 24


class Progress:
    """Flights done, their rate, the time left, violations.

    Args:
        stream: where to write; a live line when it is a terminal, else one line every ten seconds.
        clock: monotonic wall clock [s].

    Attributes:
        flights: how many are to be flown.
        done: how many are.
        done_s: what that was expected to take, as simulated time [s].
        left_s: what the rest is expected to take [s]; only asked when it is shown.
        most_s: wall time after which no more is begun [s], seen from now; infinite without a budget.
        stage: what the flights are part of, such as `look 2 of 3`.
        violations: violations so far, in words.
    """

    def __init__(self, *, stream: TextIO | None = None, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream = stream or sys.stderr
        self._live = self._stream.isatty()
        self._clock = clock
        self._start_s = self._shown_s = clock()
        self.flights, self.done = 0, 0
        self.done_s = 0.0
        self.left_s: Callable[[], float] = lambda: 0.0
        self.most_s: Callable[[], float] = lambda: math.inf
        self.stage, self.violations = "", ""

    def start(self) -> None:
        """The first flight is handed out: the clock starts, once."""
        if not self.done:
            self._start_s = self._shown_s = self._clock()

    def advance(self) -> None:
        """One more flight is done; show it when it is time to."""
        self.done += 1
        now_s = self._clock()
        if now_s - self._shown_s >= (LIVE_EVERY_S if self._live else LINE_EVERY_S):
            self._shown_s = now_s
            self._show()

    def line(self, text: str) -> None:
        """A lasting line, above the live one."""
        self._stream.write(f"\r\x1b[K{text}\n" if self._live else f"{text}\n")
        if self._live and self.done:
            self._show()
        self._stream.flush()

    def close(self) -> None:
        """Leave the last count as a lasting line."""
        if self._live:
            self._stream.write("\r\x1b[K")
        if self.done:
            self._stream.write(f"{self.summary()}\n")
        self._stream.flush()

    @property
    def time_left_s(self) -> float | None:
        """Wall time that the remaining flights will take [s]; None before the first is done."""
        needed_s = self.wall_s(self.left_s())
        return None if needed_s is None else min(self.most_s(), needed_s)

    def wall_s(self, simulated_s: float) -> float | None:
        """Wall time that so much simulated time takes at the pace so far [s]; None before the first flight is done."""
        return (self._clock() - self._start_s) * simulated_s / self.done_s if self.done_s else None

    def summary(self) -> str:
        """How many flights were flown in how long."""
        elapsed_s = self._clock() - self._start_s
        rate = f", {self.done / elapsed_s:.1f} a second" if elapsed_s >= 1.0 else ""
        return f"{self.done} of {self.flights} flights flown in {duration(elapsed_s)}{rate}"

    def _show(self) -> None:
        left_s = self.time_left_s
        left = f"{duration(left_s)} left" if left_s is not None else "time left not known yet"
        elapsed_s = max(self._clock() - self._start_s, 1e-9)
        parts = [f"{self.done}/{self.flights} flights", f"{self.done / elapsed_s:.1f}/s", left]
        if self.stage:
            parts.append(self.stage)
        if self.violations:
            parts.append(f"violations: {self.violations}")
        text = "  ".join(parts)
        if self._live:
            room = shutil.get_terminal_size().columns - 1  # a line that wraps could not be written over
            width = max(0, min(BAR_WIDTH, room - len(text) - len("[] ")))
            whole_s = self.done_s + self.left_s()
            full = min(width, round(width * self.done_s / whole_s)) if whole_s else width
            bar = f"[{'#' * full}{'.' * (width - full)}] " if width else ""
            self._stream.write(f"\r\x1b[K{f'{bar}{text}'[:room]}")
        else:
            self._stream.write(f"{text}\n")
        self._stream.flush()


class Silence(Progress):
    """Counts without showing anything; `--quiet`."""

    def line(self, text: str) -> None:
        """Show nothing."""

    def close(self) -> None:
        """Show nothing."""

    def _show(self) -> None:
        """Show nothing."""


def duration(seconds: float) -> str:
    """A span of time as a person says it.

    >>> [duration(s) for s in (0.4, 7, 75, 3720)]
    ['0 s', '7 s', '1 min 15 s', '1 h 02 min']
    """
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
