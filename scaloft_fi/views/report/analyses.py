"""What follows from the flights, for the page: ladders, margins, what kills what, survivors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import KillMatrix
from scaloft_fi.analysis.margin import whens
from scaloft_fi.analysis.roster import Roster, plain
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.suite import interactions, minimal_suite, orders, subsumption
from scaloft_fi.analysis.survivor import backgrounds
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.hazop.name import cell_of
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.views.kills.survivors import short_units, survivors
from scaloft_fi.views.report.evidence import Evidence
from scaloft_fi.views.report.ladder import by_ladder, searched
from scaloft_fi.views.report.thresholds import thresholds
from scaloft_fi.views.worksheet.margins import cell_margins


def analyses(evidence: Evidence, scored: Score, matrix: KillMatrix) -> dict[str, Any]:
    """By section of the page; of the default mutants only, where ladders would count one fault several times.

    Args:
        evidence: what the page is made from.
        scored: the score of its flights.
        matrix: their kill matrix.
    """
    study, outcomes, roster = evidence.study, evidence.outcomes, evidence.study.roster
    counted = {row.id for row in matrix.mutants if row.counted}
    kills = {id_: keys for id_, keys in matrix.kills.items() if id_ in counted}
    listed = interactions(matrix)
    units, campaign = short_units(study.requirements), evidence.campaign
    known = backgrounds(study.matrix, [row.id for row in matrix.mutants])
    return {
        "margins": margin_texts(outcomes, scored, study.matrix),
        "ladders": ladders(scored, study.matrix, roster),
        "thresholds": thresholds(outcomes, scored, study.matrix, study.requirements),
        "whens": plain(whens(outcomes, scored)),
        "interactions": plain(listed),
        "orders": plain(orders(listed, matrix.space)),
        "suite": plain(minimal_suite(kills, [key for key, _ in matrix.space.situations])),
        "subsumption": plain(subsumption(kills)),
        "survivors": plain(survivors(outcomes, scored, matrix, known, units, campaign, study.finds)),
    }


def margin_texts(outcomes: Sequence[Outcome], scored: Score, cells: Matrix) -> dict[str, str]:
    """The margin of each cell that has one; faults without an order have a verdict and no margin."""
    verdicts = tuple(verdict.words for verdict in Verdict)
    margins = {
        cell: [part for part in text.split("; ") if any(map(str.isdigit, part)) and not part.endswith(verdicts)]
        for cell, text in cell_margins(outcomes, scored, cells).items()
    }
    return {cell: "; ".join(parts) for cell, parts in margins.items() if parts}


def ladders(scored: Score, cells: Matrix, roster: Roster) -> list[dict[str, Any]]:
    """Per cell flown with more than one magnitude its rungs from mild to strong; shifted phases are left out.

    A magnitude that a search flew is left out: its share would be one of situations chosen by their kills.
    """
    by_cell: dict[str, list[MutantScore]] = {}
    order, left_out = by_ladder(cells, roster), searched(scored.mutants, roster)
    for mutant in scored.mutants:
        if mutant.subject.magnitude and "#" not in mutant.subject.id and mutant.subject.id not in left_out:
            by_cell.setdefault(cell_of(mutant.subject.id), []).append(mutant)
    return [
        {
            "cell": cell.name,
            "rungs": [
                {
                    "id": rung.subject.id,
                    "magnitude": rung.subject.magnitude,
                    "default": roster.counts(rung.subject),
                    "verdict": rung.verdict.value,
                    "kill_rate": plain(rung.kill_rate),
                }
                for rung in sorted(by_cell[cell.name], key=lambda one: order(one.subject.id))
            ],
        }
        for cell in cells
        if len(by_cell.get(cell.name, [])) > 1
    ]
