"""`scaloft-fi kills`: what kills what, and what to do about the rest."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.files import check_writable, write
from scaloft_fi.cli.options import campaign_option, format_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import tell_line
from scaloft_fi.errors import InputError

if TYPE_CHECKING:
    from scaloft_fi.analysis.suite import Subsumption

PARTS = ("conditions", "situations", "suite", "subsumption", "survivors")
PICTURES = (".svg", ".png", ".dot")


@verb(
    "kills",
    examples=(
        ("See where every mutant is killed", "scaloft-fi kills"),
        ("Ask what to do about one survivor", "scaloft-fi kills MORE-human --show survivors"),
        ("Find the fewest situations that keep every kill", "scaloft-fi kills --show suite"),
    ),
)
@click.argument("mutants", nargs=-1, shell_complete=names.mutants, metavar="[MUTANT...]")
@study_option
@campaign_option
@click.option(
    "--show",
    "parts",
    multiple=True,
    type=click.Choice(PARTS),
    help="Only this part, at length (repeatable).  [default: every part, shortened]",
)
@click.option(
    "--situation",
    "situations",
    multiple=True,
    shell_complete=names.situations,
    metavar="KEY|GLOB",
    help="Say also which mutants are killed in these situations together (repeatable).",
)
@click.option(
    "--by-requirement", is_flag=True, help="Subsumption tells kills by different requirements of a situation apart."
)
@format_option
@tables_option
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw the subsumption graph there: .svg, .png or .dot.",
)
def kills_command(
    mutants: tuple[str, ...],
    study_folder: Path | None,
    campaign: str,
    parts: tuple[str, ...],
    situations: tuple[str, ...],
    by_requirement: bool,
    style: str,
    tables_folder: Path | None,
    output: Path | None,
) -> None:
    """Print where each mutant is killed, which situations are needed, and what to do about the survivors.

    MUTANT is an id, a cell's name or a pattern; without any it is every mutant flown but the controls.
    """
    if output is not None and output.suffix.lower() not in PICTURES:
        raise InputError(f"--output={str(output)!r} must end in .svg, .png or .dot")
    check_writable(output)
    from scaloft_fi.study import Study
    from scaloft_fi.views.answers.kills import kills, subsumption_graph

    study = Study.open(study_folder)
    if output is not None:
        _draw(subsumption_graph(study, campaign, mutants, by_requirement=by_requirement), output)
        return
    told = kills(study, campaign, mutants, show=parts, situations=situations, by_requirement=by_requirement)
    answer(told, style, tables_folder)


def _draw(graph: Subsumption, output: Path) -> None:
    from scaloft_fi.views.pictures.picture import png
    from scaloft_fi.views.pictures.subsumption_picture import dot, draw_subsumption

    suffix = output.suffix.lower()
    if suffix == ".dot":
        write(output, dot(graph).encode())
    else:
        svg = draw_subsumption(graph)
        write(output, png(svg) if suffix == ".png" else svg.encode())
    tell_line(f"subsumption graph: {output}")
