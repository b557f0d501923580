"""A planned flight: mutant, situation and seed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scaloft_fi.judge.outcome import BASELINE, Subject
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
        return subject_of(self.mutant)

    @property
    def name(self) -> str:
        """`MUTANT/SITUATION/SEED`, the argument of `replay`."""
        return f"{self.subject.id}/{self.situation.key}/{self.seed}"


def subject_of(mutant: Mutant | None) -> Subject:
    """The subject of a mutant's flight; None = the baseline."""
    if mutant is None:
        return Subject(BASELINE)
    return Subject(mutant.id, mutant.guideword, mutant.parameter, mutant.magnitude)
