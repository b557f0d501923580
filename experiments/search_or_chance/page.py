"""The results of the experiment, from its searches and their flights."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from experiments.search_or_chance.compare import REDRAWS, Counts, answer, beside_each, redrawn, share, totals
from experiments.search_or_chance.plan import BUDGET, seed_of
from experiments.search_or_chance.proposers import ARMS, SEARCH
from experiments.search_or_chance.sample import Block
from experiments.search_or_chance.searches import Search, Sought
from scaloft_fi.analysis.seeking import distance
from scaloft_fi.campaign.seeking.finds import SEEN_ON
from scaloft_fi.judge.outcome import BASELINE, Outcome

Rows = Iterable[Sequence[object]]
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

    def of(self, arm: str) -> list[Sought]:
        """What an arm came to for each mutant."""
        return [sought for (_, own), one in sorted(self.by_place.items()) if own == arm for sought in one.sought]

    def in_opening(self, block: int, arm: str) -> frozenset[tuple[str, str]]:
        """The mutants of a search that situations of the opening show, with the situation."""
        search = self.by_place[block, arm]
        return frozenset((one.mutant, one.shown_in) for one in search.sought if one.shown_in in search.opening)

    def after_opening(self, arm: str) -> list[tuple[str, str]]:
        """The situations that an arm proposed, each with the mutants that were flown there."""
        return [
            (sought.mutant, key)
            for (_, own), one in self.by_place.items()
            if own == arm
            for key in one.proposed
            for sought in one.sought
            if _flight(sought.mutant, key) in self.flights
        ]

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
    lines = [
        "",
        "## Flown",
        "",
        _told(evidence),
        "",
        *(_decided(evidence, redraws) if evidence.complete else [UNFINISHED]),
        "",
        "### Arms",
        "",
        *_table(("", *ARMS), _arms(evidence)),
        "",
        "### Mutants detected after so many flights for each mutant of the block",
        "",
        *_table(("flights", *ARMS), _curve(evidence)),
        "",
        "### Blocks",
        "",
        *_table(("block", *ARMS), _blocks(evidence)),
        "",
        "### Mutants",
        "",
        "Flights of the search after which a mutant was detected: requirement, violating of the confirming flights.",
        "",
        *_table(("block", "mutant", *ARMS), _mutants(evidence)),
    ]
    return "\n".join(lines) + "\n"


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
    spreads = redrawn(evidence.counts, redraws)
    rows = [
        (name, own - number, f"{low:+g} to {high:+g}", f"{beside:.2g}")
        for name, number, (low, high), beside in zip(
            list(ARMS)[1:], others, spreads, beside_each(evidence.counts), strict=True
        )
    ]
    yield from _table((f"`{SEARCH}` beside", "more mutants", "blocks drawn again", "p (Holm)"), rows)


def _arms(evidence: Evidence) -> Iterator[Sequence[object]]:
    sought = {arm: evidence.of(arm) for arm in ARMS}

    def row(name: str, value: Callable[[str], object]) -> Sequence[object]:
        return (name, *map(value, ARMS))

    def later(arm: str) -> list[bool]:
        return [evidence.shows(mutant, key) for mutant, key in evidence.after_opening(arm)]

    def opened(arm: str) -> int:
        return sum(len(evidence.in_opening(block, own)) for block, own in evidence.by_place if own == arm)

    yield row("flights asked for", lambda arm: sum(o.used for (_, own), o in evidence.by_place.items() if own == arm))
    yield row("newly detected", lambda arm: sum(bool(one.shown_in) for one in sought[arm]))
    yield row("- by situations of the opening", opened)
    yield row(
        "situations after the opening, that show a mutant of those flown there",
        lambda arm: f"{100 * share(later(arm)):.1f} % of {len(later(arm))}",
    )
    yield row("candidates", lambda arm: sum(one.candidates for one in sought[arm]))


def _curve(evidence: Evidence) -> Iterator[Sequence[object]]:
    for step in range(1, STEPS + 1):
        flights = evidence.budget * step // STEPS
        yield (flights, *(sum(0 < each <= flights for each in _after(evidence, arm)) for arm in ARMS))


def _after(evidence: Evidence, arm: str) -> Iterator[float]:
    """Flights for each mutant of the block after which an arm detected a mutant."""
    for (_, own), search in evidence.by_place.items():
        if own == arm:
            yield from (one.after / len(search.sought) for one in search.sought)


def _blocks(evidence: Evidence) -> Iterator[Sequence[object]]:
    for number in range(1, len(evidence.blocks) + 1):
        own = [evidence.by_place.get((number, arm)) for arm in ARMS]
        yield (number, *("" if one is None else sum(bool(s.shown_in) for s in one.sought) for one in own))


def _mutants(evidence: Evidence) -> Iterator[Sequence[object]]:
    for number, block in enumerate(evidence.blocks, 1):
        for place, mutant in enumerate(block):
            own = [evidence.by_place.get((number, arm)) for arm in ARMS]
            yield (number, mutant, *("" if one is None else _words(one.sought[place]) for one in own))


def _words(sought: Sought) -> str:
    told = sought.evidence
    return f"{sought.after}: {told.requirement} {told.violated}/{told.flights}" if told else "-"


def _table(head: Sequence[str], rows: Rows) -> Iterator[str]:
    for row in (head, ["---"] * len(head), *rows):
        yield f"| {' | '.join(map(str, row))} |"
