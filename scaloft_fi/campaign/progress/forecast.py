"""How much is still to be flown, as so many simulated seconds, learnt from what came home.  It enters no result."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, field

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.mutants.mutant import PLACEBO

PRIOR_SHARE = 0.78
"""What is flown of a mutant's flight when it begins where it leaves its baseline, measured over the reference campaign
as a share of the flight's duration."""
PRIOR_FLOWN = 0.86
"""The part of mutants' flights that leave their baseline, and so are flown, of the same campaign."""
PRIOR_S = 60.0
"""What the prior weighs: about one flight of the mutant [s]."""
FLIGHT_S = 8.0
"""What a flight costs beside its length, told as so much more of it [s].

It is begun and judged, and the short ones are often those that strike something, which near things fly slower (7.7 ms
a simulated second where others take 6.1).  Of what was left of three full campaigns the time was told wrong by 7 % on
average with it, by 11 % without.
"""
WHOLE = frozenset({BASELINE, PLACEBO.id})
"""What is always flown whole."""


@dataclass
class _Draw:
    """A situation and seed.

    Attributes:
        nominal_s: nominal mission time [s].
        due: subjects that are expected.
        home: outcomes that came home whole, and how long they are together [s].
        reached_s: the latest time at which a mutant left the baseline [s from take-off].
        costs: what mutants cost that are not yet learnt from, by subject [s].
    """

    nominal_s: float
    due: set[str] = field(default_factory=set)
    home: int = 0
    home_s: float = 0.0
    reached_s: float = 0.0
    costs: list[tuple[str, float]] = field(default_factory=list)

    @property
    def length_s(self) -> float:
        """How long a whole flight lasts here [s]."""
        return self.home_s / self.home


class Forecast:
    """Flown and left [s, simulated], `FLIGHT_S` for each flight included.

    A flight is expected to cost its mutant's usual share of what whole flights of its draw last.  That is the mean of
    those that are home; where none is, the nominal mission time times what begun draws have taken of theirs.  Within a
    draw those come home first that leave the baseline early, and those that never do come last and cost nothing.  So
    shares are learnt when a draw's baseline is home, and of a draw under way only what comes after the latest leaving
    is still expected of each.

    Args:
        share: whether flights begin where they leave their baseline; else they are whole.
    """

    def __init__(self, *, share: bool) -> None:
        self._sharing = share
        self._draws: dict[tuple[str, int], _Draw] = {}
        self._begun: dict[tuple[str, int], _Draw] = {}
        self._fresh, self._fresh_s = Counter[str](), defaultdict[str, float](float)
        self._learnt, self._flown = Counter[str](), Counter[str]()
        self._costs_s, self._lengths_s = defaultdict[str, float](float), defaultdict[str, float](float)
        self.done_s = 0.0

    def expect(self, flight: Flight, nominal_s: float) -> bool:
        """A flight is to come, whose mission takes nominally so long [s]; returns whether that is new."""
        draw, subject = self._draw(flight, nominal_s), flight.subject.id
        if subject in draw.due:
            return False
        draw.due.add(subject)
        if not draw.home:
            self._refresh(subject, nominal_s, 1)
        return True

    def known(self, flight: Flight, outcome: Outcome, nominal_s: float) -> None:
        """A whole flight was home before: it tells how long flights last there."""
        self._measure(flight, self._draw(flight, nominal_s), outcome)

    def home(self, flight: Flight, outcome: Outcome, nominal_s: float) -> bool:
        """A flight came home; returns whether it was expected."""
        draw, cost_s = self._draw(flight, nominal_s), self._cost_s(flight, outcome)
        expected = self._arrive(draw, flight.subject.id)
        self.done_s += cost_s + FLIGHT_S * (cost_s > 0.0)
        if not outcome.invalid:
            self._measure(flight, draw, outcome)
            if _whole(flight):
                if flight.mutant is None:
                    self._learn(draw)
            else:
                draw.costs.append((flight.subject.id, cost_s))
                draw.reached_s = max(draw.reached_s, outcome.infected_at_s or 0.0)
        return expected

    @property
    def left_s(self) -> float:
        """What is still to be flown [s]."""
        begun_s = sum(draw.length_s for draw in self._begun.values())
        stretch = begun_s / sum(draw.nominal_s for draw in self._begun.values()) if self._begun else 1.0
        fresh_s = sum(self._costs(name, stretch * self._fresh_s[name], due) for name, due in self._fresh.items())
        return max(0.0, fresh_s) + sum(self._left_s(draw) for draw in self._begun.values() if draw.due)

    def cost_s(self, flight: Flight, length_s: float) -> float:
        """What a flight is expected to cost whose whole length is so much [s]."""
        return self._costs(flight.subject.id, length_s, 1)

    def _left_s(self, draw: _Draw) -> float:
        """Of a draw under way."""
        length_s = draw.length_s
        ahead = max(0.0, 1.0 - draw.reached_s / length_s) if self._sharing and length_s else 1.0
        whole = draw.due & WHOLE
        return sum(self._costs(subject, length_s, 1) for subject in whole) + ahead * sum(
            self._costs(subject, length_s, 1) for subject in draw.due - whole
        )

    def _arrive(self, draw: _Draw, subject: str) -> bool:
        """A flight is not due any more; returns whether it was."""
        if subject not in draw.due:
            return False
        draw.due.remove(subject)
        if not draw.home:
            self._refresh(subject, draw.nominal_s, -1)
        return True

    def _refresh(self, subject: str, nominal_s: float, by: int) -> None:
        """A flight more, or one less, is due of a draw of which nothing is home."""
        self._fresh[subject] += by
        self._fresh_s[subject] += by * nominal_s

    def _costs(self, subject: str, length_s: float, flights: int) -> float:
        """What so many flights are expected to cost whose whole lengths are so much together [s]."""
        return length_s * self._share(subject) + FLIGHT_S * flights * self._flown_share(subject)

    def _draw(self, flight: Flight, nominal_s: float) -> _Draw:
        return self._draws.setdefault(_place(flight), _Draw(nominal_s))

    def _measure(self, flight: Flight, draw: _Draw, outcome: Outcome) -> None:
        """How long a flight lasts here."""
        if not draw.home:
            self._begun[_place(flight)] = draw
            for subject in draw.due:
                self._refresh(subject, draw.nominal_s, -1)
        draw.home += 1
        draw.home_s += outcome.duration_s

    def _learn(self, draw: _Draw) -> None:
        for subject, cost_s in draw.costs:
            self._costs_s[subject] += cost_s
            self._lengths_s[subject] += draw.length_s
            self._learnt[subject] += 1
            self._flown[subject] += cost_s > 0.0
        draw.costs.clear()

    def _share(self, subject: str) -> float:
        """What is flown of a whole flight's length."""
        if subject in WHOLE:
            return 1.0
        prior, length_s = PRIOR_SHARE if self._sharing else 1.0, self._lengths_s.get(subject, 0.0)
        return (self._costs_s.get(subject, 0.0) + prior * PRIOR_S) / (length_s + PRIOR_S)

    def _flown_share(self, subject: str) -> float:
        """How many of its flights are flown at all, as a share."""
        if subject in WHOLE or not self._sharing:
            return 1.0
        return (self._flown[subject] + PRIOR_FLOWN) / (self._learnt[subject] + 1)

    def _cost_s(self, flight: Flight, outcome: Outcome) -> float:
        if not self._sharing or _whole(flight):
            return outcome.duration_s
        return 0.0 if outcome.infected_at_s is None else outcome.duration_s - outcome.infected_at_s


def _whole(flight: Flight) -> bool:
    return flight.subject.id in WHOLE


def _place(flight: Flight) -> tuple[str, int]:
    return flight.situation.key, flight.seed
