"""The search for one mutant: its proposals, its candidates, what it found."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scaloft_fi.analysis.pool import LEAST, Pool
from scaloft_fi.analysis.seeking import confirmed, does_mission, safely_held, seeds_for, share_of, shrunk
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.runs.seeking.flights import SEEN_ON, SearchFlights
from scaloft_fi.campaign.runs.seeking.proposals import Proposer
from scaloft_fi.mutants.mutant import Mutant

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scaloft_fi.judge.outcome import Outcome
    from scaloft_fi.sim.found import Evidence
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.sim.situation import Situation


@dataclass
class Quest:
    """The search for one mutant.

    Attributes:
        mutant: the mutant.
        proposals: what is proposed for it.
        shrinks: whether a situation is shrunk before it is confirmed.
        candidates: situations that spent a share of alpha, whether or not their pool was fit for the test.
        spent: what they spent of alpha.
        shown_in: the situation that shows it; None before it is found.
        after: flights of the search when it was found.
        rejected: situations that are not tested again.
    """

    mutant: Mutant
    proposals: Proposer
    shrinks: bool = True
    candidates: int = 0
    spent: float = 0.0
    shown_in: Situation | None = None
    after: int = 0
    rejected: set[Situation] = field(default_factory=set)

    def pursued(
        self, situation: Situation, flights: SearchFlights, grid: Grid, alpha: float
    ) -> tuple[Situation, Evidence] | None:
        """The situation, shrunk if that is confirmed too, with the evidence; None where nothing is confirmed.

        Args:
            situation: shows the mutant with the first seed of the search.
            flights: of the search.
            grid: the grid.
            alpha: the study's, of which each candidate spends its share.

        Raises:
            Interrupted, SpentError: as `SearchFlights.fly`.
        """
        flights.beside([self.mutant], [situation], SEEN_ON)
        if not flights.shown_by(self.mutant, situation):
            return None

        def shows(asked: Sequence[Situation], every: bool) -> list[bool]:
            flights.beside([self.mutant], asked, SEEN_ON if every else SEEN_ON[:1])
            if every:
                return [bool(flights.shown_by(self.mutant, one)) for one in asked]
            return [flights.distance(self.mutant, one) < 0.0 for one in asked]

        for one in dict.fromkeys((shrunk(situation, grid, shows), situation) if self.shrinks else (situation,)):
            evidence = self.confirmation(one, flights, alpha)
            if evidence is not None:
                return one, evidence
        return None

    def confirmation(self, situation: Situation, flights: SearchFlights, alpha: float) -> Evidence | None:
        """The evidence of seeds that the search never flew; None where they do not confirm the situation.

        A candidate spends its share of alpha before its pool is looked at: one whose pool is not steady, or where the
        unmutated drone does not do its mission, has spent it too.

        Raises:
            Interrupted, SpentError: as `SearchFlights.fly`.
        """
        names = flights.shown_by(self.mutant, situation)
        if not names or situation in self.rejected:
            return None
        self.rejected.add(situation)
        number = flights.candidate(self.mutant, situation)
        share = share_of(alpha, number)
        self.candidates += 1
        self.spent += share
        baselines = _flown(None, situation, LEAST, flights)
        if not (flights.anyhow or does_mission(baselines)):
            return None
        pool = Pool.of(baselines)
        steady = safely_held(pool, situation.key, names, baselines)
        seeds = seeds_for(pool, situation.key, steady, share)
        if seeds is None:
            return None
        if seeds > LEAST:
            baselines = _flown(None, situation, seeds, flights)
        evidence = confirmed(_flown(self.mutant, situation, seeds, flights), baselines, steady, number, share)
        if evidence is not None:
            self.shown_in, self.after = situation, flights.used
        return evidence


def _flown(mutant: Mutant | None, situation: Situation, seeds: int, flights: SearchFlights) -> list[Outcome]:
    """The outcomes of the first seeds that no search flies."""
    wanted = [Flight(mutant, situation, seed) for seed in range(seeds)]
    flights.fly(wanted)
    return [outcome for flight in wanted if (outcome := flights.outcome(flight)) is not None]
