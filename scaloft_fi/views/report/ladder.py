"""The mutants of a cell from mild to strong, magnitudes that a search flew among those of the catalogue."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from scaloft_fi.analysis.margin import Scale
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.hazop.name import cell_of, parse, split_magnitude


def by_ladder(cells: Matrix, roster: Roster) -> Callable[[str], tuple[int, int, float, float, str]]:
    """A sort key of ids: the roster's order of cells, then its faults, magnitudes from mild to strong, times, events.

    Magnitudes without an order stay in the catalogue's.
    """

    def key(id_: str) -> tuple[int, int, float, float, str]:
        name = parse(id_)
        place, member = roster.rank(id_)[1:3]
        phase = math.inf if name.event else name.phase_s
        magnitude, unit = split_magnitude(name.magnitude)
        faults = cells.cell(name.cell).faults if name.cell in cells else ()
        for number, fault in enumerate(faults):
            scale = Scale.of(fault.magnitude) if fault.magnitude and fault.magnitude.unit == unit else None
            if scale and not isinstance(magnitude, str):
                return place, number, scale.strength(magnitude), phase, id_
        return place, len(faults), member, phase, id_

    return key


def searched(mutants: Iterable[MutantScore], roster: Roster) -> frozenset[str]:
    """The ids off the catalogue flown in fewer situations than others of their cell: what a search flies."""
    listed = list(mutants)
    flown: dict[str, int] = {}
    for mutant in listed:
        cell = cell_of(mutant.subject.id)
        flown[cell] = max(flown.get(cell, 0), mutant.kill_rate_flown.whole)
    ids = {m.subject.id for m in listed if m.kill_rate_flown.whole < flown[cell_of(m.subject.id)]}
    return frozenset(ids.difference(roster.ids))
