"""Constraints on the axes: combinations of values that the grid excludes, each with its reason."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.sim.situation import Axis

MOST_CONSTRAINTS = 100
"""Each is compared with every point of the grid."""


@dataclass(frozen=True)
class Constraint:
    """A combination of axis values that is impossible or of no interest.

    Attributes:
        excluded: the excluded values by axis; a point is excluded if it has an excluded value on each of these axes.
        reason: why no situation has the combination.
        place: `file:line` of the constraint.
    """

    excluded: Mapping[str, frozenset[int]]
    reason: str
    place: str

    def forbids(self, levels: Mapping[str, int]) -> bool:
        """Whether the constraint excludes a point with these values.

        >>> Constraint({"T": frozenset({0}), "W": frozenset({1, 2})}, "no room", "").forbids({"T": 0, "W": 2, "H": 0})
        True
        """
        return all(levels[axis] in values for axis, values in self.excluded.items())


def read_constraints(item: Item | None, axes: Iterable[Axis]) -> tuple[Constraint, ...]:
    """Read the list under `constraints`; an absent list gives no constraints.

    Raises:
        InputError: a constraint names an unknown axis or value, names fewer than two axes, or lacks its reason.
    """
    known = {axis.id: axis for axis in axes}
    return tuple(_constraint(entry, known) for entry in item.items(most=MOST_CONSTRAINTS)) if item else ()


def _constraint(item: Item, axes: Mapping[str, Axis]) -> Constraint:
    excluded_item = item.need("exclude")
    excluded = {name: _values(name, entry, axes) for name, entry in excluded_item.mapping().items()}
    if len(excluded) < 2:
        raise InputError(
            f"{excluded_item.place}: exclude must name the values of at least 2 axes; "
            "to exclude a single value, remove it from its axis"
        )
    constraint = Constraint(excluded, item.need("reason").text(), item.place)
    item.close()
    return constraint


def _values(name: str, item: Item, axes: Mapping[str, Axis]) -> frozenset[int]:
    """The values of one axis in an `exclude`: one value or a list."""
    if name not in axes:
        raise InputError(f"{item.place}: exclude names the unknown axis {name!r}{did_you_mean(name, axes)}")
    return read_values(axes[name], item)


def read_values(axis: Axis, item: Item) -> frozenset[int]:
    """Values of an axis: one id or a list of ids.

    Raises:
        InputError: the axis has no such value.
    """
    last = len(axis.values) - 1
    entries = item.items() if isinstance(item.value, tuple) else (item,)
    numbers = frozenset(entry.whole() for entry in entries)
    if not numbers or max(numbers) > last:
        raise item.error(f"values of axis {axis.id!r}, 0 to {last}")
    return numbers
