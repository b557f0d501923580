"""The arms of the experiment on search and chance, the mutants of its blocks, and one search.

What proposes the situations after the opening is an arm; the opening is `seek`'s and the same in all of them.  The
array of pairs is a covering array of strength 2 over the values of a grid's axes and the bins of its free axes: a free
axis has three bins of equal probability.  Two of them are its benign value, as in a random draw (`FreeAxis.drawn`), so
the arms that leave the choice to chance are off the benign values about equally often.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from importlib import import_module
from itertools import count, islice
from pathlib import Path
from typing import Any

from experiments import PUBLISHED
from experiments.flights import Row, counted, outcomes, read_lines, write_lines
from experiments.wide import POOL, SEEDS
from scaloft_fi.analysis.score import score
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.seeking import seek as proposals
from scaloft_fi.campaign.seeking.finds import Allowance
from scaloft_fi.campaign.seeking.seek import MakeProposer, Parameters, Possible, Proposal, Proposer, at_shares, seek
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.sim.grid import Evidence, Grid
from scaloft_fi.sim.situation import DEVIATES, Situation
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study

BINS = round(1 / DEVIATES)
OFF = BINS - 1
"""The bin off the benign value."""
STRENGTH = 2
Bins = dict[str, int]
"""The value of each axis, and the bin of each free axis."""
Share = Callable[[str, str], float]
"""The share 0 <= share < 1 of an axis' `level` or `number`, as `at_shares` takes it."""


def array(grid: Grid, seed: int, number: int) -> Iterator[Share]:
    """The shares of the situations of an array that has every pair of values and bins that some situation has.

    Args:
        grid: the grid.
        seed: seed of the search.
        number: which array of the search; each breaks ties in its own way.
    """
    sizes = {axis.id: len(axis.values) for axis in grid.axes}

    def share(place: int, row: Bins, axis: str, what: str) -> float:
        if what == "level":
            return (row[axis] + 0.5) / sizes[axis]
        inside = (key_words("search or chance", "2-way", seed, number, place, axis)[0] >> 11) / 2**53
        return min((row[axis] + inside) / BINS, 1 - 2**-53)

    return (partial(share, place, row) for place, row in enumerate(pair_rows(grid, f"{seed}-{number}")))


def pair_rows(grid: Grid, salt: str) -> list[Bins]:
    """The rows of an array; the salt breaks its ties."""
    factors = {axis.id: list(range(len(axis.values))) for axis in grid.axes}
    factors |= {axis.id: list(range(BINS)) for axis in grid.free}
    make = import_module("covertable").make
    rows: list[Bins] = make(factors, strength=STRENGTH, salt=salt, tolerance=0, constraints=list(_constraints(grid)))
    return rows


def _constraints(grid: Grid) -> Iterator[dict[str, Any]]:
    """In the library's words: no excluded combination, and a free axis off its benign value only where it may be."""
    for constraint in grid.constraints:
        axes = [(axis, constraint.excluded[axis.id]) for axis in grid.axes if axis.id in constraint.excluded]
        yield _any(_is(axis.id, value.id) for axis, out in axes for value in axis.values if value.id not in out)
    for free in grid.free:
        for other, values in free.only_with.items():
            yield _any([{**_is(free.id, OFF), "operator": "ne"}, *(_is(other, value) for value in sorted(values))])


def _any(conditions: Iterable[dict[str, Any]]) -> dict[str, Any]:
    return {"operator": "or", "conditions": list(conditions)}


def _is(axis: str, value: int) -> dict[str, Any]:
    return {"operator": "eq", "left": axis, "value": value}


MOST_LOG2 = 8
"""The low-discrepancy sequence ends after 2^8 points; no budget of the experiment reaches that."""
Shares = Callable[["Grid", int], Iterator[Share]]
"""The shares of each situation that an arm proposes, from the grid and the seed of the search."""


@dataclass
class Listed:
    """Proposes for one mutant, whatever the distances, the next situations of a list that its block shares."""

    left: Iterator[Proposal]
    nearest: float = proposals.IMPOSSIBLE
    count: int = 0

    def ask(self, count: int) -> list[Proposal]:
        """The next situations; fewer at the end of the list."""
        return list(islice(self.left, count))

    def tell(self, distances: Sequence[tuple[Proposal, float]]) -> None:
        """Tell the distances; they change no proposal."""
        self.count += len(distances)
        self.nearest = min([self.nearest, *(distance for _, distance in distances)])


@dataclass
class Chance:
    """Makes the proposers of one search, which share one list.

    Attributes:
        shares: what the list is made from.
    """

    shares: Shares
    _list: Iterator[Proposal] | None = None

    def __call__(self, grid: Grid, possible: Possible, seed: int, _mutant: str) -> Proposer:
        """The proposer of a mutant."""
        self._list = self._list or _distinct(grid, possible, seed, self.shares)
        return Listed(self._list)


def _distinct(grid: Grid, possible: Possible, seed: int, shares: Shares) -> Iterator[Proposal]:
    """Situations that can be flown, each once."""
    known: set[Situation] = set()
    for share in shares(grid, seed):
        parameters = with_ends(grid, share)
        situation = proposals.placed(grid, parameters)
        if situation is not None and situation not in known and possible(situation):
            known.add(situation)
            yield Proposal(situation, parameters)


def with_ends(grid: Grid, share: Share) -> Parameters:
    """The parameters at shares, half of the numbers off their benign values at an end of their range.

    So it is in the opening, but here a number follows from one share, and the greater from the greater.
    """

    def ended(axis: str, what: str) -> float:
        drawn = share(axis, what)
        inside = ((drawn - 1 + DEVIATES) / DEVIATES - (1 - proposals.EDGES) / 2) / proposals.EDGES
        if what == "level" or drawn < 1 - DEVIATES:
            return drawn
        return min(1 - DEVIATES + DEVIATES * max(inside, 0.0), 1 - 2**-53)

    return at_shares(grid, ended)


def _at_random(_grid: Grid, seed: int) -> Iterator[Share]:
    """Each share at random."""

    def share(number: int, axis: str, what: str) -> float:
        return (key_words("search or chance", "random", seed, number, axis, what)[0] >> 11) / 2**53

    return (partial(share, number) for number in count())


def _low_discrepancy(grid: Grid, seed: int) -> Iterator[Share]:
    """A scrambled Sobol sequence over a level for each axis, and a share for each number."""
    from scipy.stats import qmc  # takes longer to import than the plan takes

    asked = [*((axis.id, "level") for axis in grid.axes), *((axis.id, "number") for axis in grid.free)]
    columns = {what: place for place, what in enumerate(asked)}
    sequence = qmc.Sobol(len(columns), scramble=True, seed=key_words("search or chance", "sobol", seed)[0])
    for point in sequence.random_base2(MOST_LOG2).tolist():
        yield lambda axis, what, point=point: point[columns[axis, what]]  # type: ignore[misc]


def _pairwise(grid: Grid, seed: int) -> Iterator[Share]:
    """Arrays of all pairs, one after the other."""
    for number in count():
        yield from array(grid, seed, number)


SEARCH = "seek"
ARMS: Mapping[str, Callable[[], MakeProposer]] = {
    SEARCH: lambda: proposals.Proposals,
    "random": partial(Chance, _at_random),
    "low-discrepancy": partial(Chance, _low_discrepancy),
    "2-way": partial(Chance, _pairwise),
}
"""What makes the proposers of one search, by arm."""


FILE = PUBLISHED / "search_or_chance_blocks.txt"
FEWEST, MOST = 2, 4
"""Mutants of a block."""
Block = tuple[str, ...]
"""Ids of the mutants of a block, which have one parameter and are sought together."""


def survivors(study: Study, rows: Iterable[Row]) -> list[str]:
    """Defaults that no safety requirement detects in the published flights, with three seeds and a pool of ten.

    Args:
        study: the study.
        rows: the published flights.

    Returns:
        Ids in the order of the matrix.
    """
    some = counted(rows, study.roster.defaults.values(), SEEDS, POOL)
    scored = score(outcomes(study, some), study.roster, study.space).mutants
    detected = {mutant.subject.id for mutant in scored if mutant.detected}
    return [id_ for id_ in study.roster.defaults.values() if id_ not in detected]


def at_risk(study: Study, ids: Iterable[str]) -> list[str]:
    """Those of the defaults whose cell names a safety requirement."""
    safety = {requirement.name for requirement in study.requirements if requirement.kind is Kind.SAFETY}
    named = {study.roster.defaults.get(cell.name) for cell in study.matrix if safety & set(cell.requirements)}
    return [id_ for id_ in ids if id_ in named]


def blocks_of(study: Study, ids: Iterable[str]) -> list[Block]:
    """The blocks, in the order of the ids: of each parameter with two of them or more, four at most, drawn by key."""
    parameters: dict[str, list[str]] = {}
    for id_ in ids:
        parameters.setdefault(realise(study.matrix, id_).parameter, []).append(id_)
    drawn = [
        sorted(own, key=lambda id_: key_words("search or chance", id_))[:MOST]
        for own in parameters.values()
        if len(own) >= FEWEST
    ]
    return [tuple(sorted(block, key=parameters[realise(study.matrix, block[0]).parameter].index)) for block in drawn]


def read_blocks() -> Sequence[Block]:
    """The blocks of the committed file."""
    return [tuple(line.split()) for line in FILE.read_text(encoding="utf-8").splitlines()]


@dataclass(frozen=True)
class Sought:
    """What a search for one mutant came to.

    Attributes:
        mutant: its id.
        shown_in: key of the situation that shows it; empty where none was found.
        after: flights of the search when it was found; 0 where it was not.
        evidence: of fresh seeds; None where it was not found.
        candidates: situations that were tested on fresh seeds.
    """

    mutant: str
    shown_in: str
    after: int
    evidence: Evidence | None
    candidates: int


@dataclass(frozen=True)
class Search:
    """A search.

    Attributes:
        block: number of the block, from 1.
        arm: what proposed the situations.
        seed: of the search.
        budget: flights that it was allowed.
        used: flights that it asked for.
        sought: the mutants of the block.
        opening: keys of the situations of the opening.
        proposed: keys of those that the arm proposed; the last may have been too many for the budget.
    """

    block: int
    arm: str
    seed: int
    budget: int
    used: int
    sought: tuple[Sought, ...]
    opening: tuple[str, ...]
    proposed: tuple[str, ...]


FIRST_SEED = 1901
"""Seed of the searches of the first block; each block has the next one."""


def seed_of(block: int) -> int:
    """The seed of the searches of a block, which are numbered from 1."""
    return FIRST_SEED + block - 1


def search(study: Study, number: int, mutants: Block, arm: str, folder: Path, *, budget: int, jobs: int) -> Search:
    """Search with an arm for the mutants of a block; nothing is shrunk, nor written into the study.

    Args:
        study: the study, with the grid that is searched.
        number: of the block.
        mutants: ids of its mutants.
        arm: name of the arm.
        folder: of the campaign that holds the flights of all arms of the block; stored flights are not flown again.
        budget: flights, stored ones included.
        jobs: number of processes.

    Raises:
        Interrupted: the user stopped the search; all outcomes are saved.
    """
    make, proposed, opened = ARMS[arm](), dict[str, None](), list[Proposal]()
    seed, progress = seed_of(number), Progress()
    progress.line(f"block {number}, {arm}: {', '.join(mutants)}")

    def proposer(grid: Grid, possible: Possible, own: int, mutant: str) -> Proposer:
        made = make(grid, possible, own, mutant)
        ask = made.ask

        def noted(count: int) -> list[Proposal]:
            asked = ask(count)
            proposed.update(dict.fromkeys(one.situation.key for one in asked))
            return asked

        made.ask = noted  # type: ignore[method-assign]
        return made

    def first(grid: Grid, own: int, possible: Possible) -> list[Proposal]:
        opened[:] = proposals.opening(grid, own, possible)
        return opened

    report = seek(
        study,
        [realise(study.matrix, mutant) for mutant in mutants],
        folder,
        RunOptions(jobs=jobs),
        seed=seed,
        allowance=Allowance(flights=budget),
        progress=progress,
        save=lambda _finds: None,
        proposer=proposer,
        first=first,
        shrinks=False,
        anyhow=True,
    )
    shows = {mutant: evidence for find in report.finds for mutant, evidence in find.shows.items()}
    sought = tuple(
        Sought(one.mutant, one.shown_in, one.after, shows.get(one.mutant), one.candidates) for one in report.sought
    )
    keys = tuple(one.situation.key for one in opened)
    return Search(number, arm, seed, budget, report.used, sought, keys, tuple(proposed))


def read_searches(path: Path) -> list[Search]:
    """The searches of a file; none if there is no file."""
    return list(map(_search, read_lines(path)))


def write_searches(path: Path, searches: Iterable[Search]) -> None:
    """Write the file anew and replace the old one at once; equal searches give equal bytes, whatever their order."""
    ordered = sorted(searches, key=lambda one: (one.block, one.arm, one.budget))
    write_lines(path, map(asdict, ordered))


def _search(row: Mapping[str, Any]) -> Search:
    keys = {name: tuple(row[name]) for name in ("opening", "proposed")}
    return Search(**{**row, **keys, "sought": tuple(map(_sought, row["sought"]))})


def _sought(row: Mapping[str, Any]) -> Sought:
    return Sought(**{**row, "evidence": Evidence(**({"mission": 0} | row["evidence"])) if row["evidence"] else None})
