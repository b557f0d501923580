"""Does search beat chance?  `seek` beside random, low-discrepancy and 2-way situations, at equal flights.

    python -m experiments.search_or_chance [--jobs N] [--output FILE]

Flies the searches for the blocks of `search_or_chance_blocks.txt`, one after the other: campaigns in
`results/campaigns/search_or_chance` hold their flights, and finished searches are kept beside the page, in
`search_or_chance_searches.jsonl.gz`, so the same command goes on where it stopped.  Delete both after a change of the
study or of the code.  New flights are published in `search_or_chance_flights.jsonl.gz`.
"""

from __future__ import annotations

import experiments.published_kernels  # noqa: F401 - it must be imported before numpy

# isort: split

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from itertools import product
from pathlib import Path
from statistics import mean

import numpy as np

from experiments import ROOT, search_arms
from experiments import flights as kept_flights
from experiments.flights import stored
from experiments.pages import Row, blocks, table, write
from experiments.search_arms import ARMS, SEARCH, Block, Search, Sought, seed_of
from scaloft_fi.analysis.detection import holm
from scaloft_fi.analysis.seeking import distance
from scaloft_fi.campaign.seeking.finds import SEEN_ON
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.streams import generator
from scaloft_fi.study import Study

LEVEL = 0.05
"""Two-sided p at which arms differ."""
REDRAWS = 2_000
"""How often the blocks are drawn again."""
Counts = Sequence[Sequence[int]]
"""By block the number of mutants that each arm newly detects, the search first."""


class Answer(StrEnum):
    """What rule 1 says of the search."""

    BETTER = "yes"
    WORSE = "no, chance finds more"
    NO_DIFFERENCE = "no difference is shown"


def exact_p(counts: Counts) -> float:
    """Two-sided p of the first arm's total.

    If what proposes the situations makes no difference, each arm's count in a block might as well be the first arm's,
    whatever the other blocks have.  p is the share of all such choices whose total is as far from their mean.

    >>> exact_p([(1, 0)] * 5), exact_p([(1, 1, 1), (0, 0, 0)]), exact_p([(1, 0, 0)])
    (0.0625, 1.0, 0.3333333333333333)
    """
    ways = {0: 1}
    for block in counts:
        after: dict[int, int] = {}
        for (own, arms), (total, number) in product(Counter(_deviations(block)).items(), ways.items()):
            after[total + own] = after.get(total + own, 0) + arms * number
        ways = after
    seen = abs(sum(_deviations(block)[0] for block in counts))
    return sum(number for total, number in ways.items() if abs(total) >= seen) / sum(ways.values())


def _deviations(block: Sequence[int]) -> list[int]:
    """Each arm's count less the mean of all, times the number of arms."""
    return [len(block) * own - sum(block) for own in block]


def totals(counts: Counts) -> list[int]:
    """By arm the number of mutants over all blocks."""
    return [sum(arm) for arm in zip(*counts, strict=True)]


def answer(counts: Counts) -> tuple[Answer, float]:
    """What rule 1 says, and its p."""
    p = exact_p(counts)
    own, *others = totals(counts)
    if p <= LEVEL and own > max(others):
        return Answer.BETTER, p
    if p <= LEVEL and own < mean(others):
        return Answer.WORSE, p
    return Answer.NO_DIFFERENCE, p


def beside_each(counts: Counts) -> list[float]:
    """By other arm the p of the first arm beside it, adjusted by Holm."""
    ps = {other: exact_p([(block[0], block[other]) for block in counts]) for other in range(1, len(counts[0]))}
    return list(holm(ps).values())


def redrawn(counts: Counts, redraws: int = REDRAWS) -> list[tuple[int, int]]:
    """What the first arm has more than each of the others: the middle nine tenths, blocks drawn again."""
    rng = generator("search or chance", "blocks")
    more = np.array([[block[0] - other for other in block[1:]] for block in counts])
    drawn = np.array([more[rng.integers(len(more), size=len(more))].sum(axis=0) for _ in range(redraws)])
    low, high = np.quantile(drawn, (0.05, 0.95), axis=0, method="nearest")
    return list(zip(low.tolist(), high.tolist(), strict=True))


def share(holds: Iterable[bool]) -> float:
    """The share that holds; 0 of nothing."""
    return mean(listed) if (listed := [*map(float, holds)]) else 0.0


BUDGET = 60
"""Flights of a search for each of its mutants; a search is an arm with the mutants of a block."""
UNFINISHED = "Searches are missing, or the arms of a block differ in the opening: the rule is not decided."
STEPS = 5
"""Rows of the table of mutants detected after so many flights."""


@dataclass(frozen=True)
class Evidence:
    """What was flown.

    Attributes:
        blocks: the mutants of each block.
        searches: the searches.
        flights: their flights by name.
        budget: flights of a search for each of its mutants.
    """

    blocks: Sequence[Block]
    searches: Sequence[Search]
    flights: Mapping[str, Outcome]
    budget: int = BUDGET

    @cached_property
    def by_place(self) -> Mapping[tuple[int, str], Search]:
        """The searches that were planned, by block and arm."""
        planned = {(n, seed_of(n), self.budget * len(block), block) for n, block in enumerate(self.blocks, 1)}
        return {
            (one.block, one.arm): one
            for one in self.searches
            if (one.block, one.seed, one.budget, tuple(sought.mutant for sought in one.sought)) in planned
        }

    def of(self, arm: str) -> list[Search]:
        """The searches of an arm, block by block."""
        return [one for (_, own), one in sorted(self.by_place.items(), key=lambda entry: entry[0]) if own == arm]

    def in_opening(self, block: int, arm: str) -> frozenset[tuple[str, str]]:
        """The mutants of a search that situations of the opening show, with the situation."""
        search = self.by_place[block, arm]
        return frozenset((one.mutant, one.shown_in) for one in search.sought if one.shown_in in search.opening)

    def after_opening(self, arm: str) -> list[tuple[str, str]]:
        """The situations that an arm proposed, each with the mutants that were flown there."""
        every = ((sought.mutant, key) for one in self.of(arm) for key in one.proposed for sought in one.sought)
        return [(mutant, key) for mutant, key in every if _flight(mutant, key) in self.flights]

    @property
    def complete(self) -> bool:
        """Whether the rule may be decided."""
        numbers = range(1, len(self.blocks) + 1)
        return (
            self.budget == BUDGET
            and self.by_place.keys() == {(block, arm) for block in numbers for arm in ARMS}
            and all(len({self.in_opening(block, arm) for arm in ARMS}) == 1 for block in numbers)
        )

    @cached_property
    def counts(self) -> Counts:
        """By block the number of mutants that each arm detects."""
        return [
            [sum(bool(one.shown_in) for one in self.by_place[block, arm].sought) for arm in ARMS]
            for block in range(1, len(self.blocks) + 1)
        ]

    def shows(self, mutant: str, situation: str) -> bool:
        """Whether a situation shows a mutant with the first seed of the search."""
        theirs, own = (self.flights.get(_flight(subject, situation)) for subject in (BASELINE, mutant))
        return distance(own, theirs, anyhow=True) < 0.0


def _flight(subject: str, situation: str) -> str:
    """Name of the flight with the first seed of the search."""
    return f"{subject}/{situation}/{SEEN_ON[0]}"


def flown(evidence: Evidence, redraws: int = REDRAWS) -> str:
    """The section with the results."""
    return blocks(
        "## Flown",
        _told(evidence),
        _decided(evidence, redraws) if evidence.complete else UNFINISHED,
        "### Arms",
        table(("", *ARMS), _arms(evidence)),
        "### Mutants detected after so many flights for each mutant of the block",
        table(("flights", *ARMS), _curve(evidence)),
        "### Blocks",
        table(("block", *ARMS), _blocks(evidence)),
        "### Mutants",
        "Flights of the search after which a mutant was detected: requirement, violating of the confirming flights.",
        table(("block", "mutant", *ARMS), _mutants(evidence)),
    )


def _told(evidence: Evidence) -> str:
    used = sum(one.used for one in evidence.by_place.values())
    invalid = sum(bool(outcome.invalid) for outcome in evidence.flights.values())
    seconds = sum(outcome.duration_s for outcome in evidence.flights.values())
    return (
        f"{len(evidence.by_place)} of {len(evidence.blocks) * len(ARMS)} searches asked for {used:,} flights: "
        f"{len(evidence.flights):,} different ones of {seconds:,.0f} simulated s, {invalid} of them invalid."
    )


def _decided(evidence: Evidence, redraws: int) -> Iterator[str]:
    told, p = answer(evidence.counts)
    own, *others = totals(evidence.counts)
    mutants = sum(map(len, evidence.blocks))
    listed = ", ".join(f"{name} {number}" for name, number in zip(list(ARMS)[1:], others, strict=True))
    yield f"**Rule 1: {told.value}.**  `{SEARCH}` newly detects {own} of {mutants} mutants; {listed}.  p = {p:.2g}."
    yield ""
    named = zip(list(ARMS)[1:], others, redrawn(evidence.counts, redraws), beside_each(evidence.counts), strict=True)
    rows = []
    for name, number, (low, high), beside in named:
        rows.append((name, own - number, f"{low:+g} to {high:+g}", f"{beside:.2g}"))
    yield from table((f"`{SEARCH}` beside", "more mutants", "blocks drawn again", "p (Holm)"), rows)


def _arms(evidence: Evidence) -> Iterator[Row]:
    sought = {arm: [one for search in evidence.of(arm) for one in search.sought] for arm in ARMS}

    def row(name: str, value: Callable[[str], object]) -> Row:
        return (name, *map(value, ARMS))

    def later(arm: str) -> list[bool]:
        return [evidence.shows(mutant, key) for mutant, key in evidence.after_opening(arm)]

    def opened(arm: str) -> int:
        return sum(len(evidence.in_opening(search.block, arm)) for search in evidence.of(arm))

    yield row("flights asked for", lambda arm: sum(search.used for search in evidence.of(arm)))
    yield row("newly detected", lambda arm: sum(bool(one.shown_in) for one in sought[arm]))
    yield row("- by situations of the opening", opened)
    yield row(
        "situations after the opening, that show a mutant of those flown there",
        lambda arm: f"{100 * share(later(arm)):.1f} % of {len(later(arm))}",
    )
    yield row("candidates", lambda arm: sum(one.candidates for one in sought[arm]))


def _curve(evidence: Evidence) -> Iterator[Row]:
    """By number of flights for each mutant of the block the mutants that each arm detected after no more."""
    after = {arm: [one.after / len(own.sought) for own in evidence.of(arm) for one in own.sought] for arm in ARMS}
    for step in range(1, STEPS + 1):
        flights = evidence.budget * step // STEPS
        yield (flights, *(sum(0 < each <= flights for each in after[arm]) for arm in ARMS))


def _blocks(evidence: Evidence) -> Iterator[Row]:
    for number in range(1, len(evidence.blocks) + 1):
        own = [evidence.by_place.get((number, arm)) for arm in ARMS]
        yield (number, *("" if one is None else sum(bool(s.shown_in) for s in one.sought) for one in own))


def _mutants(evidence: Evidence) -> Iterator[Row]:
    for number, block in enumerate(evidence.blocks, 1):
        for place, mutant in enumerate(block):
            own = [evidence.by_place.get((number, arm)) for arm in ARMS]
            yield (number, mutant, *("" if one is None else _words(one.sought[place]) for one in own))


def _words(sought: Sought) -> str:
    told = sought.evidence
    return f"{sought.after}: {told.requirement} {told.violated}/{told.flights}" if told else "-"


CAMPAIGNS = ROOT / "results" / "campaigns" / "search_or_chance"
SEARCHES, FLIGHTS = "search_or_chance_searches.jsonl.gz", "search_or_chance_flights.jsonl.gz"
GRID = "search"
KEPT = "all arms"
"""Name in the file of flights: arms share flights."""


def fly(study: Study, blocks: Sequence[Block], campaigns: Path, path: Path, jobs: int) -> list[Search]:
    """Fly the searches that the file lacks; returns all searches of the file.

    Args:
        study: the study, with the grid that is searched.
        blocks: the mutants of each block.
        campaigns: folder with a campaign for each block.
        path: the file of searches.
        jobs: number of processes.
    """
    searches = search_arms.read_searches(path)
    done = {(one.block, one.arm, one.budget) for one in searches}
    for number, mutants in enumerate(blocks, 1):
        flights, folder = BUDGET * len(mutants), campaigns / f"{number:02}"
        for arm in ARMS:
            if (number, arm, flights) not in done:
                searches.append(search_arms.search(study, number, mutants, arm, folder, budget=flights, jobs=jobs))
                search_arms.write_searches(path, searches)
    return searches


def flights_in(study: Study, campaigns: Path, blocks: int) -> Mapping[str, Outcome]:
    """The flights of the first blocks by name."""
    campaign = (stored(study, campaigns / f"{number:02}") for number in range(1, blocks + 1))
    return {name: outcome for flights in campaign for name, outcome in flights.items()}


def results(_study: Study, jobs: int, folder: Path) -> str:
    """Fly what is missing, and tell."""
    mutants, path = search_arms.read_blocks(), folder / FLIGHTS
    before = search_arms.read_searches(folder / SEARCHES)
    study = Study.open(ROOT, GRID)
    searches = fly(study, mutants, CAMPAIGNS, folder / SEARCHES, jobs)
    if len(searches) > len(before):
        kept_flights.write(path, {KEPT: flights_in(study, CAMPAIGNS, len(mutants))})
    return flown(Evidence(mutants, searches, kept_flights.read(path)[KEPT]))


if __name__ == "__main__":
    write(__doc__, "search_or_chance", results)
