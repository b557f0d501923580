"""The progress of a run: flights done, rate, time left, violations.  Nothing here decides a result."""

from __future__ import annotations

import math
import shutil
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, TextIO

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.judge.outcome import BASELINE, Outcome, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.output import line, marked_sentence, show
from scaloft_fi.study import Study

SHARE = 0.78
"""Flown share of a mutant's flight that begins where it leaves its baseline; measured in the reference campaign."""
FLIGHT_S = 8.0
"""Fixed cost of a flight: start and judgement [s, simulated]."""
WHOLE = frozenset({BASELINE, PLACEBO.id})
"""Subjects that are always flown whole."""


MUTANTS = "mutants"


def violation_line(outcome: Outcome, violation: Violation) -> str:
    """The warning line of a violation."""
    struck = f", struck {violation.struck}" if violation.struck else ""
    place = f"({violation.x:.2f}, {violation.y:.2f}, {violation.z:.2f})"
    return f"{violation.requirement} violated at {violation.t_s:.2f} s at {place} m{struck}: {outcome.name}"


LIVE_EVERY_S = 0.5
LINE_EVERY_S = 10.0
TALLY_EVERY_S = 10.0
TALLY_SHARE = 0.005
"""Largest share of the run's wall time that the tally of detected faults takes."""
BAR_WIDTH = 24


class Progress:
    """Flights done, their rate, the time left, violations, and on a terminal what is detected so far.

    Args:
        stream: output stream; a terminal gets a live screen of some lines, which vanishes at the end; any other stream
            gets one line every ten seconds.
        clock: monotonic wall clock [s].
        tally: makes the lines of what is detected so far from the words of `stored`; None for no such lines.
        counts: what is counted, and the word for what has ended.

    Attributes:
        flights: number of expected flights.
        done: number of flown flights.
        done_s: expected simulated time of the flown flights [s].
        simulated_s: simulated time of the flown flights [s].
        left_s: returns the expected simulated time of the remaining flights [s]; called only for the display.
        most_s: returns the remaining budget of wall time [s]; infinite without a budget.
        stage: stage of the run, such as `look 2 of 3`.
        violations: summary of the violations so far.
        stored: returns the arguments of `tally`: what the campaign holds; None while nothing is scored.
    """

    def __init__(
        self,
        *,
        stream: TextIO | None = None,
        clock: Callable[[], float] = time.monotonic,
        tally: Callable[..., Sequence[str]] | None = None,
        counts: tuple[str, str] = ("flights", "flown"),
    ) -> None:
        self._stream = stream or sys.stderr
        self._live = self._stream.isatty()
        self._clock, self._counts = clock, counts
        self._start_s = self._shown_s = clock()
        self.flights, self.done = 0, 0
        self.done_s = self.simulated_s = 0.0
        self._tally, self._tally_due_s = tally, self._start_s + TALLY_EVERY_S
        self._tallied: Sequence[str] = ()
        self._drawn = 0
        self.stored: Callable[[], tuple[Any, ...]] | None = None
        self.left_s: Callable[[], float] = lambda: 0.0
        self.most_s: Callable[[], float] = lambda: math.inf
        self.stage, self.violations = "", ""

    def start(self) -> None:
        """Start the clock when the first flight is handed out."""
        if not self.done:
            self._start_s = self._shown_s = self._clock()

    def advance(self) -> None:
        """Count one more flight, and update the display when it is due."""
        self.done += 1
        now_s = self._clock()
        if now_s - self._shown_s >= (LIVE_EVERY_S if self._live else LINE_EVERY_S):
            self._shown_s = now_s
            self._show()

    def line(self, text: str) -> None:
        """Print a permanent line above the live screen."""
        told = marked_sentence(line(text), self._stream)
        show(self._stream, f"{self._erased()}{told}\n")
        if self._live and self.done:
            self._show()

    def close(self) -> None:
        """Take the live screen away, and print the last count as a permanent line."""
        show(self._stream, self._erased() + f"{self.summary()}\n" * bool(self.done))

    @property
    def time_left_s(self) -> float | None:
        """Expected wall time of the remaining flights [s]; None before the first flight is done."""
        needed_s = self.wall_s(self.left_s())
        return None if needed_s is None else min(self.most_s(), needed_s)

    def wall_s(self, simulated_s: float) -> float | None:
        """Expected wall time of `simulated_s` at the current rate [s]; None before the first flight is done."""
        return (self._clock() - self._start_s) * simulated_s / self.done_s if self.done_s else None

    def summary(self) -> str:
        """The number of flown flights and the time they took."""
        elapsed_s = self._clock() - self._start_s
        rate = f", {self.done / elapsed_s:.1f} a second" if elapsed_s >= 1.0 else ""
        what, done = self._counts
        return f"{self.done} of {self.flights} {what} {done} in {duration(elapsed_s)}{rate}"

    def _show(self) -> None:
        left_s = self.time_left_s
        left = f"{duration(left_s)} left" if left_s is not None else "time left not known yet"
        elapsed_s = max(self._clock() - self._start_s, 1e-9)
        parts = [f"{self.done}/{self.flights} {self._counts[0]}", f"{self.done / elapsed_s:.1f}/s", left]
        if self.stage:
            parts.append(self.stage)
        violations = f"violations: {self.violations}"
        if self._live:
            rate = f"{self.simulated_s / elapsed_s:.0f} simulated s a second" if self.simulated_s else ""
            self._draw("  ".join(parts), [rate, violations * bool(self.violations), *self._detected()])
        else:
            show(self._stream, "  ".join(parts + [violations] * bool(self.violations)) + "\n")

    def _draw(self, first: str, below: Sequence[str]) -> None:
        """Draw the live screen in place of the last one."""
        size = shutil.get_terminal_size()
        room = size.columns - 1  # a line that wraps cannot be overwritten
        width = max(0, min(BAR_WIDTH, room - len(first) - len("[] ")))
        whole_s = self.done_s + self.left_s()
        full = min(width, round(width * self.done_s / whole_s)) if whole_s else width
        bar = f"[{'#' * full}{'.' * (width - full)}] " if width else ""
        lines = [each[:room] for each in (f"{bar}{first}", *filter(None, below))][: max(1, size.lines - 1)]
        show(self._stream, self._erased() + "\n".join(lines))
        self._drawn = len(lines)

    def _erased(self) -> str:
        """What takes the live screen away."""
        up = f"\x1b[{self._drawn - 1}A" if self._drawn > 1 else ""
        self._drawn = 0
        return f"\r{up}\x1b[J" * self._live

    def _detected(self) -> Sequence[str]:
        """The lines of the tally, made anew where that is due."""
        now_s = self._clock()
        if self._tally is not None and self.stored is not None and now_s >= self._tally_due_s:
            self._tallied = self._tally(*self.stored())
            took_s = self._clock() - now_s
            self._tally_due_s = now_s + max(TALLY_EVERY_S, took_s / TALLY_SHARE)
        return self._tallied


class Silence(Progress):
    """Counts and shows nothing; `--quiet`."""

    def line(self, text: str) -> None:
        """Show nothing."""

    def close(self) -> None:
        """Show nothing."""

    def _show(self) -> None:
        """Show nothing."""


def duration(seconds: float) -> str:
    """Format a duration in words.

    >>> [duration(s) for s in (0.4, 7, 75, 3720)]
    ['0 s', '7 s', '1 min 15 s', '1 h 02 min']
    """
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


class Reporter:
    """Keeps the progress up to date.

    What flights cost is expected from the nominal mission times of their situations.  In a run of the reference
    campaign the remaining time was 20 % too short to 7 % too long from the first tenth of the run on.

    Args:
        study: the study.
        progress: the display.
        log: path of the mission log.
        share: whether mutants share the beginning of their baseline; if not, they are flown whole.
        warnings: whether each violation is shown when its outcome arrives.

    Attributes:
        left_s: expected cost of the announced flights that remain [s, simulated].
        maybe_s: expected cost of flights that may be announced later [s, simulated].
    """

    def __init__(self, study: Study, progress: Progress, log: Path, *, share: bool, warnings: bool) -> None:
        self.progress, self.left_s, self.maybe_s = progress, 0.0, 0.0
        self._study, self._log, self._warnings = study, log, warnings
        self._share = SHARE if share else 1.0
        self._due, self._violations = set[str](), Counter[str]()
        progress.left_s = lambda: self.left_s + self.maybe_s

    def cost_s(self, flight: Flight) -> float:
        """Expected cost of a flight [s, simulated]."""
        share = 1.0 if flight.subject.id in WHOLE else self._share
        return self._study.expected_s(flight.situation) * share + FLIGHT_S

    def expect(self, flights: Iterable[Flight]) -> None:
        """Announce flights; a flight that was announced before is not counted again."""
        for flight in flights:
            if flight.name not in self._due:
                self._due.add(flight.name)
                self.left_s += self.cost_s(flight)
                self.progress.flights += 1

    def arrived(self, flight: Flight, outcome: Outcome, *, news: bool) -> None:
        """Record an outcome.

        Args:
            flight: the flight.
            outcome: its outcome.
            news: whether the store lacked the outcome.
        """
        if news:
            self._show_outcome(outcome)
        cost_s = self.cost_s(flight)
        self.progress.done_s += cost_s
        self.progress.simulated_s += outcome.duration_s
        if flight.name in self._due:
            self._due.remove(flight.name)
            self.left_s = max(0.0, self.left_s - cost_s) if self._due else 0.0
            self.progress.advance()

    def wall_s(self, flights: Iterable[Flight]) -> float:
        """Expected wall time of these flights at the current rate [s, wall]; 0 before the first outcome."""
        return self.progress.wall_s(sum(map(self.cost_s, flights))) or 0.0

    def close(self) -> None:
        """Print the last counts, and the file that lists every violation."""
        if self.progress.violations:
            self.progress.line(f"violations: {self.progress.violations}; all of them are in {self._log}")
        self.progress.close()

    def _show_outcome(self, outcome: Outcome) -> None:
        """Count the violations of safety and operability requirements, by subject, and warn of them."""
        counts, group = self._violations, outcome.mutant if outcome.mutant in WHOLE else MUTANTS
        told = [violation for violation in outcome.violations if violation.kind is not Kind.REPORTED]
        counts[group] += len(told)
        if counts.total():
            by_group = ", ".join(f"{name} {counts[name]}" for name in (BASELINE, MUTANTS, PLACEBO.id) if counts[name])
            self.progress.violations = f"{counts.total()} ({by_group})"
        if outcome.invalid:
            self.progress.line(f"warning: invalid, not counted: {outcome.name}: {outcome.invalid}")
        for violation in told if self._warnings else ():
            self.progress.line(f"warning: {violation_line(outcome, violation)}")
