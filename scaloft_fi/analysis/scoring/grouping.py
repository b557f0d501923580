"""The score again, part by part: by guideword, parameter, severity, requirement, situation or axis value."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.analysis.scoring.mutant_score import MutantScore, Result
from scaloft_fi.analysis.scoring.score import Score
from scaloft_fi.hazop.matrix import UNCLASSED, class_of, worst_first
from scaloft_fi.judge.space import Space


class By(StrEnum):
    """What to group by."""

    GUIDEWORD = "guideword"
    PARAMETER = "parameter"
    SEVERITY = "severity"
    SITUATION = "situation"
    REQUIREMENT = "requirement"
    AXIS = "axis"


@dataclass(frozen=True)
class Group:
    """One part of the score.

    Attributes:
        by: what the parts are.
        name: of the part.
        tested: detected mutants of those put to the test; of a situation, a requirement or an axis value those with a
            kill there of those that it tests, and of an axis value mutants in situations.
        flown: the same detected, of those flown.
        axis, value: ids of an axis and of its value; None where the parts are none.
    """

    by: By
    name: str
    tested: Ratio
    flown: Ratio
    axis: str | None = None
    value: str | None = None


def groups(scored: Score, by: By, space: Space) -> tuple[Group, ...]:
    """Group the default mutants of credible cells."""
    mutants = scored.counted
    if by is By.GUIDEWORD:
        return _of_mutants(by, mutants, lambda mutant: mutant.subject.guideword)
    if by is By.PARAMETER:
        return _of_mutants(by, mutants, lambda mutant: mutant.subject.parameter)
    if by is By.SEVERITY:
        ordered = worst_first(mutants, lambda mutant: mutant.severity)
        return _of_mutants(by, ordered, lambda mutant: class_of(mutant.severity) or UNCLASSED)
    if by is By.REQUIREMENT:
        return _of_requirements(mutants)
    results = [result for mutant in mutants for result in mutant.results]
    if by is By.SITUATION:
        keys = sorted({result.situation for result in results}, key=space.rank)
        return tuple(_of_results(by, key, (r for r in results if r.situation == key)) for key in keys)
    return tuple(
        replace(
            _of_results(
                by, f"{axis} = {space.word(number, value)}", (r for r in results if _at(space, r, number) == value)
            ),
            axis=axis,
            value=value,
        )
        for number, axis in enumerate(space.axes)
        for value in space.values[number]
    )


def _at(space: Space, result: Result, axis: int) -> str:
    point = space.point.get(result.situation)
    return point[axis] if point else ""


def _of_mutants(by: By, mutants: Iterable[MutantScore], name: Callable[[MutantScore], str]) -> tuple[Group, ...]:
    parts: dict[str, list[MutantScore]] = {}
    for mutant in mutants:
        parts.setdefault(name(mutant), []).append(mutant)
    return tuple(_of_part(by, part, members) for part, members in parts.items())


def _of_part(by: By, name: str, members: list[MutantScore]) -> Group:
    detected = sum(mutant.detected for mutant in members)
    return Group(by, name, Ratio(detected, sum(mutant.tested for mutant in members)), Ratio(detected, len(members)))


def _of_results(by: By, name: str, results: Iterable[Result]) -> Group:
    listed = list(results)
    killed = sum(bool(result.kills) for result in listed)
    return Group(by, name, Ratio(killed, sum(result.tested for result in listed)), Ratio(killed, len(listed)))


def _of_requirements(mutants: Sequence[MutantScore]) -> tuple[Group, ...]:
    names = dict.fromkeys(name for mutant in mutants for name in mutant.tests)
    parts = []
    for name in names:
        able = [mutant for mutant in mutants if name in mutant.tests]
        detected = sum(name in (*mutant.safety.by, *mutant.operability.by) for mutant in able)
        parts.append(Group(By.REQUIREMENT, name, Ratio(detected, len(able)), Ratio(detected, len(mutants))))
    return tuple(parts)
