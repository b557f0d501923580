"""The deviation matrix: every guideword applied to every parameter."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.cell import Cell, CellStatus
from scaloft_fi.hazop.guideword import Guideword
from scaloft_fi.hazop.parameter import Parameter
from scaloft_fi.hazop.severity import SeverityClass


@dataclass(frozen=True)
class Matrix:
    """A total map guideword x parameter -> cell.

    Iterates over its cells, parameter by parameter, in the order of the study.

    Attributes:
        guidewords: in the order of the study.
        parameters: in the order of the study.
        cells: by (guideword id, parameter id).
        classes: of severity, worst first; empty in a study without them.
        severities: class of each cell that has one, by the cell's name.

    Raises:
        ValueError: a cell is missing, or one stands under a name that is not its own.
    """

    guidewords: tuple[Guideword, ...]
    parameters: tuple[Parameter, ...]
    cells: Mapping[tuple[str, str], Cell]
    classes: tuple[SeverityClass, ...] = ()
    severities: Mapping[str, SeverityClass] = field(default_factory=dict)

    def __post_init__(self) -> None:
        keys = {(word.id, parameter.id) for word in self.guidewords for parameter in self.parameters}
        if keys != set(self.cells):
            raise ValueError(f"the matrix is not total: {sorted(keys ^ set(self.cells))}")
        for key, cell in self.cells.items():
            if key != (cell.guideword, cell.parameter):
                raise ValueError(f"{cell.name} stands under {key}")

    def __iter__(self) -> Iterator[Cell]:
        return (self.cells[word.id, parameter.id] for parameter in self.parameters for word in self.guidewords)

    def __len__(self) -> int:
        return len(self.cells)

    def __contains__(self, name: object) -> bool:
        return name in self._by_name

    @cached_property
    def _by_name(self) -> Mapping[str, Cell]:
        return {cell.name: cell for cell in self}

    def cell(self, name: str) -> Cell:
        """Find the cell called `GUIDEWORD-parameter`.

        Raises:
            InputError: there is none; it says which is the nearest.
        """
        if name in self._by_name:
            return self._by_name[name]
        names = {known.casefold(): known for known in self._by_name}
        hint = did_you_mean(names.get(name.casefold(), name), names.values())
        raise InputError(f"no cell {name!r}{hint}")

    def counts(self) -> dict[CellStatus, int]:
        """Count the cells of each status."""
        return {status: sum(cell.status is status for cell in self) for status in CellStatus}

    def only(self, guidewords: Collection[str] = (), parameters: Collection[str] = ()) -> Matrix:
        """Keep the part of the matrix under these guidewords and parameters; an argument that is not given means all.

        Raises:
            InputError: a name is not in the matrix.
        """
        words = tuple(word for word in self.guidewords if word.id in guidewords or not guidewords)
        kept = tuple(parameter for parameter in self.parameters if parameter.id in parameters or not parameters)
        _all_known("guideword", guidewords, [word.id for word in self.guidewords])
        _all_known("parameter", parameters, [parameter.id for parameter in self.parameters])
        cells = {(w.id, p.id): self.cells[w.id, p.id] for w in words for p in kept}
        return replace(self, guidewords=words, parameters=kept, cells=cells)


def _all_known(noun: str, names: Collection[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            raise InputError(f"no {noun} {name!r}{did_you_mean(name, known)}")
