"""How much is still to be flown, as expected simulated time.  It enters no result."""

from __future__ import annotations

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.mutants.mutant import PLACEBO

SHARE = 0.78
"""What is flown of a mutant's flight when it begins where it leaves its baseline, measured over the reference campaign
as a share of the flight's duration."""
FLIGHT_S = 8.0
"""What a flight costs beside its length: it is begun and judged [s, simulated]."""
WHOLE = frozenset({BASELINE, PLACEBO.id})
"""What is always flown whole."""


class Forecast:
    """Flown and left [s, simulated], from the nominal mission times of situations alone.

    Over the flights of the reference campaign the time left was wrong by 12 % on average.

    Args:
        share: whether mutants are flown only from where they leave their baseline; else they are whole.

    Attributes:
        done_s: expected cost of the flights that were flown.
        left_s: expected cost of those that did not.
    """

    def __init__(self, *, share: bool) -> None:
        self._share = SHARE if share else 1.0
        self._due: set[str] = set()
        self.done_s = self.left_s = 0.0

    def cost_s(self, flight: Flight, nominal_s: float) -> float:
        """What a flight is expected to cost whose nominal mission time is `nominal_s` [s, simulated]."""
        return nominal_s * (1.0 if flight.subject.id in WHOLE else self._share) + FLIGHT_S

    def expect(self, flight: Flight, nominal_s: float) -> bool:
        """A flight is to come; returns whether that is new."""
        if flight.name in self._due:
            return False
        self._due.add(flight.name)
        self.left_s += self.cost_s(flight, nominal_s)
        return True

    def arrived(self, flight: Flight, nominal_s: float) -> bool:
        """A flight was flown; returns whether it was expected."""
        cost_s = self.cost_s(flight, nominal_s)
        self.done_s += cost_s
        if flight.name not in self._due:
            return False
        self._due.remove(flight.name)
        self.left_s = max(0.0, self.left_s - cost_s) if self._due else 0.0
        return True
