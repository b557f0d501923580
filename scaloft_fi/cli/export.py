"""`scaloft-fi export`: one row per flight, or the campaign in the format of another tool."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scaloft_fi.cli.files import check_writable, write
from scaloft_fi.cli.options import campaign_option, study_option
from scaloft_fi.errors import InputError

if TYPE_CHECKING:
    from scaloft_fi.study import Study


def _json(study: Study, campaign: str) -> bytes:
    from scaloft_fi.views.flights.export import to_json

    return to_json(_rows(study, campaign)).encode()


def _csv(study: Study, campaign: str) -> bytes:
    from scaloft_fi.views.flights.export import to_csv

    return to_csv(_rows(study, campaign), _names(study)).encode()


def _parquet(study: Study, campaign: str) -> bytes:
    from scaloft_fi.views.exchange.parquet import parquet
    from scaloft_fi.views.flights.export import columns

    rows = _rows(study, campaign)
    return parquet(rows, columns(rows, _names(study)))


def _mutation_testing(study: Study, campaign: str) -> bytes:
    from scaloft_fi.views.exchange.gather import dossier
    from scaloft_fi.views.exchange.mutation_testing import mutation_testing

    return _plain(mutation_testing(dossier(study, campaign)))


def _junit(study: Study, campaign: str) -> bytes:
    from scaloft_fi.views.exchange.gather import dossier
    from scaloft_fi.views.exchange.junit import junit

    return junit(dossier(study, campaign)).encode()


def _sarif(study: Study, campaign: str) -> bytes:
    from scaloft_fi.views.exchange.gather import dossier
    from scaloft_fi.views.exchange.sarif import sarif

    return _plain(sarif(dossier(study, campaign)))


def _markdown(study: Study, campaign: str) -> bytes:
    from scaloft_fi.views.exchange.gather import dossier
    from scaloft_fi.views.exchange.summary import summary

    return summary(dossier(study, campaign)).encode()


def _gsn(study: Study, campaign: str) -> bytes:
    from scaloft_fi.views.exchange.gather import dossier
    from scaloft_fi.views.exchange.gsn import gsn

    return gsn(dossier(study, campaign)).encode()


def _sace(study: Study, campaign: str) -> bytes:
    from scaloft_fi.views.exchange.gather import dossier
    from scaloft_fi.views.exchange.sace import to_markdown

    return to_markdown(dossier(study, campaign)).encode()


def _sace_json(study: Study, campaign: str) -> bytes:
    from scaloft_fi.views.exchange.gather import dossier
    from scaloft_fi.views.exchange.sace import to_json

    return _plain(to_json(dossier(study, campaign)))


FORMATS: dict[str, tuple[Callable[[Study, str], bytes], str]] = {
    "json": (_json, "one row per flight, a list"),
    "csv": (_csv, "the same columns"),
    "parquet": (_parquet, "the same, typed (extra: parquet)"),
    "markdown": (_markdown, "a page for the summary of a CI job"),
    "junit": (_junit, "a test per mutant, one that is not detected fails"),
    "sarif": (_sarif, "what is not detected on the lines of the HAZOP matrix, SARIF 2.1.0"),
    "mutation-testing": (_mutation_testing, "mutation-testing-report-schema 2"),
    "gsn": (_gsn, "the argument in goal structuring notation, for gsn2x"),
    "sace": (_sace, "the verification log, SACE artefact [SS], Markdown"),
    "sace-json": (_sace_json, "the same as JSON"),
}
"""What `--format` takes: what writes it, and what it is."""


@click.command("export", epilog="Formats: " + "; ".join(f"{name}: {about}" for name, (_, about) in FORMATS.items()))
@study_option
@campaign_option
@click.option("--format", "style", type=click.Choice(list(FORMATS)), default="json", show_default=True)
@click.option("--output", type=click.Path(path_type=Path), metavar="FILE", help="Write there instead of printing.")
def export_command(study_folder: Path | None, campaign: str, style: str, output: Path | None) -> None:
    """Print one row per flight, ordered by mutant, situation and seed, or the campaign in another tool's format.

    Facts of the simulation only: no clock, host or worker is in it.
    """
    check_writable(output)
    if output is None and style == "parquet":
        raise InputError("--format='parquet' is no text: give --output FILE")
    from scaloft_fi.study import Study

    content = FORMATS[style][0](Study.open(study_folder), campaign)
    if output is None:
        click.echo(content, nl=False)
    else:
        write(output, content)


def _names(study: Study) -> list[str]:
    return [requirement.name for requirement in study.requirements]


def _rows(study: Study, campaign: str) -> list[dict[str, object]]:
    from scaloft_fi.campaign.store.held import current
    from scaloft_fi.views.flights.export import export_rows

    return export_rows(current(study, campaign), study.roster, study.space, _names(study))


def _plain(content: object) -> bytes:
    import json

    return (json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()
