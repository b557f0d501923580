"""The deviation matrix, cell by cell, and the requirements, formula by formula."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from scaloft_fi.checks.finding import Finding, Findings, Severity, finding_of
from scaloft_fi.document import Item, is_there, load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.load import SHEETS, load_guidewords, load_parameters, misnamed_cells, misnamed_sheets, read_cell
from scaloft_fi.hazop.matrix import (
    SEVERITIES,
    Cell,
    CellStatus,
    Guideword,
    Matrix,
    Parameter,
    SeverityClass,
    load_severities,
)
from scaloft_fi.judge.bounds import ANY, Ranges, Spans, bounds_of, constants, verdict, within_caps
from scaloft_fi.judge.requirement import MOST, TRIGGER, Check, Kind, Requirement, read_definition, read_requirement
from scaloft_fi.judge.stl import Formula, inside_always, tokenize
from scaloft_fi.mutants.catalogue import derive
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.study import Study


@dataclass(frozen=True)
class KnownSignals:
    """The signals of a study.

    Attributes:
        ranges: what each can read, by name.
        caps: the cap of each belief and optional signal that has one; None = not even the simulator's signals have any.
    """

    ranges: Ranges
    caps: Mapping[str, float] | None = field(default_factory=dict)

    @property
    def check(self) -> Check:
        """The check of a formula: thresholds within caps, and the grammar."""
        return Formula.parse if self.caps is None else within_caps(Formula.parse, self.caps)


KEYS = ("definitions", "requirements")
"""The keys of `sim/requirements.yaml`."""


def kinds_in(path: Path) -> Mapping[str, str]:
    """The kind of each requirement by name, as it stands in the file; empty for a file that cannot be read so far."""
    try:
        entries = load(path).need("requirements").mapping()
        return {name: str(kind.value) if (kind := item.get("kind")) else "" for name, item in entries.items()}
    except InputError:
        return {}


def check_requirements(path: Path, known: KnownSignals, findings: Findings) -> int:
    """Read every definition and requirement; returns how many requirements there are.

    Args:
        path: `sim/requirements.yaml`.
        known: the signals.
        findings: takes the findings.
    """
    read: list[Requirement] = []
    entries: Mapping[str, Item] = {}
    with findings.collecting():
        document = load(path)
        definitions = document.get("definitions")
        ranges, texts = dict(known.ranges), dict[str, str]()
        for name, item in (definitions.mapping(most=MOST) if definitions else {}).items():
            with findings.collecting():
                texts[name] = read_definition(name, item, set(ranges), known.check)
                formula = Formula.parse(texts[name], set(ranges))
                _tell_constants(formula, ranges, item.place, f"definition {name!r}", findings)
                ranges[name] = bounds_of(formula, ranges)
            ranges.setdefault(name, ANY)  # its name is known, whatever it says
            texts.setdefault(name, str(item.value))
        entries = document.need("requirements").mapping(most=MOST)
        for item in entries.values():
            with findings.collecting():
                read.append(read_requirement(item, texts, set(ranges), known.check))
                _check_bounds(read[-1], item, ranges, findings)
        for key, item in document.mapping().items():
            if key not in KEYS:
                hint = did_you_mean(key, KEYS)
                raise InputError(f"{item.place}: unknown key {key!r} in {document.name}{hint}")
        if len(read) == len(entries) and not any(one.kind is Kind.SAFETY for one in read):
            what = "no requirement is of kind safety, so no mutant can be detected"
            findings.wrong(document.need("requirements").place, what, "give one of them `kind: safety`")
    return len(entries)


def _check_bounds(requirement: Requirement, item: Item, ranges: Mapping[str, Spans], findings: Findings) -> None:
    known = dict(ranges)
    trigger = item.get("trigger")
    if trigger is not None:
        formula = Formula.parse(requirement.trigger, set(known))
        known[TRIGGER] = bounds_of(formula, known)
        always = verdict(known[TRIGGER])
        if always is False:
            what = f"the trigger of {requirement.name} comes true in no flight, so the requirement is vacuous in all"
            findings.wrong(trigger.place, what, _reads(formula, known))
            return
        if always:
            what = f"the trigger of {requirement.name} is true at every sample of every flight"
            findings.note(trigger.place, what, "leave it out, or mend it")
        else:
            _tell_constants(formula, known, trigger.place, f"trigger of {requirement.name}", findings)
    body = inside_always(requirement.text)
    assert body is not None
    formula = Formula.parse(body, set(known))
    always, place = verdict(bounds_of(formula, known)), item.need("formula").place
    if always is not None:
        what = f"{requirement.name} is {'held' if always else 'violated'} by every flight, whatever the drone does"
        findings.wrong(place, what, _reads(formula, known))
    else:
        _tell_constants(formula, known, place, f"formula of {requirement.name}", findings)


def check_predicate(
    text: str, place: str, name: str, known: KnownSignals, passing: Collection[str], findings: Findings
) -> None:
    """Check the formula `realised` of a value.

    Args:
        text: the formula.
        place: where it stands.
        name: name of the value.
        known: the signals that every flight records.
        passing: names of the signals that only some flights record.
        findings: takes the findings.

    Raises:
        FormulaError: it is no formula over the signals, or compares one beyond its cap.
    """
    ranges = {**dict.fromkeys(passing, ANY), **known.ranges}
    formula = known.check(text, set(ranges))
    always = verdict(bounds_of(formula, ranges))
    if always is not None:
        what = f"realised of {name} comes true in {'every' if always else 'no'} flight: {text}"
        findings.wrong(place, what, _reads(formula, ranges))
    else:
        _tell_constants(formula, ranges, place, f"realised of {name}", findings)


def _tell_constants(formula: Formula, ranges: Ranges, place: str, about: str, findings: Findings) -> None:
    for comparison, true in constants(formula, ranges):
        what = f"'{comparison}' in the {about} is {str(true).lower()} at every sample of every flight"
        findings.note(place, what, _reads(formula, ranges, tokenize(comparison)))


def _reads(formula: Formula, ranges: Mapping[str, Spans], words: Collection[str] = ()) -> str:
    """What the signals of a formula can read, as advice."""
    names = [name for name in formula.names if not words or name in " ".join(words)]
    spans = [f"{name} {' or '.join(_span(*span) for span in ranges[name])}" for name in names if name in ranges]
    return f"compare with what can be measured: {', '.join(spans)}"


def _span(low: float, high: float) -> str:
    return f"is {low:g}" if low == high else f"is {low:g} to {high:g}".replace("-inf to inf", "any number")


NAMED = 5
"""Seams or cells that a note names."""


@dataclass(frozen=True)
class MatrixCheck:
    """What was read of the matrix.

    Attributes:
        cells: the cells that can be read.
        mutants: number of mutants that the matrix derives; None where it cannot.
        matrix: the whole matrix; None where a part of it cannot be read.
    """

    cells: tuple[Cell, ...] = ()
    mutants: int | None = None
    matrix: Matrix | None = None


def check_matrix(study: Study, stack: Declaration | None, kinds: Mapping[str, str], findings: Findings) -> MatrixCheck:
    """Read the matrix, and hold it against stack and requirements.

    Args:
        study: the study.
        stack: declaration of its stack; None where it cannot be read, which leaves seams and operators unchecked.
        kinds: kind of each requirement by name; empty where they cannot be read.
        findings: takes the findings.
    """
    before, hazop = findings.errors, study.folder / "hazop"
    words: tuple[Guideword, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    places: dict[str, str] = {}
    with findings.collecting():
        path = hazop / "guidewords.yaml"
        words = tuple(Guideword(name, name, "") for name in load(path).mapping())  # where one of them is wrong
        words = load_guidewords(path)
    with findings.collecting():
        path = hazop / "parameters.yaml"
        places = {name: item.place for name, item in load(path).mapping().items()}
        parameters = tuple(Parameter(name, name, "", "", "") for name in places)
        parameters, places = load_parameters(path)
    classes: tuple[SeverityClass, ...] = ()
    with findings.collecting():
        path = hazop / SEVERITIES
        names = load(path).mapping() if is_there(path) else {}
        classes = tuple(SeverityClass(rank, name, name, "") for rank, name in enumerate(names))
        classes = load_severities(path)
    if not words or not parameters:
        return MatrixCheck()
    findings.all_of(misnamed_sheets(hazop / SHEETS, places))
    read = [pair for one in parameters for pair in _cells(study, one, words, stack, classes, findings)]
    cells = [cell for cell, _ in read]
    for cell in cells:
        _check_requirements(cell, kinds, findings)
        if stack is not None:
            _check_faults(cell, words, parameters, findings)
    whole = findings.errors == before
    if whole or len(cells) == len(words) * len(parameters):
        _check_controls(study, cells, stack, findings)
        _check_seams(study, cells, stack, findings)
        _check_severities(study, classes, read, findings)
    if not whole or stack is None:
        return MatrixCheck(tuple(cells))
    matrix: Matrix | None = None
    mutants: int | None = None
    with findings.collecting():
        matrix = study.matrix
        mutants = len(derive(matrix))
        _ = study.catalogue  # reading it compares it with the matrix
    with findings.collecting():
        _ = study.alpha
    return MatrixCheck(tuple(cells), mutants, matrix)


def _cells(
    study: Study,
    parameter: Parameter,
    words: Iterable[Guideword],
    stack: Declaration | None,
    classes: tuple[SeverityClass, ...],
    findings: Findings,
) -> Iterator[tuple[Cell, SeverityClass | None]]:
    path, ids = study.folder / "hazop" / SHEETS / f"{parameter.id}.yaml", [word.id for word in words]
    if not is_there(path):
        return
    with findings.collecting():
        sheet, seams = load(path), stack.by_name if stack else None
        if not findings.all_of(misnamed_cells(sheet, ids)):
            ids = [word for word in ids if word in sheet.mapping()]  # a blank cell may be the one that is misnamed
        yield from findings.each(lambda word: read_cell(sheet, word, parameter.id, seams, classes), ids)


def _check_requirements(cell: Cell, kinds: Mapping[str, str], findings: Findings) -> None:
    for name in cell.requirements if kinds else ():
        if name not in kinds:
            hint = did_you_mean(name, kinds).removeprefix("; ")
            findings.wrong(cell.requirements_place, f"{name!r} of {cell.name} is no requirement", hint)
    deciding = [name for name in cell.requirements if kinds.get(name, "safety") != "reported"]
    if cell.status is CellStatus.CONTROL and not deciding:
        findings.wrong(
            cell.requirements_place,
            f"the control {cell.name} names no requirement of kind safety or operability, so it can never show itself",
            "name the requirement that its fault must violate",
        )


def _check_faults(cell: Cell, words: Iterable[Guideword], parameters: Iterable[Parameter], findings: Findings) -> None:
    """Derive the mutants of each fault alone: operator, seam, arguments and every magnitude must fit."""
    word = next(one for one in words if one.id == cell.guideword)
    parameter = next(one for one in parameters if one.id == cell.parameter)
    for fault in cell.faults:
        alone = {(cell.guideword, cell.parameter): replace(cell, faults=(fault,))}
        try:
            derive(Matrix((word,), (parameter,), alone))
        except InputError as error:
            found = finding_of(str(error))
            takes = f"`scaloft-fi operators {fault.operator}` shows what it takes"
            findings.add(replace(found, remedy=found.remedy or takes))


def _check_controls(study: Study, cells: Sequence[Cell], stack: Declaration | None, findings: Findings) -> None:
    controls = [cell for cell in cells if cell.status is CellStatus.CONTROL]
    place = str(study.folder / "hazop" / SHEETS)
    if to_do := [cell.name for cell in cells if cell.status is CellStatus.TO_DO]:
        what = f"cells to do, without a mutant: {_some(to_do)}"
        remedy = "give each faults and requirements with status credible, or a reason with status not_meaningful"
        findings.add(Finding(Severity.NOTE, place, None, what, remedy=remedy))
    if not controls:
        what = "no cell is a control, so no flight proves that faults reach the drone"
        remedy = "give a cell `status: control` whose fault no drone survives, such as velocity commands turned round"
        findings.add(Finding(Severity.NOTE, place, None, what, remedy=remedy))
    elif stack and stack.canaries and not any(cell.faults[0].seam in stack.canaries for cell in controls):
        names = ", ".join(stack.canaries)
        what = f"no control strikes a seam that carries samples in every situation ({names})"
        remedy = "make a cell with a fault there a control, because `run --mutant` flies one control in one situation"
        findings.add(Finding(Severity.NOTE, place, None, what, remedy=remedy))


def _check_seams(study: Study, cells: Iterable[Cell], stack: Declaration | None, findings: Findings) -> None:
    used = {fault.seam for cell in cells for fault in cell.faults}
    seams = list(stack.by_name) if stack else []
    idle = [name for name in seams if name not in used]
    if idle:
        what = f"no cell of the matrix has a fault at {len(idle)} of the stack's {len(seams)} seams: {_some(idle)}"
        remedy = "ask the guidewords of what they carry, or leave them out on purpose; `scaloft-fi seams` counts cells"
        findings.add(Finding(Severity.NOTE, str(study.folder / "hazop" / SHEETS), None, what, remedy=remedy))


def _check_severities(
    study: Study,
    classes: Iterable[SeverityClass],
    read: Iterable[tuple[Cell, SeverityClass | None]],
    findings: Findings,
) -> None:
    """Name the credible cells without a class, where the study has classes."""
    lacking = [cell.name for cell, severity in read if cell.status is CellStatus.CREDIBLE and severity is None]
    names = [one.id for one in classes]
    if names and lacking:
        what = f"severity is missing in {len(lacking)} credible cells: {_some(lacking)}"
        remedy = f"give each a class, `severity: {names[0]}` or another of {SEVERITIES}; without one it stands last"
        findings.add(Finding(Severity.NOTE, str(study.folder / "hazop" / SEVERITIES), None, what, remedy=remedy))


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:NAMED]) + (f" and {len(names) - NAMED} more" if len(names) > NAMED else "")
