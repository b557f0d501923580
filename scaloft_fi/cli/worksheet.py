"""`scaloft-fi worksheet`: the HAZOP worksheet filled back with what the flights say."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scaloft_fi.cli.files import check_writable, write
from scaloft_fi.cli.finds import told
from scaloft_fi.cli.options import FORMATS, campaign_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import tell
from scaloft_fi.terminal import PIPED

if TYPE_CHECKING:
    from scaloft_fi.views.worksheet.worksheet import SheetRow


@verb(
    "worksheet",
    examples=(
        ("Print the worksheet with what the flights found", "scaloft-fi worksheet"),
        ("Bring it to the HAZOP meeting as a workbook", "scaloft-fi worksheet --format xlsx --output worksheet.xlsx"),
        ("Put it into a paper", "scaloft-fi worksheet --format latex --output worksheet.tex"),
    ),
)
@study_option
@campaign_option
@click.option(
    "--format",
    "style",
    type=click.Choice((*FORMATS, "xlsx")),
    default="table",
    show_default=True,
    help="How the sheet is written; csv, xlsx and json have every column.  A text that a spreadsheet would take for a "
    "formula begins with ' in csv, and is a plain text in xlsx.",
)
@click.option("--output", type=click.Path(path_type=Path), metavar="FILE", help="Write the sheet to FILE.")
def worksheet_command(study_folder: Path | None, campaign: str, style: str, output: Path | None) -> None:
    """Print the HAZOP worksheet: every deviation beside what its default mutant did in the campaign.

    Deviations that are not credible stand in a log with their reason.  What only a team can judge (severity,
    likelihood, recommendation, ...) is left empty.
    """
    if style == "xlsx" and output is None:
        raise click.UsageError("--format xlsx goes into a file: name it with --output")
    check_writable(output)
    from scaloft_fi.study import Study
    from scaloft_fi.views.snapshot import snapshot
    from scaloft_fi.views.worksheet.worksheet import worksheet
    from scaloft_fi.views.worksheet.worksheet_text import to_text

    study = Study.open(study_folder)
    with snapshot(study, campaign) as now:
        study = now.study
        finds = told(study.finds)
        rows = worksheet(study.matrix, now.outcomes, now.score, study.space, study.dispositions, finds, campaign)
    if output is not None:
        write(output, _content(rows, style))
    elif style == "table":
        tell(to_text(rows))
    else:
        tell(_content(rows, style))


def _content(rows: Sequence[SheetRow], style: str) -> bytes:
    if style == "xlsx":
        from scaloft_fi.views.worksheet.spreadsheet import to_xlsx

        return to_xlsx(rows)
    if style == "json":
        from scaloft_fi.views.worksheet.worksheet_record import WORKSHEET, worksheet_values

        return WORKSHEET.json(worksheet_values(rows)).encode()
    from scaloft_fi.views.worksheet.worksheet_text import to_csv, to_latex, to_markdown, to_text

    if style == "table":
        return to_text(rows, width=PIPED, marked=False).encode()
    return {"markdown": to_markdown, "csv": to_csv, "latex": to_latex}[style](rows).encode()
