"""A study: the folder of everything a user edits, opened part by part, with the checks only the whole can make."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scaloft_fi.document import load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.folder import find_study
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.stack.seam import SEAMS

if TYPE_CHECKING:
    from scaloft_fi.mutants.mutant import Mutant
    from scaloft_fi.results.requirement import Requirement
    from scaloft_fi.results.roster import Roster
    from scaloft_fi.results.space import Realisation, Space
    from scaloft_fi.sim.config import SimConfig
    from scaloft_fi.sim.situation import Grid, Situation

PACKAGE = Path(__file__).resolve().parent
FLYING_CODE = ("stack", "sim", "mutants", "results/outcome.py", "results/requirement.py", "results/stl.py")
"""The sources that can change an outcome."""
NOT_FLOWN = ("situations.yaml", "requirements.yaml", "sources.yaml")
"""Files of `sim/` that do not enter a flight as a whole."""


@dataclass(frozen=True)
class Study:
    """A study; each part is read when it is first asked for.

    Attributes:
        folder: holds `hazop/`, `mutants/` and `sim/`.
    """

    folder: Path

    @classmethod
    def open(cls, folder: Path | str | None = None) -> Study:
        """The study in `folder`, else the nearest one upwards, else the packaged one.

        Raises:
            InputError: it is none.
        """
        return cls(find_study(folder))

    @property
    def packaged(self) -> bool:
        """Whether it is the one that came with the installed package, where no results can be written."""
        return self.folder.resolve() == PACKAGE / "_study"

    @property
    def results_folder(self) -> Path:
        """Where campaigns are."""
        return (Path.cwd() if self.packaged else self.folder) / "results"

    @cached_property
    def matrix(self) -> Matrix:
        """The deviation matrix."""
        return load_matrix(self.folder / "hazop", SEAMS)

    @cached_property
    def catalogue(self) -> tuple[Mutant, ...]:
        """Every mutant, proved to be what the matrix gives."""
        from scaloft_fi.mutants.catalogue import check

        return check(self.folder / "mutants", self.matrix)

    @cached_property
    def requirements(self) -> tuple[Requirement, ...]:
        """What flights are judged by."""
        from scaloft_fi.results.requirement import load_requirements
        from scaloft_fi.sim.signals import SIGNALS

        return load_requirements(self.folder / "sim" / "requirements.yaml", SIGNALS)

    @cached_property
    def roster(self) -> Roster:
        """The mutants as scores count them."""
        from scaloft_fi.hazop.cell import CellStatus
        from scaloft_fi.mutants.derive import default_of
        from scaloft_fi.results.roster import Roster

        credible = [cell for cell in self.matrix if cell.status is CellStatus.CREDIBLE]
        controls = frozenset(cell.name for cell in self.matrix if cell.status is CellStatus.CONTROL)
        defaults = {cell.name: default_of(cell).id for cell in credible}
        return Roster(defaults, controls, tuple(mutant.id for mutant in self.catalogue))

    def check(self) -> None:
        """Read every part and hold it against the others.

        Raises:
            InputError: naming the place of the first thing that does not fit.
        """
        known = [requirement.name for requirement in self.requirements]
        for cell in self.matrix:
            for name in cell.requirements:
                if name not in known:
                    place = cell.requirements_place
                    raise InputError(f"{place}: requirement {name!r} of {cell.name} is not one{did_you_mean(name, known)}")
        _ = self.catalogue, self.sim, self.grid
