"""The worksheet as an XLSX workbook: sheet, survivors, log of deviations not credible, what the columns say.

openpyxl writes it.  Every text is written as a text, with the mark that keeps it one when somebody edits the cell: a
study's `=1+1` is never a formula.  The same sheet gives the same bytes: the file carries no clock.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Sequence
from typing import Any

from scaloft_fi.console import printable
from scaloft_fi.errors import InputError
from scaloft_fi.views.tables.literal import FORMULA
from scaloft_fi.views.worksheet.worksheet import COLUMNS, FINDINGS, TEAM, Column, SheetRow, SheetValue, population
from scaloft_fi.views.worksheet.worksheet_text import (
    LOG_KEYS,
    LOG_TITLE,
    SURVIVORS_KEYS,
    SURVIVORS_TITLE,
    TITLE,
    columns,
    parts,
    survivors,
)

LONGEST = 32_767
"""Characters of a cell: Excel's own limit, which openpyxl would cut at without a word."""
CUT = " [cut]"
_ESCAPE = re.compile(r"_(?=x[0-9A-Fa-f]{4}_)")
"""What Excel would read as a character (ECMA-376, ST_Xstring: _x0041_ is an A)."""
EPOCH = (1980, 1, 1, 0, 0, 0)
"""Date of every file in the archive: the earliest that ZIP knows."""
FILLS = {"study": "D9E2F3", "findings": "E2EFDA", "team": "FFF2CC"}
"""Header colours of the three parts; the titles say the same in words."""
FRAME = ("Company", "Team", "Process", "Operation mode", "Date", "Page")
"""Header fields of the classic sheet, for the team to fill in."""


def to_xlsx(rows: Sequence[SheetRow]) -> bytes:
    """The workbook.

    Raises:
        InputError: openpyxl is not installed.
    """
    try:
        from openpyxl import Workbook
    except ImportError:
        raise InputError("--format=xlsx needs openpyxl: pip install 'scaloft-fi[xlsx]'") from None
    sheet, log = parts(rows)
    book = Workbook()
    _fill(book.active, TITLE, COLUMNS, sheet)
    if alive := survivors(rows):
        _fill(book.create_sheet(), SURVIVORS_TITLE, columns(SURVIVORS_KEYS), alive)
    _fill(book.create_sheet(), LOG_TITLE, columns(LOG_KEYS), log)
    _about(book.create_sheet(), rows)
    raw = io.BytesIO()
    book.save(raw)
    return _without_clock(raw.getvalue())


def _fill(page: Any, title: str, shown: Sequence[Column], rows: Sequence[SheetRow]) -> None:
    from openpyxl.utils import get_column_letter

    page.title = title
    for at, column in enumerate(shown, 1):
        page.column_dimensions[get_column_letter(at)].width = column.width
        _head(_put(page, 1, at, column.title), column)
    for line, row in enumerate(rows, 2):
        for at, column in enumerate(shown, 1):
            _put(page, line, at, row.values[column.key])
    page.freeze_panes = "B2"
    page.auto_filter.ref = f"A1:{get_column_letter(len(shown))}{len(rows) + 1}"
    page.page_setup.orientation, page.page_setup.fitToWidth, page.page_setup.fitToHeight = "landscape", 1, 0
    page.sheet_properties.pageSetUpPr.fitToPage = True
    page.print_title_rows = "1:1"


def _head(cell: Any, column: Column) -> None:
    from openpyxl.styles import Font, PatternFill

    part = "team" if column in TEAM else "findings" if column in FINDINGS else "study"
    cell.font, cell.fill = Font(bold=True), PatternFill("solid", fgColor=FILLS[part])


def _put(page: Any, line: int, at: int, value: SheetValue) -> Any:
    from openpyxl.styles import Alignment

    cell = page.cell(line, at)
    cell.alignment = Alignment(wrap_text=True, vertical="top")
    if isinstance(value, str):
        text = _ESCAPE.sub("_x005F_", printable(value))
        cell.value = text if len(text) <= LONGEST else text[: LONGEST - len(CUT)] + CUT
        cell.data_type = "s"
        cell.quotePrefix = text.startswith(FORMULA)
    else:
        cell.value = value
    return cell


def _about(page: Any, rows: Sequence[SheetRow]) -> None:
    """What the columns say, and the fields at the head of the classic sheet."""
    page.title = "About"
    lines: list[tuple[str, str]] = [*((name, "") for name in FRAME), ("Population", population(rows)), ("", "")]
    lines += [(column.title, column.about) for column in COLUMNS]
    for line, texts in enumerate(lines, 1):
        for at, text in enumerate(texts, 1):
            _put(page, line, at, text)
    page.column_dimensions["A"].width, page.column_dimensions["B"].width = 24, 100


def _without_clock(raw: bytes) -> bytes:
    """The archive with every time taken out."""
    text = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(raw)) as old, zipfile.ZipFile(text, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "docProps/core.xml":
                content = re.sub(rb"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", b"1980-01-01T00:00:00Z", content)
            entry: Any = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            new.writestr(entry, content)
    return text.getvalue()
