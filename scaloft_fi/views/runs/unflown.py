"""The flights that a run left out, by parameter and by situation, so that nobody reads a part as the whole."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.plan.plan import Plan
from scaloft_fi.views.tables.table import Table


def unflown_tables(planned: Plan, left: Sequence[Flight]) -> tuple[Table, ...]:
    """Two tables, or none when nothing is left."""
    if not left:
        return ()
    flights = list(dict.fromkeys((*planned.known, *left)))
    note = (
        f"{len(left)} of {len(flights)} planned flights were not flown; the same command without --budget flies them."
    )
    return (
        _table("Not flown, by parameter", "parameter", flights, left, _parameter, note),
        _table("Not flown, by situation", "situation", flights, left, lambda flight: flight.situation.key, note),
    )


def _parameter(flight: Flight) -> str:
    return flight.subject.parameter or flight.subject.id


def _table(
    title: str,
    header: str,
    flights: Iterable[Flight],
    left: Iterable[Flight],
    part: Callable[[Flight], str],
    note: str,
) -> Table:
    planned, missing = Counter(map(part, flights)), Counter(map(part, left))
    rows = tuple((name, planned[name], planned[name] - missing[name], missing[name]) for name in planned)
    return Table(title, (header, "planned", "flown", "not flown"), rows, (note,))
