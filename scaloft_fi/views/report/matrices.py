"""The two matrices of the page: the HAZOP study's cells, and mutants x situations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scaloft_fi.analysis.kill_matrix import Entry, KillMatrix, gray_order
from scaloft_fi.analysis.pool import Pool
from scaloft_fi.analysis.roster import Ratio, Roster, plain
from scaloft_fi.analysis.score import Kill, MutantScore, Result, Score
from scaloft_fi.campaign.seeking.finds import words_of
from scaloft_fi.hazop.matrix import Matrix, class_of
from scaloft_fi.hazop.name import cell_of
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Ruled, Rulings, Situations
from scaloft_fi.views.report.certainty import certainty
from scaloft_fi.views.report.karnaugh import terms
from scaloft_fi.views.report.ladder import searched
from scaloft_fi.views.report.signs import Sign, opening, seen_in, shown_by, sign_of

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid

EVERY_VALUE_BENIGN = "every value benign"
SIGNS = [sign.value for sign in Sign]
KEPT = (
    *("id", "guideword", "parameter", "magnitude", "severity", "status", "verdict", "firm"),
    *("kill_rate", "kill_rate_flown", "decided_at"),
)
"""What the page takes over from the score's JSON on a mutant."""


def situations(space: Space, grid: Grid) -> list[dict[str, Any]]:
    """Every situation in Gray-code order: each differs from the one before in one axis by one step.

    `words` has the value of each axis, `name` those that are not benign.
    """
    return [
        {
            "key": key,
            "levels": [space.values[axis].index(value) for axis, value in enumerate(space.point[key])],
            "words": list(space.words_of(key)),
            "name": ", ".join(words_of(grid.situation(key), grid)) or EVERY_VALUE_BENIGN,
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
            "severity": class_of(matrix.severities.get(cell.name)),
            "requirements": list(cell.requirements),
            "reason": cell.reason,
            "predicted": cell.predicted,
            "expected": [fault.expected.reason for fault in cell.faults if fault.expected],
            "default": cell.default_id if cell.faults else "",
            "mutants": by_cell.get(cell.name, []),
        }
        for cell in matrix
    ]


def mutants(
    scored: Score,
    matrix: KillMatrix,
    rulings: Rulings,
    records: Iterable[Mapping[str, Any]],
    roster: Roster,
    keys: Sequence[str],
    order: Callable[[str], Any],
) -> list[dict[str, Any]]:
    """Every mutant and control flown.

    Args:
        scored: of the campaign.
        matrix: its kill matrix.
        rulings: of its flights.
        records: the mutants and controls of the score's JSON.
        roster: says which mutants count.
        keys: of the situations, in the order of `results`.
        order: of ids.
    """
    known = {entry["id"]: entry for entry in records}
    extra = searched(scored.mutants, roster)
    described = []
    for mutant in sorted((*scored.mutants, *scored.controls), key=lambda one: order(one.subject.id)):
        id_, flights = mutant.subject.id, rulings.mutants[mutant.subject]
        row = matrix.row[id_]
        entries = {entry.situation: entry for entry in row.entries}
        results = {result.situation: result for result in mutant.results}
        described.append(
            {name: known[id_][name] for name in KEPT}
            | _mutant(mutant, flights, roster, matrix.space)
            | {
                "certainty": certainty(mutant, scored.alpha),
                "kills": [_kill(kill, flights[kill.situation], scored.pool) for kill in _kills(mutant)],
                "searched": id_ in extra,
                "tests": _tests(mutant, scored.pool),
                "results": [_result(entries[key], results.get(key), flights, scored.pool) for key in keys],
                "terms": terms(matrix.space, row),
            }
        )
    return described


def _mutant(scored: MutantScore, flights: Situations, roster: Roster, space: Space) -> dict[str, Any]:
    first = scored.first
    return {
        "cell": cell_of(scored.subject.id),
        "control": roster.is_control(scored.subject),
        "counts": roster.counts(scored.subject),
        "by": [*scored.safety.by, *scored.operability.by],
        "shows": list(shown_by(scored, flights)) if roster.is_control(scored.subject) else [],
        "condition": scored.condition(space),
        "first": {"requirement": first.requirement, "t_s": first.t_s, "situation": first.situation, "seed": first.seed}
        if first
        else None,
    }


def _kills(scored: MutantScore) -> Iterable[Kill]:
    """By safety requirements, of which the most violated come first, then by operability."""
    for kills in (scored.kills, scored.operability_kills):
        yield from sorted(kills, key=lambda kill: -kill.violated / kill.flights)


def _kill(kill: Kill, flights: Sequence[Ruled], pool: Pool) -> dict[str, Any]:
    """A kill with the flight to open, which has it: its seed, when it violates the requirement, what it strikes."""
    seed = opening(flights, (kill.requirement,))
    (violation,) = (
        v for one in flights if one.seed == seed for v in one.violations if v.requirement == kill.requirement
    )
    beside = pool.pairs[kill.situation, kill.requirement]
    return {
        "situation": kill.situation,
        "requirement": kill.requirement,
        "flights": plain(Ratio(kill.violated, kill.flights)),
        "baseline": plain(Ratio(beside.violated, beside.judged)),
        "seed": seed,
        "t_s": violation.t_s,
        "struck": violation.struck,
    }


def _tests(scored: MutantScore, pool: Pool) -> list[dict[str, Any]]:
    """Per requirement that puts the mutant to the test somewhere its p, and what was seen there.

    Returns:
        `kills`: situations with a kill, of those that test it; `flights`: of the mutant that violate, in these;
        `baseline`: of the pool that violate, of those judged, in these.
    """
    records, p = [], {**scored.safety.p, **scored.operability.p}
    for name in (*pool.requirements(Kind.SAFETY), *pool.requirements(Kind.OPERABILITY)):
        tests = [result for result in scored.results if name in (*result.steady, *result.steady_operability)]
        if not tests:
            continue
        kills = sum(name in (*result.kills, *result.operability_kills) for result in tests)
        pairs = [pool.pairs[result.situation, name] for result in tests]
        violated = sum(dict(result.violated).get(name, 0) for result in tests)
        records.append(
            {
                "requirement": name,
                "p": p[name],
                "kills": plain(Ratio(kills, len(tests))),
                "flights": plain(Ratio(violated, sum(result.flown for result in tests))),
                "baseline": plain(Ratio(sum(own.violated for own in pairs), sum(own.judged for own in pairs))),
            }
        )
    return records


def _result(entry: Entry, result: Result | None, flights: Situations, pool: Pool) -> list[Any] | None:
    """Sign by its place in `SIGNS`, flights that count, seed to open, flights that violate each, by which it is a sign.

    Null where nothing was flown.
    """
    if entry.situation not in flights:
        return None
    violated = {name: count for name, count in entry.violated if (entry.situation, name) in pool.pairs}
    operability = result.operability_kills if result else ()
    seen = seen_in(entry, pool)
    seed = opening(flights[entry.situation], (*entry.kills, *operability, *seen, *violated))
    return [SIGNS.index(sign_of(entry, seen)), entry.flown, seed, violated, list(entry.kills or seen)]


def by_situation(scored: Score, roster: Roster, keys: Sequence[str]) -> list[dict[str, int]]:
    """Per situation the default mutants with a kill, of those that it puts to the test, and of those flown."""
    counted = [mutant for mutant in scored.mutants if roster.counts(mutant.subject)]
    entries = []
    for key in keys:
        results = [result for mutant in counted for result in mutant.results if result.situation == key]
        entries.append(
            {
                "killed": sum(bool(result.kills) for result in results),
                "tested": sum(result.tested for result in results),
                "flown": len(results),
            }
        )
    return entries
