"""One search: an arm, with the mutants of a block; and the file of searches, one line of JSON for each."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments.search_or_chance.proposers import ARMS
from scaloft_fi.campaign.flights.fly import Flyer
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.seeking.finds import Allowance
from scaloft_fi.campaign.seeking.proposals import Possible, Proposal, Proposer, opening
from scaloft_fi.campaign.seeking.seek import seek
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.output import write_whole
from scaloft_fi.sim.found import Evidence
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid


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


@dataclass
class Noted:
    """A proposer whose proposals are noted, each once."""

    proposer: Proposer
    keys: dict[str, None]

    def ask(self, count: int) -> list[Proposal]:
        """As the proposer."""
        asked = self.proposer.ask(count)
        self.keys |= dict.fromkeys(one.situation.key for one in asked)
        return asked

    def tell(self, distances: Sequence[tuple[Proposal, float]]) -> None:
        """As the proposer."""
        self.proposer.tell(distances)

    @property
    def nearest(self) -> float:
        """As the proposer."""
        return self.proposer.nearest

    @property
    def count(self) -> int:
        """As the proposer."""
        return self.proposer.count


def search(
    study: Study,
    number: int,
    mutants: Sequence[str],
    arm: str,
    folder: Path,
    *,
    seed: int,
    budget: int,
    jobs: int,
    progress: Progress,
    flyer: Flyer | None = None,
) -> Search:
    """Search with an arm for the mutants of a block; nothing is shrunk, nor written into the study.

    Args:
        study: the study, with the grid that is searched.
        number: of the block.
        mutants: ids of its mutants.
        arm: name of the arm.
        folder: of the campaign that holds the flights of all arms of the block; stored flights are not flown again.
        seed: of the search.
        budget: flights, stored ones included.
        jobs: number of processes.
        progress: progress display.
        flyer: flies; PyBullet when None.

    Raises:
        Interrupted: the user stopped the search; all outcomes are saved.
    """
    make, proposed, opened = ARMS[arm](), dict[str, None](), list[Proposal]()

    def proposer(grid: Grid, possible: Possible, own: int, mutant: str) -> Proposer:
        return Noted(make(grid, possible, own, mutant), proposed)

    def first(grid: Grid, own: int, possible: Possible) -> list[Proposal]:
        opened[:] = opening(grid, own, possible)
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
        flyer=flyer,
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
    if not path.exists():
        return []
    with gzip.open(path, "rt", encoding="utf-8") as lines:
        return [_search(json.loads(line)) for line in lines]


def write_searches(path: Path, searches: Iterable[Search]) -> None:
    """Write the file anew and replace the old one at once; equal searches give equal bytes, whatever their order."""
    ordered = sorted(searches, key=lambda one: (one.block, one.arm, one.budget))
    content = "".join(f"{json.dumps(asdict(one), allow_nan=False)}\n" for one in ordered)
    write_whole(path, gzip.compress(content.encode(), mtime=0))


def _search(row: Mapping[str, Any]) -> Search:
    keys = {name: tuple(row[name]) for name in ("opening", "proposed")}
    return Search(**{**row, **keys, "sought": tuple(map(_sought, row["sought"]))})


def _sought(row: Mapping[str, Any]) -> Sought:
    return Sought(**{**row, "evidence": Evidence(**({"mission": 0} | row["evidence"])) if row["evidence"] else None})
