"""A planned flight: mutant, situation and seed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scaloft_fi.judge.outcome import Subject
from scaloft_fi.mutants.mutant import Mutant

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation


@dataclass(frozen=True)
class Flight:
    """One planned flight.

    Attributes:
        mutant: the mutant; None = the baseline.
        situation, seed: situation and seed of the flight.
    """

    mutant: Mutant | None
    situation: Situation
    seed: int

    @property
    def subject(self) -> Subject:
        """The subject of the flight."""
        return Subject.of(self.mutant)

    @property
    def name(self) -> str:
        """`MUTANT/SITUATION/SEED`, the argument of `replay`."""
        return f"{self.subject.id}/{self.situation.key}/{self.seed}"
