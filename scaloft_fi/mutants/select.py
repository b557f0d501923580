"""From what a user writes to mutants: a cell's name, an id, or a pattern."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants.derive import realise
from scaloft_fi.mutants.mutant import Mutant, parse

_GLOB = re.compile(r"[*?\[]")


def select(patterns: Iterable[str], matrix: Matrix, catalogue: Sequence[Mutant]) -> tuple[Mutant, ...]:
    """The mutants that `patterns` mean, without repeats, in the order of the patterns.

    A pattern with `*`, `?` or `[` matches the catalogue's ids; a bare cell name is its default; any other id is
    realised from the matrix, also when its magnitude or phase is not in the catalogue.

    Raises:
        InputError: a pattern matches nothing, or an id is not allowed; it names the nearest id.
    """
    chosen: dict[str, Mutant] = {}
    for pattern in patterns:
        for mutant in _meant(pattern, matrix, catalogue):
            chosen.setdefault(mutant.id, mutant)
    return tuple(chosen.values())


def _meant(pattern: str, matrix: Matrix, catalogue: Sequence[Mutant]) -> Iterable[Mutant]:
    if _GLOB.search(pattern):
        found = [mutant for mutant in catalogue if fnmatchcase(mutant.id, pattern)]
        if not found:
            raise InputError(f"no mutant matches {pattern!r}{_nearest(pattern, catalogue)}")
        return found
    try:
        cell = parse(pattern).cell
    except InputError as error:
        raise InputError(f"{error}{_nearest(pattern, catalogue)}") from None
    if cell not in matrix:
        raise InputError(f"no mutant {pattern!r}{_nearest(pattern, catalogue)}")
    return (realise(matrix, pattern),)


def _nearest(text: str, catalogue: Sequence[Mutant]) -> str:
    """The nearest id or cell name, whatever the case of the letters."""
    names = {name.casefold(): name for mutant in catalogue for name in (mutant.cell, mutant.id)}
    return did_you_mean(names.get(text.casefold(), text), names.values())
