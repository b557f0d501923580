"""Report the run to the user: remaining work, violations, failures of the harness."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.progress.forecast import Forecast
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.progress.violations import Violations
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study


class Reporter:
    """Keeps the progress up to date.

    Args:
        study: the study.
        progress: the display.
        log: path of the mission log.
        share: whether mutants share the beginning of their baseline.
        warnings: whether each violation is shown when its outcome arrives.
    """

    def __init__(self, study: Study, progress: Progress, log: Path, *, share: bool, warnings: bool) -> None:
        self.progress = progress
        self._study = study
        self._forecast = Forecast(share=share)
        progress.left_s = lambda: self._forecast.left_s
        self._warnings, self._log = warnings, log
        self._violations = Violations()

    def expect(self, flights: Iterable[Flight]) -> None:
        """Announce flights; a flight that was announced before is not counted again."""
        for flight in flights:
            if self._forecast.expect(flight, self._nominal_s(flight)):
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
        expected = self._forecast.arrived(flight, self._nominal_s(flight))
        self.progress.done_s = self._forecast.done_s
        self.progress.simulated_s += outcome.duration_s
        if expected:
            self.progress.advance()

    def wall_s(self, flights: Iterable[Flight]) -> float:
        """Expected wall time of these flights at the current rate [s, wall]; 0 before the first outcome."""
        expected_s = sum(self._forecast.cost_s(flight, self._nominal_s(flight)) for flight in flights)
        return self.progress.wall_s(expected_s) or 0.0

    def close(self) -> None:
        """Print the last counts, and the file that lists every violation."""
        if self.progress.violations:
            self.progress.line(f"violations: {self.progress.violations}; all of them are in {self._log}")
        self.progress.close()

    def _show_outcome(self, outcome: Outcome) -> None:
        lines = self._violations.add(outcome)
        self.progress.violations = str(self._violations)
        if outcome.invalid:
            self.progress.line(f"warning: invalid, not counted: {outcome.name}: {outcome.invalid}")
        for line in lines if self._warnings else ():
            self.progress.line(f"warning: {line}")

    def _nominal_s(self, flight: Flight) -> float:
        return self._study.expected_s(flight.situation)
