"""The smallest set of situations that keeps every kill: a minimum set cover, found exactly where that is affordable.

Mutants are the rows to be hit, situations the columns that hit them.  Rows that contain another row and columns within
another column are dropped, what remains is searched by branch and bound (Coudert, "Two-level logic minimization: an
overview", Integration 17, 1994: unate covering; its bound is a set of rows that share no column).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

MOST_ENTRIES = 10_000_000
"""Entries of the matrix looked at in one search, over all branches (some ten seconds); beyond, the answer is greedy."""
MOST_COLUMNS = 2_000
"""Beyond this many columns only equal ones are dropped, not those within others."""
MOST_COUNTED = 1_000_000
"""Minimum sets counted; beyond, their number is None."""


@dataclass(frozen=True)
class Suite:
    """Situations that together kill every mutant that any situation kills.

    Attributes:
        situations: in the order of the columns; the first such set in that order, when exact.
        exact: whether no smaller set does; else it is at most this many.
        alternatives: how many sets of this size do; None when not exact or too many to count.
        needed: situations in every such set, because some mutant dies nowhere else.
    """

    situations: tuple[str, ...]
    exact: bool
    alternatives: int | None
    needed: tuple[str, ...]


def minimal_suite(
    kills: Mapping[str, Collection[str]], situations: Sequence[str], *, most_entries: int = MOST_ENTRIES
) -> Suite:
    """The smallest set of situations that hits every kill set.

    Args:
        kills: per mutant the situations that kill it; empty sets are left alone.
        situations: every situation, in the order by which ties are broken.
        most_entries: entries looked at before it turns greedy.

    Raises:
        ValueError: a kill set names a situation that is not in `situations`.
    """
    place = {key: number for number, key in enumerate(situations)}
    unknown = {key for keys in kills.values() for key in keys} - set(place)
    if unknown:
        raise ValueError(f"kills in unknown situations: {sorted(unknown)}")
    rows = _minimal_rows(frozenset(place[key] for key in keys) for keys in kills.values() if keys)
    needed = tuple(situations[min(row)] for row in sorted(rows, key=sorted) if len(row) == 1)
    search = _Search(most_entries)
    try:
        best = search.least(rows, len(situations))
        assert best is not None
        chosen = _first_in_order(search, rows, len(best))
        exact = True
    except _TooMany:
        chosen, exact = _greedy(rows), False
    return Suite(
        situations=tuple(situations[column] for column in sorted(chosen)),
        exact=exact,
        alternatives=_count(rows, len(chosen), most_entries) if exact else None,
        needed=needed,
    )


Rows = frozenset[frozenset[int]]
"""What is still to be hit, each by one of its columns."""


class _TooMany(Exception):  # noqa: N818 - a limit, no error
    """The search looked at more than allowed."""


@dataclass
class _Search:
    """Branch and bound over unate covers, with its results kept for sets of rows it meets again."""

    most: int
    looked_at: int = 0
    known: dict[Rows, frozenset[int]] = field(default_factory=dict)

    def least(self, rows: Rows, most_columns: int) -> frozenset[int] | None:
        """A smallest set of columns that hits all rows, None when it takes more than `most_columns`.

        Raises:
            _TooMany: beyond the limit.
        """
        self.looked_at += 1 + sum(map(len, rows))
        if self.looked_at > self.most:
            raise _TooMany
        chosen, rows = _reduce(rows)
        budget = most_columns - len(chosen)
        if not rows:
            return chosen if budget >= 0 else None
        if rows in self.known:
            known = self.known[rows]
            return chosen | known if len(known) <= budget else None
        if _bound(rows) > budget:
            return None
        best: frozenset[int] | None = None
        allowed = budget
        branching = min(rows, key=lambda row: (len(row), sorted(row)))
        for column in sorted(branching, key=lambda c: (-sum(c in row for row in rows), c)):
            rest = self.least(frozenset(row for row in rows if column not in row), allowed - 1)
            if rest is not None:
                best = rest | {column}
                allowed = len(best) - 1
        if best is None:
            return None
        self.known[rows] = best
        return chosen | best


def _minimal_rows(rows: Iterable[frozenset[int]]) -> Rows:
    """The rows that contain no other: whoever hits those hits all."""
    kept: list[frozenset[int]] = []
    for row in sorted(set(rows), key=len):
        if not any(smaller <= row for smaller in kept):
            kept.append(row)
    return frozenset(kept)


def _reduce(rows: Rows) -> tuple[frozenset[int], Rows]:
    """Columns that are forced, and the rows that remain without dominated rows and columns."""
    forced: frozenset[int] = frozenset()
    while True:
        single = frozenset(column for row in rows if len(row) == 1 for column in row)
        forced |= single
        rows = frozenset(row for row in rows if not row & single)
        kept = _undominated(rows)
        smaller = _minimal_rows(row & kept for row in rows)
        if smaller == rows and not any(len(row) == 1 for row in rows):
            return forced, rows
        rows = smaller


def _undominated(rows: Rows) -> frozenset[int]:
    """The columns that hit what no other column hits as well; of equal ones the first."""
    hits = _hits(rows)
    first: dict[int, int] = {}
    for column in sorted(hits):
        first.setdefault(hits[column], column)
    if len(first) > MOST_COLUMNS:
        return frozenset(first.values())
    kept: list[int] = []
    for mask in sorted(first, key=lambda mask: (-mask.bit_count(), first[mask])):
        if not any(mask & ~larger == 0 for larger in kept):
            kept.append(mask)
    return frozenset(first[mask] for mask in kept)


def _hits(rows: Rows) -> dict[int, int]:
    """Per column the rows it hits, as bits."""
    hits: dict[int, int] = {}
    for number, row in enumerate(rows):
        for column in row:
            hits[column] = hits.get(column, 0) | 1 << number
    return hits


def _bound(rows: Rows) -> int:
    """How many rows, greedily picked, share no column: each needs a column of its own."""
    used: set[int] = set()
    number = 0
    for row in sorted(rows, key=lambda row: (len(row), sorted(row))):
        if not row & used:
            used |= row
            number += 1
    return number


def _first_in_order(search: _Search, rows: Rows, size: int) -> frozenset[int]:
    """Of the smallest sets the one that comes first when each is listed in the columns' order."""
    chosen: set[int] = set()
    columns = sorted(frozenset().union(*rows))
    for column in columns:
        if not rows:
            break
        left = frozenset(row for row in rows if column not in row)
        if left == rows:
            continue
        if search.least(left, size - len(chosen) - 1) is None:
            rows = _minimal_rows(row - {column} for row in rows)
        else:
            chosen.add(column)
            rows = left
    return frozenset(chosen)


def _count(rows: Rows, size: int, most_entries: int) -> int | None:
    """How many sets of `size` columns hit all rows; None beyond the limits.

    Columns that hit the same rows stand for one another, and a smallest set never has two of them.
    """
    classes: dict[int, list[int]] = {}
    for column, mask in sorted(_hits(rows).items()):
        classes.setdefault(mask, []).append(column)
    weight = {columns[0]: len(columns) for columns in classes.values()}
    looked_at = 0

    def count(left: Rows, budget: int) -> int:
        nonlocal looked_at
        looked_at += 1 + sum(map(len, left))
        if looked_at > most_entries:
            raise _TooMany
        if not left:
            return 1 if budget == 0 else 0
        if frozenset() in left or _bound(left) > budget:
            return 0
        total = 0
        branching = min(left, key=lambda row: (len(row), sorted(row)))
        barred: set[int] = set()
        for column in sorted(branching):
            # a set counts in the branch of its first column of this row
            rest = frozenset(row - barred for row in left if column not in row)
            total += weight[column] * count(rest, budget - 1)
            barred.add(column)
        return total

    try:
        number = count(frozenset(frozenset(c for c in row if c in weight) for row in rows), size)
    except _TooMany:
        return None
    return number if number <= MOST_COUNTED else None


def _greedy(rows: Rows) -> frozenset[int]:
    """Always the column that hits most, the first of equals; what later ones make superfluous is dropped."""
    chosen: list[int] = []
    left = rows
    while left:
        hits = Counter(column for row in left for column in row)
        chosen.append(max(hits, key=lambda column: (hits[column], -column)))
        left = frozenset(row for row in left if chosen[-1] not in row)
    for column in list(chosen):
        if all(row & (set(chosen) - {column}) for row in rows):
            chosen.remove(column)
    return frozenset(chosen)
