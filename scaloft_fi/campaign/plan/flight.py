"""One planned flight: what is patched in, and where it is flown."""

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
        mutant: what is patched in; None = the baseline.
        situation, seed: where.
    """

    mutant: Mutant | None
    situation: Situation
    seed: int

    @property
    def subject(self) -> Subject:
        """What is flown, as results name it."""
        return Subject.of(self.mutant)

    @property
    def name(self) -> str:
        """`MUTANT/SITUATION/SEED`, as `replay` takes it."""
        return f"{self.subject.id}/{self.situation.key}/{self.seed}"
