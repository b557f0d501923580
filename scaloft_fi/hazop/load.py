"""Find the folder of the study, and read its `hazop/`; every unknown or invalid entry is refused with file and line.

Operators and their arguments are checked in `mutants`, names of requirements in `study`; both use the places that this
module keeps.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Protocol

from scaloft_fi.document import Item, is_folder, is_there, load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.matrix import (
    PERIODS,
    SEVERITIES,
    Cell,
    CellStatus,
    Expected,
    Fault,
    Guideword,
    Magnitude,
    Matrix,
    Parameter,
    Rung,
    SeverityClass,
    Value,
    Worse,
    load_severities,
    read_severity,
    worse,
)

FOLDERS = ("hazop", "mutants", "sim")
_PACKAGE = Path(__file__).resolve().parents[1]


def find_study(path: Path | str | None = None) -> Path:
    """Find the study's folder: `path`, else the nearest study upwards, the packaged study, or the checkout's.

    Raises:
        InputError: `path` is not a study, or no study exists in any of these places.
    """
    if path is not None:
        lacking = [f"{name}/" for name in FOLDERS if not is_folder(Path(path) / name)]
        if lacking:
            allowed = "a folder with hazop/, mutants/ and sim/"
            raise InputError(f"--study={str(path)!r} must be {allowed}; it lacks {', '.join(lacking)}")
        return Path(path)
    here = _here()
    near = nearest_study(here)
    if near is not None:
        return near
    try:
        return reference_study()
    except InputError as error:
        allowed = "a folder with hazop/, mutants/ and sim/"
        raise InputError(f"no study in {here} or above it: {allowed}; name one with --study") from error


def reference_study() -> Path:
    """The study of this installation: the packaged study, else the checkout's.

    Raises:
        InputError: the installation has lost it.
    """
    for folder in (_PACKAGE / "_study", _PACKAGE.parent):
        if _is_study(folder):
            return folder
    raise InputError(f"{_PACKAGE}: the reference study is missing; install scaloft-fi again")


def nearest_study(folder: Path | None = None) -> Path | None:
    """The study in a folder (default: the current one), or in the nearest folder above it; None where there is none.

    Raises:
        InputError: the current folder cannot be read.
    """
    here = folder or _here()
    return next((one for one in (here, *here.parents) if one != _PACKAGE and _is_study(one)), None)


def _is_study(folder: Path) -> bool:
    """The package has folders of these names too; callers leave it out."""
    return all(is_folder(folder / name) for name in FOLDERS)


def _here() -> Path:
    try:
        return Path.cwd()
    except OSError as error:
        raise InputError(
            f"the current folder cannot be read: {error.strerror}; go to another or name --study"
        ) from error


class Carrier(Protocol):
    """The part of a seam that the matrix needs."""

    @property
    def message(self) -> type:
        """Type of the seam's samples."""
        ...


Seams = Mapping[str, Carrier]

SHEETS = "matrix"
"""Folder of the files of cells, one for each parameter."""
MOST_ENTRIES = 100
"""Most causes, requirements or faults of a cell, and most magnitudes of a ladder."""
LARGEST_ARGUMENT = 1e12

_UNIT = re.compile(r"[A-Za-z%][A-Za-z0-9%]*")
_NAMED_RUNG = re.compile(r"[A-Za-z][A-Za-z0-9_.]*")


def load_matrix(hazop: Path, seams: Seams | None = None) -> Matrix:
    """Read the matrix of a study folder's `hazop/`.

    Args:
        hazop: folder with `guidewords.yaml`, `parameters.yaml`, `matrix/<parameter>.yaml` and, if the study has classes
            of severity, `severities.yaml`.
        seams: seams of the stack by name; None leaves the seams of the faults unchecked.

    Raises:
        InputError: an entry is not allowed; the message names file and line.
    """
    guidewords = load_guidewords(hazop / "guidewords.yaml")
    parameters, places = load_parameters(hazop / "parameters.yaml")
    for error in misnamed_sheets(hazop / SHEETS, places):
        raise error
    classes = load_severities(hazop / SEVERITIES)
    cells: dict[tuple[str, str], Cell] = {}
    severities: dict[str, SeverityClass] = {}
    for parameter in parameters:
        for cell, severity in load_cells(hazop / SHEETS / f"{parameter.id}.yaml", guidewords, seams, classes):
            cells[cell.guideword, cell.parameter] = cell
            if severity:
                severities[cell.name] = severity
    return Matrix(guidewords, parameters, cells, classes, severities)


def misnamed_sheets(folder: Path, parameters: Mapping[str, str]) -> Iterator[InputError]:
    """An error for each file of cells without a parameter, and for each parameter without a file.

    Args:
        folder: the folder of the files.
        parameters: place of each parameter by id.
    """
    for path in sorted(folder.glob("*.yaml")):
        if path.stem not in parameters:
            yield InputError(f"{path}:1: {path.stem!r} is not a parameter{did_you_mean(path.stem, parameters)}")
    for name, place in parameters.items():
        path = folder / f"{name}.yaml"
        if not is_there(path):
            yield InputError(f"{place}: parameter {name!r} has no cells: {path} is missing")


def load_guidewords(path: Path) -> tuple[Guideword, ...]:
    """Read the guidewords of one file, in the order of the file.

    Raises:
        InputError: a guideword is not in capitals, an extension gives no reason, a key is missing or unknown.
    """
    words = []
    for name, item in load(path).mapping().items():
        _guard_name(item, name, r"[A-Z][A-Z0-9]*", "capital letters, as in a mutant's id")
        extension = (flag := item.get("extension")) is not None and flag.flag()
        words.append(
            Guideword(
                id=name,
                title=item.need("title").text(),
                meaning=item.need("meaning").text(),
                extension=extension,
                reason=item.need("reason").text() if extension else "",
            )
        )
        item.close()
    return tuple(words)


def load_parameters(path: Path) -> tuple[tuple[Parameter, ...], dict[str, str]]:
    """Read the parameters of one file, in the order of the file, and the place of each by id.

    Raises:
        InputError: an id is not in small letters, a key is missing or unknown.
    """
    parameters, places = [], {}
    for name, item in load(path).mapping().items():
        _guard_name(item, name, r"[a-z][a-z0-9_]*", "small letters, as in a mutant's id")
        fields = {key: item.need(key).text() for key in ("title", "intent", "node", "unit")}
        parameters.append(Parameter(id=name, **fields))
        places[name] = item.place
        item.close()
    return tuple(parameters), places


def load_cells(
    path: Path, guidewords: tuple[Guideword, ...], seams: Seams | None = None, classes: tuple[SeverityClass, ...] = ()
) -> tuple[tuple[Cell, SeverityClass | None], ...]:
    """Read the cells of one parameter with their severity, one for each guideword; the parameter names the file.

    Raises:
        InputError: a guideword is unknown, a guideword has no cell, a key of a cell is missing or not allowed.
    """
    sheet, ids = load(path), [word.id for word in guidewords]
    for error in misnamed_cells(sheet, ids):
        raise error
    return tuple(read_cell(sheet, word, path.stem, seams, classes) for word in ids)


def misnamed_cells(sheet: Item, guidewords: Collection[str]) -> Iterator[InputError]:
    """An error for each cell of a file that has no guideword."""
    for name, item in sheet.mapping().items():
        if name not in guidewords:
            yield InputError(f"{item.place}: {name!r} is not a guideword{did_you_mean(name, guidewords)}")


def read_cell(
    sheet: Item, guideword: str, parameter: str, seams: Seams | None = None, classes: tuple[SeverityClass, ...] = ()
) -> tuple[Cell, SeverityClass | None]:
    """Read one cell of the file of a parameter, and its severity.

    Raises:
        InputError: the cell is blank, or a key of it is missing or not allowed.
    """
    item = sheet.get(guideword)
    if item is None or item.value is None:
        place, name = (item or sheet).place, f"{guideword}-{parameter}"
        raise InputError(
            f"{place}: the cell {name} is blank; it must be credible, a control, or not_meaningful with a reason"
        )
    status = CellStatus(item.need("status").choice(tuple(CellStatus)))
    severity = read_severity(item, classes)
    if status is CellStatus.NOT_MEANINGFUL:
        cell = Cell(guideword, parameter, status, reason=item.need("reason").text(), place=item.place)
    else:
        requirements = item.need("requirements")
        cell = Cell(
            guideword,
            parameter,
            status,
            deviation=item.need("deviation").text(),
            causes=tuple(cause.text() for cause in _nonempty(item.need("causes"))),
            effect=item.need("effect").text(),
            requirements=tuple(name.text() for name in _nonempty(requirements)),
            faults=tuple(_fault(fault, seams) for fault in _nonempty(item.need("faults"))),
            predicted=predicted.text() if (predicted := item.get("predicted")) else "",
            place=item.place,
            requirements_place=requirements.place,
        )
        _guard_units(cell)
    item.close()
    return cell, severity


def _fault(item: Item, seams: Seams | None) -> Fault:
    seam, operator = item.need("seam"), item.need("operator")
    arguments = given.mapping() if (given := item.get("arguments")) else {}
    magnitude = _magnitude(entry) if (entry := item.get("magnitude")) else None
    if magnitude is not None and magnitude.argument in arguments:
        place = arguments[magnitude.argument].place
        raise InputError(f"{place}: {magnitude.argument!r} is set by the magnitude and cannot be a fixed argument too")
    phases, known = item.get("phases"), item.get("expected")
    named = {"seam": seam, "operator": operator, **arguments} | ({"phases": phases} if phases else {})
    fault = Fault(
        seam=(name := seam.text() if seams is None else seam.choice(sorted(seams))),
        message=None if seams is None else seams[name].message,
        operator=operator.text(),
        arguments={name: _value(argument) for name, argument in arguments.items()},
        magnitude=magnitude,
        phases=phases is not None and phases.flag(),
        expected=_expected(known, magnitude) if known else None,
        place=item.place,
        places={name: entry.place for name, entry in named.items()},
    )
    item.close()
    if fault.phases and not any(
        name in PERIODS for name in (*fault.arguments, magnitude.argument if magnitude else "")
    ):
        raise InputError(
            f"{item.place}: a fault with phases must have its {' or '.join(PERIODS)}, of which a phase is a share"
        )
    return fault


def _magnitude(item: Item) -> Magnitude:
    ladder, default = item.need("ladder"), item.need("default")
    rungs = tuple(_rung(rung) for rung in _nonempty(ladder))
    if len({type(rung) for rung in rungs}) > 1:
        raise ladder.error("all numbers or all names")
    if len(set(rungs)) < len(rungs):
        raise ladder.error("different magnitudes")
    if (chosen := _rung(default)) not in rungs:
        raise default.error(f"on the ladder: {', '.join(map(_written, rungs))}")
    named = isinstance(rungs[0], str)
    unit = item.get("unit")
    factor = item.get("scale")
    direction, neutral = item.get("worse"), item.get("neutral")
    magnitude = Magnitude(
        argument=item.need("argument").text(),
        unit=_unit(unit) if unit else "",
        ladder=rungs,
        default=chosen,
        scale=factor.number() if factor else 1.0,
        worse=direction.choice(tuple(Worse)) if direction else "",
        neutral=neutral.number() if neutral else None,
        place=item.place,
    )
    if named and unit is not None and magnitude.unit:
        raise unit.error("left out where the ladder holds names")
    if factor is not None and (named or magnitude.scale == 0 or not math.isfinite(magnitude.scale)):
        raise factor.error("left out where the ladder holds names" if named else "a finite number other than 0")
    if named and direction is not None and magnitude.worse != Worse.UNORDERED:
        raise direction.error("left out where the ladder holds names")
    if neutral is not None and worse(magnitude) is Worse.UNORDERED:
        raise neutral.error("left out where the ladder has no order")
    item.close()
    return magnitude


def _expected(item: Item, magnitude: Magnitude | None) -> Expected:
    status, reason, only = item.need("status"), item.need("reason"), item.get("magnitudes")
    rungs = tuple(_rung(rung) for rung in _nonempty(only)) if only else ()
    for rung in rungs:
        if magnitude is None or rung not in magnitude.ladder:
            assert only is not None
            ladder = ", ".join(map(_written, magnitude.ladder)) if magnitude else "none, the fault has no magnitude"
            raise InputError(f"{only.place}: magnitudes: {_written(rung)} must be on the ladder: {ladder}")
    item.close()
    return Expected(reason.text(), rungs, status.choice(("not_infected",)), item.place)


def _guard_name(item: Item, name: str, pattern: str, allowed: str) -> None:
    if not re.fullmatch(pattern, name):
        raise InputError(f"{item.place}: name {name!r} must be {allowed}")


def _guard_units(cell: Cell) -> None:
    """Refuse two faults of a cell whose magnitudes have the same unit: the unit in an id selects the fault."""
    units: list[str] = []
    for fault in cell.faults:
        if len(cell.faults) > 1 and (fault.magnitude is None or fault.magnitude.unit in units):
            allowed = "a magnitude in a unit of its own; the unit in an id selects the fault"
            raise InputError(f"{fault.place}: each fault of {cell.name} must have {allowed}")
        units.append(fault.magnitude.unit if fault.magnitude else "")


def _nonempty(item: Item) -> tuple[Item, ...]:
    entries = item.items(most=MOST_ENTRIES)
    if not entries:
        raise item.error("a list of at least one")
    return entries


def _unit(item: Item) -> str:
    if item.value == "" or (isinstance(item.value, str) and _UNIT.fullmatch(item.value)):
        return item.value
    raise item.error("a unit of letters, digits and %, as in a mutant's id")


def _rung(item: Item) -> Rung:
    if isinstance(item.value, str):
        if not _NAMED_RUNG.fullmatch(item.value):
            raise item.error("a number, or a name of letters, digits, _ and .")
        return item.value
    return _number(item)


def _number(item: Item) -> float:
    """A magnitude or an argument; an operator may allow `.inf`, such as a hold that never ends."""
    return item.number(least=-LARGEST_ARGUMENT, most=LARGEST_ARGUMENT, infinite=True)


def _written(rung: Rung) -> str:
    return rung if isinstance(rung, str) else f"{rung:g}"


def _value(item: Item) -> Value:
    if isinstance(item.value, bool):
        return item.value
    return item.text() if isinstance(item.value, str) else _number(item)
