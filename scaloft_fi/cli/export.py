"""`scaloft-fi export`: one row per flight."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli.files import check_writable, write
from scaloft_fi.cli.options import campaign_option, study_option


@click.command("export")
@study_option
@campaign_option
@click.option("--format", "style", type=click.Choice(("json", "csv")), default="json", show_default=True)
@click.option("--output", type=click.Path(path_type=Path), metavar="FILE", help="Write there instead of printing.")
def export_command(study_folder: Path | None, campaign: str, style: str, output: Path | None) -> None:
    """Print one row per flight, ordered by mutant, situation and seed: facts of the simulation only."""
    check_writable(output)
    from scaloft_fi.campaign.held import current
    from scaloft_fi.results.export import export_rows, to_csv, to_json
    from scaloft_fi.study import Study

    study = Study.open(study_folder)
    names = [requirement.name for requirement in study.requirements]
    rows = export_rows(current(study, campaign), study.roster, study.space, names)
    text = to_json(rows) if style == "json" else to_csv(rows, names)
    if output is None:
        click.echo(text, nl=False)
    else:
        write(output, text.encode())
