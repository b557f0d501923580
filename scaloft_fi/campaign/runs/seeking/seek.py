"""The search: families of mutants in turn, a generation each, until each mutant is shown or the budget is used up.

Everything follows from the seed, the mutants asked for and the outcomes: an interrupted search asks for the same
flights again, finds them in the store, and goes on where it stopped.  A budget decides only how far it goes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.analysis.seeking import REJECTED, Effort
from scaloft_fi.campaign.flights.worker import Flyer
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.runs.campaign import Campaign, opened
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.run import write_log
from scaloft_fi.campaign.runs.seeking.family import families
from scaloft_fi.campaign.runs.seeking.finds import NAMED, words_of
from scaloft_fi.campaign.runs.seeking.flights import SEEN_ON, Allowance, SearchFlights, SpentError
from scaloft_fi.campaign.runs.seeking.proposals import (
    Flyable,
    MakeProposer,
    Opening,
    Proposal,
    Proposals,
    opening,
)
from scaloft_fi.campaign.runs.seeking.quest import Quest
from scaloft_fi.campaign.runs.seeking.sought import Unnamed
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.sim.found import Evidence, Find
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.sim.situation import Situation

IDLE = 20
"""Turns without a new situation or candidate, after which a search without a budget ends."""
CHUNK = 8
"""Situations of the opening that are flown at once."""


@dataclass(frozen=True)
class Sought:
    """What the search for one mutant came to.

    Attributes:
        mutant: its id.
        shown_in: key of the situation that shows it; empty where none was found.
        after: flights of the search, stored ones included, when it was found; 0 where it was not.
        candidates: situations that were tested on fresh seeds; spent: what they spent of alpha.
        effort: how far the search came with it.
    """

    mutant: str
    shown_in: str
    after: int
    candidates: int
    spent: float
    effort: Effort


@dataclass(frozen=True)
class SeekReport:
    """The result of a search.

    Attributes:
        finds: the found situations, in the order of finding.
        sought: one entry for each mutant, in the order of the search.
        used: flights of the search, stored ones included; flown: flights that this run flew.
        spent: whether the budget ended the search.
        alpha: the study's, which the candidates of each mutant share.
        anyhow: whether situations counted where the unmutated drone does not do its mission.
    """

    finds: tuple[Find, ...]
    sought: tuple[Sought, ...]
    used: int
    flown: int
    spent: bool
    alpha: float
    anyhow: bool


def seek(
    study: Study,
    mutants: Sequence[Mutant],
    folder: Path,
    options: RunOptions | None = None,
    *,
    seed: int,
    allowance: Allowance,
    progress: Progress,
    save: Callable[[Sequence[Find]], None],
    unnamed: Unnamed | None = None,
    flyer: Flyer | None = None,
    proposer: MakeProposer = Proposals,
    first: Opening = opening,
    shrinks: bool = True,
    anyhow: bool = False,
) -> SeekReport:
    """Search for a situation for each mutant.

    Args:
        study: the study, with the grid that is searched.
        mutants: the mutants, in the order of their turns.
        folder: folder of the campaign that holds the flights of the search.
        options: options of the run; one process when None.
        seed: seed of the search.
        allowance: the budget.
        progress: progress display.
        save: called with all finds after each find.
        unnamed: what is remembered of a search for which nobody named the mutants.
        flyer: flies; PyBullet when None.
        proposer: makes what proposes the situations for a mutant.
        first: makes the situations that are flown for every mutant first.
        shrinks: whether a situation is shrunk before it is confirmed.
        anyhow: whether a situation counts where the unmutated drone does not do its mission, or misses its values.

    Raises:
        InputError: Optuna is missing, the folder or the store cannot be written, or the study cannot be flown.
        Interrupted: the user stopped the search; all outcomes and finds are saved.
    """
    possible = Flyable(study)
    quests = [Quest(mutant, proposer(study.grid, possible, seed, mutant.id), shrinks=shrinks) for mutant in mutants]
    opened_with = list(first(study.grid, seed, possible))
    flown_first = [Flight(None, one.situation, SEEN_ON[0]) for one in opened_with]
    with opened(
        study, folder, options or RunOptions(), progress=progress, flyer=flyer, first=flown_first[:1]
    ) as campaign:
        search = _Search(campaign, study, quests, seed, SearchFlights(campaign, allowance, anyhow=anyhow), save)
        spent = False
        if unnamed is not None:
            unnamed.begin(campaign.store)
        try:
            search.begin(opened_with)
            search.turns()
        except SpentError:
            spent = True
        finally:
            campaign.reporter.close()
            write_log(study, folder, current_in(study, campaign.store))
        if unnamed is not None:
            unnamed.end(campaign.store)
        used, finds = search.flights.used, tuple(search.finds)
        return SeekReport(finds, search.sought(), used, campaign.flown, spent, study.alpha, anyhow)


class _Search:
    """A search so far.

    Attributes:
        finds: the found situations.
        flights: the flights of the search.
    """

    def __init__(
        self,
        campaign: Campaign,
        study: Study,
        quests: Sequence[Quest],
        seed: int,
        flights: SearchFlights,
        save: Callable[[Sequence[Find]], None],
    ) -> None:
        self._campaign, self._study, self._quests = campaign, study, quests
        self._seed, self._save = seed, save
        self.finds: list[Find] = []
        self.flights = flights

    def begin(self, first: Sequence[Proposal]) -> None:
        """Fly the first situations for every mutant.

        Raises:
            Interrupted, SpentError: as `SearchFlights.fly`.
        """
        for begin in range(0, len(first), CHUNK):
            proposed = first[begin : begin + CHUNK]
            self._tell_stage(f"opening {begin + len(proposed)} of {len(first)}")
            self._generation(self._sought, proposed)

    def turns(self) -> None:
        """Give each family a generation, again and again, until all mutants are shown.

        Raises:
            Interrupted, SpentError: as `SearchFlights.fly`.
        """
        own, turn, idle = families(self._quests), 0, 0
        while self._sought and idle < IDLE:
            turn += 1
            before = self.flights.used
            for family in own:
                if family.pauses:
                    family.pauses -= 1
                elif family.sought:
                    self._tell_stage(f"turn {turn}: {family.sought[0].mutant.parameter}")
                    nearest = family.nearest
                    self._generation(family.sought, family.ask())
                    family.rest_after(nearest)
            idle = idle + 1 if self.flights.used == before else 0

    @property
    def _sought(self) -> list[Quest]:
        return [quest for quest in self._quests if quest.shown_in is None]

    def _generation(self, quests: Sequence[Quest], proposed: Sequence[Proposal]) -> None:
        """Fly situations for mutants, and pursue what looks like a find, the most distant violation first."""
        self.flights.beside([quest.mutant for quest in quests], [one.situation for one in proposed], SEEN_ON[:1])
        far = {
            quest.mutant.id: {one.situation: self.flights.distance(quest.mutant, one.situation) for one in proposed}
            for quest in quests
        }
        try:
            for quest in quests:
                self._pursue_all(quest, far[quest.mutant.id])
        finally:
            for quest in quests:
                quest.proposals.tell([(one, far[quest.mutant.id][one.situation]) for one in proposed])

    def _pursue_all(self, quest: Quest, distances: dict[Situation, float]) -> None:
        """Pursue violations until one is a find; those that are none are rejected."""
        for situation in sorted(distances, key=lambda one: distances[one]):
            if distances[situation] >= 0.0 or quest.shown_in is not None:
                break
            if not self._pursue(quest, situation):
                distances[situation] = REJECTED

    def _pursue(self, quest: Quest, situation: Situation) -> bool:
        """Whether the situation led to a find, which is then noted."""
        found = quest.pursued(situation, self.flights, self._grid, self._study.alpha)
        if found is None:
            return False
        situation, evidence = found
        shows = {quest.mutant.id: evidence}
        self._note(quest, situation, shows)
        shows |= self._others(situation)
        self._note(quest, situation, shows)
        others = f", and {len(shows) - 1} others" if len(shows) > 1 else ""
        words = ", ".join(words_of(situation, self._grid)) or "the benign situation"
        self._campaign.reporter.progress.line(f"found: {situation.key} ({words}) shows {quest.mutant.id}{others}")
        return True

    def _others(self, situation: Situation) -> dict[str, Evidence]:
        """The evidence for the other mutants still sought that the situation shows, on the same seeds."""
        mutants = [quest.mutant for quest in self._sought]
        self.flights.beside(mutants, [situation], SEEN_ON[:1])
        near = [quest for quest in self._sought if self.flights.distance(quest.mutant, situation) < 0.0]
        self.flights.beside([quest.mutant for quest in near], [situation], SEEN_ON[1:])
        told = {quest.mutant.id: quest.confirmation(situation, self.flights, self._study.alpha) for quest in near}
        return {mutant: evidence for mutant, evidence in told.items() if evidence is not None}

    def _note(self, quest: Quest, situation: Situation, shows: dict[str, Evidence]) -> None:
        """Record a find, and save all finds."""
        name = NAMED + quest.mutant.id
        find = Find(name, situation.key, words_of(situation, self._grid), quest.mutant.id, dict(shows), self._seed)
        self.finds = [*(one for one in self.finds if one.name != name), find]
        self._save(self.finds)

    @property
    def _grid(self) -> Grid:
        return self._study.grid

    def _tell_stage(self, now: str) -> None:
        shown = sum(one.shown_in is not None for one in self._quests)
        self._campaign.reporter.progress.stage = f"{now}, {shown} of {len(self._quests)} shown"

    def sought(self) -> tuple[Sought, ...]:
        """What the search for each mutant came to."""
        efforts = self.flights.efforts()
        return tuple(
            Sought(
                quest.mutant.id,
                quest.shown_in.key if quest.shown_in is not None else "",
                quest.after,
                quest.candidates,
                quest.spent,
                efforts.get(quest.mutant.id, Effort()),
            )
            for quest in self._quests
        )
