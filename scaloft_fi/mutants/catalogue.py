"""The catalogue: a committed file with every mutant of the study, one on each line."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from itertools import zip_longest
from pathlib import Path

from scaloft_fi.errors import InputError, shown
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants.derive import derive
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.output import write_whole
from scaloft_fi.reading import CATALOGUE_BYTES, UnreadableError, read_text

FILE = "catalogue.jsonl"
LONGEST_LINE = 10_000
"""Most characters of a line; those of the reference study have at most 290."""
_REMEDY = "write it with `scaloft-fi mutants --write`"


def lines(catalogue: Iterable[Mutant]) -> list[str]:
    """One JSON object for each mutant, with sorted keys: the same mutants give the same bytes."""
    return [json.dumps(mutant.to_json(), sort_keys=True, ensure_ascii=False) for mutant in catalogue]


def write(folder: Path, catalogue: Iterable[Mutant]) -> Path:
    """Write the catalogue of a study's `mutants/` folder.

    Raises:
        InputError: the folder cannot be written to.
    """
    path = folder / FILE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, "".join(f"{line}\n" for line in lines(catalogue)).encode())
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
    return path


def read(folder: Path) -> tuple[Mutant, ...]:
    """Read the catalogue of a study's `mutants/` folder.

    Raises:
        InputError: there is none, or a line is not a mutant.
    """
    return tuple(_mutant(folder / FILE, number, line) for number, line in enumerate(_text(folder), 1))


def check(folder: Path, matrix: Matrix) -> tuple[Mutant, ...]:
    """The catalogue of a study's `mutants/` folder, compared line by line with what its matrix derives.

    Raises:
        InputError: there is none, or it is stale; it names the first id that differs.
    """
    derived = derive(matrix)
    path = folder / FILE
    for number, (line, expected) in enumerate(zip_longest(_text(folder), lines(derived)), 1):
        if line == expected:
            continue
        raise InputError(
            f"{path}:{number}: the catalogue is stale: {_difference(path, number, line, derived)}; {_REMEDY}"
        )
    return derived


def _difference(path: Path, number: int, line: str | None, derived: Sequence[Mutant]) -> str:
    expected = derived[number - 1].id if number <= len(derived) else None
    if line is None:
        return f"{expected!r} is missing"
    written = _mutant(path, number, line).id
    if expected is None:
        return f"{shown(written)} is not in the matrix"
    if written == expected:
        return f"{shown(written)} differs from the matrix"
    return f"{shown(written)} stands where the matrix gives {expected!r}"


def _text(folder: Path) -> list[str]:
    path = folder / FILE
    try:
        return read_text(path, CATALOGUE_BYTES).splitlines()
    except UnreadableError as error:
        raise InputError(f"{error}; {_REMEDY}") from error


def _mutant(path: Path, number: int, line: str) -> Mutant:
    if len(line) > LONGEST_LINE:
        raise InputError(f"{path}:{number}: the line must have at most {LONGEST_LINE:,} characters; {_REMEDY}")
    try:
        return Mutant.from_json(json.loads(line))
    except (ValueError, TypeError, AttributeError, RecursionError, InputError) as error:
        reason = str(error) if isinstance(error, InputError) else "not a mutant in JSON"
        raise InputError(f"{path}:{number}: {reason}; {_REMEDY}") from error
