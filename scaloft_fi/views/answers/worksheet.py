"""What `worksheet` answers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from scaloft_fi.console import PIPED
from scaloft_fi.errors import InputError
from scaloft_fi.output import write_named
from scaloft_fi.study import Study
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.snapshot import snapshot
from scaloft_fi.views.stale import Stale
from scaloft_fi.views.tables.table import Format
from scaloft_fi.views.worksheet.worksheet import SheetRow
from scaloft_fi.views.worksheet.worksheet import worksheet as filled_back
from scaloft_fi.views.worksheet.worksheet_record import WORKSHEET, worksheet_values
from scaloft_fi.views.worksheet.worksheet_text import sheet_tables, to_csv, to_latex, to_markdown, to_text

XLSX = "xlsx"
STYLES = (*Format, XLSX)
"""How the sheet is written."""
_ENDS = {".txt": "table", ".md": "markdown", ".csv": "csv", ".json": "json", ".tex": "latex", ".xlsx": XLSX}


class Worksheet(Answer):
    """The HAZOP worksheet with what the flights found.

    Args:
        rows: the rows of the sheet.
        stale: the flights that no longer count.
        warnings: as of `Answer`.
    """

    def __init__(self, rows: Sequence[SheetRow], stale: Stale, warnings: Sequence[str]) -> None:
        super().__init__(
            WORKSHEET,
            lambda: worksheet_values(rows) | stale.values,
            lambda: sheet_tables(rows),
            warnings=(*stale.sentences, *warnings),
        )
        self._sheet = rows

    def text(self, style: str = "table") -> str:
        """What the verb prints; as `csv` the sheet for people.

        Raises:
            InputError: there is no such style.
        """
        made = {Format.TABLE: to_text, Format.MARKDOWN: to_markdown, Format.CSV: to_csv, Format.LATEX: to_latex}
        return made[Format(style)](self._sheet) if style in made else super().text(style)

    def content(self, style: str) -> bytes:
        """The bytes of a file in a style of `STYLES`."""
        if style == XLSX:
            from scaloft_fi.views.worksheet.spreadsheet import to_xlsx

            return to_xlsx(self._sheet)
        if style == Format.TABLE:
            return to_text(self._sheet, width=PIPED, marked=False).encode()
        return self.text(style).encode()

    def save(self, path: Path | str) -> Path:
        """Write the sheet; the end of the name decides the format.

        Args:
            path: a name that ends in `.xlsx`, `.csv`, `.md`, `.tex`, `.json` or `.txt`.

        Raises:
            InputError: the name ends otherwise, the file cannot be written, or openpyxl is missing for `.xlsx`.
        """
        file = Path(path)
        style = _ENDS.get(file.suffix.lower())
        if style is None:
            raise InputError(f"path={str(path)!r} must end in {', '.join(_ENDS)}")
        write_named(file, self.content(style), "path")
        return file


def worksheet(study: Study, campaign: str) -> Worksheet:
    """Every deviation of the matrix beside what its default mutant did in the campaign.

    Raises:
        InputError: there is no such campaign, or it holds no flight that counts.
    """
    with snapshot(study, campaign) as now:
        study, finds, stale = now.study, now.study.finds, now.stale
        rows = filled_back(study.matrix, now.outcomes, now.score, study.space, study.dispositions, finds, now.name)
    return Worksheet(rows, stale, finds.warnings)
