"""Selects mutants by what a user writes: a cell's name, an id, or a pattern."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.hazop.name import parse
from scaloft_fi.mutants.derive import default_of, realise
from scaloft_fi.mutants.mutant import Mutant

_GLOB = re.compile(r"[*?\[]")


def select(patterns: Iterable[str], matrix: Matrix, catalogue: Sequence[Mutant]) -> tuple[Mutant, ...]:
    """The mutants that `patterns` select, without repeats, in the order of the patterns.

    A bare cell name stands for the cell's default.  A pattern with `*`, `?` or `[` matches ids of the catalogue and
    names of cells: `LATE-human*` is the whole ladder, `*-human` the defaults of every cell of `human`.  Any other id is
    realised from the matrix, also when its magnitude or phase is not in the catalogue.

    Raises:
        InputError: a pattern matches nothing, or an id is not allowed; it names the nearest id.
    """
    chosen: dict[str, Mutant] = {}
    for pattern in patterns:
        for mutant in _selected(pattern, matrix, catalogue):
            chosen.setdefault(mutant.id, mutant)
    return tuple(chosen.values())


def _selected(pattern: str, matrix: Matrix, catalogue: Sequence[Mutant]) -> Iterable[Mutant]:
    if _GLOB.search(pattern):
        named = {default_of(cell).id for cell in matrix if cell.faults and fnmatchcase(cell.name, pattern)}
        matching = [mutant for mutant in catalogue if mutant.id in named or fnmatchcase(mutant.id, pattern)]
        if not matching:
            raise InputError(f"no mutant matches {pattern!r}{_nearest(pattern, catalogue)}")
        return matching
    try:
        cell = parse(pattern).cell
    except InputError as error:
        raise InputError(f"{error}{_nearest(pattern, catalogue)}") from None
    if cell not in matrix:
        raise InputError(f"no mutant {pattern!r}{_nearest(pattern, catalogue)}")
    return (realise(matrix, pattern),)


def _nearest(text: str, catalogue: Sequence[Mutant]) -> str:
    """A hint at the nearest id or cell name; upper and lower case do not matter."""
    names = {name.casefold(): name for mutant in catalogue for name in (mutant.cell, mutant.id)}
    return did_you_mean(names.get(text.casefold(), text), names.values())
