"""Find the folder of the study, and read its `hazop/`; every unknown or invalid entry is refused with file and line.

Operators and their arguments are checked in `mutants`, names of requirements in `study`; both use the places that this
module keeps.
"""

from __future__ import annotations

import shlex
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from scaloft_fi.document import Item, is_folder, is_there, load
from scaloft_fi.errors import Faults, InputError, did_you_mean
from scaloft_fi.hazop import matrix as matrices
from scaloft_fi.marks import ByName, Choices, Either, Examples, Pattern, Size
from scaloft_fi.model import value_of
from scaloft_fi.output import STUDY_OPTION

if TYPE_CHECKING:
    from scaloft_fi.stack.declaration import Seam

FOLDERS = ("hazop", "mutants", "sim")
_PACKAGE = Path(__file__).resolve().parents[1]
MOST_BESIDE = 1_000
"""Most entries of a folder among which a study is looked for."""


@contextmanager
def named_study(folder: Path | None) -> Iterator[None]:
    """Within it the commands that are printed name the study as the user did."""
    nearest = nearest_study() if folder is not None else None
    same = folder is None or (nearest is not None and folder.resolve() == nearest.resolve())
    before = STUDY_OPTION.set("" if same else f" --study {shlex.quote(str(folder))}")
    try:
        yield
    finally:
        STUDY_OPTION.reset(before)


def find_study(path: Path | str | None = None) -> Path:
    """Find the study's folder: `path`, else the nearest study upwards, the packaged study, or the checkout's.

    Raises:
        InputError: `path` is not a study, or no study exists in any of these places.
    """
    allowed = "a folder with hazop/, mutants/ and sim/"
    if path is not None:
        if lacking := [f"{name}/" for name in FOLDERS if not is_folder(Path(path) / name)]:
            absent = not is_there(Path(path))
            flaw = f"there is no such folder{_studies_beside(path)}" if absent else f"it lacks {', '.join(lacking)}"
            raise InputError(f"--study={str(path)!r} must be {allowed}; {flaw}")
        return Path(path)
    here = _here()
    try:
        return nearest_study(here) or reference_study()
    except InputError as error:
        raise InputError(f"no study in {here} or above it: {allowed}; name one with --study") from error


def _studies_beside(path: Path | str) -> str:
    """The hint at a study in the folder in which this one would stand."""
    folder, studies = Path(path).parent, list[str]()
    with suppress(OSError, ValueError):  # no such folder either; a NUL in the name
        beside = islice(folder.iterdir(), MOST_BESIDE)
        studies = [str(one) for one in beside if _is_study(one) and one.resolve() != _PACKAGE]
    return did_you_mean(str(path), studies)


def study_around(campaign: str) -> Path | None:
    """The study in whose results/campaigns/ the folder of a campaign stands, where a path names it; else None."""
    path = Path(campaign)
    within = path.parts[-3:-1] == ("results", "campaigns")
    return path.parents[2] if within and _is_study(path.parents[2]) else None


def reference_study() -> Path:
    """The study of this installation: the packaged study, else the checkout's.

    Raises:
        InputError: the installation has lost it.
    """
    for folder in (_PACKAGE / "_study", _PACKAGE.parent):
        if _is_study(folder):
            return folder
    raise InputError(f"{_PACKAGE}: the reference study is missing; install scaloft-fi again")


def shipped(name: str) -> Path:
    """A folder of the checkout that the wheel carries too, with _ before its name."""
    return next(one for one in (_PACKAGE / f"_{name}", _PACKAGE.parent / name) if is_folder(one))


def is_packaged(folder: Path) -> bool:
    """Whether this is the study of the installed package, whose folder takes no results."""
    return folder.resolve() == _PACKAGE / "_study"


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


Seams = Mapping[str, "Seam"]
SHEETS = "matrix"
"""Folder of the files of cells, one for each parameter."""
GUIDEWORD, PARAMETER = "[A-Z][A-Z0-9]*", "[a-z][a-z0-9_]*"
Guidewords = Annotated[
    tuple[matrices.Guideword, ...], ByName(), Pattern(GUIDEWORD, "capital letters, as in a mutant's id")
]
Parameters = Annotated[
    tuple[matrices.Parameter, ...], ByName(), Pattern(PARAMETER, "small letters, as in a mutant's id")
]


@dataclass(frozen=True)
class NotMeaningful:
    """A cell that makes no sense.

    Attributes:
        status: the guideword makes no sense for this parameter.
        reason: why it makes no sense.
        team: what only people can fill in.
    """

    status: Literal["not_meaningful"]
    reason: str
    team: matrices.Team = matrices.NO_TEAM


@dataclass(frozen=True)
class ToDo:
    """A draft of a cell, as of a row of somebody's sheet; it is counted, and never flown.

    Attributes:
        status: somebody has to give the cell faults and requirements, or a reason why it is not meaningful.
        deviation: how the parameter deviates.
        causes: what could bring the deviation about.
        effect: the consequence.
        severity: severity, in any words.
        faults: what its names suggest as faults.
        team: what only people can fill in.
        source: the file, and the rows, that it was drafted from.
    """

    status: Literal["to_do"]
    deviation: str = ""
    causes: Annotated[tuple[str, ...], Size(0, matrices.MOST_ENTRIES)] = ()
    effect: str = ""
    severity: str = ""
    faults: Annotated[tuple[matrices.Fault, ...], Size(0, matrices.MOST_ENTRIES)] = ()
    team: matrices.Team = matrices.NO_TEAM
    source: str = ""


@dataclass(frozen=True)
class Tested:
    """A cell with faults.

    Attributes:
        status: how the study classifies the cell: a fault that could occur, or a crude one that the tests must detect.
        deviation: how the parameter deviates, in a sentence.
        causes: what could bring the deviation about.
        effect: the effect on the next stage, then on the flight.
        requirements: the requirements at risk, by their names in sim/requirements.yaml.
        faults: what produces the deviation; the first is the default, and with several each needs a unit of its own.
        severity: of a credible cell: a class of hazop/severities.yaml.
        predicted: what the study expects of the flights, written before they are flown.
        team: what only people can fill in.
        source: the file, and the rows, that the cell was drafted from.
    """

    status: Literal["credible", "control"]
    deviation: Annotated[str, Examples("Detection delivered late.")]
    causes: Annotated[tuple[str, ...], Size(1, matrices.MOST_ENTRIES)]
    effect: str
    requirements: Annotated[tuple[Annotated[str, Examples("SR1")], ...], Size(1, matrices.MOST_ENTRIES)]
    faults: Annotated[tuple[matrices.Fault, ...], Size(1, matrices.MOST_ENTRIES)]
    severity: Annotated[
        str, Choices(named="classes"), Pattern(matrices.SEVERITY, "the name of a class"), Examples("injury")
    ] = ""
    predicted: str = ""
    team: matrices.Team = matrices.NO_TEAM
    source: str = ""

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a severity of a cell that is not credible, and two faults whose magnitudes have the same unit."""
        if self.severity and self.status == "control":
            yield item.need("severity").error("left out where the cell is not credible")
        units: list[str] = []
        for fault in self.faults:
            if len(self.faults) > 1 and (fault.magnitude is None or fault.magnitude.unit in units):
                allowed = "a magnitude in a unit of its own; the unit in an id selects the fault"
                yield InputError(f"{fault.place}: each fault of {item.name} must have {allowed}")
            units.append(fault.magnitude.unit if fault.magnitude else "")


CellModel = Annotated[NotMeaningful | Tested | ToDo, Either(by="status")]


def load_matrix(hazop: Path, seams: Seams | None = None) -> matrices.Matrix:
    """Read the matrix of a study folder's `hazop/`.

    Args:
        hazop: folder with `guidewords.yaml`, `parameters.yaml`, `matrix/<parameter>.yaml` and, if the study has classes
            of severity, `severities.yaml`.
        seams: seams of the stack by name; None leaves the seams of the faults unchecked.

    Raises:
        InputError: an entry is not allowed; the message names file and line.
    """
    faults = Faults()
    guidewords = load_guidewords(hazop / "guidewords.yaml")
    parameters, places = load_parameters(hazop / "parameters.yaml")
    faults.add(*misnamed_sheets(hazop / SHEETS, places))
    classes = matrices.load_severities(hazop / matrices.SEVERITIES)
    cells: dict[tuple[str, str], matrices.Cell] = {}
    severities: dict[str, matrices.SeverityClass] = {}
    for path in (hazop / SHEETS / f"{parameter.id}.yaml" for parameter in parameters):
        with faults.collecting():
            for cell, severity in load_cells(path, guidewords, seams, classes) if is_there(path) else ():
                cells[cell.guideword, cell.parameter] = cell
                if severity:
                    severities[cell.name] = severity
    faults.end()
    return matrices.Matrix(guidewords, parameters, cells, classes, severities)


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


def load_guidewords(path: Path) -> tuple[matrices.Guideword, ...]:
    """Read the guidewords of one file, in the order of the file.

    Raises:
        InputError: a guideword is not in capitals, an extension gives no reason, a key is missing or unknown.
    """
    words: tuple[matrices.Guideword, ...] = value_of(Guidewords, load(path))
    return words


def load_parameters(path: Path) -> tuple[tuple[matrices.Parameter, ...], dict[str, str]]:
    """Read the parameters of one file, in the order of the file, and the place of each by id.

    Raises:
        InputError: an id is not in small letters, a key is missing or unknown.
    """
    document = load(path)
    return value_of(Parameters, document), {name: item.place for name, item in document.mapping().items()}


def load_cells(
    path: Path,
    guidewords: tuple[matrices.Guideword, ...],
    seams: Seams | None = None,
    classes: tuple[matrices.SeverityClass, ...] = (),
) -> tuple[tuple[matrices.Cell, matrices.SeverityClass | None], ...]:
    """Read the cells of one parameter with their severity, one for each guideword; the parameter names the file.

    Raises:
        InputError: a guideword is unknown, a guideword has no cell, a key of a cell is missing or not allowed.
    """
    sheet, faults, cells = load(path), Faults(), list[tuple[matrices.Cell, matrices.SeverityClass | None]]()
    words = [word.id for word in guidewords]
    if misnamed := list(misnamed_cells(sheet, words)):
        faults.add(*misnamed)
        words = [word for word in words if word in sheet.mapping()]  # a blank cell may be the one that is misnamed
    for word in words:
        with faults.collecting():
            cells.append(read_cell(sheet, word, path.stem, seams, classes))
    faults.end()
    return tuple(cells)


def misnamed_cells(sheet: Item, guidewords: Collection[str]) -> Iterator[InputError]:
    """An error for each cell of a file that has no guideword."""
    for name, item in sheet.mapping().items():
        if name not in guidewords:
            yield InputError(f"{item.place}: {name!r} is not a guideword{did_you_mean(name, guidewords)}")


def read_cell(
    sheet: Item,
    guideword: str,
    parameter: str,
    seams: Seams | None = None,
    classes: tuple[matrices.SeverityClass, ...] = (),
) -> tuple[matrices.Cell, matrices.SeverityClass | None]:
    """Read one cell of the file of a parameter, and its severity.

    Raises:
        InputError: the cell is blank, or a key of it is missing or not allowed.
    """
    item = sheet.get(guideword)
    if item is None or item.value is None:
        blank = f"the cell {guideword}-{parameter} is blank"
        raise InputError(
            f"{(item or sheet).place}: {blank}; it must be credible, a control, not_meaningful with a reason, or to_do"
        )
    names = {"classes": [one.id for one in classes], **({"seams": sorted(seams)} if seams else {})}
    model: NotMeaningful | Tested | ToDo = value_of(CellModel, item, names)
    status, team = matrices.CellStatus(model.status), model.team
    if isinstance(model, NotMeaningful):
        return matrices.Cell(guideword, parameter, status, reason=model.reason, team=team, place=item.place), None
    severity = next((one for one in classes if one.id == model.severity), None)
    if isinstance(model, ToDo):
        drafted, said = "" if severity else model.severity, (model.deviation, model.causes, model.effect)
        draft = matrices.Cell(guideword, parameter, status, *said, team=team, drafted=drafted, proposed=model.faults)
        return replace(draft, place=item.place), severity
    if model.severity and severity is None:
        raise item.need("severity").error(
            f"left out in a study without classes: hazop/{matrices.SEVERITIES} lists them"
        )
    faults = model.faults
    if seams is not None:
        if faults and not seams:
            offers = "left out where what flies offers no seam: `seams` of sim/flyer.yaml names them"
            raise item.need("faults").error(offers)
        faults = tuple(replace(fault, message=seams[fault.seam].message) for fault in faults)
    told = model.deviation, model.causes, model.effect, model.requirements, faults, "", model.predicted, team
    place, requirements_place = item.place, item.need("requirements").place
    cell = matrices.Cell(guideword, parameter, status, *told, place=place, requirements_place=requirements_place)
    return cell, severity
