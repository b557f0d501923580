"""What the axes of a grid must agree on: every value has a situation, and no two axes set one path."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from scaloft_fi.errors import InputError
from scaloft_fi.sim.constraint import Constraint
from scaloft_fi.sim.patch import overlap
from scaloft_fi.sim.situation import Axis, Situation


def lonely_values(
    axes: Sequence[Axis], situations: Sequence[Situation], constraints: Sequence[Constraint]
) -> Iterator[InputError]:
    """An error for each value of which the constraints exclude every situation."""
    if not constraints:
        return
    left = {level for situation in situations for level in situation.levels}
    for axis in axes:
        for value in axis.values:
            if (axis.id, value.id) not in left:
                wanted = f"constraints must leave every value a situation, {axis.id}{value.id} has none"
                yield InputError(f"{constraints[0].place}: {wanted}")


def common_paths(axes: Sequence[Axis], situations: Sequence[Situation]) -> Iterator[InputError]:
    """An error for each two values of two axes that set one path, or a path and a part of it, in a situation."""
    for first, second in itertools.combinations(axes, 2):
        for one, other in itertools.product(first.values, second.values):
            twice = next((path for path in other.changes for set_ in one.changes if overlap(path, set_)), None)
            pair = {(first.id, one.id), (second.id, other.id)}
            if twice is None or not (both := [s.key for s in situations if pair.issubset(s.levels)]):
                continue
            names = f"{first.id}{one.id} and {second.id}{other.id}"
            sentence = f"{other.changes[twice].place}: {names} both set {twice}, in situation {both[0]}"
            yield InputError(f"{sentence}; {remedy((first.id, one.id), (second.id, other.id))}")


def remedy(*levels: tuple[str, int]) -> str:
    """The constraint that excludes a combination of values, as advice.

    >>> remedy(("T", 1), ("W", 2))
    'exclude them under constraints: {exclude: {T: 1, W: 2}, reason: ...}'
    """
    values = ", ".join(f"{axis}: {level}" for axis, level in levels)
    return f"exclude them under constraints: {{exclude: {{{values}}}, reason: ...}}"
