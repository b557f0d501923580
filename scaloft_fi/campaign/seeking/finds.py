"""What a search flies, finds, writes to `sim/found.yaml`, remembers in the store, and flies again on fresh seeds.

An interrupted search has written finds already.  If it left out the mutants that these show when it goes on, it would
not find what it would have found without the interruption.

The candidates of a mutant are numbered over all searches of a campaign: another seed is no new share of alpha.

Each replication has a block of seeds of its own, which its campaign remembers: finds that fail once and are replicated
again get other seeds.  A replication that was interrupted, or had invalid flights, goes on with its own seeds.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from itertools import chain, count
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import yaml

from scaloft_fi.analysis import seeking
from scaloft_fi.analysis.seeking import Effort, Place, Replica, replicas
from scaloft_fi.campaign.flights.fly import Flight, Flyer
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import ONE_PROCESS, RunOptions
from scaloft_fi.campaign.runs.run import Budget, Run, budget_s, opened, write_log
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import current_in, remember_search
from scaloft_fi.campaign.store.store import Store, read_store
from scaloft_fi.errors import GateError, InputError
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.output import write_own
from scaloft_fi.sim.grid import FOUND_FILE, Break, Find, Finds, read_finds
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.sim.situation import Situation


SEARCH_BEGUN, SEARCH_ENDED, CANDIDATE = "seek begun", "seek ended", "seek candidate"
"""Prefixes of the names of the notes."""


@dataclass(frozen=True)
class Unnamed:
    """A search for which nobody named mutants.

    Attributes:
        seed: of the search.
        campaign: the campaign whose score says what is not detected.
        mutants: what is sought, in the order of the turns.
        number: how many such searches of the store began before.
    """

    seed: int
    campaign: str
    mutants: tuple[str, ...]
    number: int = 0

    def begin(self, store: Store) -> None:
        """Remember it.

        Raises:
            InputError: the store cannot be written.
        """
        store.remember(SEARCH_BEGUN, asdict(self), self.number)

    def end(self, store: Store) -> None:
        """Remember that it came to its end, or used up its budget.

        Raises:
            InputError: the store cannot be written.
        """
        store.remember(SEARCH_ENDED, self.number, self.number)


def interrupted(folder: Path, seed: int, campaign: str) -> Unnamed | None:
    """The last search of a folder if it did not end and had this seed and campaign.

    Raises:
        InputError: the store cannot be read.
    """
    begun, ended = _notes(folder)
    last = begun[-1] if begun else None
    return last if last and last.number not in ended and (last.seed, last.campaign) == (seed, campaign) else None


def anew(folder: Path, seed: int, campaign: str, mutants: Sequence[str]) -> Unnamed:
    """The next search of a folder.

    Raises:
        InputError: the store cannot be read.
    """
    return Unnamed(seed, campaign, tuple(mutants), len(_notes(folder)[0]))


def _notes(folder: Path) -> tuple[list[Unnamed], set[int]]:
    """The searches that began, in their order, and the numbers of those that ended."""

    def read(content: Any) -> Unnamed:
        mutants = tuple(map(str, content["mutants"]))
        return Unnamed(int(content["seed"]), str(content["campaign"]), mutants, int(content["number"]))

    with read_store(folder / STORE_NAME) as store:
        if store is None:
            return [], set()
        begun = sorted(store.records(SEARCH_BEGUN, read), key=attrgetter("number"))
        return begun, set(store.records(SEARCH_ENDED, int))


@contextmanager
def searching(
    study: Study,
    folder: Path,
    options: RunOptions,
    *,
    progress: Progress,
    flyer: Flyer | None,
    first: Sequence[Flight],
) -> Iterator[Run]:
    """Open the campaign of a search as `opened` does; however the search ends, its mission log is written."""
    with opened(study, folder, options, progress=progress, flyer=flyer, first=first) as campaign:
        try:
            yield campaign
        finally:
            campaign.reporter.close()
            write_log(study, folder, current_in(study, campaign.store))


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


@dataclass(frozen=True)
class Sought:
    """A mutant.

    Attributes:
        mutant: id of the mutant.
        shown_in: key of the situation that shows it; empty where none was found.
        after: flights of the search, stored ones included, when it was found; 0 where it was not.
        candidates: situations that were tested on fresh seeds.
        spent: what these and the untested ones spent of alpha (0..1).
        effort: how far the search came, in flights with its first seed.
        untested: situations that spent a share of alpha and whose fresh seeds the budget left unflown.
    """

    mutant: str
    shown_in: str
    after: int
    candidates: int
    spent: float
    effort: Effort
    untested: int = 0


@dataclass(frozen=True, kw_only=True)
class SeekReport:
    """The situations that a search found: those that show mutants, or those that break the unmutated drone.

    Attributes:
        finds: the situations that show mutants, in the order of finding.
        sought: the mutants that were sought, in the order of the search; of `seek baseline` empty.
        breaks: of `seek baseline`: the situations that break the unmutated drone, in the order of finding.
        replicas: of `seek --replicate`: the pairs of find and mutant that were flown again.
        first: of `seek --replicate`: the first seed; null: a search.
        situations: of `seek baseline`: situations flown; null: mutants were sought.
        broken: of these situations, where the drone violates with the first seed; null: mutants were sought.
        candidates: of `seek baseline`: violations that were tested on fresh seeds; null: mutants were sought.
        again: of `seek baseline`: flights flown again to see what the drone believed; null: mutants were sought.
        used: flights of the search, stored ones and those flown again included.
        flown: flights that this run flew.
        spent: whether the budget ended the search.
        needed: flights with which the search would have gone on; null: no budget of flights ended it.
        alpha: the study's, which the candidates of a mutant share; null: of `seek baseline`.
        anyhow: whether situations counted where the unmutated drone does not do its mission.
    """

    finds: tuple[Find, ...] = ()
    sought: tuple[Sought, ...] = ()
    breaks: tuple[Break, ...] = ()
    replicas: tuple[Replica, ...] = ()
    first: int | None = None
    situations: int | None = None
    broken: int | None = None
    candidates: int | None = None
    again: int | None = None
    used: int
    flown: int
    spent: bool = False
    needed: int | None = None
    alpha: float | None = None
    anyhow: bool = True


OTHER_SEEDS = 1_000_000
"""What PLACEBO's seeds are shifted by: it stands for the unmutated drone under seeds of its own."""


IDLE = 20
"""Turns without a new flight, after which a search without a budget ends."""


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
        needed: flights with which the search would go on; None before a budget of flights ends it.
    """

    def __init__(self, campaign: Run, allowance: Allowance, *, anyhow: bool = False) -> None:
        self._campaign, self._allowance, self.anyhow = campaign, allowance, anyhow
        noted = campaign.store.records(
            CANDIDATE, lambda one: (str(one["mutant"]), str(one["situation"]), one["number"])
        )
        self._candidates = {(mutant, situation): int(number) for mutant, situation, number in noted}
        self._budget = Budget(allowance.seconds)
        self._known: dict[str, Outcome | None] = {}
        self._unstored = 0
        self.needed: int | None = None
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
        flown = {  # PLACEBO is the baseline with another seed
            name: Flight(None, one.situation, one.seed + OTHER_SEEDS) if one.mutant == PLACEBO else one
            for name, one in new.items()
        }
        remember_search(self._campaign.store)
        self._campaign.plan(flown.values())
        self._campaign.fly(flown.values(), lambda flights: self._budget.while_it_lasts(self._campaign.arrange(flights)))
        self.raise_if_stopped()
        late = {one.name for one in self._campaign.missing(flown.values())} if self._budget.left_s <= 0.0 else set()
        outcomes = {outcome.name: outcome for outcome in self._campaign.outcomes(flown.values())}
        for name, flight in new.items():
            if flown[name].name in late:
                continue
            outcome = outcomes.get(flown[name].name)
            if outcome is not None and flight.mutant == PLACEBO:  # as if it were a flight that altered something
                outcome = replace(outcome, subject=flight.subject, seed=flight.seed, altered=1)
            self._known[name] = outcome
        if late:
            raise SpentError

    def take_turns(self, turn: Callable[[int], None], wanted: Callable[[], bool] = lambda: True) -> None:
        """Take turns, numbered from 1, as long as they are `wanted`, until `IDLE` of them bring no new flight.

        Raises:
            Interrupted, SpentError: as `fly`.
        """
        idle, numbers = 0, count(1)
        while wanted() and idle < IDLE:
            before = self.used
            turn(next(numbers))
            idle = idle + 1 if self.used == before else 0

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
        if self._allowance.flights is not None and self.used + count > self._allowance.flights:
            self.needed = self.used + count
            raise SpentError
        if self._budget.left_s <= 0.0:
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
        of_use = [
            one
            for one in baselines
            if one.name not in self._known or seeking.is_of_use(self._known[one.name], anyhow=self.anyhow)
        ]
        theirs = (Flight(mutant, one.situation, one.seed) for one in of_use for mutant in mutants)
        self.fly([*baselines, *theirs])

    def distance(self, mutant: Mutant, situation: Situation) -> float:
        """How far a situation is from showing a mutant, with the first seed of the search."""
        return seeking.distance(*self._pair(mutant, situation, SEEN_ON[0]), anyhow=self.anyhow)

    def shown_by(self, mutant: Mutant, situation: Situation) -> tuple[str, ...]:
        """The requirements by which a situation shows a mutant with every seed of the search."""
        pairs = (self._pair(mutant, situation, seed) for seed in SEEN_ON)
        first, *others = (seeking.shown_by(*pair, anyhow=self.anyhow) for pair in pairs)
        return tuple(name for name in first if all(name in names for names in others))

    def candidate(self, mutant: Mutant, situation: Situation) -> int:
        """Which candidate of the mutant a situation is, from 1, over all searches of the campaign.

        Raises:
            InputError: the store cannot be written.
        """
        place = mutant.id, situation.key
        if place not in self._candidates:  # a new one is remembered
            number = 1 + max((one for (other, _), one in self._candidates.items() if other == mutant.id), default=0)
            self._candidates[place] = number
            note = {"mutant": mutant.id, "situation": situation.key, "number": number}
            self._campaign.store.remember(CANDIDATE, note, " ".join(place))
        return self._candidates[place]

    def efforts(self) -> dict[str, Effort]:
        """How far the search came with each mutant, by id; without mutants that were not flown."""
        by_subject: dict[str, dict[str, Outcome]] = {}
        for outcome in self._known.values():
            if outcome is not None and outcome.seed == SEEN_ON[0]:
                by_subject.setdefault(outcome.mutant, {})[outcome.situation] = outcome
        baselines = by_subject.pop(BASELINE, {})
        return {
            mutant: seeking.effort_of(own.values(), baselines, anyhow=self.anyhow) for mutant, own in by_subject.items()
        }

    def _pair(self, mutant: Mutant, situation: Situation, seed: int) -> tuple[Outcome | None, Outcome | None]:
        return self.outcome(Flight(mutant, situation, seed)), self.outcome(Flight(None, situation, seed))


HEADER = """\
# Situations that `scaloft-fi seek` found, named for the grid that was searched.
#
# finds: each shows mutants: the mutant violates a safety requirement there that the unmutated drone holds.  Evidence:
# flights with the seeds 0, 1, ..., which the search never flew, by the score's own test; again: flights of
# `scaloft-fi seek --replicate`, with fresh seeds.
# `scaloft-fi run --grid NAME+found` flies them, NAME being the study's own grid.  They were chosen because of verdicts:
# a score that uses them is called selected.
#
# breaks: in each the unmutated drone violates a safety requirement in most of its flights with the seeds 0, 1, ...
# They put no mutant to the test, so NAME+found leaves them out.
"""
NAMED = "shows-"
"""The name of a find is this and the mutant that it was found for."""
DIGITS = 4
"""Significant digits of numbers."""


def saver(folder: Path, grid: str) -> Callable[[Sequence[Find]], None]:
    """Returns a function that writes the situations that show mutants, found by a search over `grid`.

    Finds of earlier searches stay, but for those of the same names.

    Args:
        folder: the study's `sim` folder.
        grid: name of the grid that is searched.

    Raises:
        InputError: the file that is there cannot be read, or has finds of another grid.
    """
    earlier = _earlier(folder, grid)

    def save(finds: Sequence[Find]) -> None:
        told = [find for find in finds if find.mutant != PLACEBO_ID]  # a false find is told, and flown by nobody
        _write(folder, replace(earlier, finds=_merged(earlier.finds, told)))

    return save


def break_saver(folder: Path, grid: str) -> Callable[[Sequence[Break]], None]:
    """Returns a function that writes the situations that break the unmutated drone; all else is as for `saver`."""
    earlier = _earlier(folder, grid)
    return lambda breaks: _write(folder, replace(earlier, breaks=_merged(earlier.breaks, breaks)))


def keep(folder: Path, grid: str, finds: Sequence[Find]) -> None:
    """Write these situations that show mutants in the place of all that the file has.

    Raises:
        InputError: as `saver`.
    """
    _write(folder, replace(_earlier(folder, grid), finds=tuple(finds)))


def holding(finds: Sequence[Find], replicas: Sequence[Replica]) -> tuple[Find, ...]:
    """The finds after a replication: without the mutants that did not hold; what was not replicated or decided stays.

    A find whose own mutant did not hold is named for the first one that did, unless that name is taken.
    """
    told = {(one.find, one.mutant): one for one in replicas}
    taken = {find.name for find in finds}
    kept = []
    for find in finds:
        shows = {
            mutant: replace(evidence, again=replica.again) if replica and replica.holds else evidence
            for mutant, evidence in find.shows.items()
            if (replica := told.get((find.name, mutant))) is None or replica.holds is not False
        }
        if not shows:
            continue
        mutant = find.mutant if find.mutant in shows else next(iter(shows))
        name = NAMED + mutant
        same = mutant == find.mutant or name in taken
        taken.add(name)
        kept.append(replace(find, name=find.name if same else name, mutant=mutant, shows=shows))
    return tuple(sorted(kept, key=lambda find: find.name))


def _earlier(folder: Path, grid: str) -> Finds:
    earlier = read_finds(folder) or Finds(grid, ())
    if earlier.grid != grid:
        sentence = f"{folder / FOUND_FILE}: grid={earlier.grid!r} must be {grid!r}, the grid that is searched"
        raise InputError(f"{sentence}; move the file away to begin another one")
    return earlier


def _write(folder: Path, finds: Finds) -> None:
    write_own(folder / FOUND_FILE, text(finds).encode())


_Named = TypeVar("_Named", Find, Break)


def _merged(earlier: Sequence[_Named], newer: Sequence[_Named]) -> tuple[_Named, ...]:
    """All of them in the order of their names."""
    by_name = {one.name: one for one in chain(earlier, newer)}
    return tuple(by_name[name] for name in sorted(by_name))


def words_of(situation: Situation, grid: Grid) -> tuple[str, ...]:
    """The values of a situation that are not benign, in words."""
    numbers = dict(situation.numbers)
    values = grid.values(situation).items()
    return tuple(value.title for axis, value in values if axis in numbers or value.id != 0)


def text(finds: Finds) -> str:
    """The content of the file."""
    plain = {
        "grid": finds.grid,
        "finds": {find.name: _plain(find) for find in finds.finds},
        "breaks": {one.name: _broken(one) for one in finds.breaks},
    }
    dumped: str = yaml.safe_dump(plain, sort_keys=False, allow_unicode=False, width=110)
    return f"{HEADER}\n{dumped}"


def _plain(find: Find) -> dict[str, Any]:
    shows = {mutant: _short(asdict(evidence)) for mutant, evidence in find.shows.items()}
    return {
        "situation": find.situation,
        "words": list(find.words),
        "mutant": find.mutant,
        "seed": find.seed,
        "shows": shows,
    }


def _broken(one: Break) -> dict[str, Any]:
    values = asdict(one) | {"words": list(one.words), "place": [float(f"{metres:.3f}") for metres in one.place]}
    return {key: value for key, value in _short(values).items() if key != "name"}


def _short(values: dict[str, Any]) -> dict[str, Any]:
    """Floats with few digits; what is empty left out."""
    short = {key: float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value for key, value in values.items()}
    short |= {key: _short(value) for key, value in values.items() if isinstance(value, dict)}
    return {key: value for key, value in short.items() if value not in ("", None)}


FRESH, BLOCK = 100_000, 100
"""First seed of the first replication, and how far the next ones are apart."""
REPLICATION_BEGUN, REPLICATION_ENDED = "replication begun", "replication ended"
"""Prefixes of the names of the notes."""

Ask = Mapping[str, Sequence[str]]
"""The mutants that are replicated, by name of the find."""


def replicate(
    study: Study,
    finds: Sequence[Find],
    ask: Ask,
    folder: Path,
    options: RunOptions = ONE_PROCESS,
    *,
    progress: Progress,
    flyer: Flyer | None = None,
    anyhow: bool = False,
) -> SeekReport:
    """Fly pairs of find and mutant on fresh seeds.

    Args:
        study: the study, with the grid that was searched.
        finds: all finds of the study.
        ask: the pairs that are replicated.
        folder: folder of the campaign that holds the flights.
        options: options of the run.
        progress: progress display.
        flyer: flies; PyBullet when None.
        anyhow: whether a pair may hold where the unmutated drone does not do its mission.

    Raises:
        GateError: more flights are invalid than the options allow; nothing is decided.
        InputError: the folder or the store cannot be written, a find does not fit the study, or it cannot be flown.
        Interrupted: the user stopped the replication; all outcomes are saved.
    """
    asked = [find for find in finds if ask.get(find.name)]
    situations = {find.name: study.grid.situation(find.situation) for find in asked}
    mutants = {mutant: realise(study.matrix, mutant) for find in asked for mutant in ask[find.name]}
    begun = [Flight(None, situation, FRESH) for situation in situations.values()]
    with searching(study, folder, options, progress=progress, flyer=flyer, first=begun[:1]) as campaign:
        number = _begin(campaign.store, {find.name: list(ask[find.name]) for find in asked}, _block(finds, folder))
        first = FRESH + BLOCK * number
        seeds, flights = range(first, first + seeking.SEEDS), SearchFlights(campaign, Allowance(), anyhow=anyhow)
        progress.stage = f"{sum(map(len, ask.values()))} pairs of find and mutant, seeds from {first}"
        pools = {
            situation: [Flight(None, situation, first + seed) for seed in range(seeking.POOL)]
            for situation in situations.values()
        }
        pairs: dict[Place, list[Flight]] = {
            (find.name, mutant): [Flight(mutants[mutant], situations[find.name], seed) for seed in seeds]
            for find in asked
            for mutant in ask[find.name]
        }
        every = [flight for some in (*pools.values(), *pairs.values()) for flight in some]
        flights.fly(every)
        broken = [one for flight in every if (one := flights.outcome(flight)) is not None and one.invalid]
        if len(broken) > options.max_invalid * len(every):
            raise GateError(
                f"gate failed: {len(broken)} of {len(every)} flights are invalid, more than {options.max_invalid:.0%}: "
                f"{broken[0].name} ({broken[0].invalid}); nothing is decided, and sim/{FOUND_FILE} stays as it was; "
                "the same command flies them again"
            )
        if not broken:
            campaign.store.remember(REPLICATION_ENDED, number, number)

        def outcomes(wanted: Sequence[Flight]) -> list[Outcome]:
            return [outcome for flight in wanted if (outcome := flights.outcome(flight)) is not None]

        told = replicas(
            asked,
            {place: outcomes(some) for place, some in pairs.items()},
            {situation.key: outcomes(some) for situation, some in pools.items()},
            first,
            study.alpha,
            anyhow=anyhow,
        )
        return SeekReport(
            replicas=told, first=first, used=flights.used, flown=campaign.flown, alpha=study.alpha, anyhow=anyhow
        )


def _block(finds: Sequence[Find], folder: Path) -> int:
    """The first block of seeds that no replication of these finds used, nor one of a campaign beside `folder`."""
    used = [evidence.again.seed for find in finds for evidence in find.shows.values() if evidence.again]
    numbers = {(seed - FRESH) // BLOCK for seed in used}
    for path in folder.parent.glob(f"*/{STORE_NAME}"):
        with suppress(InputError), read_store(path) as store:  # one that cannot be read was written by another version
            numbers |= set(_begun(store)) if store is not None and path.parent != folder else set()
    return max(numbers, default=-1) + 1


def _begun(store: Store) -> dict[int, Any]:
    """What each replication that began asked for, by its number."""
    return dict(store.records(REPLICATION_BEGUN, lambda one: (int(one["number"]), one["ask"])))


def _begin(store: Store, ask: Ask, least: int) -> int:
    """The number of the replication: that of the last one if it did not end and asked for the same, else a new one."""
    begun = _begun(store)
    last = max(begun, default=None)
    if last is not None and last not in store.records(REPLICATION_ENDED, int) and begun[last] == ask:
        return last
    number = least if last is None else max(least, last + 1)
    store.remember(REPLICATION_BEGUN, {"number": number, "ask": ask}, number)
    return number
