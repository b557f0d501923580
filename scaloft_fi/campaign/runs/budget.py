"""A run with a budget of wall time, and an order of flights whose every beginning is a fair sample of the plan."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from itertools import pairwise
from typing import TypeVar

from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.plan.plan import Plan
from scaloft_fi.errors import InputError
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study

Item = TypeVar("Item")

UNITS_S = (3600, 60, 1)
GROUP = 16
"""Approximate number of mutants that share one flight of a baseline; each group flies the baseline again."""


def budget_s(text: str) -> float:
    """Parse a duration such as `1h30m` [s].

    >>> [budget_s(text) for text in ("90s", "10m", "1h30m")]
    [90.0, 600.0, 5400.0]

    Raises:
        InputError: the text is no duration above 0.
    """
    match = re.fullmatch(r"(?:(\d{1,6})h)?(?:(\d{1,6})m)?(?:(\d{1,6})s)?", text.strip())
    parts = match.groups(default="0") if match else ("0", "0", "0")
    total_s = sum(int(part) * unit for part, unit in zip(parts, UNITS_S, strict=True))
    if not total_s:
        raise InputError(f"--budget={text!r} must be a time above 0 with its unit, such as 90s, 10m or 1h30m")
    return float(total_s)


class Budget:
    """A budget of wall time; its clock starts at its creation.

    Args:
        seconds: size of the budget [s]; None = unlimited.
        clock: monotonic wall clock [s].
    """

    def __init__(self, seconds: float | None, clock: Callable[[], float] = time.monotonic) -> None:
        self._end_s = None if seconds is None else clock() + seconds
        self._clock = clock

    @property
    def left_s(self) -> float:
        """Remaining time [s]; infinite for an unlimited budget."""
        return math.inf if self._end_s is None else max(0.0, self._end_s - self._clock())

    def while_it_lasts(
        self, batches: Iterable[Batch], needs_s: Callable[[Batch], float] = lambda _task: 0.0
    ) -> Iterator[Batch]:
        """Yield `batches` until the budget is used up; a batch that was handed out is flown to its end.

        A batch that stops in the middle would keep the mutants that are flown first, which infect early.  The first
        batch that is not expected to end in time ends the run; a shorter batch instead would favour short flights.

        Args:
            batches: batches in the order of flight.
            needs_s: expected wall time of a batch [s].
        """
        for batch in batches:
            if self.left_s <= needs_s(batch):
                return
            yield batch


def fair_order(
    study: Study, planned: Plan, arrange: Callable[[Sequence[Flight]], Iterable[Batch]], missing: Iterable[Flight]
) -> Iterator[Batch]:
    """Batches of the `missing` flights of a plan in random, stratified order.

    Each turn draws every pair of situation and seed once, in random order, each with one random group of mutants in
    which every parameter has its share; the turns end when every pair has had every group.  So at any time every
    planned flight of a mutant had the same chance, and the numbers of draws of two situations, or of two groups, differ
    by at most one.  The baseline and PLACEBO are flown at the first draw of their situation.  The order depends on the
    study only, so a run with another budget continues where the last run ended.
    """
    seed = study.inputs["sim"], study.inputs["requirements"]
    wanted = set(missing)
    draws = interleaved(
        planned.baselines,
        lambda flight: flight.situation.key,
        lambda flight: f"{flight.situation.key}/{flight.seed}",
        (*seed, "draws"),
    )
    mutants = list(dict.fromkeys(f.mutant for f in planned.mutants if f.mutant is not None and f.mutant != PLACEBO))
    order = interleaved(mutants, lambda mutant: mutant.parameter, lambda mutant: mutant.id, (*seed, "mutants"))
    groups = _groups(order)
    for turn in range(len(groups)):
        for place, draw in enumerate(draws):
            members = (*([None, PLACEBO] if turn == 0 else []), *groups[(place + turn) % len(groups)])
            unit = [Flight(member, draw.situation, draw.seed) for member in members]
            yield from arrange([flight for flight in unit if flight in wanted])


def interleaved(
    items: Sequence[Item], stratum: Callable[[Item], Hashable], name: Callable[[Item], str], seed: Sequence[str]
) -> list[Item]:
    """The items in a random order in which every stretch has its share of each stratum, up to one item.

    Systematic sampling: the n members of a stratum, shuffled, get the positions (i + u) / n with one random u.

    Args:
        items: the items, each once.
        stratum: stratum of an item.
        name: unique name of an item.
        seed: name of the random stream; the order of `items` does not matter.
    """

    def chance(*parts: str) -> float:
        return key_words(*seed, *parts)[0] / 2**64

    strata: dict[Hashable, list[Item]] = {}
    for item in sorted(items, key=lambda item: (chance("shuffle", name(item)), name(item))):
        strata.setdefault(stratum(item), []).append(item)
    placed = [
        ((index + chance("offset", str(key))) / len(members), chance("tie", name(item)), item)
        for key, members in strata.items()
        for index, item in enumerate(members)
    ]
    return [item for _, _, item in sorted(placed, key=lambda entry: entry[:2])]


def _groups(order: Sequence[Mutant]) -> list[list[Mutant]]:
    """Split mutants into groups of about `GROUP`; without mutants, one empty group."""
    count = max(1, round(len(order) / GROUP))
    bounds = [len(order) * group // count for group in range(count + 1)]
    return [list(order[low:high]) for low, high in pairwise(bounds)]
