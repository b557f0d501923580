"""Situation coverage: how much of the grid was flown.  Never one percentage: each has a blind spot of its own."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scaloft_fi.analysis.plain import plain
from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.analysis.scoring.pool import Pool, State
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Compliance, Kind
from scaloft_fi.judge.space import Point, Space
from scaloft_fi.judge.status import apart

if TYPE_CHECKING:
    from scaloft_fi.analysis.situations.t_way import TWay

STRENGTHS = (1, 2, 3, 4, 5)
SHARES = (0.5, 0.75, 1.0)
"""The p of (p, t)-completeness."""


@dataclass(frozen=True)
class Coverage:
    """Coverage of the situation space.  A number drawn from a range covers its bin: bins count, not drawn numbers.

    Attributes:
        situations: distinct situations flown, of the grid.
        draws: test cases flown, a situation with a seed each.
        pool: those of them in which the baseline alone was flown, to decide by.
        combinations: per strength t, the combinations of values of t axes that were flown, of all that situations have.
        realised: situations whose every value came true together in a baseline flight, of the grid.
        states: how many safety pairs (situation flown x safety requirement) the baseline pool finds in each state; a
            situation with drawn numbers has pairs of its own.
        by_axis: per axis, the situations whose value there came true in a baseline flight, of those with one.
        requirements: per requirement, the situations where it was triggered in a baseline flight, of those with one: in
            the others it was vacuous or left open, and nothing was tested by it.
    """

    situations: Ratio
    draws: int
    pool: int
    combinations: tuple[TWay, ...]
    realised: Ratio
    states: Mapping[State, int]
    by_axis: tuple[tuple[str, Ratio], ...]
    requirements: tuple[tuple[str, Ratio], ...]

    @property
    def t_way(self) -> tuple[tuple[int, Ratio], ...]:
        """Per strength t, the combinations flown, of all."""
        return tuple((one.strength, one.total) for one in self.combinations)

    @property
    def steady(self) -> Ratio:
        """Safety pairs that put a fault to the test, of those in situations with a pool."""
        return Ratio(self.states[State.STEADY], sum(self.states.values()) - self.states[State.UNKNOWN])


def coverage(outcomes: Iterable[Outcome], space: Space) -> Coverage:
    """Coverage by the flights that count; a flight outside the grid or an invalid one covers nothing."""
    clean, flown = apart(outcomes)
    return coverage_of(clean, {(outcome.situation, outcome.seed) for outcome in flown if not outcome.invalid}, space)


def coverage_of(clean: Iterable[Outcome], draws: Collection[tuple[str, int]], space: Space) -> Coverage:
    """The same of the baselines `clean` and of the `draws` in which mutants were flown."""
    from scaloft_fi.analysis.situations.t_way import t_ways

    valid = [outcome for outcome in clean if not outcome.invalid]
    keys = {outcome.situation for outcome in valid} | {situation for situation, _ in draws}
    point = {key: place for key in keys if (place := space.point.get(key))}
    baselines = list(
        {(outcome.situation, outcome.seed): outcome for outcome in valid if outcome.situation in point}.values()
    )
    beside = {draw for draw in draws if draw[0] in point}
    alone = {(outcome.situation, outcome.seed) for outcome in baselines} - beside
    judged = {point[outcome.situation] for outcome in baselines}
    flown = set(point.values())
    came_true = {(point[outcome.situation], axis) for outcome in baselines for axis, true in outcome.realised if true}
    whole = {
        point[outcome.situation]
        for outcome in baselines
        if outcome.realised and all(true for _, true in outcome.realised)
    }
    return Coverage(
        situations=Ratio(len(flown), len(space.points)),
        draws=len(beside) + len(alone),
        pool=len(alone),
        combinations=t_ways(point, space, STRENGTHS),
        realised=Ratio(len(whole), len(space.points)),
        states=_states(Pool.of(baselines), point),
        by_axis=tuple(
            (axis, Ratio(sum((place, axis) in came_true for place in judged), len(judged))) for axis in space.axes
        ),
        requirements=_requirements(baselines, point, len(judged)),
    )


def _states(pool: Pool, flown: Iterable[str]) -> dict[State, int]:
    names = pool.requirements(Kind.SAFETY)
    pairs = Counter(pool.states.get((key, name), State.UNKNOWN) for key in flown for name in names)
    return {state: pairs[state] for state in State}


def _requirements(
    baselines: Iterable[Outcome], point: Mapping[str, Point], judged: int
) -> tuple[tuple[str, Ratio], ...]:
    triggered: dict[str, set[Point]] = {}
    for outcome in baselines:
        for reading in outcome.readings:
            points = triggered.setdefault(reading.requirement, set())
            if reading.compliance in (Compliance.HELD, Compliance.VIOLATED):
                points.add(point[outcome.situation])
    return tuple((name, Ratio(len(points), judged)) for name, points in triggered.items())


def coverage_json(covered: Coverage) -> dict[str, Any]:
    """Every number of the coverage as plain JSON values; `t_way` per strength, with its (p, t)-completeness."""
    return {
        "situations": plain(covered.situations),
        "draws": covered.draws,
        "pool": covered.pool,
        "t_way": {
            str(one.strength): {
                **plain(one.total),
                "complete": {f"{share:g}": plain(one.complete(share)) for share in SHARES},
            }
            for one in covered.combinations
        },
        "realised": plain(covered.realised),
        "realised_by_axis": plain(dict(covered.by_axis)),
        "steady": plain(covered.steady),
        "states": plain(covered.states),
        "requirements": plain(dict(covered.requirements)),
    }
