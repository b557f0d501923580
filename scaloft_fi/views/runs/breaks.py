"""What a search found that breaks the unmutated drone."""

from __future__ import annotations

from scaloft_fi.campaign.seeking.breaks import BreaksReport
from scaloft_fi.sim.found import Break
from scaloft_fi.views.tables.table import Table


def breaks_table(report: BreaksReport, campaign: str, *, claims: bool) -> Table:
    """The breaks; `campaign` holds their flights, `claims` tells whether the stack declares claims."""
    rows = tuple(
        (
            number,
            f"{one.requirement} {one.violated}/{one.flights}",
            one.struck or "nothing",
            place(one),
            belief(one),
            f"{one.alike}/{one.flights}",
        )
        for number, one in enumerate(report.breaks, 1)
    )
    told = [
        f"{number}: {one.situation}: {', '.join(one.words) or 'every value benign'}; after {one.t_s:.1f} s: "
        f"`scaloft-fi replay baseline/{one.situation}/{one.flight} --campaign {campaign}`."
        for number, one in enumerate(report.breaks, 1)
    ]
    beliefs = (
        "wrong belief: the stage that was the most wrong in the last second before, and by how much."
        if claims
        else "wrong belief: not known, because the stack declares no claims (docs/stack.md)."
    )
    ended = "the budget ended the search" if report.spent else "the search came to its end"
    again = f"{report.again} flown again to see what the drone believed"
    notes = (
        *told,
        "violates: of the flights with fresh seeds; alike: those that do so in this way.",
        beliefs,
        f"The drone broke in {report.broken} of {report.situations} situations.",
        f"{report.used} flights in all, {report.flown} of them flown now, {again}; {ended}.",
    )
    headers = ("", "violates", "strikes", "where", "wrong belief", "alike")
    ways = f"{len(rows)} {'way' if len(rows) == 1 else 'ways'}"
    return Table(f"The unmutated drone breaks in {ways}", headers, rows, notes)


def place(one: Break) -> str:
    """Where the drone is: the leg of the route, and the nearer of its ends unless a body is struck."""
    return one.leg if one.near == one.struck else f"near {one.near}, {one.leg}"


def belief(one: Break) -> str:
    """The belief that was the most wrong, and by how much."""
    return f"{one.belief}, {one.error:.2f} {one.unit}" if one.belief else "none"
