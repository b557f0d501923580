"""Covering arrays: few situations that together have every combination of the values of t axes.

`covertable` builds them; it breaks ties by a hash of a salt, so one of several salts finds a smaller array than most.
On five binary axes that gives the minimum, 6, 10 and 16 situations for t = 2, 3, 4 (`tests/results/test_covering.py`
proves that fewer cannot do).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib import import_module
from itertools import combinations, product
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.analysis.situations.t_way import Ids, Levels, levels_of, table
from scaloft_fi.errors import InputError
from scaloft_fi.judge.space import Space
from scaloft_fi.streams import generator

SALTS = 64
"""Arrays that are tried; the smallest is kept."""
WORK = 400_000
"""Combinations to be covered, in all arrays that are tried: a large grid gets fewer salts."""
MOST_TERMS = 40
"""With more forbidden combinations the library is slow: the array is then built from the situations, greedily."""
Forbidden = tuple[tuple[int, ...], tuple[int, ...]]
"""Axes, and the places of the values there that no situation has together."""


def covering_array(space: Space, keys: Sequence[str], strength: int, seed: int) -> tuple[str, ...]:
    """Situations out of `keys` that have every combination of `strength` axes that any of `keys` has.

    Args:
        space: the grid.
        keys: the situations to choose from.
        strength: number of axes, 1 to all of them.
        seed: another seed gives another array, as a rule of the same size.

    Returns:
        Keys in the order in which they were found.

    Raises:
        InputError: `covertable` is not installed, or the strength is none.
    """
    axes = len(space.axes)
    if not 1 <= strength <= axes:
        raise InputError(f"strength={strength} of a covering array must be 1 to {axes}, the number of axes")
    levels = levels_of(keys, space)
    if strength == axes or len(levels) <= 1:
        return tuple(keys)
    codes, size = table(levels, space, strength)
    wanted = np.zeros(size, bool)
    wanted[codes] = True
    terms = forbidden(levels)
    work = int(wanted.sum()) * axes * (1 if terms is None else 1 + len(terms))
    tries = max(1, min(SALTS, WORK // work))
    if terms is None:
        rng = generator("covering array", strength, seed)
        begun = [[int(rng.integers(len(levels)))] for _ in range(tries)]
    else:
        row_of = {tuple(row): number for number, row in enumerate(levels.tolist())}
        arrays = _arrays(levels, terms, strength, seed, tries)
        begun = [[row_of[row] for row in rows if row in row_of] for rows in arrays]
    return tuple(keys[row] for row in min((_whole(rows, codes, wanted) for rows in begun), key=len))


def greedy_array(space: Space, keys: Sequence[str], strength: int) -> tuple[tuple[str, ...], int]:
    """As `covering_array`, at once and without `covertable`, a little larger; and how many combinations there are."""
    codes, size = table(levels_of(keys, space), space, strength)
    wanted = np.zeros(size, bool)
    wanted[codes] = True
    return tuple(keys[row] for row in _whole([], codes, wanted)), int(wanted.sum())


def _arrays(
    levels: Levels, terms: Sequence[Forbidden], strength: int, seed: int, tries: int
) -> Iterator[list[tuple[int, ...]]]:
    """What the library finds with one salt after the other, each row the places of its values."""
    try:
        make = import_module("covertable").make
    except ImportError as error:
        reason = "covering arrays need covertable: pip install 'scaloft-fi[covering]'"
        raise InputError(reason) from error
    factors = {f"a{axis}": sorted(set(column)) for axis, column in enumerate(levels.T.tolist())}
    constraints = [_constraint(*term) for term in terms]
    for salt in range(tries):
        rows = make(factors, strength=strength, salt=f"{seed}-{salt}", tolerance=0, constraints=constraints)
        yield [tuple(row[name] for name in factors) for row in rows]


def forbidden(levels: Levels) -> list[Forbidden] | None:
    """The smallest combinations of the points' values that no point has; together they leave exactly the points.

    Args:
        levels: (points, axes), no point twice.

    Returns:
        None when there are more than `MOST_TERMS`: the points are scattered, not a grid with something taken out.
    """
    values = [sorted(set(column)) for column in levels.T.tolist()]
    if len(levels) == prod(map(len, values)):
        return []
    left = np.array(list(product(*values)), np.int64)
    forbidden: list[Forbidden] = []
    for size in range(2, len(values) + 1):
        for axes in combinations(range(len(values)), size):
            if len(left) == len(levels) or len(forbidden) > MOST_TERMS:
                return forbidden if len(forbidden) <= MOST_TERMS else None
            radix = np.array([prod(max(values[axis]) + 1 for axis in axes[i + 1 :]) for i in range(size)])
            missing = ~np.isin(left[:, axes] @ radix, levels[:, axes] @ radix)
            forbidden += [(axes, tuple(row)) for row in np.unique(left[missing][:, axes], axis=0).tolist()]
            left = left[~missing]
    return forbidden if len(forbidden) <= MOST_TERMS else None


def _constraint(axes: tuple[int, ...], places: tuple[int, ...]) -> dict[str, Any]:
    """Not all of these values together, in the library's words."""
    return {
        "operator": "or",
        "conditions": [{"operator": "ne", "left": f"a{a}", "value": v} for a, v in zip(axes, places, strict=True)],
    }


def _whole(rows: list[int], codes: Ids, wanted: NDArray[np.bool_]) -> list[int]:
    """The rows without those that the others make superfluous, and with what they may lack, greedily."""
    kept = list(dict.fromkeys(rows))
    times = np.bincount(codes[kept].ravel(), minlength=len(wanted))
    for row in reversed(kept.copy()):
        if (times[codes[row]] > 1).all():
            times[codes[row]] -= 1
            kept.remove(row)
    open_ = wanted & (times == 0)
    while open_.any():
        kept.append(int(open_[codes].sum(axis=1).argmax()))
        open_[codes[kept[-1]]] = False
    return kept
