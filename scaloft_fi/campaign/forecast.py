"""How much is still to be flown, in simulated seconds, learnt from what came home.  It enters no result."""

from __future__ import annotations

from collections import defaultdict

from scaloft_fi.campaign.plan import Flight
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.results.outcome import Outcome

Draw = tuple[str, int]

PRIOR_SHARE = 0.8
"""What is flown of a mutant's flight when it begins where it leaves its baseline, measured over the reference campaign
as a share of the baseline's duration; it weighs as much as one flight of the mutant."""


class Forecast:
    """Flown and left [s, simulated].

    A flight is expected to cost its mutant's usual share of its draw's length.  The length is the baseline's duration
    once that is home, until then the nominal mission time times what baselines have taken of theirs.  The share is
    learnt draw by draw: within a draw those come home first that leave the baseline early, and those that never do come
    last and cost nothing, so that half a draw would mislead.

    Args:
        share: whether flights begin where they leave their baseline; else they are whole.
    """

    def __init__(self, *, share: bool) -> None:
        self._sharing = share
        self._due: dict[Draw, dict[str, float]] = defaultdict(dict)
        self._known_s: dict[Draw, float] = {}
        self._left_nominal_s: dict[str, float] = defaultdict(float)
        self._left_known_s: dict[str, float] = defaultdict(float)
        self._held: dict[Draw, list[tuple[str, float]]] = defaultdict(list)
        self._cost_s: dict[str, float] = defaultdict(float)
        self._length_s: dict[str, float] = defaultdict(float)
        self._baselines_s = self._nominal_s = 0.0
        self.done_s = 0.0

    def expect(self, flight: Flight, nominal_s: float) -> bool:
        """A flight is to come, whose mission takes nominally so long [s]; returns whether that is new."""
        draw, subject = _draw(flight), flight.subject.id
        if subject in self._due[draw]:
            return False
        self._due[draw][subject] = nominal_s
        if draw in self._known_s:
            self._left_known_s[subject] += self._known_s[draw]
        else:
            self._left_nominal_s[subject] += nominal_s
        return True

    def drop(self, flight: Flight) -> bool:
        """A flight is not to come any more; returns whether it was."""
        draw, subject = _draw(flight), flight.subject.id
        nominal_s = self._due[draw].pop(subject, None)
        if nominal_s is None:
            return False
        if draw in self._known_s:
            self._left_known_s[subject] -= self._known_s[draw]
        else:
            self._left_nominal_s[subject] -= nominal_s
        return True

    def home(self, flight: Flight, outcome: Outcome, nominal_s: float) -> bool:
        """A flight came home; returns whether it was expected."""
        expected = self.drop(flight)
        cost_s = self._flown_s(flight, outcome)
        self.done_s += cost_s
        draw = _draw(flight)
        if flight.mutant is None:
            self._baseline(draw, outcome, nominal_s)
        elif flight.mutant != PLACEBO and not outcome.invalid:
            self._held[draw].append((flight.subject.id, cost_s))
            self._learn(draw)
        return expected

    @property
    def left_s(self) -> float:
        """What is still to be flown [s]."""
        stretch = (self._baselines_s + 1.0) / (self._nominal_s + 1.0)
        return sum(
            max(0.0, self._left_known_s[subject] + stretch * self._left_nominal_s[subject]) * self._share(subject)
            for subject in self._left_known_s.keys() | self._left_nominal_s.keys()
        )

    def _baseline(self, draw: Draw, outcome: Outcome, nominal_s: float) -> None:
        if outcome.invalid or draw in self._known_s:
            return
        self._known_s[draw] = outcome.duration_s
        self._baselines_s += outcome.duration_s
        self._nominal_s += nominal_s
        for subject, due_s in self._due[draw].items():
            self._left_nominal_s[subject] -= due_s
            self._left_known_s[subject] += outcome.duration_s
        self._learn(draw)

    def _learn(self, draw: Draw) -> None:
        if draw in self._known_s:
            for subject, cost_s in self._held.pop(draw, []):
                self._cost_s[subject] += cost_s
                self._length_s[subject] += self._known_s[draw]

    def _share(self, subject: str) -> float:
        if subject in ("baseline", PLACEBO.id):
            return 1.0
        prior = PRIOR_SHARE if self._sharing else 1.0
        one_s = self._baselines_s / max(1, len(self._known_s)) or 1.0
        return (self._cost_s[subject] + prior * one_s) / (self._length_s[subject] + one_s)

    def _flown_s(self, flight: Flight, outcome: Outcome) -> float:
        if not self._sharing or flight.mutant is None or flight.mutant == PLACEBO:
            return outcome.duration_s
        return 0.0 if outcome.infected_at_s is None else outcome.duration_s - outcome.infected_at_s


def _draw(flight: Flight) -> Draw:
    return flight.situation.key, flight.seed
