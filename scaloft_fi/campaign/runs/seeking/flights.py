"""The flights of a search: flown where the campaign lacks them, counted against the budget, looked up by name."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from scaloft_fi.analysis.seeking import Effort, distance, effort_of, is_of_use, shown_by
from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.runs.budget import Budget, budget_s
from scaloft_fi.campaign.runs.campaign import Campaign
from scaloft_fi.campaign.runs.seeking.sought import Candidates
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, Outcome, Subject
from scaloft_fi.mutants.mutant import PLACEBO, Mutant

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation

SEEN_ON = (1_000, 1_001, 1_002)
"""Seeds of the search; a situation is proposed and shrunk on the first one, and kept where all of them show the fault.
The seeds that confirm it are 0, 1, ..., which the search never flies."""

TOGETHER = 16
"""Most mutants that fly together with a baseline not known yet.  A baseline's flight is shared by the mutants that fly
with it, up to the first sample that each alters, and costs as much again where it flew before; where it turns out to be
of no use, all of them flew in vain.  With 0.9 of the baselines of use and a mutant at 0.6 of a whole flight, both
measured in a trial, waiting pays from 16 mutants on."""


@dataclass(frozen=True)
class Allowance:
    """The budget of a search.

    Attributes:
        flights: number of flights, stored ones included; None = unlimited.
        seconds: wall time [s]; None = unlimited.
    """

    flights: int | None = None
    seconds: float | None = None

    @classmethod
    def parse(cls, text: str | None) -> Allowance:
        """Parse `2000flights`, or a duration such as `10m`.

        >>> Allowance.parse("2000flights"), Allowance.parse("10m")
        (Allowance(flights=2000, seconds=None), Allowance(flights=None, seconds=600.0))

        Raises:
            InputError: the text is neither.
        """
        if text is None:
            return cls()
        if match := re.fullmatch(r"([1-9]\d{0,8}) ?flights?", text.strip()):
            return cls(flights=int(match[1]))
        try:
            return cls(seconds=budget_s(text))
        except InputError:
            allowed = "a number of flights such as 2000flights, or a time with its unit such as 90s, 10m or 1h30m"
            raise InputError(f"--budget={text!r} must be {allowed}") from None


OTHER_SEEDS = 1_000_000
"""What PLACEBO's seeds are shifted by: it stands for the unmutated drone under seeds of its own."""


class SpentError(Exception):
    """The budget is used up."""


class SearchFlights:
    """Flies for a search, and answers from outcomes.

    PLACEBO stands for a fault that does nothing: the unmutated drone under other seeds.  A search that finds a
    situation for it is wrong.

    Args:
        campaign: the open campaign.
        allowance: the budget.
        anyhow: whether a situation counts where the unmutated drone does not do its mission.

    Attributes:
        used: number of different flights that the search asked for, stored ones and unstored ones included.
        anyhow: as the argument.
    """

    def __init__(self, campaign: Campaign, allowance: Allowance, *, anyhow: bool = False) -> None:
        self._campaign, self._allowance, self.anyhow = campaign, allowance, anyhow
        self._candidates = Candidates(campaign.store)
        self._budget = Budget(allowance.seconds)
        self._known: dict[str, Outcome | None] = {}
        self._unstored = 0
        campaign.reporter.progress.most_s = lambda: self._budget.left_s

    @property
    def used(self) -> int:
        """Number of different flights of the search so far."""
        return len(self._known) + self._unstored

    def fly(self, flights: Iterable[Flight]) -> None:
        """Fly what is not known yet.

        Raises:
            Interrupted: the user stopped the search; all outcomes are saved.
            SpentError: the budget does not allow these flights.
        """
        new = {flight.name: flight for flight in flights if flight.name not in self._known}
        if not new:
            return
        self._afford(len(new))
        flown = {name: _flown_for(flight) for name, flight in new.items()}
        self._campaign.plan(flown.values())
        self._campaign.fly(flown.values(), self._in_time)
        self.raise_if_stopped()
        if self._budget.left_s <= 0.0 and self._campaign.missing(flown.values()):
            raise SpentError
        outcomes = {outcome.name: outcome for outcome in self._campaign.outcomes(flown.values())}
        for name, flight in new.items():
            outcome = outcomes.get(flown[name].name)
            self._known[name] = outcome if outcome is None or flight.mutant != PLACEBO else _as_placebo(outcome)

    def _in_time(self, flights: Sequence[Flight]) -> Iterable[Batch]:
        return self._budget.while_it_lasts(self._campaign.arrange(flights))

    def spend(self, count: int) -> None:
        """Spend the budget on flights that the campaign does not store.

        Raises:
            SpentError: the budget does not allow them.
        """
        self._afford(count)
        self._unstored += count

    def raise_if_stopped(self) -> None:
        """Raise if the user asked to stop.

        Raises:
            Interrupted: the user did.
        """
        self._campaign.raise_if_stopped("the flights of the search so far are")

    def _afford(self, count: int) -> None:
        most = math.inf if self._allowance.flights is None else self._allowance.flights
        if self.used + count > most or self._budget.left_s <= 0.0:
            raise SpentError

    def outcome(self, flight: Flight) -> Outcome | None:
        """The outcome of a known flight; None where the harness failed."""
        return self._known.get(flight.name)

    def beside(self, mutants: Sequence[Mutant], situations: Sequence[Situation], seeds: Sequence[int]) -> None:
        """Fly baselines and mutants, without mutants where a known baseline holds no requirement with room.

        Up to `TOGETHER` mutants fly with their baselines; before more of them, the baselines fly alone.

        Raises:
            Interrupted, SpentError: as `fly`.
        """
        baselines = [Flight(None, situation, seed) for situation in situations for seed in seeds]
        if len(mutants) > TOGETHER:
            self.fly(baselines)
        of_use = [one for one in baselines if one.name not in self._known or self._is_of_use(one)]
        theirs = (Flight(mutant, one.situation, one.seed) for one in of_use for mutant in mutants)
        self.fly([*baselines, *theirs])

    def distance(self, mutant: Mutant, situation: Situation) -> float:
        """How far a situation is from showing a mutant, with the first seed of the search."""
        return distance(*self._pair(mutant, situation, SEEN_ON[0]), anyhow=self.anyhow)

    def shown_by(self, mutant: Mutant, situation: Situation) -> tuple[str, ...]:
        """The requirements by which a situation shows a mutant with every seed of the search."""
        pairs = (self._pair(mutant, situation, seed) for seed in SEEN_ON)
        first, *others = (shown_by(*pair, anyhow=self.anyhow) for pair in pairs)
        return tuple(name for name in first if all(name in names for names in others))

    def candidate(self, mutant: Mutant, situation: Situation) -> int:
        """Which candidate of the mutant a situation is, from 1, over all searches of the campaign.

        Raises:
            InputError: the store cannot be written.
        """
        return self._candidates.number(mutant.id, situation.key)

    def efforts(self) -> dict[str, Effort]:
        """How far the search came with each mutant, by id; without mutants that were not flown."""
        by_subject: dict[str, dict[str, Outcome]] = {}
        for outcome in self._known.values():
            if outcome is not None and outcome.seed == SEEN_ON[0]:
                by_subject.setdefault(outcome.mutant, {})[outcome.situation] = outcome
        baselines = by_subject.pop(BASELINE, {})
        return {
            mutant: effort_of(flights.values(), baselines, anyhow=self.anyhow) for mutant, flights in by_subject.items()
        }

    def _is_of_use(self, baseline: Flight) -> bool:
        return is_of_use(self.outcome(baseline), anyhow=self.anyhow)

    def _pair(self, mutant: Mutant, situation: Situation, seed: int) -> tuple[Outcome | None, Outcome | None]:
        return self.outcome(Flight(mutant, situation, seed)), self.outcome(Flight(None, situation, seed))


def _flown_for(flight: Flight) -> Flight:
    """The flight that is flown for a flight of the search."""
    return Flight(None, flight.situation, flight.seed + OTHER_SEEDS) if flight.mutant == PLACEBO else flight


def _as_placebo(baseline: Outcome) -> Outcome:
    """A baseline as if it were a mutant's flight that altered something."""
    return replace(baseline, subject=Subject.of(PLACEBO), seed=baseline.seed - OTHER_SEEDS, altered=1)
