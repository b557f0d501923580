"""What `kills` answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import KillMatrix, kill_matrix
from scaloft_fi.analysis.suite import (
    Subsumption,
    chosen_kills,
    interactions,
    kills_by_requirement,
    minimal_suite,
    orders,
    redundancies,
    situation_kills,
    subsumption,
)
from scaloft_fi.analysis.survivor import backgrounds
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.mutants.catalogue import select
from scaloft_fi.study import Study
from scaloft_fi.views.kills import kill_tables as tables
from scaloft_fi.views.kills.kill_record import KILLS, kill_values
from scaloft_fi.views.kills.survivors import Survivor, short_units, survivors
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.snapshot import Snapshot, snapshot
from scaloft_fi.views.tables.table import Table

PARTS = {
    "conditions": "conditions",
    "situations": "situations",
    "suite": "summary",
    "subsumption": "subsumption_nodes",
    "survivors": "survivors",
}
"""The parts that can be asked for, and the table of each that `csv` prints where it alone is asked for."""


def kills(
    study: Study,
    campaign: str,
    mutants: Sequence[str] = (),
    *,
    show: Sequence[str] = (),
    situations: Sequence[str] = (),
    by_requirement: bool = False,
) -> Answer:
    """Where mutants are killed, which situations are needed, and what would change the rest.

    Args:
        study: the study, with any of its grids.
        campaign: name of the campaign.
        mutants: names, ids or patterns; by default every mutant flown but the controls.
        show: those of `PARTS` that are asked for, told at length; by default all, told shortly.
        situations: keys, aliases or patterns; what they kill together is told too.
        by_requirement: whether subsumption tells kills by different requirements of a situation apart.

    Raises:
        InputError: there is no such campaign, mutant, situation or part, or the campaign holds no such flight.
    """
    for part in show:
        if part not in PARTS:
            raise InputError(f"--show={part!r} must be one of {', '.join(PARTS)}{did_you_mean(part, PARTS)}")
    wanted = show or tuple(PARTS)
    with snapshot(study, campaign) as now:
        study = now.study
        matrix, stale = _chosen(now, mutants), now.stale
        cases = _survivors(now, matrix) if "survivors" in wanted else ()
    chosen = [situation.key for situation in study.grid.select(situations)] if situations else []
    results = _results(matrix, _graph(matrix, by_requirement), cases, wanted, chosen)
    return Answer(
        KILLS,
        lambda: kill_values(matrix, results) | stale.values,
        lambda: _tables(results, matrix, short=not show),
        rows=PARTS[show[0]] if len(show) == 1 else "",
        warnings=(*stale.sentences, *(study.finds.warnings if "survivors" in wanted else ())),
    )


def subsumption_graph(
    study: Study, campaign: str, mutants: Sequence[str] = (), *, by_requirement: bool = False
) -> Subsumption:
    """Which kills imply which; the arguments are those of `kills`.

    Raises:
        InputError: there is no such campaign or mutant, or the campaign holds no such flight.
    """
    with snapshot(study, campaign) as now:
        return _graph(_chosen(now, mutants), by_requirement)


def _chosen(now: Snapshot, patterns: Sequence[str]) -> KillMatrix:
    """The rows that `patterns` mean.

    Raises:
        InputError: a pattern means nothing, or nothing that the campaign holds.
    """
    study = now.study
    matrix = kill_matrix(now.score, study.roster, study.space)
    if not patterns:
        return matrix
    asked = [mutant.id for mutant in select(patterns, study.matrix, study.catalogue)]
    flown = [id_ for id_ in asked if id_ in matrix.row]
    if not flown:
        raise InputError(f"the campaign holds no flight of {', '.join(asked[:3])}{', ...' if len(asked) > 3 else ''}")
    return matrix.only(flown)


def _graph(matrix: KillMatrix, by_requirement: bool) -> Subsumption:
    return subsumption(kills_by_requirement(matrix) if by_requirement else matrix.kills)


def _survivors(now: Snapshot, matrix: KillMatrix) -> tuple[Survivor, ...]:
    """The survivors among `matrix`, judged beside all that the campaign holds."""
    ids = {row.id for row in matrix.mutants if row.verdict is not Verdict.DETECTED}
    seeds = sorted({outcome.seed for outcome in now.outcomes if outcome.mutant in ids})
    tracked = now.with_tracks(now.outcomes, [BASELINE, *ids], seeds[:1])
    known = backgrounds(now.study.matrix, [mutant.subject.id for mutant in now.score.mutants])
    units = short_units(now.study.requirements)
    return survivors(tracked, now.score, matrix, known, units, now.name, now.study.finds)


def _results(
    matrix: KillMatrix, graph: Subsumption, cases: Sequence[Survivor], wanted: Sequence[str], chosen: Sequence[str]
) -> dict[str, Any]:
    """What is asked for, by name."""
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
    told = shown[:-1] if "survivors" in results else shown
    return [*tables.with_detected(told, matrix), *shown[len(told) :]]
