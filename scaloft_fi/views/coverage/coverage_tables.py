"""Situation coverage as tables: all of its numbers, and how the situations were chosen."""

from __future__ import annotations

from collections.abc import Sequence

from scaloft_fi.analysis.coverage import SHARES, Coverage
from scaloft_fi.analysis.pool import LEAST, State
from scaloft_fi.judge.space import Space
from scaloft_fi.views.tables.table import Table

MEANINGS = {
    State.STEADY: "at least nine tenths of the baseline's flights hold it: it tests a fault",
    State.UNSTEADY: "the baseline holds it or not by chance",
    State.RED: "most of the baseline's flights violate it",
    State.OPEN: "more than a tenth of the baseline's flights end before it is judged",
    State.VACUOUS: "less than half of the baseline's flights trigger it",
    State.UNKNOWN: f"the situation has fewer than {LEAST} baseline flights",
}


def coverage_tables(
    covered: Coverage, space: Space, choices: Sequence[tuple[str, int, int, int]] = ()
) -> tuple[Table, ...]:
    """Every number of the coverage.

    Args:
        covered: the coverage.
        space: the grid.
        choices: per choice that was made its text, seed, test cases and distinct situations.
    """
    rows = [
        ("distinct situations", str(covered.situations), "situations of the grid"),
        ("draws", str(covered.draws), "test cases: situations flown, each seed anew"),
        *([("pool", str(covered.pool), "of these draws, the baseline's alone, to decide by")] if covered.pool else []),
        ("realised", str(covered.realised), "situations whose every value came true in a baseline flight"),
        ("steady pairs", str(covered.steady), "situation x safety requirement, where the baseline has a pool"),
    ]
    rows += [
        (f"realised {axis}", str(ratio), "flown situations where the value on that axis came true")
        for axis, ratio in covered.by_axis
    ]
    rows += [
        (f"triggered {name}", str(ratio), "flown situations where it was triggered and judged")
        for name, ratio in covered.requirements
    ]
    tables = [
        Table("Situation coverage", ("coverage", "part/whole", "of"), tuple(rows)),
        _states(covered),
        _t_way(covered, len(space.axes)),
    ]
    if choices:
        headers = ("--choose", "--choose-seed", "test cases", "distinct situations")
        tables.append(Table("How situations were chosen", headers, tuple(choices)))
    return tuple(tables)


def _states(covered: Coverage) -> Table:
    rows = tuple((state.value, covered.states[state], meaning) for state, meaning in MEANINGS.items())
    return Table("Safety requirements in the situations flown", ("state", "pairs", "meaning"), rows)


def _t_way(covered: Coverage, axes: int) -> Table:
    rows = tuple(
        (f"{one.strength}-way", str(one.total), *(str(one.complete(share)) for share in SHARES))
        for one in covered.combinations
        if one.strength <= axes
    )
    headers = ("combinations", "covered", *(f"p = {share:g}" for share in SHARES))
    notes = (
        "Covered: value combinations of t axes that were flown, of all that the grid has.",
        "p: (p, t)-completeness: choices of t axes with at least the share p of these covered.",
    )
    return Table("Combinations of axis values", headers, rows, notes)
