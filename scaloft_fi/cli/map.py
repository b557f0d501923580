"""`scaloft-fi map`: mine, bodies and route of one situation, without flying."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import answer
from scaloft_fi.cli.files import check_writable, write
from scaloft_fi.cli.options import format_option, grid_of_study_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import say
from scaloft_fi.errors import InputError

PICTURES = (".svg", ".png")


@verb(
    "map",
    examples=(
        ("Tell what stands and happens in the benign situation", "scaloft-fi map"),
        ("Draw a situation with a corner and a person", "scaloft-fi map T1O0W0D0H1 --output map.svg"),
        ("Draw a situation of the grid `wide`", "scaloft-fi map --grid wide --output map.png"),
    ),
)
@click.argument("situation", required=False, shell_complete=names.situations)
@study_option
@grid_of_study_option
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw the map: mine, bodies, route, waypoints and happenings with their names and a scale (.svg, .png).",
)
@format_option
def map_command(
    situation: str | None, study_folder: Path | None, grid: str | None, output: Path | None, style: str
) -> None:
    """Show mine, bodies, route and happenings of one situation, without flying it.

    SITUATION is a key or another name of it; by default every axis has its benign value.
    """
    if output is not None and output.suffix.lower() not in PICTURES:
        raise InputError(f"--output={str(output)!r} must end in .svg or .png")
    check_writable(output)
    from scaloft_fi.study import Study
    from scaloft_fi.views.outputs.answer import Answer
    from scaloft_fi.views.pictures.picture import png
    from scaloft_fi.views.pictures.plan import draw_plan
    from scaloft_fi.views.pictures.situation_plan import MAP, map_table, map_values, plan_of

    study = Study.open(study_folder, grid)
    one = study.grid.situation(situation) if situation else study.grid.situations[0]
    answer(Answer(MAP, lambda: map_values(study, one), lambda: (map_table(study, one),)), style)
    if output is not None:
        drawn = draw_plan(plan_of(study, one), title=one.key, subtitle=", ".join(study.grid.titles(one)))
        write(output, png(drawn) if output.suffix.lower() == ".png" else drawn.encode())
        say(f"map: {output}")
