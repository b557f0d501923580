"""The mutants of a study: derived from the deviation matrix, selected by name, listed in a committed file."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fnmatch import fnmatchcase
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.document import CATALOGUE_BYTES, UnreadableError, read_text
from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.hazop.matrix import Cell, CellStatus, Fault, Matrix, Name, Rung, parse, split_magnitude
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operator import OperatorError
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.output import write_whole, writing

if TYPE_CHECKING:
    from scaloft_fi.stack.declaration import Seam


def derive(matrix: Matrix) -> tuple[Mutant, ...]:
    """All mutants of a matrix, in the order parameter, guideword, fault, magnitude, phase.

    Raises:
        InputError: naming file and line of an operator, seam or argument that does not exist or is not allowed.
    """
    return tuple(
        _patched(cell, fault, rung, *strikes)
        for cell in matrix
        for fault in cell.faults
        for rung in fault.rungs
        for strikes in fault.strikes(rung)
    )


def defaults(matrix: Matrix) -> tuple[Mutant, ...]:
    """One mutant for each credible and each control cell: its first fault at the default magnitude, unshifted.

    Raises:
        InputError: as `derive`.
    """
    return tuple(default_of(cell) for cell in matrix if cell.faults)


def default_of(cell: Cell) -> Mutant:
    """The mutant that the bare name of a cell stands for.

    Raises:
        InputError: the cell is not meaningful; or as `derive`.
    """
    _refuse_blank(cell)
    fault = cell.faults[0]
    return _patched(cell, fault, fault.magnitude.default if fault.magnitude else None)


def realise(matrix: Matrix, text: str) -> Mutant:
    """The mutant that an id stands for, in the catalogue or not.

    Raises:
        InputError: the id is malformed, its cell is unknown or not meaningful, or its magnitude or phase is not
            allowed.
    """
    name = parse(text)
    cell = matrix.cell(name.cell)
    _refuse_blank(cell)
    fault, rung = _chosen(cell, name, text)
    return _patched(cell, fault, rung, name.phase_s, name.event, written=text)


def source_of(matrix: Matrix, mutant: Mutant) -> tuple[Fault, Rung | None]:
    """The fault of the matrix that a mutant realises, and its magnitude there."""
    cell = matrix.cells[mutant.guideword, mutant.parameter]
    return _chosen(cell, mutant.name, mutant.id)


def _refuse_blank(cell: Cell) -> None:
    if cell.status is CellStatus.NOT_MEANINGFUL:
        raise InputError(f"mutant {cell.name!r} does not exist; the cell is not meaningful: {cell.reason}")
    if cell.status is CellStatus.TO_DO:
        remedy = "give it faults, requirements and the status credible"
        raise InputError(f"mutant {cell.name!r} does not exist; the cell is to do: {remedy} ({cell.place})")


def _chosen(cell: Cell, name: Name, text: str) -> tuple[Fault, Rung | None]:
    """The fault that the unit of the magnitude picks, and the magnitude."""
    first = cell.faults[0]
    if not name.magnitude:
        return first, first.magnitude.default if first.magnitude else None
    rung, unit = split_magnitude(name.magnitude)
    laddered = [(fault, fault.magnitude) for fault in cell.faults if fault.magnitude is not None]
    if not laddered:
        raise InputError(f"mutant {text!r}: {cell.name} has no magnitude; write {cell.name!r}")
    for fault, magnitude in laddered:
        if unit == magnitude.unit and isinstance(rung, str) == isinstance(magnitude.ladder[0], str):
            return fault, rung
    ladder = [f"{cell.name}@{magnitude.text(rung)}" for _, magnitude in laddered for rung in magnitude.ladder]
    raise InputError(f"mutant {text!r}: {name.magnitude!r} is no magnitude of {cell.name}{did_you_mean(text, ladder)}")


def _patched(
    cell: Cell, fault: Fault, rung: Rung | None, phase_s: float = 0.0, event: str = "", written: str = ""
) -> Mutant:
    """The mutant of `fault`; errors name `written`, the id that a user wrote, or else the place in the matrix."""
    try:
        operator = OPERATORS[fault.operator]
    except InputError as error:
        raise InputError(f"{fault.place_of('operator')}: {error}") from None
    message = fault.message
    if message is None:
        raise ValueError(f"{cell.name}: the matrix was read without the stack's seams")
    magnitude = "" if fault.magnitude is None or rung is None else fault.magnitude.text(rung)
    name = Name(cell.guideword, cell.parameter, magnitude, float(f"{phase_s:g}"), event)
    arguments = dict(fault.arguments)
    if fault.magnitude is not None and rung is not None:
        arguments[fault.magnitude.argument] = fault.magnitude.value(rung)
    if name.phase and not fault.phases:
        bare = replace(name, phase_s=0.0, event="")
        raise InputError(f"mutant {written!r}: {cell.name} has no phase; write {str(bare)!r}")
    if event:
        _check_event(name, fault, written)
    elif fault.phases:
        arguments["phase_s"] = name.phase_s
    try:
        checked = operator.check(fault.seam, message, arguments)
    except OperatorError as error:
        place = (
            f"mutant {written!r}" if written else fault.place_of("phases" if error.about == "phase_s" else error.about)
        )
        raise InputError(f"{place}: {error}") from None
    where = fault.seam, fault.operator, checked, event
    return Mutant(str(name), cell.guideword, cell.parameter, magnitude, name.phase_s, *where)


def _check_event(name: Name, fault: Fault, written: str) -> None:
    """Refuse an event that does not exist or cannot come."""
    if name.event not in fault.events:
        raise InputError(f"mutant {written!r}: no event {name.event!r}{did_you_mean(name.event, fault.events)}")
    if why_not := fault.events[name.event]:
        raise InputError(f"mutant {written!r}: the event {name.event!r} cannot come: {why_not}")


def with_events(matrix: Matrix, events: Mapping[str, str]) -> Matrix:
    """The matrix whose faults with phases strike at events too.

    Args:
        matrix: the matrix.
        events: by name of an event of a flight why it can come in no flight of the study; "" if it can.
    """
    cells = {
        key: replace(cell, faults=tuple(replace(f, events=events) if f.phases else f for f in cell.faults))
        for key, cell in matrix.cells.items()
    }
    return replace(matrix, cells=cells)


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
    """A hint at the nearest id or cell name, or the first that a pattern matches; case does not matter."""
    names = {name.casefold(): name for mutant in catalogue for name in (mutant.cell, mutant.id)}
    fits = (name for folded, name in names.items() if fnmatchcase(folded, text.casefold()))
    return did_you_mean(next(fits, text), names.values())


CATALOGUE = "catalogue.jsonl"
LONGEST_LINE = 10_000
"""Most characters of a line; those of the reference study have at most 290."""
_REMEDY = "write it with `scaloft-fi mutants --write`"


def catalogue_lines(catalogue: Iterable[Mutant]) -> list[str]:
    """One JSON object for each mutant, with sorted keys: the same mutants give the same bytes."""
    return [json.dumps(mutant.to_json(), sort_keys=True, ensure_ascii=False) for mutant in catalogue]


def suggested(word: str, about: str, matrices: Iterable[Matrix], seams: Mapping[str, Seam]) -> Fault | None:
    """The fault that the names in somebody's sheet suggest; None where they fit no seam, or nothing that a study does.

    The seam is the one whose name, stages and message share most words with the text, if it is one alone; the fault is
    that of the guideword which stands most often in matrices and fits the seam, one at that seam before all others.

    Args:
        word: a guideword.
        about: node, parameter and deviation, as the sheet has them.
        matrices: with faults to learn from.
        seams: of the study's stack.
    """
    told = _words(about)
    shared = {name: len(told & _words(f"{name} {seam.edge}")) + 2 * (name in told) for name, seam in seams.items()}
    best = [name for name, count in shared.items() if count and count == max(shared.values())]
    if len(best) != 1:
        return None
    seam, faults = (
        seams[best[0]],
        [fault for matrix in matrices for cell in matrix if cell.guideword == word for fault in cell.faults],
    )
    operators = Counter(fault.operator for fault in faults)
    for fault in sorted(faults, key=lambda one: (one.seam != seam.name, -operators[one.operator])):
        moved = replace(fault, seam=seam.name, message=seam.message, expected=None, places={})
        with suppress(InputError):
            _patched(Cell(word, "x", CellStatus.CREDIBLE), moved, fault.magnitude.default if fault.magnitude else None)
            return moved
    return None


def _words(text: str) -> set[str]:
    """The words of a text, without an s at their end."""
    return {word.removesuffix("s") for word in re.findall(r"[a-z]{3,}", text.casefold())}


def write_catalogue(folder: Path, catalogue: Iterable[Mutant]) -> Path:
    """Write the catalogue of a study's `mutants/` folder.

    Raises:
        InputError: the folder cannot be written to.
    """
    path = folder / CATALOGUE
    content = "".join(f"{line}\n" for line in catalogue_lines(catalogue)).encode()
    with writing(f"{path}: cannot be written"):
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, content)
    return path


def check_catalogue(folder: Path, matrix: Matrix) -> tuple[Mutant, ...]:
    """The catalogue of a study's `mutants/` folder, compared line by line with what its matrix derives.

    Raises:
        InputError: there is none, or it is stale; it names the first id that differs.
    """
    derived, path = derive(matrix), folder / CATALOGUE
    try:
        lines = read_text(path, CATALOGUE_BYTES).splitlines()
    except UnreadableError as error:
        raise InputError(f"{error}; {_REMEDY}") from error
    for number, (line, expected, mutant) in enumerate(zip_longest(lines, catalogue_lines(derived), derived), 1):
        if line == expected:
            continue
        written = "" if line is None else _mutant(path, number, line).id
        if line is None:
            what = f"{mutant.id!r} is missing"
        elif mutant is None:
            what = f"{shown(written)} is not in the matrix"
        elif written == mutant.id:
            what = f"{shown(written)} differs from the matrix"
        else:
            what = f"{shown(written)} stands where the matrix gives {mutant.id!r}"
        raise InputError(f"{path}:{number}: the catalogue is stale: {what}; {_REMEDY}")
    return derived


def _mutant(path: Path, number: int, line: str) -> Mutant:
    if len(line) > LONGEST_LINE:
        raise InputError(f"{path}:{number}: the line must have at most {LONGEST_LINE:,} characters; {_REMEDY}")
    try:
        return Mutant.from_json(json.loads(line))
    except (ValueError, TypeError, AttributeError, RecursionError, InputError) as error:
        reason = str(error) if isinstance(error, InputError) else "not a mutant in JSON"
        raise InputError(f"{path}:{number}: {reason}; {_REMEDY}") from error
