"""The search: families of mutants in turn, a generation each, until each mutant is shown or the budget is used up.

A situation that is proposed for one of them is flown for all: they share its baseline, and a situation where the drone
depends on what one of them changes is a good one for the others.

Everything follows from the seed, the mutants asked for and the outcomes: an interrupted search asks for the same
flights again, finds them in the store, and goes on where it stopped.  A budget decides only how far it goes.

Situations are proposed for one mutant by Optuna's tree-structured Parzen estimator (TPE), by ask and tell.  TPE
(Bergstra et al., NeurIPS 2011) models where good and bad situations lie, handles axes that exist only with values of
other axes, and needs few trials.  It is told of situations that others proposed too.  A free axis is one parameter,
whose greatest values alone are off the benign value of the axis (`FreeAxis.drawn`): TPE so learns whether and where at
once.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import count, islice
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from scaloft_fi.analysis import seeking
from scaloft_fi.analysis.detection import LEAST, Pool
from scaloft_fi.analysis.seeking import brief, situation_at
from scaloft_fi.campaign.flights.fly import Flight, Flyer
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import ONE_PROCESS, RunOptions
from scaloft_fi.campaign.runs.run import Run
from scaloft_fi.campaign.seeking import finds
from scaloft_fi.campaign.seeking.finds import SEEN_ON, SearchFlights, SeekReport, Sought, SpentError
from scaloft_fi.errors import needed, refused
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.registry import grouped
from scaloft_fi.sim.grid import Evidence, Find
from scaloft_fi.sim.situation import DEVIATES, Situation
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.judge.outcome import Outcome
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.sim.situation import Situation
    from scaloft_fi.study import Study


OPENING = 24
"""Situations that are flown for every mutant first; TPE proposes the others."""
EDGES = 1 / 2
"""Share of the numbers of the opening off their benign values that are not at an end of their range."""
TRIES = 10
"""Times that TPE is asked again for a situation that is impossible or was proposed before."""
IMPOSSIBLE = 3.0
"""What TPE is told of an impossible situation: farther from the fault than any other."""

Parameters = Mapping[str, Any]
Possible = Callable[[Situation], bool]
"""Whether a situation can be flown."""


def require_optuna() -> Any:
    """Import Optuna.

    Raises:
        InputError: it is not installed.
    """
    optuna = needed("optuna", "seek needs optuna", "seek")
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    return optuna


@dataclass(frozen=True)
class Proposal:
    """A proposed situation, and what it was made from."""

    situation: Situation
    parameters: Parameters


class Proposer(Protocol):
    """Proposes situations for one mutant."""

    @property
    def nearest(self) -> float:
        """The least distance so far."""

    def ask(self, count: int) -> list[Proposal]:
        """The next situations, none of them flown for the mutant before."""

    def tell(self, distances: Sequence[tuple[Proposal, float]]) -> None:
        """Tell how far situations are from showing the mutant, whoever proposed them."""


MakeProposer = Callable[["Grid", Possible, int, str], Proposer]
"""Makes the proposer of a mutant, from the grid, what can be flown, the seed of the search and the mutant's id."""
Opening = Callable[["Grid", int, Possible], Iterable[Proposal]]
"""Makes the situations that are flown for every mutant first, from the grid, the seed and what can be flown."""


def flyable(study: Study, situation: Situation) -> bool:
    """Whether a situation can be flown: its world is possible and its mission not too long."""
    return not refused(study.scenario, situation)


class Proposals:
    """The proposals for one mutant.

    Args:
        grid: the grid.
        possible: whether a situation can be flown.
        seed: seed of the search.
        mutant: id of the mutant, which names its stream of randomness.
    """

    def __init__(self, grid: Grid, possible: Possible, seed: int, mutant: str) -> None:
        self._optuna = optuna = require_optuna()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            sampler = optuna.samplers.TPESampler(
                n_startup_trials=OPENING,
                multivariate=True,
                group=True,
                constant_liar=True,
                seed=key_words("seek", seed, mutant)[0] % 2**32,
            )
        self._grid, self._possible = grid, possible
        self._study = optuna.create_study(sampler=sampler)
        self._asked: dict[Situation, Any] = {}
        self._known: dict[Situation, float] = {}

    def ask(self, count: int) -> list[Proposal]:
        """The next situations, none of them flown for the mutant before; fewer where TPE finds no more."""
        proposed: list[Proposal] = []
        for _ in range(count * TRIES):
            trial = self._study.ask()
            parameters = _suggest(trial, self._grid)
            situation = placed(self._grid, parameters)
            if situation is None or situation in self._asked or not self._possible(situation):
                self._study.tell(trial, IMPOSSIBLE)
            elif situation in self._known:
                self._study.tell(trial, self._known[situation])
            else:
                self._asked[situation] = trial
                proposed.append(Proposal(situation, parameters))
            if len(proposed) == count:
                break
        return proposed

    def tell(self, distances: Sequence[tuple[Proposal, float]]) -> None:
        """Tell how far situations are from showing the mutant, whoever proposed them."""
        for proposal, distance in distances:
            self._known[proposal.situation] = distance
            if (trial := self._asked.pop(proposal.situation, None)) is not None:
                self._study.tell(trial, distance)
            else:
                self._study.add_trial(self._trial(proposal.parameters, distance))

    def _trial(self, parameters: Parameters, distance: float) -> Any:
        choices = {axis.id: list(range(len(axis.values))) for axis in self._grid.axes}
        whole, part = self._optuna.distributions.CategoricalDistribution, self._optuna.distributions.FloatDistribution
        shapes = {name: whole(choices[name]) if name in choices else part(0.0, 1.0) for name in parameters}
        return self._optuna.create_trial(params=dict(parameters), distributions=shapes, value=distance)

    @property
    def nearest(self) -> float:
        """The least distance so far."""
        return min(self._known.values(), default=IMPOSSIBLE)

    @property
    def situations(self) -> tuple[Situation, ...]:
        """The situations so far, in the order in which they were told."""
        return tuple(self._known)


def opening(grid: Grid, seed: int, possible: Possible) -> Iterator[Proposal]:
    """The first proposals, the same for every mutant."""
    return islice(draws(grid, seed, possible), OPENING)


def draws(grid: Grid, seed: int, possible: Possible) -> Iterator[Proposal]:
    """Distinct situations of the grid that can be flown, drawn one after another, until no more are found.

    Half of the numbers off their benign values are at an end of their range: faults show at the edges of what the
    drone can do (boundary value analysis).
    """

    def share(number: int, axis: str, what: str) -> float:
        drawn = (key_words("seek", "opening", seed, number, axis, what)[0] >> 11) / 2**53  # exact, below 1
        if what == "level" or drawn < 1 - DEVIATES or share(number, axis, "level") < EDGES:
            return drawn
        return 1 - DEVIATES if drawn < 1 - DEVIATES / 2 else 1 - 2**-53

    known: set[Situation] = set()
    new = 0
    for number in count():
        parameters = at_shares(grid, partial(share, number))
        situation = placed(grid, parameters)
        if situation is not None and situation not in known and possible(situation):
            known.add(situation)
            new = number
            yield Proposal(situation, parameters)
        elif number - new > OPENING * TRIES:
            return


def at_shares(grid: Grid, share: Callable[[str, str], float]) -> Parameters:
    """The parameters at shares 0 <= share < 1 of an axis' `level` and `number`, as a random draw has them."""
    return _parameters(
        grid, lambda axis, count: int(share(axis, "level") * count), lambda name: share(name.rstrip("="), "number")
    )


def _suggest(trial: Any, grid: Grid) -> Parameters:
    """The parameters of a trial, each suggested where the situation has it."""

    def level(axis: str, count: int) -> int:
        chosen: int = trial.suggest_categorical(axis, list(range(count)))
        return chosen

    return _parameters(grid, level, lambda name: float(trial.suggest_float(name, 0.0, 1.0)))


def _parameters(grid: Grid, level: Callable[[str, int], int], number: Callable[[str], float]) -> Parameters:
    """The parameters of a situation: a level for each axis, and a number, 0 to 1, where the situation has one."""
    levels = {axis.id: level(axis.id, len(axis.values)) for axis in grid.axes}
    names = [f"{axis.id}=" for axis in grid.axes if axis.range]
    names += [axis.id for axis in grid.free if axis.goes_with(levels)]
    return {**levels, **{name: number(name) for name in names}}


def placed(grid: Grid, parameters: Parameters) -> Situation | None:
    """The situation of parameters; None where the grid has none.  A number is written as short as people say it."""
    levels = {axis.id: int(parameters[axis.id]) for axis in grid.axes}
    numbers: dict[str, float] = {}
    for axis in grid.axes:
        if axis.range:
            exact = axis.range.draw(levels[axis.id], min(parameters[f"{axis.id}="], 1 - 2**-53))
            short = brief(exact)
            numbers[axis.id] = short if axis.range.bin(short) == levels[axis.id] else exact
    for free in grid.free:
        drawn = free.drawn(parameters.get(free.id, 0.0))
        if drawn is not None:
            numbers[free.id] = short if free.holds(short := brief(drawn)) else drawn
    return situation_at(grid, levels, numbers)


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
    return [Family(own) for own in grouped(quests, lambda quest: quest.mutant.parameter).values()]


@dataclass
class Quest:
    """The search for one mutant.

    Attributes:
        mutant: the mutant.
        proposals: what is proposed for it.
        shrinks: whether a situation is shrunk before it is confirmed.
        candidates: situations that were tested on fresh seeds, whether or not their pool was fit for the test.
        untested: situations whose fresh seeds the budget left unflown.
        spent: what both spent of alpha.
        shown_in: the situation that shows it; None before it is found.
        after: flights of the search when it was found.
        rejected: situations that are not tested again.
    """

    mutant: Mutant
    proposals: Proposer
    shrinks: bool = True
    candidates: int = 0
    untested: int = 0
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

        for one in dict.fromkeys((seeking.shrunk(situation, grid, shows), situation) if self.shrinks else (situation,)):
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
        share = seeking.share_of(alpha, number)
        self.candidates += 1
        self.spent += share
        try:
            baselines = _flown(None, situation, LEAST, flights)
            if not (flights.anyhow or seeking.does_mission(baselines)):
                return None
            pool = Pool.of(baselines)
            steady = seeking.safely_held(pool, situation.key, names, baselines)
            seeds = seeking.seeds_for(pool, situation.key, steady, share)
            if seeds is None:
                return None
            if seeds > LEAST:
                baselines = _flown(None, situation, seeds, flights)
            own = _flown(self.mutant, situation, seeds, flights)
        except SpentError:
            self.candidates, self.untested = self.candidates - 1, self.untested + 1
            raise
        evidence = seeking.confirmed(own, baselines, steady, number, share)
        if evidence is not None:
            self.shown_in, self.after = situation, flights.used
        return evidence


def _flown(mutant: Mutant | None, situation: Situation, seeds: int, flights: SearchFlights) -> list[Outcome]:
    """The outcomes of the first seeds that no search flies."""
    wanted = [Flight(mutant, situation, seed) for seed in range(seeds)]
    flights.fly(wanted)
    return [outcome for flight in wanted if (outcome := flights.outcome(flight)) is not None]


CHUNK = 8
"""Situations of the opening that are flown at once."""


def seek(
    study: Study,
    mutants: Sequence[Mutant],
    folder: Path,
    options: RunOptions = ONE_PROCESS,
    *,
    seed: int,
    allowance: finds.Allowance,
    progress: Progress,
    save: Callable[[Sequence[Find]], None],
    unnamed: finds.Unnamed | None = None,
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
        options: options of the run.
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
    possible = partial(flyable, study)
    quests = [Quest(mutant, proposer(study.grid, possible, seed, mutant.id), shrinks=shrinks) for mutant in mutants]
    opened_with = list(first(study.grid, seed, possible))
    flown_first = [Flight(None, one.situation, SEEN_ON[0]) for one in opened_with]
    with finds.searching(study, folder, options, progress=progress, flyer=flyer, first=flown_first[:1]) as campaign:
        search = _Search(campaign, quests, seed, SearchFlights(campaign, allowance, anyhow=anyhow), save)
        spent = False
        if unnamed is not None:
            unnamed.begin(campaign.store)
        try:
            search.begin(opened_with)
            search.turns()
        except SpentError:
            spent = True
        if unnamed is not None:
            unnamed.end(campaign.store)
        return SeekReport(
            finds=tuple(search.finds),
            sought=search.sought(),
            used=search.flights.used,
            flown=campaign.flown,
            spent=spent,
            needed=search.flights.needed,
            alpha=study.alpha,
            anyhow=anyhow,
        )


@dataclass
class _Search:
    """A search so far.

    Attributes:
        campaign, quests, seed, save: as for `seek`.
        flights: the flights of the search.
        finds: the found situations.
    """

    campaign: Run
    quests: Sequence[Quest]
    seed: int
    flights: SearchFlights
    save: Callable[[Sequence[Find]], None]
    finds: list[Find] = field(default_factory=list)

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
        own = families(self.quests)

        def turn(number: int) -> None:
            for family in own:
                if family.pauses:
                    family.pauses -= 1
                elif family.sought:
                    self._tell_stage(f"turn {number}: {family.sought[0].mutant.parameter}")
                    nearest = family.nearest
                    self._generation(family.sought, family.ask())
                    family.rest_after(nearest)

        self.flights.take_turns(turn, lambda: bool(self._sought))

    @property
    def _sought(self) -> list[Quest]:
        return [quest for quest in self.quests if quest.shown_in is None]

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
            found = quest.pursued(situation, self.flights, self._grid, self.campaign.study.alpha)
            if found is None:
                distances[situation] = seeking.REJECTED
            else:
                self._note_all(quest, *found)

    def _note_all(self, quest: Quest, situation: Situation, evidence: Evidence) -> None:
        """Note a find, then which other mutants still sought it shows, on the same seeds."""
        shows = {quest.mutant.id: evidence}
        self._note(quest, situation, shows)
        self.flights.beside([one.mutant for one in self._sought], [situation], SEEN_ON[:1])
        near = [one for one in self._sought if self.flights.distance(one.mutant, situation) < 0.0]
        self.flights.beside([one.mutant for one in near], [situation], SEEN_ON[1:])
        for other in near:
            told = other.confirmation(situation, self.flights, self.campaign.study.alpha)
            shows |= {other.mutant.id: told} if told is not None else {}
        self._note(quest, situation, shows)
        others = f", and {len(shows) - 1} others" if len(shows) > 1 else ""
        words = ", ".join(finds.words_of(situation, self._grid)) or "the benign situation"
        self.campaign.reporter.progress.line(f"found: {situation.key} ({words}) shows {quest.mutant.id}{others}")

    def _note(self, quest: Quest, situation: Situation, shows: dict[str, Evidence]) -> None:
        """Record a find, and save all finds."""
        name = finds.NAMED + quest.mutant.id
        find = Find(name, situation.key, finds.words_of(situation, self._grid), quest.mutant.id, dict(shows), self.seed)
        self.finds = [*(one for one in self.finds if one.name != name), find]
        self.save(self.finds)

    @property
    def _grid(self) -> Grid:
        return self.campaign.study.grid

    def _tell_stage(self, now: str) -> None:
        shown = sum(one.shown_in is not None for one in self.quests)
        self.campaign.reporter.progress.stage = f"{now}, {shown} of {len(self.quests)} shown"

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
                efforts.get(quest.mutant.id, seeking.Effort()),
                quest.untested,
            )
            for quest in self.quests
        )
