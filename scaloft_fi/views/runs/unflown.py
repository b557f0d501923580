"""The flights that a run left out, by parameter and by situation, so that nobody reads a part as the whole."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.plan import Plan
from scaloft_fi.views.tables.table import Table


@dataclass(frozen=True)
class Unflown:
    """A part of a plan of which flights were not flown.

    Attributes:
        by: `parameter` or `situation`.
        name: of the part.
        planned, flown, not_flown: number of flights.
    """

    by: str
    name: str
    planned: int
    flown: int
    not_flown: int


def unflown(planned: Plan, left: Sequence[Flight]) -> tuple[Unflown, ...]:
    """The plan by parameter, then by situation; nothing where no flight is left."""
    if not left:
        return ()
    flights = list(dict.fromkeys((*planned.known, *left)))
    return (
        *_parts("parameter", flights, left, lambda flight: flight.subject.parameter or flight.subject.id),
        *_parts("situation", flights, left, lambda flight: flight.situation.key),
    )


def _parts(
    by: str, flights: Iterable[Flight], left: Iterable[Flight], part: Callable[[Flight], str]
) -> Iterator[Unflown]:
    planned, missing = Counter(map(part, flights)), Counter(map(part, left))
    return (Unflown(by, name, count, count - missing[name], missing[name]) for name, count in planned.items())


def unflown_tables(parts: Sequence[Unflown]) -> tuple[Table, ...]:
    """Two tables, or none when nothing is left."""
    return tuple(
        _table(title, header, [one for one in parts if one.by == header])
        for title, header in (("Not flown, by parameter", "parameter"), ("Not flown, by situation", "situation"))
        if parts
    )


def _table(title: str, header: str, parts: Sequence[Unflown]) -> Table:
    left, planned = sum(one.not_flown for one in parts), sum(one.planned for one in parts)
    note = f"{left} of {planned} planned flights were not flown; the same command without --budget flies them."
    rows = tuple((one.name, one.planned, one.flown, one.not_flown) for one in parts)
    return Table(title, (header, "planned", "flown", "not flown"), rows, (note,))
