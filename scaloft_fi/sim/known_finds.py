"""The finds and breaks of a study that still fit it, for the verbs that read results."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.sim.found import FILE, Break, Find, read_finds
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
        breaks: situations that break the unmutated drone, in the file's order; misfits are told as those of finds.
    """

    finds: tuple[Find, ...] = ()
    misfits: Mapping[str, str] = field(default_factory=dict)
    grid: str = ""
    searched: Grid | None = None
    breaks: tuple[Break, ...] = ()

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
        searched = searched_grid(folder, found, proved=False)
    except InputError as error:
        return KnownFinds((), dict.fromkeys(found.named, str(error)), grid)
    misfits: dict[str, str] = {}
    named: tuple[Find | Break, ...] = (*found.finds, *found.breaks)
    for one in named:
        try:
            _check(one, searched, matrix, requirements)
        except InputError as error:
            misfits[one.name] = str(error)
    return KnownFinds(
        tuple(find for find in found.finds if find.name not in misfits),
        misfits,
        grid,
        searched,
        tuple(one for one in found.breaks if one.name not in misfits),
    )


def _check(one: Find | Break, searched: Grid, matrix: Matrix, requirements: Collection[str]) -> None:
    """Refuse what has a situation, mutants or requirements that the study does not have.

    Raises:
        InputError: it has them.
    """
    searched.situation(one.situation)
    shows = one.shows if isinstance(one, Find) else {}
    for mutant in shows:
        realise(matrix, mutant)
    judged = [evidence.requirement for evidence in shows.values()] if isinstance(one, Find) else [one.requirement]
    for requirement in judged:
        if requirement not in requirements:
            raise InputError(f"no requirement {shown(requirement)}{did_you_mean(requirement, requirements)}")
