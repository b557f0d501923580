"""`scaloft-fi kills`: what kills what, and what to do about the rest."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.files import check_writable, write
from scaloft_fi.cli.finds import told
from scaloft_fi.cli.options import campaign_option, format_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import tell_line
from scaloft_fi.errors import InputError

if TYPE_CHECKING:
    from scaloft_fi.analysis.kills.kill_matrix import KillMatrix
    from scaloft_fi.analysis.kills.subsumption import Subsumption
    from scaloft_fi.study import Study
    from scaloft_fi.views.kills.survivors import Survivor
    from scaloft_fi.views.snapshot import Snapshot
    from scaloft_fi.views.tables.table import Table

PARTS = {
    "conditions": "conditions",
    "situations": "situations",
    "suite": "summary",
    "subsumption": "subsumption_nodes",
    "survivors": "survivors",
}
"""The table of each part in CSV."""
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
    type=click.Choice(tuple(PARTS)),
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
    from scaloft_fi.analysis.kills.kill_matrix import kill_matrix
    from scaloft_fi.study import Study
    from scaloft_fi.views.kills.kill_record import KILLS, kill_values
    from scaloft_fi.views.snapshot import snapshot
    from scaloft_fi.views.tables.table import render

    study = Study.open(study_folder)
    wanted = parts or tuple(PARTS)
    with snapshot(study, campaign) as now:
        study = now.study
        matrix = _chosen(study, kill_matrix(now.score, study.roster, study.space), mutants)
        cases = _survivors(now, matrix, campaign) if "survivors" in wanted and output is None else ()
    if output is not None:
        _draw(_graph(matrix, by_requirement), output)
        return
    chosen = [situation.key for situation in study.grid.select(situations)] if situations else []
    results = _results(matrix, _graph(matrix, by_requirement), cases, wanted, chosen)
    answer(
        KILLS,
        lambda: kill_values(matrix, results),
        style,
        lambda how: render(_tables(results, matrix, short=not parts), how),
        tables_folder,
        rows=PARTS[parts[0]] if len(parts) == 1 else "",
    )


def _chosen(study: Study, matrix: KillMatrix, patterns: Sequence[str]) -> KillMatrix:
    """The rows that `patterns` mean.

    Raises:
        InputError: a pattern means nothing, or nothing that the campaign holds.
    """
    if not patterns:
        return matrix
    from scaloft_fi.mutants.select import select

    asked = [mutant.id for mutant in select(patterns, study.matrix, study.catalogue)]
    flown = [id_ for id_ in asked if id_ in matrix.row]
    if not flown:
        raise InputError(f"the campaign holds no flight of {', '.join(asked[:3])}{', ...' if len(asked) > 3 else ''}")
    return matrix.only(flown)


def _graph(matrix: KillMatrix, by_requirement: bool) -> Subsumption:
    from scaloft_fi.analysis.kills.subsumption import kills_by_requirement, subsumption

    return subsumption(kills_by_requirement(matrix) if by_requirement else matrix.kills)


def _survivors(now: Snapshot, matrix: KillMatrix, campaign: str) -> tuple[Survivor, ...]:
    """The survivors among `matrix`, judged beside all that the campaign holds."""
    from scaloft_fi.analysis.kills.background import backgrounds
    from scaloft_fi.analysis.scoring.detection import Verdict
    from scaloft_fi.judge.outcome import BASELINE
    from scaloft_fi.views.kills.survivors import short_units, survivors

    ids = {row.id for row in matrix.mutants if row.verdict is not Verdict.DETECTED}
    seeds = sorted({outcome.seed for outcome in now.outcomes if outcome.mutant in ids})
    tracked = now.with_tracks(now.outcomes, [BASELINE, *ids], seeds[:1])
    known = backgrounds(now.study.matrix, [mutant.subject.id for mutant in now.score.mutants])
    units, finds = short_units(now.study.requirements), told(now.study.finds)
    return survivors(tracked, now.score, matrix, known, units, campaign, finds)


def _results(
    matrix: KillMatrix, graph: Subsumption, cases: Sequence[Survivor], wanted: Sequence[str], chosen: Sequence[str]
) -> dict[str, Any]:
    """What is asked for, by name."""
    from scaloft_fi.analysis.kills.interaction import interactions, orders
    from scaloft_fi.analysis.kills.minimal_suite import minimal_suite
    from scaloft_fi.analysis.kills.situation_kills import chosen_kills, situation_kills
    from scaloft_fi.analysis.kills.subsumption import redundancies

    results: dict[str, Any] = {}
    if chosen:
        results["chosen"] = chosen_kills(matrix, chosen)
    if "conditions" in wanted:
        results["conditions"] = interactions(matrix)
        results["orders"] = orders(results["conditions"], matrix.space)
    if "situations" in wanted:
        results["situations"] = situation_kills(matrix)
    if "suite" in wanted:
        results["suite"] = minimal_suite(matrix.kills, matrix.flown)
    if "subsumption" in wanted:
        results["subsumption"] = graph
        results["redundancies"] = redundancies(graph)
    if "survivors" in wanted:
        results["survivors"] = cases
    return results


def _tables(results: Mapping[str, Any], matrix: KillMatrix, *, short: bool) -> list[Table]:
    """A table for each result, but none for redundancies where there are none."""
    from scaloft_fi.views.kills import kill_tables as tables

    made: dict[str, Callable[[Any], Table]] = {
        "chosen": tables.chosen_table,
        "conditions": tables.interaction_table,
        "orders": tables.order_table,
        "situations": lambda listed: tables.situation_table(listed, matrix.space, short=short),
        "suite": lambda suite: tables.suite_table(suite, matrix),
        "subsumption": lambda graph: tables.subsumption_table(graph, short=short),
        "redundancies": tables.redundancy_table,
        "survivors": tables.survivor_summary if short else tables.survivor_table,
    }
    shown = [made[name](result) for name, result in results.items() if result or name != "redundancies"]
    kills = shown[:-1] if "survivors" in results else shown
    return [*tables.with_scattered(kills, matrix), *shown[len(kills) :]]


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
