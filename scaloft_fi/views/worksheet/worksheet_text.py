"""The worksheet as text: for a terminal, Markdown, LaTeX, and CSV that a spreadsheet opens.

Deviations that are not credible stand in a log of their own, with their reason; CSV is one table and has them there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from scaloft_fi.console import line
from scaloft_fi.hazop.matrix import CellStatus, worst_first
from scaloft_fi.views.tables.literal import latex, markdown
from scaloft_fi.views.tables.table import Format, Table, csv_text, render
from scaloft_fi.views.worksheet.worksheet import COLUMNS, FOUND, SPARE, Column, SheetRow, SheetValue, population

TITLE, LOG_TITLE = "HAZOP worksheet", "Deviations not credible"
LOG_KEYS = ("cell", "parameter", "rationale")
IN_TERMINAL = ("cell", "severity", "verdict", "operability", "kill_rate", "margin", "where", "disposition")
SURVIVORS_TITLE = "Survivors, worst class first"
SURVIVORS_KEYS = ("cell", "effect", "severity", "verdict", "disposition")
FINDS_TITLE, FINDS_KEYS = "Finds for survivors", ("cell", *FOUND)
LATEX_NOTE = (
    "% needs longtable, booktabs, array, pdflscape\n"
    "% letters that are not Latin need XeLaTeX or LuaLaTeX, with a font that has them"
)
LONG_WORD = 16
"""A column is made wide enough for words up to this length [characters]."""


def parts(rows: Sequence[SheetRow]) -> tuple[list[SheetRow], list[SheetRow]]:
    """The deviations that can happen, and the log of those that are not credible."""
    log = [row for row in rows if row.cell.status is CellStatus.NOT_MEANINGFUL]
    return [row for row in rows if row.cell.status is not CellStatus.NOT_MEANINGFUL], log


def columns(keys: Sequence[str] = ()) -> list[Column]:
    """The columns with these keys, or those that fit a page."""
    return [column for column in COLUMNS if (column.key in keys if keys else column.short)]


def survivors(rows: Sequence[SheetRow]) -> list[SheetRow]:
    """The credible deviations flown and not detected, the worst class first; none where no cell has a class."""
    classed = any(row.severity for row in rows)
    return worst_first((row for row in rows if row.survives), lambda row: row.severity) if classed else []


def filled(shown: Sequence[Column], rows: Sequence[SheetRow]) -> list[Column]:
    """The columns without those that may be spared and have no value in any row."""
    return [column for column in shown if column.key not in SPARE or any(row.values[column.key] for row in rows)]


def value_text(value: SheetValue) -> str:
    """A value in a cell; nothing where there is none."""
    return "" if value is None else str(value)


def to_text(rows: Sequence[SheetRow], *, width: int | None = None, marked: bool | None = None) -> str:
    """For a terminal: the tables of `sheet_tables`.

    Args:
        rows: of the worksheet.
        width: of the text, as of `render`.
        marked: whether it has colours, as of `render`.
    """
    return render(sheet_tables(rows), Format.TABLE, width=width, marked=marked)


def sheet_tables(rows: Sequence[SheetRow]) -> tuple[Table, ...]:
    """The findings of each deviation, survivors by class and finds where there are any, then the log."""
    sheet, log = parts(rows)
    found, alive = [row for row in sheet if row.values["find"]], survivors(rows)
    return (
        _table(
            TITLE, filled(columns(IN_TERMINAL), sheet), sheet, (population(rows), "Every column: --format csv or xlsx.")
        ),
        *([_table(SURVIVORS_TITLE, columns(SURVIVORS_KEYS), alive)] if alive else []),
        *([_table(FINDS_TITLE, columns(FINDS_KEYS), found)] if found else []),
        _table(LOG_TITLE, columns(LOG_KEYS), log),
    )


def _table(title: str, shown: Sequence[Column], rows: Sequence[SheetRow], notes: tuple[str, ...] = ()) -> Table:
    lines = tuple(tuple(line(value_text(row.values[column.key])) for column in shown) for row in rows)
    return Table(title, tuple(column.title for column in shown), lines, notes)


def to_markdown(rows: Sequence[SheetRow]) -> str:
    """Markdown tables; every character of the study's is taken literally."""
    sheet, log = parts(rows)
    alive = survivors(rows)
    return "\n".join(
        [
            f"### {TITLE}\n",
            *_piped(filled(columns(), sheet), sheet),
            f"\n{markdown(population(rows))}\n",
            *([f"### {SURVIVORS_TITLE}\n", *_piped(columns(SURVIVORS_KEYS), alive), ""] if alive else []),
            f"### {LOG_TITLE}\n",
            *_piped(columns(LOG_KEYS), log),
            "",
        ]
    )


def _piped(shown: Sequence[Column], rows: Sequence[SheetRow]) -> list[str]:
    lines = [[markdown(value_text(row.values[column.key])) for column in shown] for row in rows]
    header = [[column.title for column in shown], ["---"] * len(shown)]
    return [f"| {' | '.join(cells)} |" for cells in (*header, *lines)]


def to_latex(rows: Sequence[SheetRow]) -> str:
    """A fragment with long tables on landscape pages, header rows repeated."""
    sheet, log = parts(rows)
    alive = survivors(rows)
    tables = [
        _longtable(TITLE, filled(columns(), sheet), sheet),
        latex(population(rows)),
        *([_longtable(SURVIVORS_TITLE, columns(SURVIVORS_KEYS), alive)] if alive else []),
        _longtable(LOG_TITLE, columns(LOG_KEYS), log),
    ]
    return "\n".join(
        [
            LATEX_NOTE,
            r"\begin{landscape}\scriptsize\setlength{\tabcolsep}{2.5pt}\raggedright",
            *tables,
            r"\end{landscape}",
            "",
        ]
    )


def _longtable(title: str, shown: Sequence[Column], rows: Sequence[SheetRow]) -> str:
    widths = [_width(column, rows) for column in shown]
    # without \\hspace TeX would not hyphenate a cell's first word
    spec = "".join(
        f">{{\\raggedright\\arraybackslash\\hspace{{0pt}}}}"
        f"p{{\\dimexpr {width / sum(widths):.5f}\\linewidth-2\\tabcolsep\\relax}}"
        for width in widths
    )
    header = _row([column.title for column in shown], latex)
    lines = [_row([value_text(row.values[column.key]) for column in shown], latex) for row in rows]
    caption = f"\\caption{{{latex(title)}}}\\\\"
    head = [f"\\begin{{longtable}}{{{spec}}}", caption, "\\toprule", header, "\\midrule", "\\endhead", "\\bottomrule"]
    return "\n".join([*head, "\\endfoot", *lines, "\\end{longtable}"])


def _width(column: Column, rows: Sequence[SheetRow]) -> float:
    """The share of a column: in a narrow one its longest word, capitals half as wide again, fills half of it."""
    words = " ".join([column.title, *(value_text(row.values[column.key]) for row in rows)]).replace("-", "- ").split()
    longest = max(len(word) + sum(letter.isupper() for letter in word) / 2 for word in words)
    return max(column.width, 2 * min(LONG_WORD, longest))


def _row(cells: Sequence[str], escape: Callable[[str], str]) -> str:
    # an empty group, so that a text that begins with [ or * is no option of the line before
    return "{}" + " & ".join(map(escape, cells)) + r" \\\addlinespace[2pt]"


def to_csv(rows: Sequence[SheetRow]) -> str:
    """Every column of every cell; a text that a spreadsheet would take for a formula begins with `'`."""
    lines = ([row.values[column.key] for column in COLUMNS] for row in rows)
    return csv_text([column.key for column in COLUMNS], lines)
