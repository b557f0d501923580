"""`scaloft-fi hazop`: bring somebody's HAZOP or STPA sheet into the study, and what people edited in a worksheet."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import click
import yaml

from scaloft_fi.document import edited, is_there, read_text
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.load import SHEETS, load_guidewords, load_matrix, reference_study
from scaloft_fi.hazop.matrix import Cell, CellStatus, Fault, Guideword, Matrix, Team, parse
from scaloft_fi.hazop.render import ladder
from scaloft_fi.hazop.sheet import HEADS, MOST_TEXT, Draft, Line, Sorted, read_sheet, sort
from scaloft_fi.mutants.catalogue import suggested
from scaloft_fi.output import printable, write_named
from scaloft_fi.study import Study
from scaloft_fi.verbs.options import Option, check_own, several, verb
from scaloft_fi.verbs.worksheet import CUT, SheetRow
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table, counted

TO_SAY, TO_DO = "to do", CellStatus.TO_DO.value
"""What stands where a parameter of a sheet lacks a text that it must have; the status of a drafted cell."""
TEAM = tuple(Team.__dataclass_fields__)


class RowState(StrEnum):
    """What became of a row of a sheet."""

    DRAFTED = "drafted"
    THERE = "in_the_study"
    LEFT_OUT = "left_out"


@dataclass(frozen=True)
class ImportedRow:
    """A row of the sheet.

    Attributes:
        place: sheet and row.
        state: drafted; in the study: the study has this cell; left out: nothing says which cell it is about.
        cell: the cell; null: none.
        proposed: fault that the names suggest, for somebody to look at; null: none fits.
        why: why it is not drafted; null: it is.
    """

    place: str
    state: RowState
    cell: str | None
    proposed: str | None
    why: str | None


@dataclass(frozen=True)
class Edit:
    """A text that people changed in a worksheet.

    Attributes:
        cell: the cell, or the parameter.
        key: in the YAML of the study.
        before: in the study.
        after: in the worksheet.
        where: the file and line of the cell or parameter; of a cell that the study lacks, sheet and row.
        written: whether the study has it now.
        why: why it can only be changed by hand; null: `--write` changes it.
    """

    cell: str
    key: str
    before: str
    after: str
    where: str
    written: bool
    why: str | None


@dataclass(frozen=True)
class BroughtIn:
    """What a sheet brings into the study.

    Attributes:
        file: path of the sheet.
        rows: with import, what became of each row.
        to_do: cells of the study that are to do, those of the sheet included.
        edits: with diff, what people edited.
        files: the files that were written.
    """

    file: Path
    rows: tuple[ImportedRow, ...]
    to_do: int
    edits: tuple[Edit, ...]
    files: tuple[Path, ...]


HAZOP = Output("hazop", "1.0", BroughtIn, rows="rows")


def cell_yaml(draft: Draft, proposed: Fault | None, source: str) -> dict[str, Any]:
    """A drafted cell, as in the YAML of a study."""
    team = {key: draft.told(key) for key in TEAM if draft.told(key)}
    told = {
        "deviation": draft.told("deviation"),
        "causes": draft.texts["causes"],
        "effect": draft.told("effect"),
        "severity": draft.told("severity"),
        "team": team,
        "faults": [fault_yaml(proposed)] if proposed else [],
        "source": f"{source}, {', '.join(draft.places)}",
    }
    return {"status": TO_DO, **{key: value for key, value in told.items() if value}}


def fault_yaml(fault: Fault) -> dict[str, Any]:
    """A fault, as in the YAML of a study."""
    magnitude = fault.magnitude and {
        key: list(value) if isinstance(value, tuple) else value
        for key, value in asdict(fault.magnitude).items()
        if key != "place" and value not in (None, "") and (key, value) != ("scale", 1.0)
    }
    raised = magnitude and {"unit": "", **magnitude}
    told = {"arguments": dict(fault.arguments), "magnitude": raised, "phases": fault.phases}
    return {"seam": fault.seam, "operator": fault.operator, **{key: value for key, value in told.items() if value}}


def drafted(study: Study, found: Sorted, file: Path) -> tuple[dict[Path, str], Mapping[str, Fault]]:
    """The files that drafts make or add to, by path, and the proposed faults by cell.

    A parameter that the study lacks gets a file of its own.  What the study has is only added to: parameters,
    guidewords, and for each of these a cell of every parameter.

    Raises:
        InputError: a file of that name is there, or cannot be read.
    """
    hazop, matrix, seams = study.folder / "hazop", study.matrix, study.stack.by_name
    about = {one.id: f"{one.title} {one.node}" for one in matrix.parameters}
    about |= {name: " ".join(said.values()) for name, said in found.parameters.items()}
    known = (matrix, load_matrix(reference_study() / "hazop"))
    faults = {
        name: suggested(draft.guideword, f"{about[draft.parameter]} {draft.told('deviation')}", known, seams)
        for name, draft in found.drafts.items()
    }
    proposed, files = {name: fault for name, fault in faults.items() if fault}, dict[Path, str]()

    def cells(parameter: str, words: Iterable[str]) -> str:
        def cell(name: str) -> dict[str, Any]:
            draft = found.drafts.get(name)
            return cell_yaml(draft, proposed.get(name), file.name) if draft else {"status": TO_DO}

        return _dumped({word: cell(f"{word}-{parameter}") for word in words})

    words = [*(word.id for word in matrix.guidewords), *found.words]
    for parameter in found.parameters:
        path = hazop / SHEETS / f"{parameter}.yaml"
        if is_there(path):
            raise InputError(f"{path}: is there already, and would be overwritten; --parameter TEXT=NAME names another")
        head = f"# Drafts from {printable(file.name)}; a cell flies once it is credible.\n"
        files[path] = head + cells(parameter, words)
    keys = ("title", "intent", "node", "unit")
    entries = {name: {key: said.get(key) or TO_SAY for key in keys} for name, said in found.parameters.items()}
    lacking = [one for one in further_words() if one.id in found.words]
    told = {one.id: {key: value for key, value in vars(one).items() if key != "id" and value} for one in lacking}
    added = {hazop / "parameters.yaml": entries, hazop / "guidewords.yaml": told}
    texts = {path: _dumped(more) for path, more in added.items() if more}
    texts |= {hazop / SHEETS / f"{one.id}.yaml": cells(one.id, found.words) for one in matrix.parameters if found.words}
    return files | {path: read_text(path).rstrip("\n") + "\n" + text for path, text in texts.items()}, proposed


def further_words() -> tuple[Guideword, ...]:
    """The guidewords that a study may get from a sheet: those of the reference study."""
    return load_guidewords(reference_study() / "hazop" / "guidewords.yaml")


def _dumped(value: object) -> str:
    return yaml.safe_dump(value, sort_keys=False, allow_unicode=True, width=120)


def checked(study: Study, files: Mapping[Path, str]) -> None:
    """Read the matrix that the files would make, before any is written.

    Raises:
        InputError: it is none, or names a requirement that the study lacks.
    """
    hazop = study.folder / "hazop"
    with tempfile.TemporaryDirectory(prefix="scaloft-fi-") as folder:
        copy = Path(folder) / "hazop"
        shutil.copytree(hazop, copy)
        for path, text in files.items():
            (copy / path.relative_to(hazop)).write_text(text, encoding="utf-8")
        try:
            cells, now = load_matrix(copy, study.stack.by_name), study.matrix
            other = (one for one in cells if one.name in now and now.cell(one.name).requirements != one.requirements)
            study.check_requirements(other)
        except InputError as error:
            raise InputError(str(error).replace(str(copy), str(hazop))) from error


def imported(study: Study, file: Path, found: Sorted, *, writing: bool) -> BroughtIn:
    """What became of each row; with `writing`, the drafts are written into new files.

    Raises:
        InputError: as `drafted`, or a file cannot be written.
    """
    files, proposed = drafted(study, found, file)
    checked(study, files)
    for path, text in files.items() if writing else ():
        write_named(path, text.encode(), "FILE")
    rows = []
    for row in found.rows:
        fault = proposed.get(row.cell)
        state = RowState.DRAFTED if not row.why else RowState.THERE if row.cell else RowState.LEFT_OUT
        said = f"{fault.operator} at {fault.seam} {ladder(fault)}".strip() if fault else None
        rows.append(ImportedRow(row.place, state, row.cell or None, said, row.why or None))
    old, more = len(study.matrix.parameters), len(found.parameters)
    added = len(study.matrix.guidewords) * more + len(found.words) * (old + more)
    to_do = study.matrix.counts()[CellStatus.TO_DO] + added
    return BroughtIn(file, tuple(rows), to_do, (), tuple(files) if writing else ())


Change = tuple[Path, tuple[str | int, ...], str | None]
"""A file, the way to a value in it, and its new text; no way: it is changed by hand."""


def edits_of(matrix: Matrix, hazop: Path, lines: Iterable[Line]) -> Iterator[tuple[Edit, Change]]:
    """What people edited in a worksheet that a study wrote, and how it is changed in the study.

    Args:
        matrix: of the study.
        hazop: folder of its files.
        lines: rows of the worksheet.

    Raises:
        InputError: one text was edited in two ways.
    """
    told = dict[tuple[str, str], str]()
    parameters = {one.id: one for one in matrix.parameters}
    for line in lines:
        name = line.texts.get("cell", "")
        if name not in matrix:
            why = f"the study has no such cell{did_you_mean(name, [cell.name for cell in matrix])}"
            yield from [(Edit(name, "cell", "", name, line.place, False, why), (hazop, (), None))] if name else ()
            continue
        cell = matrix.cell(name)
        values = SheetRow(cell, parameters[cell.parameter], matrix.severities.get(name)).values
        for key in line.keys - {"cell", "guideword"}:
            before, after = _shown(values[_COLUMN.get(key, key)]), _shown(line.texts.get(key))
            about = cell.parameter if key in _OF_PARAMETER else name
            if before in (after, f"'{after}"):  # CSV marks texts so
                continue
            if told.setdefault((about, key), after) != after:
                ways = f"{after!r} and {told[about, key]!r}"
                raise InputError(f"{line.place}: {key} of {about} is edited in two ways: {ways}")
            yield from _edit(hazop, cell, key, before, after)


_COLUMN = {"intent": "design_intent"}
_OF_PARAMETER = {"node": "node", "intent": "intent", "parameter": "title"}


def _shown(value: object) -> str:
    text = "" if value is None else " ".join(printable(str(value)).split())
    return text.removesuffix(CUT)[:MOST_TEXT]


def _edit(hazop: Path, cell: Cell, key: str, before: str, after: str) -> Iterator[tuple[Edit, Change]]:
    """The changes that one edited text makes."""
    path, about, where = hazop / SHEETS / f"{cell.parameter}.yaml", cell.name, cell.place
    steps: tuple[str | int, ...] = (cell.guideword, key)
    if key in _OF_PARAMETER:
        path, about, steps = hazop / "parameters.yaml", cell.parameter, (cell.parameter, _OF_PARAMETER[key])
        where = f"{path}"
    elif key in TEAM:
        steps = (cell.guideword, "team", key)
    elif key == "rationale":
        steps = (cell.guideword, "reason" if cell.status is CellStatus.NOT_MEANINGFUL else "predicted")
    if key in ("causes", "requirements"):
        old = list(cell.causes if key == "causes" else cell.requirements)
        new = [one.strip() for one in after.split(";" if key == "causes" else ",") if one.strip()]
        if len(new) < len(old) or not new:
            by_hand = "an entry was taken out: edit it by hand"
            yield Edit(about, key, before, after, where, False, by_hand), (path, (), None)
            return
        for k, one in enumerate(new):
            if k >= len(old) or one != _shown(old[k]):
                then = _shown(old[k]) if k < len(old) else ""
                yield Edit(about, f"{key}[{k}]", then, one, where, False, None), (path, (*steps, k), one)
        return
    yield Edit(about, ".".join(map(str, steps[1:])), before, after, where, False, None), (path, steps, after or None)


def differing(study: Study, file: Path, lines: Sequence[Line], *, writing: bool) -> BroughtIn:
    """What people edited; with `writing`, single values are changed in place.

    Raises:
        InputError: no row names a cell of the study; an edited text is not allowed, or cannot be changed in place.
    """
    if not any(line.texts.get("cell", "") in study.matrix for line in lines):
        others = "`scaloft-fi hazop import` reads other sheets"
        raise InputError(f"{file}: no row names a cell of the study (Deviation id); {others}")
    found = list(edits_of(study.matrix, study.folder / "hazop", lines))
    texts = dict[Path, str]()
    for _, (path, steps, value) in found if writing else ():
        if steps:
            texts[path] = edited(texts.get(path) or read_text(path), steps, value, str(path))
    checked(study, texts)
    for path, text in texts.items():
        write_named(path, text.encode(), "FILE")
    edits = tuple(replace(edit, written=writing and edit.why is None) for edit, _ in found)
    return BroughtIn(file, (), study.matrix.counts()[CellStatus.TO_DO], edits, tuple(texts))


def tables_of(told: BroughtIn, *, differ: bool) -> tuple[Table, ...]:
    """What a person reads."""
    wrote = tuple(f"written: {path}" for path in told.files)
    if differ:
        edits = tuple((one.cell, one.key, one.before, one.after, one.why or "") for one in told.edits)
        by_hand = sum(one.why is not None for one in told.edits)
        left = f", {by_hand} of them to be made by hand" if by_hand else ""
        how = wrote or ("`--write` makes them in the study.",) * bool(edits)
        heads = ("cell", "key", "in the study", "in the sheet", "by hand")
        return (Table("What people edited", heads, edits, (f"{counted(len(edits), 'edit')}{left}.", *how)),)
    rows = tuple(
        (one.place, one.state.replace("_", " "), one.cell or "", one.proposed or one.why or "") for one in told.rows
    )
    count = {state: sum(one.state is state for one in told.rows) for state in RowState}
    known, out = f"{count[RowState.THERE]} in the study already", f"{count[RowState.LEFT_OUT]} left out"
    notes = (
        f"{counted(len(rows), 'row')}: {count[RowState.DRAFTED]} drafted, {known}, {out}.",
        f"{counted(told.to_do, 'cell')} to do: never flown, until somebody gives them faults and requirements.",
        *(wrote or ("`--write` writes the drafts into the study.",) * bool(count[RowState.DRAFTED])),
    )
    return (Table("Rows of the sheet", ("row", "state", "cell", "proposed fault, or why not"), rows, notes),)


def _pairs(given: Sequence[str], option: str, allowed: Iterable[str], *, value: bool) -> dict[str, str]:
    """The pairs of an option; the key, or with `value` what stands behind the sign, is one of `allowed`, if any."""
    known, found = list(allowed), dict[str, str]()
    for one in given:
        left, sign, right = one.rpartition("=") if value else one.partition("=")
        if not sign or not left or not right:
            raise InputError(f"{option}={one!r} must have the form {'TEXT=NAME' if value else 'KEY=HEAD'}")
        name = right if value else left
        if known and name not in known:
            raise InputError(f"{option}={one!r}: {name!r} is not known{did_you_mean(name, known)}")
        found[left] = right
    return found


def hazop(
    study: Study,
    action: Annotated[str, Option("", "", metavar="import|diff", type=click.Choice(("import", "diff")))],
    file: Annotated[Path, Option("", "", metavar="FILE", type=click.Path(path_type=Path))],
    *,
    column: Annotated[
        Sequence[str],
        Option(f"Head of a column (repeatable).  KEY is one of: {', '.join(HEADS)}.", metavar="KEY=HEAD"),
    ] = (),
    sheet: Annotated[Sequence[str], Option("Sheet to read (repeatable).", metavar="NAME", otherwise="all")] = (),
    guideword: Annotated[
        Sequence[str],
        Option("Guideword of the study that a text of the sheet means (repeatable).", metavar="TEXT=WORD"),
    ] = (),
    parameter: Annotated[
        Sequence[str],
        Option(
            "Parameter, of the study or a new one, that a text of the sheet means (repeatable).", metavar="TEXT=NAME"
        ),
    ] = (),
    write: Annotated[
        bool, Option("Write: drafts into new files of the study, edits into the files where they stand.")
    ] = False,
) -> Answer:
    """Bring a HAZOP or STPA sheet (.xlsx, .csv) into the study, or show what people edited in a worksheet.

    `import` drafts each cell that the study lacks, with the texts of the sheet and the fault that its names suggest.
    A draft has the status to_do: it is counted and never flown, until somebody completes it.  `diff` compares a sheet
    that `worksheet --output` wrote with the study.  Without --write nothing is written; with it drafts go into new
    files, and an edited value changes in place.

    Examples:
        See what a sheet would bring: `scaloft-fi hazop import risks.xlsx`
        Write its drafts into the study: `scaloft-fi hazop import risks.xlsx --write`
        Show what the meeting edited: `scaloft-fi hazop diff worksheet.xlsx`

    Raises:
        InputError: the sheet cannot be read, has no heads that are known, or what it says is not allowed in a study.
    """
    heads = _pairs(column, "--column", HEADS, value=False)
    further = [one.id for one in further_words()]
    words = _pairs(guideword, "--guideword", [*(word.id for word in study.matrix.guidewords), *further], value=True)
    names = _pairs(parameter, "--parameter", (), value=True)
    for name in names.values():
        parse(f"NO-{name}")
    if write:
        check_own(study, study.folder, study.folder / "hazop")
    lines = read_sheet(file, heads, several(sheet, "sheet"))
    if action == "diff":
        told = differing(study, file, lines, writing=write)
    else:
        told = imported(study, file, sort(lines, study.matrix, words, names, further), writing=write)
    rows = "edits" if action == "diff" else "rows"
    return Answer(HAZOP, lambda: told, lambda: tables_of(told, differ=action == "diff"), rows=rows)


hazop_command = verb("hazop")(hazop)
