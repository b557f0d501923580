"""Mutants of one parameter, which search together.

A situation that is proposed for one of them is flown for all: they share its baseline, and a situation where the drone
depends on what one of them changes is a good one for the others.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil

from scaloft_fi.campaign.runs.seeking.proposals import Proposal
from scaloft_fi.campaign.runs.seeking.quest import Quest

GENERATION = 8
"""Situations that a family proposes at once, or more where `EACH` asks for it, whatever the number of processes."""
EACH = 2
"""Least number of situations that are proposed for each mutant at once."""
NEARER = 0.01
"""Least change of a distance that counts as progress."""
LONGEST_REST = 8
"""Turns that a family without progress pauses, at most."""


@dataclass
class Family:
    """The mutants of one parameter.

    Attributes:
        quests: the search for each of them.
        pauses: turns that the family still pauses.
    """

    quests: Sequence[Quest]
    pauses: int = 0
    _pause: int = 0

    @property
    def sought(self) -> list[Quest]:
        """The mutants without a find."""
        return [quest for quest in self.quests if quest.shown_in is None]

    def ask(self) -> list[Proposal]:
        """The next situations, each of them once."""
        each = max(EACH, ceil(GENERATION / len(self.sought)))
        proposed: dict[object, Proposal] = {}
        for quest in self.sought:
            for proposal in quest.proposals.ask(each):
                proposed.setdefault(proposal.situation, proposal)
        return list(proposed.values())

    def rest_after(self, nearest: Sequence[float]) -> None:
        """Pause twice as long as before where no mutant came nearer, or was found.

        Args:
            nearest: least distance of each of `quests` before the generation.
        """
        now = (quest.proposals.nearest for quest in self.quests)
        nearer = any(old - new > NEARER for old, new in zip(nearest, now, strict=True))
        self._pause = 0 if nearer else min(max(1, 2 * self._pause), LONGEST_REST)
        self.pauses = self._pause

    @property
    def nearest(self) -> list[float]:
        """Least distance for each mutant so far."""
        return [quest.proposals.nearest for quest in self.quests]


def families(quests: Iterable[Quest]) -> list[Family]:
    """The families, in the order of their first mutants."""
    by_parameter: dict[str, list[Quest]] = {}
    for quest in quests:
        by_parameter.setdefault(quest.mutant.parameter, []).append(quest)
    return [Family(own) for own in by_parameter.values()]
