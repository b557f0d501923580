"""The two matrices of the page: the HAZOP study's cells, and mutants x situations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.report.karnaugh import terms
from scaloft_fi.report.severity import searched
from scaloft_fi.results.kills.gray import gray_order
from scaloft_fi.results.kills.kill_matrix import Entry, KillMatrix
from scaloft_fi.results.roster import Roster, cell_of
from scaloft_fi.results.scoring.decision import Decision
from scaloft_fi.results.scoring.ratio import ratio_json
from scaloft_fi.results.scoring.score import MutantScore, Score
from scaloft_fi.results.space import Space
from scaloft_fi.results.status import Status

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid

STATUSES = [status.value for status in Status]
DECISIONS = [decision.value for decision in Decision]


def situations(space: Space, grid: Grid) -> list[dict[str, Any]]:
    """Every situation in Gray-code order: each differs from the one before in one axis by one step."""
    return [
        {
            "key": key,
            "levels": [space.values[axis].index(value) for axis, value in enumerate(space.point[key])],
            "words": [space.word(axis, value) for axis, value in enumerate(space.point[key])],
            "aliases": list(grid.aliases_of(grid.situation(key))),
        }
        for key in gray_order(space)
    ]


def axes(grid: Grid) -> list[dict[str, Any]]:
    """The axes with the words for their values, the benign one first."""
    return [
        {"id": axis.id, "title": axis.title, "category": axis.category, "words": [value.title for value in axis.values]}
        for axis in grid.axes
    ]


def cells(matrix: Matrix, flown: Iterable[str]) -> list[dict[str, Any]]:
    """Every entry of the deviation matrix with its mutants that were flown, the default first named."""
    by_cell: dict[str, list[str]] = {}
    for mutant in flown:
        by_cell.setdefault(cell_of(mutant), []).append(mutant)
    return [
        {
            "name": cell.name,
            "guideword": cell.guideword,
            "parameter": cell.parameter,
            "status": cell.status.value,
            "deviation": cell.deviation,
            "causes": list(cell.causes),
            "effect": cell.effect,
            "requirements": list(cell.requirements),
            "reason": cell.reason,
            "predicted": cell.predicted,
            "expected": [fault.expected.reason for fault in cell.faults if fault.expected],
            "default": f"{cell.name}@{cell.default_magnitude}".removesuffix("@") if cell.faults else "",
            "mutants": by_cell.get(cell.name, []),
        }
        for cell in matrix
    ]


def mutants(
    scored: Score, matrix: KillMatrix, roster: Roster, keys: Sequence[str], order: Callable[[str], Any]
) -> list[dict[str, Any]]:
    """Every mutant and control flown, by `order` of ids; `results` has an entry for each of `keys`, null: not flown."""
    everyone = {one.subject.id: one for one in (*scored.mutants, *scored.controls)}
    found, extra = [], searched(scored.mutants, roster)
    for id_ in sorted(everyone, key=order):
        row = matrix.row[id_]
        entries = {entry.situation: entry for entry in row.entries}
        drawn = {"results": [_result(entries[key]) for key in keys], "terms": terms(matrix.space, row)}
        found.append(_mutant(everyone[id_], roster, matrix.space) | drawn | {"searched": id_ in extra})
    return found


def _mutant(scored: MutantScore, roster: Roster, space: Space) -> dict[str, Any]:
    subject = scored.subject
    first = scored.earliest
    return {
        "id": subject.id,
        "cell": cell_of(subject.id),
        "guideword": subject.guideword,
        "parameter": subject.parameter,
        "magnitude": subject.magnitude,
        "control": roster.is_control(subject),
        "counts": roster.counts(subject),
        "status": scored.status.value,
        "kill_rate": ratio_json(scored.kill_rate),
        "kill_rate_flown": ratio_json(scored.kill_rate_flown),
        "operability": ratio_json(scored.operability),
        "requirements": {name: ratio_json(ratio) for name, ratio in scored.requirements},
        "condition": scored.condition(space),
        "earliest": {"requirement": first.requirement, "t_s": first.t_s, "flight": f"{first.situation}/{first.seed}"}
        if first
        else None,
        "decisions": {decision.value: len(scored.decisions(decision)) for decision in Decision},
        "rungs": {status.value: count for status, count in scored.rungs},
    }


def _result(entry: Entry) -> list[int] | None:
    """Status, kills, eligible, flown, decision; the words by their place in a list."""
    if entry.state not in STATUSES:
        return None
    decision = DECISIONS.index(entry.decision) if entry.decision else -1
    return [STATUSES.index(entry.state), entry.kills, entry.eligible, entry.flown, decision]


def by_situation(scored: Score, roster: Roster, keys: Sequence[str]) -> list[dict[str, int]]:
    """Per situation the default mutants killed, of those eligible there, and of those flown."""
    counted = [mutant for mutant in scored.mutants if roster.counts(mutant.subject)]
    found = []
    for key in keys:
        results = [result for mutant in counted for result in mutant.results if result.situation == key]
        found.append(
            {
                "killed": sum(result.kills > 0 for result in results),
                "eligible": sum(result.eligible > 0 for result in results),
                "flown": sum(result.flown > 0 for result in results),
            }
        )
    return found
