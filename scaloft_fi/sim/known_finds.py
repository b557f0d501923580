"""The finds of a study that still fit it, for the verbs that read results."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.mutants.derive import realise
from scaloft_fi.sim.found import FILE, Find, read_finds
from scaloft_fi.sim.grids import WITH_FOUND, own_name, searched_grid

if TYPE_CHECKING:
    from scaloft_fi.hazop.matrix import Matrix
    from scaloft_fi.sim.grid import Grid


@dataclass(frozen=True)
class KnownFinds:
    """The finds of a study.

    Attributes:
        finds: those that fit the study, in the file's order.
        misfits: why the others are left out, by name.
        grid: name of the grid that flies them.
        searched: the grid that was searched, whose keys they have; None without one.
    """

    finds: tuple[Find, ...] = ()
    misfits: Mapping[str, str] = field(default_factory=dict)
    grid: str = ""
    searched: Grid | None = None

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence for each reason for which finds are left out."""
        names: dict[str, list[str]] = {}
        for name, why in self.misfits.items():
            names.setdefault(why, []).append(name)
        return tuple(
            f"sim/{FILE}: left out, because the study has changed since: {', '.join(some)}: {why}"
            for why, some in names.items()
        )

    def of(self, mutant: str) -> tuple[Find, ...]:
        """The finds that show a mutant, the one that it was found for first."""
        shown_in = [find for find in self.finds if mutant in find.shows]
        return tuple(sorted(shown_in, key=lambda find: find.mutant != mutant))


NO_FINDS = KnownFinds()


def known_finds(folder: Path, matrix: Matrix, requirements: Collection[str]) -> KnownFinds:
    """The finds of a study; those of another version of the study are left out.

    Args:
        folder: the study's `sim` folder.
        matrix: the study's matrix.
        requirements: names of the study's requirements.

    Raises:
        InputError: as `read_finds`.
    """
    found = read_finds(folder)
    if found is None:
        return NO_FINDS
    grid = own_name(folder) + WITH_FOUND
    try:
        searched = searched_grid(folder, found)
    except InputError as error:
        return KnownFinds((), dict.fromkeys((find.name for find in found.finds), str(error)), grid)
    fitting, misfits = [], dict[str, str]()
    for find in found.finds:
        try:
            _check(find, searched, matrix, requirements)
        except InputError as error:
            misfits[find.name] = str(error)
        else:
            fitting.append(find)
    return KnownFinds(tuple(fitting), misfits, grid, searched)


def _check(find: Find, searched: Grid, matrix: Matrix, requirements: Collection[str]) -> None:
    """Refuse a find whose situation, mutants or requirements the study does not have.

    Raises:
        InputError: it has not.
    """
    searched.situation(find.situation)
    for mutant, evidence in find.shows.items():
        realise(matrix, mutant)
        if evidence.requirement not in requirements:
            hint = did_you_mean(evidence.requirement, requirements)
            raise InputError(f"no requirement {shown(evidence.requirement)}{hint}")
