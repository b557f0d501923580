"""`scaloft-fi hazop`: bring somebody's HAZOP or STPA sheet into the study, and what people edited in a worksheet."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Any

import click

from scaloft_fi.document import Steps, dumped, edited, is_there, parsed, read_text
from scaloft_fi.errors import FaultsError, InputError, did_you_mean, nearest, shown
from scaloft_fi.hazop.load import (
    SHEETS,
    Parameters,
    load_guidewords,
    load_matrix,
    load_parameters,
    read_cell,
    reference_study,
)
from scaloft_fi.hazop.matrix import Cell, CellStatus, Fault, Guideword, Team, parse
from scaloft_fi.hazop.render import ladder
from scaloft_fi.hazop.sheet import HEADS, MARKED, MOST_TEXT, Draft, Line, Sorted, plain, read_sheet, sort
from scaloft_fi.model import value_of
from scaloft_fi.mutants.catalogue import suggested
from scaloft_fi.output import printable, write_named
from scaloft_fi.study import Study
from scaloft_fi.verbs.options import Option, check_own, several, verb
from scaloft_fi.verbs.worksheet import ABOUT, CUT, FINDINGS, SheetRow, bare_rows
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
        cell: the cell, or the parameter; empty: the row has no id.
        key: in the YAML of the study.
        before: in the study.
        after: in the worksheet.
        where: the file and line of the cell or parameter; of a row that no cell takes, sheet and row.
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
    guidewords, for each of these a cell of every parameter, and the texts of a bare cell.

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

        return dumped({word: cell(f"{word}-{parameter}") for word in words})

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
    texts = {path: dumped(more) for path, more in added.items() if more}
    texts |= {hazop / SHEETS / f"{one.id}.yaml": cells(one.id, found.words) for one in matrix.parameters if found.words}
    files |= {path: read_text(path).rstrip("\n") + "\n" + text for path, text in texts.items()}
    for name, draft in ((name, draft) for name, draft in found.drafts.items() if name in matrix):
        path = hazop / SHEETS / f"{draft.parameter}.yaml"
        cell = cell_yaml(draft, proposed.get(name), file.name)
        files[path] = edited(files.get(path) or read_text(path), (draft.guideword,), cell, str(path))
    return files, proposed


def further_words() -> tuple[Guideword, ...]:
    """The guidewords that a study may get from a sheet: those of the reference study."""
    return load_guidewords(reference_study() / "hazop" / "guidewords.yaml")


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


def write_all(files: Mapping[Path, str]) -> None:
    """Write files of the study; where one cannot be written, an InputError, the others are as they were."""
    with ExitStack() as undo:
        for path, text in files.items():
            before = read_text(path) if is_there(path) else None
            write_named(path, text.encode(), "FILE")
            undo.callback(path.unlink) if before is None else undo.callback(path.write_text, before, "utf-8")
        undo.pop_all()


def imported(study: Study, file: Path, found: Sorted, *, writing: bool) -> BroughtIn:
    """What became of each row; with `writing`, the drafts are written into new files.

    Raises:
        InputError: as `drafted`, or a file cannot be written.
    """
    files, proposed = drafted(study, found, file)
    checked(study, files)
    write_all(files if writing else {})
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


@dataclass(frozen=True)
class Step:
    """Edits that are made together or not at all.

    Attributes:
        edits: what people edited.
        path: the file of the study.
        changes: the way to each value that changes in it, and its new text; none: the edits are made by hand.
        asks: what is said where the study cannot have them; empty: the refusal.
    """

    edits: tuple[Edit, ...]
    path: Path
    changes: tuple[tuple[Steps, str | None], ...] = ()
    asks: str = ""

    def by_hand(self, why: str) -> Step:
        """The edits left to a person."""
        return Step(tuple(replace(edit, why=why) for edit in self.edits), self.path)


def edits_of(rows: Iterable[SheetRow], hazop: Path, lines: Iterable[Line]) -> Iterator[Step]:
    """What people edited in a worksheet that a study wrote, and how it is changed in the study.

    A row that names no cell, or another by its words than by its id, is left to a person; so is a text whose copies
    differ, because no sheet says which of them is the edit.

    Args:
        rows: of the study, as `bare_rows` makes them.
        hazop: folder of its files.
        lines: rows of the worksheet.
    """
    by_name = {row.cell.name: row for row in rows}
    titles = {plain(row.parameter.title) for row in by_name.values()}
    firsts, cells = dict[str, str](), dict[str, dict[str, tuple[str, dict[str, str]]]]()
    for line in lines:
        row = by_name.get(name := line.texts.get("cell", ""))
        word, title = (line.texts.get(key, "") for key in ("guideword", "parameter"))
        if row is None:
            why = f"the study has no such cell{did_you_mean(name, by_name)}" if name else _NO_ID
        else:
            other = "guideword" in line.keys and plain(word).replace(" ", "") != plain(row.cell.guideword)
            other |= plain(title) != plain(row.parameter.title) and plain(title) in titles
            why = "guideword or parameter are not those of the id; nothing of the row is taken" if other else ""
        if row is None or why:
            yield Step((Edit(name, "cell", "", f"{word} {title}".strip() or name, line.place, False, why),), hazop)
            continue
        first = firsts.setdefault(row.cell.parameter, name)
        for key in (key for key in HEADS if key in line.keys - {"cell", "guideword"}):
            before, of = _shown(row.values[_COLUMN.get(key, key)]), first if key in _OF_PARAMETER else name
            _, ways = cells.setdefault(of, {}).setdefault(key, (before, {}))
            ways.setdefault(_after(before, key, line.texts.get(key, "")), line.place)
    for name, found in cells.items():
        edits, cell = dict[str, tuple[str, str]](), by_name[name].cell
        for key, (before, ways) in found.items():
            after = next((one for one in ways if one != before), before)
            if len(ways) > 1:
                copies = ", ".join(f"{shown(one)} at {place}" for one, place in ways.items())
                why = f"its copies differ: {copies}; write the same into each, and run again"
                yield Step((Edit(name, key, before, after, cell.place, False, why),), hazop)
            elif after != before:
                edits[key] = before, after
        yield from _steps(hazop, cell, edits)


def _after(before: str, key: str, text: str) -> str:
    """A text of a worksheet; that of the study, `before`, where both say the same.  CSV marks texts with '."""
    after, bare = _shown(text), _shown(MARKED.sub("", text))
    if key == "disposition" and after.endswith(f": {before}"):  # before it stands its state in a campaign
        after = before
    same = plain(before) == plain(after) if key == "status" else before in (after, f"'{after}", bare)
    return before if same else bare


_NO_ID = "it has no Deviation id; `scaloft-fi hazop import` drafts what is new"
_COLUMN = {"intent": "design_intent"}
_OF_PARAMETER = {"node": "node", "intent": "intent", "parameter": "title"}
_KEPT = {
    "operators": "faults are not taken back",
    "mutant": "the default magnitude is not taken back",
    "disposition": "not taken back: hazop/dispositions.yaml has it",
}
"""Columns of the study that are not taken back, and what is said of them."""


def _shown(value: object) -> str:
    text = "" if value is None else " ".join(printable(str(value)).split())
    return text.removesuffix(CUT)[:MOST_TEXT]


def _steps(hazop: Path, cell: Cell, edits: Mapping[str, tuple[str, str]]) -> Iterator[Step]:
    """How the edited texts of a cell, each before and after, are made."""
    path = hazop / SHEETS / f"{cell.parameter}.yaml"
    reason = "reason" if cell.status is CellStatus.NOT_MEANINGFUL else "predicted"
    for key, (before, after) in edits.items():
        way = f"team.{key}" if key in TEAM else reason if key == "rationale" else key
        step = Step((Edit(cell.name, way, before, after, cell.place, False, None),), path)
        if key in _KEPT:
            yield step.by_hand(_KEPT[key])
        elif way == "predicted" and not after:
            yield step.by_hand("a prediction stands, whatever was flown since")
        elif key == "status":
            yield from _of_status(step, cell, edits)
        elif key == "causes" or (key == "requirements" and "status" not in edits):
            yield _of_list(step, cell, key)
        elif key in _OF_PARAMETER:
            file, way = hazop / "parameters.yaml", _OF_PARAMETER[key]
            told = Edit(cell.parameter, way, before, after, load_parameters(file)[1][cell.parameter], False, None)
            yield Step((told,), file, (((cell.parameter, way), after or None),))
        elif key not in _BESIDE or "status" not in edits:
            yield replace(step, changes=(((cell.guideword, *way.split(".")), after or None),))


_BESIDE = ("rationale", "requirements")
"""What goes with a changed status."""
_ASKS = {
    CellStatus.NOT_MEANINGFUL: "a cell that is not meaningful has a reason, and no effect, causes or faults",
    CellStatus.TO_DO: "a cell that is to do has no requirements and no prediction",
}


def _of_status(step: Step, cell: Cell, edits: Mapping[str, tuple[str, str]]) -> Iterator[Step]:
    """A changed status.

    Requirements beside it go with it.  A rationale is the reason of a cell that is no longer meaningful, and no other.
    """
    (told,), known = step.edits, [status.value for status in CellStatus]
    word = plain(told.after).replace(" ", "_")
    step = replace(step, changes=(((cell.guideword, "status"), word),))
    for key, (before, after) in ((key, edits[key]) for key in _BESIDE if key in edits):
        beside = replace(step, edits=(replace(told, key=key, before=before, after=after),), changes=())
        if key == "requirements":
            beside = _of_list(beside, cell, key)
        elif word == CellStatus.NOT_MEANINGFUL:
            reason = replace(told, key="reason", before=before, after=after)
            beside = replace(beside, edits=(reason,), changes=(((cell.guideword, "reason"), after or None),))
        if word in known and beside.changes:
            step = replace(step, edits=(*beside.edits, *step.edits), changes=(*beside.changes, *step.changes))
        elif beside.edits:
            yield beside if beside.edits[0].why else beside.by_hand("its status is edited too")
    if word in known:
        has_reason = cell.status is CellStatus.NOT_MEANINGFUL
        asks = "only a cell that is not meaningful has a reason" if has_reason else _ASKS.get(CellStatus(word), "")
        yield replace(step, asks=asks)
    else:
        yield step.by_hand(f"{told.after!r} is no status{did_you_mean(word, known)}")


def _of_list(step: Step, cell: Cell, key: str) -> Step:
    """The entries of an edited list that differ; a list from which one was taken out is left to a person."""
    (told,) = step.edits
    old = list(map(_shown, cell.causes if key == "causes" else cell.requirements))
    new = [one.strip() for one in re.split(";" if key == "causes" else "[,;]", told.after) if one.strip()]
    if len(new) < len(old) or not new:
        return step.by_hand("an entry was taken out")
    changed = [(k, then, one) for k, (then, one) in enumerate(zip_longest(old, new, fillvalue="")) if one != then]
    edits = tuple(replace(told, key=f"{key}[{k}]", before=then, after=one) for k, then, one in changed)
    return replace(step, edits=edits, changes=tuple(((cell.guideword, key, k), one) for k, _, one in changed))


def differing(study: Study, file: Path, lines: Sequence[Line], *, writing: bool) -> BroughtIn:
    """What people edited; with `writing`, single values are changed in place.

    An edit that is not allowed, or cannot be made in place, is left to a person, and stops no other.

    Raises:
        InputError: no row names a cell of the study, or a file cannot be written.
    """
    if not any(line.texts.get("cell", "") in study.matrix for line in lines):
        raise InputError(f"{file}: no row names a cell of the study by its id; `scaloft-fi hazop import` reads others")
    texts, edits = dict[Path, str](), list[Edit]()
    for step in edits_of(bare_rows(study.matrix, study.dispositions), study.folder / "hazop", lines):
        try:
            text = texts.get(step.path) or read_text(step.path) if step.changes else ""
            for steps, value in step.changes:
                text = edited(text, steps, value, str(step.path))
            if step.changes:
                _check_step(study, step, text)
                texts[step.path] = text
            edits += (replace(edit, written=writing and bool(step.changes)) for edit in step.edits)
        except InputError as error:
            first = error.faults[0] if isinstance(error, FaultsError) else error
            edits += step.by_hand(step.asks or re.sub(rf"^{re.escape(str(step.path))}:(\d+:)? ", "", str(first))).edits
    checked(study, texts)
    write_all(texts if writing else {})
    return BroughtIn(file, (), study.matrix.counts()[CellStatus.TO_DO], tuple(edits), tuple(texts) if writing else ())


def _check_step(study: Study, step: Step, text: str) -> None:
    """Refuse a document of the study in which what a step changed is not allowed.

    Raises:
        InputError: it is not.
    """
    document, (name, *_) = parsed(text, step.path), step.changes[0][0]
    if step.path.parent.name != SHEETS:
        value_of(Parameters, document)
        return
    now = study.matrix.cells[str(name), step.path.stem]
    cell, _ = read_cell(document, now.guideword, now.parameter, study.stack.by_name, study.matrix.classes)
    study.check_requirements([cell] if cell.requirements != now.requirements else [])


def tables_of(told: BroughtIn, *, differ: bool) -> tuple[Table, ...]:
    """What a person reads."""
    wrote = tuple(f"written: {path}" for path in told.files)
    if differ:
        by_hand = {one: f"{Path(one.where).name}: {one.why}" for one in told.edits if one.why}
        edits = tuple((one.cell, one.key, one.before, one.after, by_hand.get(one, "")) for one in told.edits)
        left = f", {len(by_hand)} of them to be made by hand" if by_hand else ""
        makes = f"`--write` makes {'the others' if by_hand else 'them'} in the study."
        how = wrote or (makes,) * (len(edits) > len(by_hand))
        heads = ("cell", "key", "in the study", "in the sheet", "by hand")
        notes = (f"{counted(len(edits), 'edit')}{left}.", "Findings are not compared.", *how)
        return (Table("What people edited", heads, edits, notes),)
    rows = tuple(
        (one.place, one.state.replace("_", " "), one.cell or "", one.proposed or one.why or "") for one in told.rows
    )
    count = {state: len({one.place for one in told.rows if one.state is state}) for state in RowState}
    known, out = f"{count[RowState.THERE]} in the study already", f"{count[RowState.LEFT_OUT]} left out"
    total, cells = len({one.place for one in told.rows}), len({row[2] for row in rows if row[1] == RowState.DRAFTED})
    into = f"{count[RowState.DRAFTED]} drafted into {counted(cells, 'cell')}"
    notes = (
        f"{counted(total, 'row')}: {into}, {known}, {out}.",
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
    write: Annotated[bool, Option("Write into the study: drafts where it lacks them, edits where they stand.")] = False,
) -> Answer:
    """Bring a HAZOP or STPA sheet (.xlsx, .csv) into the study, or show what people edited in a worksheet.

    `import` drafts each cell that the study lacks, or that is to_do and says nothing else: the texts of the sheet, and
    the fault that its names suggest.  A draft has the status to_do: it is counted and never flown, until somebody
    completes it.  `diff` compares a sheet that `worksheet --output` wrote with the study.  Without --write nothing is
    written; with it drafts are added, and an edited value changes in place.  What cannot be changed so is told, and
    left to a person.

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
    if action == "diff" and (words or names):
        raise InputError("--guideword, --parameter: only `hazop import` reads them; a worksheet has the names of cells")
    if write:
        check_own(study, study.folder, study.folder / "hazop")
    unread = dict[str, list[str]]()
    lines = read_sheet(file, heads, several(sheet, "sheet"), unread)
    unread.pop(ABOUT, None)
    ours = {one for column in FINDINGS for one in (column.key, column.title)}
    left = {page: [shown(one) for one in dict.fromkeys(what) if one not in ours] for page, what in unread.items()}
    warnings = [f"{page or file.name}: not read: {', '.join(what)}" for page, what in left.items() if what]
    if action == "diff":
        told = differing(study, file, lines, writing=write)
        late = (one.cell for one in told.edits if one.key == "predicted" and not one.why)
        warnings += (f"{cell}: a prediction that is written after the flights is worth nothing" for cell in late)
    else:
        told = imported(study, file, sort(lines, study.matrix, words, names, further), writing=write)
        known = [one.id for one in study.matrix.parameters]
        new = ((text, name) for text, name in names.items() if name not in known)
        warnings += (f"{text!r} is a new parameter, {name!r}{nearest(name, known)}" for text, name in new)
    rows = "edits" if action == "diff" else "rows"
    return Answer(HAZOP, lambda: told, lambda: tables_of(told, differ=action == "diff"), rows=rows, warnings=warnings)


hazop_command = verb("hazop")(hazop)
