"""`scaloft-fi coverage`: how much of the situations a campaign covers, and whether that predicts its kills."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scaloft_fi.cli.files import check_writable, write
from scaloft_fi.cli.options import campaign_option, format_option, study_option
from scaloft_fi.errors import InputError

if TYPE_CHECKING:
    from scaloft_fi.analysis.curves.curves import Curves
    from scaloft_fi.analysis.curves.prediction import Prediction
    from scaloft_fi.analysis.scoring.detection import Spending
    from scaloft_fi.campaign.runs.strategy import Remembered
    from scaloft_fi.judge.rulings import Rulings
    from scaloft_fi.study import Study

PICTURES = (".svg", ".png")


@click.command("coverage")
@study_option
@campaign_option
@click.option(
    "--against-kills",
    "against",
    is_flag=True,
    help="Compare the ways to choose situations: what k of them cover and kill, beside random situations.",
)
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw coverage against kills there: .svg or .png.",
)
@format_option
def coverage_command(study_folder: Path | None, campaign: str, against: bool, output: Path | None, style: str) -> None:
    """Print the coverage of a campaign's situations, number by number."""
    from scaloft_fi.analysis.curves.curve_tables import curve_tables, curves_json
    from scaloft_fi.analysis.situations.coverage import coverage_json, coverage_of
    from scaloft_fi.study import Study
    from scaloft_fi.views.coverage.coverage_tables import coverage_tables
    from scaloft_fi.views.tables.table import Format, render

    if output is not None and output.suffix.lower() not in PICTURES:
        raise InputError(f"--output={str(output)!r} must end in .svg or .png")
    check_writable(output)
    study = Study.open(study_folder)
    rulings, choices, spending = _held(study, campaign)
    covered = coverage_of(rulings.baselines, rulings.draws, study.space)
    followed = _followed(study, rulings, spending) if against or output is not None else None
    if output is not None and followed is not None:
        _draw(followed[0], output)
    if style == Format.JSON:
        content = {"coverage": coverage_json(covered), "choices": [_choice(one) for one in choices]}
        if against and followed is not None:
            content["against_kills"] = curves_json(*followed)
        click.echo(json.dumps(content, indent=2, allow_nan=False))
        return
    made = [(one.text, one.seed, len(one.draws), len({key for key, _ in one.draws})) for one in choices]
    tables = coverage_tables(covered, study.space, made)
    if against and followed is not None:
        tables += curve_tables(*followed)
    click.echo(render(tables, Format(style)), nl=False)


def _held(study: Study, campaign: str) -> tuple[Rulings, Sequence[Remembered], Spending]:
    from scaloft_fi.campaign.runs.spending import spending_of
    from scaloft_fi.campaign.runs.strategy import remembered
    from scaloft_fi.campaign.store.folder import campaign_folder, existing
    from scaloft_fi.campaign.store.held import current
    from scaloft_fi.campaign.store.store import Store
    from scaloft_fi.judge.rulings import rulings_of

    rulings = rulings_of(current(study, campaign))
    with Store(existing(campaign_folder(study, campaign)), create=False) as store:
        return rulings, remembered(store), spending_of(study, store)


def _followed(study: Study, rulings: Rulings, spending: Spending) -> tuple[Curves, Prediction]:
    """The curves of a campaign.

    Raises:
        InputError: no default mutant was flown.
    """
    from scaloft_fi.analysis.curves.curves import curves
    from scaloft_fi.analysis.curves.prediction import predict
    from scaloft_fi.analysis.curves.trial import trial
    from scaloft_fi.analysis.scoring.score import score_of

    roster, space = study.roster, study.space
    flown = trial(score_of(rulings, roster, space, spending), rulings, roster, space, spending)
    if flown is None:
        raise InputError("coverage against kills needs default mutants of credible cells: none was flown")
    found = curves(flown)
    return found, predict(found)


def _draw(found: Curves, output: Path) -> None:
    from scaloft_fi.analysis.curves.curve_picture import curve_picture
    from scaloft_fi.views.pictures.picture import png

    svg = curve_picture(found)
    write(output, png(svg) if output.suffix.lower() == ".png" else svg.encode())
    click.echo(f"picture: {output}", err=True)


def _choice(one: Remembered) -> dict[str, object]:
    return {"choose": one.text, "seed": one.seed, "pool": one.pool, "draws": [list(draw) for draw in one.draws]}
