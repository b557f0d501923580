"""Situation coverage as tables: all of its numbers, and how the situations were chosen."""

from __future__ import annotations

from collections.abc import Sequence

from scaloft_fi.results.situations.coverage import SHARES, Coverage
from scaloft_fi.results.space import Space
from scaloft_fi.results.telling.table import Table


def coverage_tables(covered: Coverage, space: Space, choices: Sequence[tuple[str, int, int, int]]) -> tuple[Table, ...]:
    """Every number of the coverage.

    Args:
        covered: the coverage.
        space: the grid.
        choices: per choice that was made its text, seed, test cases and distinct situations.
    """
    rows = [
        ("distinct situations", covered.situations.plain, "situations of the grid"),
        ("draws", str(covered.draws), "test cases: situations flown, each seed anew"),
        *([("pool", str(covered.pool), "of these draws, the baseline's alone, to decide by")] if covered.pool else []),
        ("realised", covered.realised.plain, "situations whose every value came true in a baseline flight"),
        (
            "eligible",
            covered.eligible.plain,
            "situations where a baseline held a safety requirement: a fault could show",
        ),
    ]
    rows += [
        (f"realised {axis}", ratio.plain, "flown situations where the value on that axis came true")
        for axis, ratio in covered.by_axis
    ]
    rows += [
        (f"triggered {name}", ratio.plain, "flown situations whose baseline put the requirement to the test")
        for name, ratio in covered.requirements
    ]
    tables = [
        Table("Situation coverage", ("coverage", "part/whole", "of"), tuple(rows)),
        _t_way(covered, len(space.axes)),
    ]
    if choices:
        headers = ("--choose", "--choose-seed", "test cases", "distinct situations")
        tables.append(Table("How situations were chosen", headers, tuple(choices)))
    return tuple(tables)


def _t_way(covered: Coverage, axes: int) -> Table:
    rows = tuple(
        (f"{found.strength}-way", found.total.plain, *(found.complete(share).plain for share in SHARES))
        for found in covered.combinations
        if found.strength <= axes
    )
    headers = ("combinations", "covered", *(f"p = {share:g}" for share in SHARES))
    notes = (
        "Covered: combinations of the values of t axes that were flown, of all that situations of the grid have.",
        "p: (p, t)-completeness, the choices of t axes with at least the share p of their combinations covered.",
    )
    return Table("Combinations of axis values", headers, rows, notes)
