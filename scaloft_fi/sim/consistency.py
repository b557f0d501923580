"""What the axes of a grid must agree on: every value has a situation, and no two axes set one path."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from scaloft_fi.errors import InputError
from scaloft_fi.sim.constraint import Constraint
from scaloft_fi.sim.patch import overlap
from scaloft_fi.sim.situation import Axis, Situation


def check_values(axes: Sequence[Axis], situations: Sequence[Situation], constraints: Sequence[Constraint]) -> None:
    """Refuse constraints that exclude every situation of a value.

    Raises:
        InputError: they do.
    """
    if not constraints:
        return
    left = {level for situation in situations for level in situation.levels}
    for axis in axes:
        for value in axis.values:
            if (axis.id, value.id) not in left:
                wanted = f"constraints must leave every value a situation, {axis.id}{value.id} has none"
                raise InputError(f"{constraints[0].place}: {wanted}")


def check_paths(axes: Sequence[Axis], situations: Sequence[Situation]) -> None:
    """Refuse a situation in which two axes set one path, or a path and a part of it.

    Raises:
        InputError: there is one.
    """
    for first, second in itertools.combinations(axes, 2):
        for one, other in itertools.product(first.values, second.values):
            twice = next((path for path in other.changes for set_ in one.changes if overlap(path, set_)), None)
            pair = {(first.id, one.id), (second.id, other.id)}
            if twice is None or not (both := [s.key for s in situations if pair.issubset(s.levels)]):
                continue
            names = f"{first.id}{one.id} and {second.id}{other.id}"
            sentence = f"{other.changes[twice].place}: {names} both set {twice}, in situation {both[0]}"
            raise InputError(f"{sentence}; {remedy((first.id, one.id), (second.id, other.id))}")


def remedy(*levels: tuple[str, int]) -> str:
    """The constraint that excludes a combination of values, as advice.

    >>> remedy(("T", 1), ("W", 2))
    'exclude them under constraints: {exclude: {T: 1, W: 2}, reason: ...}'
    """
    values = ", ".join(f"{axis}: {level}" for axis, level in levels)
    return f"exclude them under constraints: {{exclude: {{{values}}}, reason: ...}}"
