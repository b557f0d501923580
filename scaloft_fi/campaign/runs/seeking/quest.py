"""The search for one mutant: its proposals, its candidates, what it found."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scaloft_fi.analysis.scoring.pool import LEAST, Pool
from scaloft_fi.analysis.seeking.aim import REJECTED
from scaloft_fi.analysis.seeking.confirmation import confirmed, safely_held, seeds_for, share_of
from scaloft_fi.analysis.seeking.shrink import shrunk
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.runs.seeking.flights import SEEN_ON, SearchFlights
from scaloft_fi.campaign.runs.seeking.proposals import Proposal, Proposals
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
        candidates: situations that were tested on fresh seeds.
        shown_in: the situation that shows it; None before it is found.
        rejected: situations that are not tested again.
    """

    mutant: Mutant
    proposals: Proposals
    candidates: int = 0
    shown_in: Situation | None = None
    rejected: set[Situation] = field(default_factory=set)

    def generation(self, flights: SearchFlights, grid: Grid, alpha: float) -> tuple[Situation, Evidence] | None:
        """Fly the next generation, and pursue what looks like a find, the most distant violation first.

        Args:
            flights: of the search.
            grid: the grid.
            alpha: the study's, of which each candidate spends its share.

        Raises:
            Interrupted, SpentError: as `SearchFlights.fly`.
        """
        proposed = self.proposals.ask()
        flights.beside([self.mutant], [one.situation for one in proposed], SEEN_ON[:1])
        for one in proposed:
            one.distance = flights.distance(self.mutant, one.situation)
        found = None
        for one in sorted(proposed, key=_distance):
            if one.distance >= 0.0 or found is not None:
                break
            found = self._pursued(one.situation, flights, grid, alpha)
            if found is None:
                one.distance = REJECTED
        self.proposals.tell(proposed)
        return found

    def _pursued(
        self, situation: Situation, flights: SearchFlights, grid: Grid, alpha: float
    ) -> tuple[Situation, Evidence] | None:
        """The situation, shrunk if that is confirmed too, with the evidence; None where nothing is confirmed."""
        flights.beside([self.mutant], [situation], SEEN_ON)
        if not flights.shown_by(self.mutant, situation):
            return None

        def shows(asked: Sequence[Situation], every: bool) -> list[bool]:
            flights.beside([self.mutant], asked, SEEN_ON if every else SEEN_ON[:1])
            if every:
                return [bool(flights.shown_by(self.mutant, one)) for one in asked]
            return [flights.distance(self.mutant, one) < 0.0 for one in asked]

        for one in dict.fromkeys((shrunk(situation, grid, shows), situation)):
            evidence = self.confirmation(one, flights, alpha)
            if evidence is not None:
                return one, evidence
        return None

    def confirmation(self, situation: Situation, flights: SearchFlights, alpha: float) -> Evidence | None:
        """The evidence of seeds that the search never flew; None where they do not confirm the situation.

        A situation whose baselines put no requirement to the test is no candidate and spends nothing.

        Raises:
            Interrupted, SpentError: as `SearchFlights.fly`.
        """
        names = flights.shown_by(self.mutant, situation)
        if not names or situation in self.rejected:
            return None
        self.rejected.add(situation)
        baselines = _flown(None, situation, LEAST, flights)
        pool = Pool.of(baselines)
        steady = safely_held(pool, situation.key, names, baselines)
        share = share_of(alpha, self.candidates + 1)
        seeds = seeds_for(pool, situation.key, steady, share)
        if seeds is None:
            return None
        self.candidates += 1
        if seeds > LEAST:
            baselines = _flown(None, situation, seeds, flights)
        evidence = confirmed(_flown(self.mutant, situation, seeds, flights), baselines, steady, self.candidates, share)
        if evidence is not None:
            self.shown_in = situation
        return evidence


def _distance(proposal: Proposal) -> float:
    return proposal.distance


def _flown(mutant: Mutant | None, situation: Situation, seeds: int, flights: SearchFlights) -> list[Outcome]:
    """The outcomes of the first seeds that no search flies."""
    wanted = [Flight(mutant, situation, seed) for seed in range(seeds)]
    flights.fly(wanted)
    return [outcome for flight in wanted if (outcome := flights.outcome(flight)) is not None]
