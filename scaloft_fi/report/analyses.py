"""What follows from the kill matrix, for the page: ladders, interaction orders, the smallest suite, subsumption."""

from __future__ import annotations

from typing import Any

from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.results.interaction import interactions, orders
from scaloft_fi.results.kill_matrix import KillMatrix
from scaloft_fi.results.minimal_suite import minimal_suite
from scaloft_fi.results.ratio import ratio_json
from scaloft_fi.results.roster import Roster, cell_of
from scaloft_fi.results.score import MutantScore, Score
from scaloft_fi.results.subsumption import subsumption


def analyses(scored: Score, matrix: KillMatrix, cells: Matrix, roster: Roster) -> dict[str, Any]:
    """By section of the page; of the default mutants only, where ladders would count one fault several times."""
    counted = {row.id for row in matrix.mutants if row.counted}
    kills = {id_: keys for id_, keys in matrix.kills.items() if id_ in counted}
    found = interactions(matrix)
    return {
        "ladders": ladders(scored, cells, roster),
        "interactions": [entry.to_json() for entry in found],
        "orders": orders(found, matrix.space).to_json(),
        "suite": minimal_suite(kills, [key for key, _ in matrix.space.points]).to_json(),
        "subsumption": subsumption(kills).to_json(),
    }


def ladders(scored: Score, cells: Matrix, roster: Roster) -> list[dict[str, Any]]:
    """Per cell flown with more than one magnitude its rungs in the catalogue's order; shifted phases are left out."""
    by_cell: dict[str, list[MutantScore]] = {}
    for mutant in scored.mutants:
        if mutant.subject.magnitude and "#" not in mutant.subject.id:
            by_cell.setdefault(cell_of(mutant.subject.id), []).append(mutant)
    return [
        {
            "cell": cell.name,
            "rungs": [
                {
                    "id": rung.subject.id,
                    "magnitude": rung.subject.magnitude,
                    "default": roster.counts(rung.subject),
                    "kill_rate": ratio_json(rung.kill_rate),
                }
                for rung in sorted(by_cell[cell.name], key=lambda one: roster.rank(one.subject.id))
            ],
        }
        for cell in cells
        if len(by_cell.get(cell.name, [])) > 1
    ]
