"""A run with a budget of wall time: in which order it flies, so that what is flown when time is up is a fair sample."""

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
"""About so many mutants fly with a baseline at a time: it is flown again for each group."""


def budget_s(text: str) -> float:
    """A span of wall time as a person writes it [s].

    >>> [budget_s(text) for text in ("90s", "10m", "1h30m")]
    [90.0, 600.0, 5400.0]

    Raises:
        InputError: it is none.
    """
    match = re.fullmatch(r"(?:(\d{1,6})h)?(?:(\d{1,6})m)?(?:(\d{1,6})s)?", text.strip())
    parts = match.groups(default="0") if match else ("0", "0", "0")
    total_s = sum(int(part) * unit for part, unit in zip(parts, UNITS_S, strict=True))
    if not total_s:
        raise InputError(f"--budget={text!r} must be a time above 0 with its unit, such as 90s, 10m or 1h30m")
    return float(total_s)


class Budget:
    """Wall time that runs out; the clock starts when it is made.

    Args:
        seconds: how much there is [s]; None = no end.
        clock: monotonic wall clock [s].
    """

    def __init__(self, seconds: float | None, clock: Callable[[], float] = time.monotonic) -> None:
        self._end_s = None if seconds is None else clock() + seconds
        self._clock = clock

    @property
    def left_s(self) -> float:
        """What is left [s]; infinite without an end."""
        return math.inf if self._end_s is None else max(0.0, self._end_s - self._clock())

    def while_it_lasts(
        self, batches: Iterable[Batch], needs_s: Callable[[Batch], float] = lambda _task: 0.0
    ) -> Iterator[Batch]:
        """`batches`, until the time is up; a batch that was handed out before is flown to its end.

        To leave it in the middle would keep of it what is flown first: the mutants that show early.  The first batch
        that is not expected to end in time is the end: to skip it for a shorter one would favour short flights.

        Args:
            batches: in the order in which they are flown.
            needs_s: wall time that a batch is expected to take [s].
        """
        for batch in batches:
            if self.left_s <= needs_s(batch):
                return
            yield batch


def fair_order(
    study: Study, planned: Plan, arrange: Callable[[Sequence[Flight]], Iterable[Batch]], missing: Iterable[Flight]
) -> Iterator[Batch]:
    """The `missing` flights of a plan in random, stratified order.

    Situations with their seeds are drawn at random, each of them in turn with one random group of mutants in which
    every parameter has its share, until every situation has had every group.  So at any time every planned flight of a
    mutant had the same chance, every situation was drawn equally often, give or take one, and so was every group.  The
    baseline and PLACEBO of a situation are flown when it is first drawn, the
    pool comes last.  The order is the study's own: the same in every run, so that another budget goes on where the
    last one ended.
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
    """The items in an order that is random, but in which any stretch has of each stratum its share, give or take one.

    Systematic sampling: the n members of a stratum, shuffled, stand at (i + u) / n with one random u for all.

    Args:
        items: each once.
        stratum: of an item.
        name: tells an item from all others.
        seed: what names the random stream; the same gives the same order, in whatever order the items come.
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
    """Stretches of about `GROUP` mutants; one empty group when there is no mutant."""
    count = max(1, round(len(order) / GROUP))
    bounds = [len(order) * group // count for group in range(count + 1)]
    return [list(order[low:high]) for low, high in pairwise(bounds)]
