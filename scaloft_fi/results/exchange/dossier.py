"""What a campaign's evidence is written from: the study's parts, its outcomes and what follows from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from scaloft_fi.hazop.cell import Cell
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.requirement import Requirement
from scaloft_fi.results.roster import Roster, cell_of
from scaloft_fi.results.scoring.score import MutantScore, Score, score
from scaloft_fi.results.situations.coverage import Coverage, coverage
from scaloft_fi.results.space import Space
from scaloft_fi.results.status import Status

WORDS = {
    Status.KILLED: "killed: a safety requirement is violated that the unmutated drone held",
    Status.SURVIVED: "survived: the flights changed, no safety requirement speaks",
    Status.MASKED: "masked: samples changed, no flight did",
    Status.BASELINE_RED: "no verdict: it acts only where the unmutated drone holds no safety requirement to its end",
    Status.NOT_INFECTED: "not infected: the fault changed no sample in any situation",
    Status.NOT_REACHED: "not reached: the patched interface carried no sample in any situation",
    Status.INVALID: "invalid: the harness failed",
}
"""What a mutant's status says, in a sentence."""


@dataclass(frozen=True)
class Dossier:
    """A campaign and what it was flown with.

    Attributes:
        study, campaign: names.
        version: of scaloft-fi.
        platform: on which the campaign was flown.
        matrix, space, roster, requirements: of the study.
        outcomes: of the campaign that count.
        sources: per file of the deviation matrix, by its path in the study, its text.
    """

    study: str
    campaign: str
    version: str
    platform: Mapping[str, str]
    matrix: Matrix
    space: Space
    roster: Roster
    requirements: tuple[Requirement, ...]
    outcomes: tuple[Outcome, ...]
    sources: Mapping[str, str]

    @cached_property
    def score(self) -> Score:
        """The campaign's score."""
        return score(self.outcomes, self.roster, self.space)

    @cached_property
    def coverage(self) -> Coverage:
        """Its situation coverage."""
        return coverage(self.outcomes, self.space)

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds of the mutants' flights."""
        return tuple(sorted({o.seed for o in self.outcomes if o.subject.guideword}))

    @property
    def counted(self) -> tuple[MutantScore, ...]:
        """The mutants that the ratios count: one of each credible cell."""
        return tuple(mutant for mutant in self.score.mutants if self.roster.counts(mutant.subject))

    @property
    def survivors(self) -> tuple[MutantScore, ...]:
        """Those of them that were put to the test and not seen."""
        return tuple(mutant for mutant in self.counted if lives(mutant))

    def cell(self, mutant: MutantScore) -> Cell:
        """The cell that a mutant comes from."""
        return self.matrix.cell(cell_of(mutant.subject.id))

    def place(self, mutant: MutantScore) -> tuple[str, int]:
        """File in the study and line of the cell that a mutant comes from."""
        path, _, line = self.cell(mutant).place.rpartition(":")
        path = path.replace("\\", "/")
        return next((name for name in self.sources if path.endswith(name)), path), int(line)

    def words(self, situation: str) -> str:
        """A situation in words: `corner, light`."""
        point = self.space.point.get(situation)
        return ", ".join(self.space.word(axis, value) for axis, value in enumerate(point)) if point else situation


def lives(mutant: MutantScore) -> bool:
    """Whether a mutant was put to the test, in an eligible situation, and not seen: it counts against the score."""
    return mutant.kill_rate.whole > 0 and not mutant.killed


def verdict(mutant: MutantScore) -> str:
    """Status, kills and by what, in a line."""
    said = WORDS[mutant.status]
    if not mutant.kill_rate.whole:
        return said
    by = ", ".join(f"{name} in {ratio.part} of {ratio.whole}" for name, ratio in mutant.requirements)
    return f"{said}; kills in {mutant.kill_rate.plain} of the eligible situations{f' ({by})' if by else ''}"
