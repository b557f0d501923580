"""`scaloft-fi worksheet`: the HAZOP worksheet filled back with what the flights say."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli.answer import answer, tell_warnings
from scaloft_fi.cli.files import check_writable, write
from scaloft_fi.cli.options import FORMATS, campaign_option, study_option
from scaloft_fi.cli.verb import verb


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

    Deviations that are not credible stand in a log with their reason.  What only a team can judge (likelihood,
    recommendation, ...) is left empty; severity is the class that the study gives.
    """
    if style == "xlsx" and output is None:
        raise click.UsageError("--format xlsx goes into a file: name it with --output")
    check_writable(output)
    from scaloft_fi.study import Study
    from scaloft_fi.views.answers.worksheet import worksheet

    sheet = worksheet(Study.open(study_folder), campaign)
    if output is None:
        answer(sheet, style)
        return
    tell_warnings(sheet)
    write(output, sheet.content(style))
