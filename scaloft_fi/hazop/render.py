"""Render the matrix for a terminal: the grid, a list of all cells, the sheet of one cell; its rows as plain data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from scaloft_fi.hazop.matrix import Cell, CellStatus, Fault, Matrix, class_of
from scaloft_fi.output import wrapped

LEGEND = (
    "3s       credible: can happen, and is flown at this default magnitude",
    "yes      credible: can happen in one form only, no magnitude",
    "CONTROL  a crude fault that the tests must detect; if it survives, the test bench is broken",
    "-        not meaningful: the guideword makes no new deviation of this parameter",
)

TO_DO = "to do    a draft that is never flown: it lacks faults and requirements, or the reason why it has none"

BESIDE = 40
"""The deviation stands beside its guideword where it has this room, else below it [characters]."""
MARK_COLUMNS = 9
"""Where the meanings begin in the legend [characters]."""
MARKS = {
    CellStatus.CREDIBLE: "yes",
    CellStatus.CONTROL: "CONTROL",
    CellStatus.NOT_MEANINGFUL: "-",
    CellStatus.TO_DO: "to do",
}


def mark(cell: Cell) -> str:
    """Return the magnitude of the default mutant; without one, a word for the status of the cell."""
    return (cell.status is CellStatus.CREDIBLE and cell.default_magnitude) or MARKS[cell.status]


def tally(matrix: Matrix) -> str:
    """Write the size of the matrix and the number of cells of each status.

    >>> tally(Matrix((), (), {}))
    '0 parameters x 0 guidewords = 0 cells: 0 credible, 0 control, 0 not meaningful'
    """
    counted = (one for one in matrix.counts().items() if one[1] or one[0] is not CellStatus.TO_DO)
    counts = ", ".join(f"{count} {status.replace('_', ' ')}" for status, count in counted)
    return f"{len(matrix.parameters)} parameters x {len(matrix.guidewords)} guidewords = {len(matrix)} cells: {counts}"


def grid_table(matrix: Matrix, signs: Mapping[str, str]) -> tuple[list[str], list[list[str]]]:
    """Return header and rows of the grid: a row for each parameter, a column for each guideword."""
    marks = {cell.name: f"{signs.get(cell.name, '')} {mark(cell)}".lstrip() for cell in matrix}
    rows = [[p.id, *(marks[f"{word.id}-{p.id}"] for word in matrix.guidewords)] for p in matrix.parameters]
    return ["", *(word.id for word in matrix.guidewords)], rows


def grid(matrix: Matrix, columns: int, signs: Mapping[str, str]) -> str:
    """Draw the grid; a grid that is too wide is split into blocks of columns."""
    header, rows = grid_table(matrix, signs)
    for gap in (2, 1):
        lines = aligned([header, *rows], gap)
        if max(map(len, lines)) <= columns:
            return "\n".join(lines)
    return blocks(header, rows, columns)


def signs_grid(matrix: Matrix, signs: Mapping[str, str], columns: int) -> list[str]:
    """The cells that have a sign, by their names, a line for each parameter; guidewords are cut to their room."""
    shown = [cell for cell in matrix if cell.name in signs]
    words = [word.id for word in matrix.guidewords if any(cell.guideword == word.id for cell in shown)]
    names = dict.fromkeys(cell.parameter for cell in shown)
    room = columns - max(map(len, names), default=0) - 1
    most = room if len(" ".join(words)) <= room else max(1, room // len(words) - 1)
    rows = [[name, *(signs.get(f"{word}-{name}", "") for word in words)] for name in names]
    head, _, *lines = aligned([["", *(word[:most] for word in words)], *rows], 1)
    return [head, *lines]


def blocks(header: Sequence[str], rows: Sequence[Sequence[str]], columns: int) -> str:
    """Align a table; a table that is too wide is split into blocks of columns, each with the first column."""
    table = [list(header), *map(list, rows)]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    parts: list[list[int]] = [[]]
    for at in range(1, len(widths)):
        if parts[-1] and widths[0] + sum(2 + widths[i] for i in (*parts[-1], at)) > columns:
            parts.append([])
        parts[-1].append(at)
    return "\n\n".join("\n".join(aligned([[row[i] for i in (0, *part)] for row in table], 2)) for part in parts)


def cells(matrix: Matrix, columns: int) -> str:
    """List every cell by parameter: guideword, mark, requirements at risk, deviation or reason."""
    tags = [(cell.guideword, mark(cell), " ".join(cell.requirements)) for cell in matrix]
    widths = [max((len(tag[i]) for tag in tags), default=0) for i in range(3)]
    blocks = []
    for parameter in matrix.parameters:
        lines = _wrapped("", f"{parameter.id}: {parameter.title} ({parameter.node})", columns)
        for word in matrix.guidewords:
            cell = matrix.cells[word.id, parameter.id]
            tag = (cell.guideword, mark(cell), " ".join(cell.requirements))
            head = "  " + "  ".join(text.ljust(width) for text, width in zip(tag, widths, strict=True)) + "  "
            if columns - len(head) < BESIDE:
                lines.append(head.rstrip())
                head = " " * 6
            lines += _wrapped(
                head, cell.deviation or (f"not meaningful: {cell.reason}" if cell.reason else cell.told), columns
            )
        blocks.append("\n".join(lines))
    return "\n\n".join(blocks)


def overview(matrix: Matrix, columns: int, signs: Mapping[str, str]) -> str:
    """Draw the grid with its legend and counts; `signs`: what a campaign says, by the name of the cell."""
    marks = (*LEGEND, TO_DO) if matrix.counts()[CellStatus.TO_DO] else LEGEND
    return "\n".join([grid(matrix, columns, signs), "", legend(marks, columns), "", wrapped(tally(matrix), columns)])


def legend(entries: Iterable[str], columns: int, at: int = MARK_COLUMNS) -> str:
    """Wrap a legend: each entry is a mark and, from the place `at` on, what the mark means."""
    return "\n".join(wrapped(entry, columns, "", " " * at) for entry in entries)


def sheet(matrix: Matrix, cell: Cell, edges: Mapping[str, str], columns: int) -> str:
    """Write all entries of one cell.

    Args:
        matrix: the matrix of the cell.
        cell: the cell.
        edges: the stages that each seam connects, by the name of the seam.
        columns: width of the text [characters].
    """
    word = next(word for word in matrix.guidewords if word.id == cell.guideword)
    parameter = next(parameter for parameter in matrix.parameters if parameter.id == cell.parameter)
    severity = matrix.severities.get(cell.name)
    entries: list[tuple[str, Iterable[str]]] = [
        ("status", [cell.status.replace("_", " ")]),
        ("parameter", [f"{parameter.title}: {parameter.intent}"]),
        ("node", [f"{parameter.node} [{parameter.unit}]"]),
        ("guideword", [f"{word.title}: {word.meaning}", *([f"extension: {word.reason}"] if word.extension else [])]),
        ("reason", [cell.reason]),
        ("deviation", [cell.deviation]),
        ("causes", [f"- {cause}" for cause in cell.causes]),
        ("effect", [cell.effect]),
        ("severity", [f"{severity.id}: {severity.title}"] if severity else []),
        ("requirements", [", ".join(cell.requirements)]),
        ("predicted", [cell.predicted]),
        *((name.replace("_", " "), [text]) for name, text in vars(cell.team).items() if text),
        *(("proposed", [f"{fault.operator} at {fault.seam} {ladder(fault)}"]) for fault in cell.proposed),
    ]
    for fault in cell.faults:
        edge = f" ({edges[fault.seam]})" if fault.seam in edges else ""
        fixed = ", ".join(f"{name} = {yaml_text(value)}" for name, value in fault.arguments.items())
        entries += [
            ("seam", [f"{fault.seam}{edge}"]),
            ("operator", [f"{fault.operator}, {fixed}" if fixed else fault.operator]),
            ("magnitude", [ladder(fault)] if fault.magnitude else []),
            ("expected", [expectation(fault)]),
            ("mutants", mutant_lines(cell, fault)),
        ]
    label = max(len(name) for name, _ in entries) + 4
    lines = [cell.name]
    for name, texts in entries:
        head = f"  {name}"
        for text in filter(None, texts):
            lines += _wrapped(head.ljust(label), text, columns, 2 if text.startswith("- ") else 0)
            head = ""
    return "\n".join(lines)


def ladder(fault: Fault) -> str:
    """List the magnitudes of a fault; the default has a star.

    >>> from scaloft_fi.hazop.matrix import Magnitude
    >>> ladder(Fault("imu", "delay", {}, Magnitude("delay_s", "ms", (5.0, 20.0), 20.0, 0.001)))
    'delay_s = 5 ms, 20 ms*  (times 0.001; * default)'
    """
    magnitude = fault.magnitude
    if magnitude is None:
        return ""
    unit = f" {magnitude.unit}" if magnitude.unit else ""
    rungs = ", ".join(f"{yaml_text(rung)}{unit}{'*' if rung == magnitude.default else ''}" for rung in magnitude.ladder)
    scale = f"times {magnitude.scale:g}; " if magnitude.scale != 1.0 else ""
    return f"{magnitude.argument} = {rungs}  ({scale}* default)"


def expectation(fault: Fault) -> str:
    """Write the expectation about a fault; empty without one."""
    if fault.expected is None:
        return ""
    rungs = ", ".join(map(yaml_text, fault.expected.magnitudes))
    return f"{fault.expected.status}{' at ' + rungs if rungs else ''}: {fault.expected.reason}"


def mutant_lines(cell: Cell, fault: Fault) -> list[str]:
    """List the mutants of a fault; the default of the cell has a star.  With phases each magnitude has its own line."""
    lines = []
    for rung in fault.rungs:
        first, *shifted = cell.mutant_ids(fault, rung)
        default = fault is cell.faults[0] and (fault.magnitude is None or rung == fault.magnitude.default)
        more = f" and {', '.join('#' + name.split('#')[1] for name in shifted)}" if shifted else ""
        lines.append(f"{first}{'*' if default else ''}{more}")
    return lines if fault.phases else [", ".join(lines)]


def yaml_text(value: object) -> str:
    """Write a value in the form of YAML.

    >>> yaml_text(0.5), yaml_text(True), yaml_text("y")
    ('0.5', 'true', 'y')
    """
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)


def aligned(rows: Sequence[Sequence[str]], gap: int) -> list[str]:
    """Align the columns of a table; the first row is the header."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        (" " * gap).join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
    return [lines[0], "-" * (sum(widths) + gap * (len(widths) - 1)), *lines[1:]]


def _wrapped(head: str, text: str, columns: int, hang: int = 0) -> list[str]:
    return wrapped(text, columns, head, " " * (len(head) + hang if head else 4)).split("\n")


SHORT_HEADER = ("parameter", "guideword", "default", "requirements", "deviation, or why it is not meaningful")


def _arguments(fault: Fault) -> str:
    return " ".join(f"{name}={yaml_text(value)}" for name, value in fault.arguments.items())


_COLUMNS: Mapping[str, Callable[[Cell, Matrix], str]] = {
    "cell": lambda cell, _: cell.name,
    "parameter": lambda cell, _: cell.parameter,
    "guideword": lambda cell, _: cell.guideword,
    "status": lambda cell, _: str(cell.status),
    "deviation": lambda cell, _: cell.deviation,
    "causes": lambda cell, _: "; ".join(cell.causes),
    "effect": lambda cell, _: cell.effect,
    "severity": lambda cell, matrix: class_of(matrix.severities.get(cell.name)),
    "requirements": lambda cell, _: "; ".join(cell.requirements),
    "reason": lambda cell, _: cell.reason,
    "predicted": lambda cell, _: cell.predicted,
    "seam": lambda cell, _: "; ".join(fault.seam for fault in cell.faults),
    "operator": lambda cell, _: "; ".join(fault.operator for fault in cell.faults),
    "arguments": lambda cell, _: "; ".join(map(_arguments, cell.faults)),
    "magnitudes": lambda cell, _: "; ".join(filter(None, map(ladder, cell.faults))),
    "expected": lambda cell, _: "; ".join(filter(None, map(expectation, cell.faults))),
    "default_mutant": lambda cell, _: cell.default_id if cell.faults else "",
}
HEADER = tuple(_COLUMNS)


def rows(matrix: Matrix) -> list[list[str]]:
    """Return a row of texts for each cell, under `HEADER`; several entries of one column are joined by `; `."""
    return [[text(cell, matrix) for text in _COLUMNS.values()] for cell in matrix]


def short_rows(matrix: Matrix) -> list[list[str]]:
    """Return a row for each cell, under `SHORT_HEADER`."""
    return [[cell.parameter, cell.guideword, mark(cell), ", ".join(cell.requirements), cell.told] for cell in matrix]
