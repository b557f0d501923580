"""What a search found, and what it did not."""

from __future__ import annotations

from typing import Any

from scaloft_fi.analysis.plain import by_field
from scaloft_fi.campaign.runs.seeking.seek import SeekReport
from scaloft_fi.views.score.finds import words
from scaloft_fi.views.tables.table import Table


def seek_tables(report: SeekReport, own: str) -> tuple[Table, Table]:
    """The finds, and the mutants without one; `own` is the name of the study's own grid."""
    rows = tuple(
        (
            mutant,
            evidence.requirement + f", strikes {evidence.struck}" * bool(evidence.struck),
            f"{evidence.violated}/{evidence.flights}",
            f"{evidence.p:.2g}",
            f"{evidence.held}/{evidence.baselines}",
            f"{evidence.margin:.2g}",
            len(find.shows) - 1,
            find.name,
        )
        for find in report.finds
        for mutant, evidence in find.shows.items()
    )
    headers = ("mutant", "violates", "flights", "p", "baseline", "margin", "others", "find")
    notes = (
        *(f"{find.name}: {find.situation}: {words(find)}." for find in report.finds),
        "Confirmed on seeds that the search never flew.  others: more sought mutants that the situation shows.",
        "p: at most alpha / 2, / 4, ... for the first, second, ... candidate of a mutant.",
        "baseline: flights that hold the requirement by more than their spread; margin: what nine in ten reach.",
        f"`scaloft-fi run --grid {own}+found` flies the situations.",
    )
    left = [one for one in report.sought if not one.shown_in]
    lacking = tuple((one.mutant, one.situations, one.candidates, round(one.nearest, 4)) for one in left)
    ended = "the budget ended the search" if report.spent else "the search came to its end"
    shown = len(report.sought) - len(left)
    return (
        Table(f"Found: {shown} of {len(report.sought)} mutants, {len(report.finds)} situations", headers, rows, notes),
        Table(
            f"Not found: {len(left)}",
            ("mutant", "situations", "candidates", "nearest"),
            lacking,
            (
                "nearest: least share of the unmutated drone's robustness that the mutant kept; below 0 it violated.",
                "candidates: situations that fresh seeds did not confirm.",
                f"{report.used} flights in all, {report.flown} of them flown now; {ended}.",
            ),
        ),
    )


def seek_json(report: SeekReport) -> dict[str, Any]:
    """Plain JSON values."""
    return by_field(report)
