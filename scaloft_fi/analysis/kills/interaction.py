"""Kill interaction order: how many axes a tester must get right, at the least, for a mutant to die.

The order of a mutant is the fewest literals of an implicant of its kills: the least t such that it is killed in every
situation that has certain values of t axes.  It is the analogue of the number of variables that trigger a failure in
NIST's studies of software failures.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from scaloft_fi.analysis.condition import condition, sides
from scaloft_fi.analysis.kills.kill_matrix import KillMatrix, KillRow
from scaloft_fi.analysis.plain import by_field, plain
from scaloft_fi.judge.space import Space

NIST = {
    "medical devices": (66, 97, 99),
    "browser": (29, 76, 95),
    "server": (42, 70, 89),
    "NASA GSFC": (68, 93, 98),
    "network sec.": (20, 65, None),
    "TCAS": (None, 53, None),
}
"""Share of failures [%] that one, at most two, at most three variables trigger; no failure needed more than six.

Source: Kuhn, NIST CSRC, "Interactions Involved in Software Failures - empirical data", table 1; its TCAS study used
seeded faults.  None: not published or not at hand.
"""
NIST_SOURCE = 'NIST CSRC (Kuhn), "Interactions Involved in Software Failures", table 1; TCAS: seeded faults'


@dataclass(frozen=True)
class Interaction:
    """How a mutant's kills depend on the axes.

    Attributes:
        mutant: id.
        counted: whether the ratios count it.
        condition: the shortest condition, as `human & light`.
        order: fewest axes that have to be right; 0 when it dies wherever it is tested.
        order_at_most: the same if it survived in every situation that does not say: there an order may rest on nothing.
        killing: situations where it is killed.
        unknown: situations that say nothing: not flown, or it infects there and no safety requirement is steady.
    """

    mutant: str
    counted: bool
    condition: str
    order: int
    order_at_most: int
    killing: int
    unknown: int


@dataclass(frozen=True)
class Orders:
    """The histogram of kill interaction orders.

    Attributes:
        counts: mutants of each order, from 0 to the number of axes.
        counts_at_most: the same of the orders where nothing unknown helps.
    """

    counts: tuple[int, ...]
    counts_at_most: tuple[int, ...]

    def cumulative(self) -> tuple[float | None, ...]:
        """Share of the killed mutants with at most this order [%], per order; None where none was killed."""
        whole = sum(self.counts)
        return tuple(100 * sum(self.counts[: t + 1]) / whole if whole else None for t in range(len(self.counts)))

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, NIST's published shares beside them."""
        return {
            **by_field(self),
            "cumulative_percent": plain(self.cumulative()),
            "nist_cumulative_percent": plain(NIST),
            "nist_source": NIST_SOURCE,
        }


def interactions(matrix: KillMatrix) -> tuple[Interaction, ...]:
    """The interaction of every mutant that is killed somewhere, in the matrix's order; controls are left out."""
    return tuple(interaction(matrix.space, row) for row in matrix.mutants if row.killing)


def interaction(space: Space, row: KillRow) -> Interaction:
    """The interaction of one mutant.

    Raises:
        ValueError: it is killed nowhere.
    """
    killing, surviving = row.killing, row.surviving
    known = {space.point[key] for key in (*killing, *surviving)}
    others = [key for key, _ in space.points if key not in set(killing)]
    return Interaction(
        mutant=row.id,
        counted=row.counted,
        condition=condition(space, killing, surviving),
        order=order(space, killing, surviving),
        order_at_most=order(space, killing, others),
        killing=len(killing),
        unknown=len(space.points) - len(known),
    )


def orders(interactions: Iterable[Interaction], space: Space) -> Orders:
    """The histogram over the mutants that the ratios count: ladders would count one fault several times."""
    counted = [entry for entry in interactions if entry.counted]
    sizes = range(len(space.axes) + 1)
    least, most = Counter(entry.order for entry in counted), Counter(entry.order_at_most for entry in counted)
    return Orders(tuple(least[size] for size in sizes), tuple(most[size] for size in sizes))


def order(space: Space, killing: Collection[str], surviving: Collection[str]) -> int:
    """Fewest literals of a box of the grid with a killing situation and no surviving one.

    A box that admits several values of an axis holds one that admits a single value, with as many literals: so it is
    enough to look for t axes whose values in some killing situation no surviving one shares.

    Raises:
        ValueError: nothing kills, or a situation both kills and is survived.
    """
    on, off = sides(space, killing, surviving)
    for size in range(len(space.axes) + 1) if on else ():
        for axes in combinations(range(len(space.axes)), size):
            spared = {tuple(point[axis] for axis in axes) for point in off}
            if any(tuple(point[axis] for axis in axes) not in spared for point in on):
                return size
    raise ValueError("an order needs a killing situation that is not survived")
