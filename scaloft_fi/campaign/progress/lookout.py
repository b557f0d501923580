"""Tells a person what a crew does: how much is left, what was violated, what was killed."""

from __future__ import annotations

from collections.abc import Iterable

from scaloft_fi.campaign.plan.plan import Flight
from scaloft_fi.campaign.progress.alarm import Alarm
from scaloft_fi.campaign.progress.forecast import Forecast
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.progress.tally import Tally
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.study import Study


class Lookout:
    """Keeps the progress up to date.

    Args:
        study: what is flown.
        progress: what a person sees.
        options: how it is flown.
    """

    def __init__(self, study: Study, progress: Progress, options: RunOptions) -> None:
        self.progress = progress
        self._study = study
        self._forecast = Forecast(share=options.share)
        progress.left_s = lambda: self._forecast.left_s
        self._tally = Tally(study.roster)
        self._alarm = Alarm(every=options.every_violation)

    def expect(self, flights: Iterable[Flight]) -> None:
        """Flights are to come; what was announced before is not counted twice."""
        for flight in flights:
            if self._forecast.expect(flight, self._nominal_s(flight)):
                self.progress.flights += 1

    def known(self, baselines: Iterable[tuple[Flight, Outcome]]) -> None:
        """Baselines that the store has: what is flown is seen beside them."""
        for flight, outcome in baselines:
            self._tally.add(outcome)
            self._forecast.known(flight, outcome, self._nominal_s(flight))

    def home(self, flight: Flight, outcome: Outcome, *, news: bool) -> None:
        """An outcome came home; `news` when the store lacked it."""
        if news:
            for line in self._alarm.lines(outcome):
                self.progress.line(line)
        self._tally.add(outcome)
        expected = self._forecast.home(flight, outcome, self._nominal_s(flight))
        self.progress.done_s = self._forecast.done_s
        self.progress.kills = str(self._tally)
        if expected:
            self.progress.advance()

    def wall_s(self, flights: Iterable[Flight]) -> float:
        """How long all processes together would fly these at the pace so far [s, wall]; 0 before anything is home."""
        expected_s = sum(self._forecast.cost_s(flight, self._nominal_s(flight)) for flight in flights)
        return self.progress.wall_s(expected_s) or 0.0

    def close(self) -> None:
        """Leave the last count, and say what was not told."""
        for line in self._alarm.last():
            self.progress.line(line)
        self.progress.close()

    def _nominal_s(self, flight: Flight) -> float:
        return self._study.expected_s(flight.situation)
