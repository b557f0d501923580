"""Situation coverage: how much of the grid was flown, t-way combinations, and situations chosen to cover.

Kuhn, Kacker, Lei, "Combinatorial Coverage Measurement", NISTIR 7878 (2012).

`covertable` builds them; it breaks ties by a hash of a salt, so one of several salts finds a smaller array than most.
On five binary axes that gives the minimum, 6, 10 and 16 situations for t = 2, 3, 4 (`tests/analysis/test_coverage.py`
proves that fewer cannot do).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from math import prod
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.analysis.detection import Pool, State
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.errors import InputError, needed
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Compliance, Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import apart
from scaloft_fi.marks import About, ByName, Called, Choices
from scaloft_fi.streams import generator

Levels = NDArray[np.int64]
"""(points, axes): the place of each value on its axis, 0 = benign."""
Ids = NDArray[np.int64]


STRENGTHS = (1, 2, 3, 4, 5)
SHARES = (0.5, 0.75, 1.0)


class Completeness(NamedTuple):
    """Choices of axes by the share of their combinations that was flown.

    Attributes:
        half: choices with 50% or more, of all.
        three_quarters: choices with 75% or more, of all.
        whole: choices with 100% or more, of all.
    """

    half: Annotated[Ratio, Called("0.5")]
    three_quarters: Annotated[Ratio, Called("0.75")]
    whole: Annotated[Ratio, Called("1")]


@dataclass(frozen=True)
class TWay:
    """Coverage of the combinations of `strength` axes.

    Attributes:
        strength: how many axes.
        axes: per choice of that many axes, the combinations covered, of those that some situation of the grid has.
    """

    strength: int
    axes: tuple[Ratio, ...]

    @property
    def total(self) -> Ratio:
        """Combinations covered, over all choices of axes."""
        return Ratio(sum(one.part for one in self.axes), sum(one.whole for one in self.axes))

    @property
    def completeness(self) -> Completeness:
        """Choices of axes by the share of their combinations that was flown."""
        return Completeness(*map(self.complete, SHARES))

    def complete(self, share: float) -> Ratio:
        """(p, t)-completeness: choices of axes with at least the share p of their combinations covered, of all."""
        return Ratio(sum(one.part >= share * one.whole for one in self.axes), len(self.axes))


def t_way(flown: Iterable[str], space: Space, strength: int) -> TWay:
    """Coverage by the situations with these keys; a combination that no situation of the grid has does not count."""
    return t_ways(flown, space, [strength])[0]


def t_ways(flown: Iterable[str], space: Space, strengths: Iterable[int]) -> tuple[TWay, ...]:
    """The same for several strengths."""
    chosen, points = levels_of(flown, space), len({point for _, point in space.points})
    whole = None if points == prod(map(len, space.values)) else levels_of((key for key, _ in space.points), space)

    def of(axes: tuple[int, ...], size: int) -> Ratio:
        possible = size if whole is None else _distinct(ids(whole, space, axes), size)
        return Ratio(_distinct(ids(chosen, space, axes), size), possible)

    return tuple(TWay(t, tuple(of(axes, size) for axes, size in choices(space, t))) for t in strengths)


def _distinct(numbers: Ids, size: int) -> int:
    """How many different numbers there are, all of them from 0 to `size` - 1."""
    seen = np.zeros(size, bool)
    seen[numbers] = True
    return int(seen.sum())


def choices(space: Space, strength: int) -> Iterator[tuple[tuple[int, ...], int]]:
    """Each choice of `strength` axes, and how many combinations their values have."""
    for axes in combinations(range(len(space.axes)), strength):
        yield axes, prod(len(space.values[axis]) for axis in axes)


def ids(levels: Levels, space: Space, axes: tuple[int, ...]) -> Ids:
    """(points,): the number of each point's combination of values on `axes`, in mixed radix."""
    number = np.zeros(len(levels), np.int64)
    for axis in axes:
        number = number * len(space.values[axis]) + levels[:, axis]
    return number


def table(levels: Levels, space: Space, strength: int) -> tuple[Ids, int]:
    """All combinations of all points: (points, choices of axes), numbered from 0 over all choices; and how many."""
    columns, first = [], 0
    for axes, size in choices(space, strength):
        columns.append(ids(levels, space, axes) + first)
        first += size
    return np.stack(columns, axis=1) if columns else np.zeros((len(levels), 0), np.int64), first


def levels_of(keys: Iterable[str], space: Space) -> Levels:
    """The points of situations, in the order of `keys`."""
    place = [{value: number for number, value in enumerate(values)} for values in space.values]
    rows = [[at[value] for at, value in zip(place, space.point[key], strict=True)] for key in keys]
    return np.array(rows, np.int64).reshape(len(rows), len(space.axes))


SALTS = 64
"""Arrays that are tried; the smallest is kept."""
WORK = 400_000
"""Combinations to be covered, in all arrays that are tried: a large grid gets fewer salts."""
MOST_TERMS = 40
"""With more forbidden combinations the library is slow: the array is then built from the situations, greedily."""
Forbidden = tuple[tuple[int, ...], tuple[int, ...]]
"""Axes, and the places of the values there that no situation has together."""


def covering_array(space: Space, keys: Sequence[str], strength: int, seed: int) -> tuple[str, ...]:
    """Situations out of `keys` that have every combination of `strength` axes that any of `keys` has.

    Args:
        space: the grid.
        keys: the situations to choose from.
        strength: number of axes, 1 to all of them.
        seed: another seed gives another array, as a rule of the same size.

    Returns:
        Keys in the order in which they were found.

    Raises:
        InputError: `covertable` is not installed, or the strength is none.
    """
    axes = len(space.axes)
    if not 1 <= strength <= axes:
        raise InputError(f"strength={strength} of a covering array must be 1 to {axes}, the number of axes")
    levels = levels_of(keys, space)
    if strength == axes or len(levels) <= 1:
        return tuple(keys)
    codes, size = table(levels, space, strength)
    wanted = np.zeros(size, bool)
    wanted[codes] = True
    terms = forbidden(levels)
    work = int(wanted.sum()) * axes * (1 if terms is None else 1 + len(terms))
    tries = max(1, min(SALTS, WORK // work))
    if terms is None:
        rng = generator("covering array", strength, seed)
        begun = [[int(rng.integers(len(levels)))] for _ in range(tries)]
    else:
        row_of = {tuple(row): number for number, row in enumerate(levels.tolist())}
        arrays = _arrays(levels, terms, strength, seed, tries)
        begun = [[row_of[row] for row in rows if row in row_of] for rows in arrays]
    return tuple(keys[row] for row in min((_whole(rows, codes, wanted) for rows in begun), key=len))


def greedy_array(space: Space, keys: Sequence[str], strength: int) -> tuple[tuple[str, ...], int]:
    """As `covering_array`, at once and without `covertable`, a little larger; and how many combinations there are."""
    codes, size = table(levels_of(keys, space), space, strength)
    wanted = np.zeros(size, bool)
    wanted[codes] = True
    return tuple(keys[row] for row in _whole([], codes, wanted)), int(wanted.sum())


def _arrays(
    levels: Levels, terms: Sequence[Forbidden], strength: int, seed: int, tries: int
) -> Iterator[list[tuple[int, ...]]]:
    """What the library finds with one salt after the other, each row the places of its values."""
    make = needed("covertable", "covering arrays need covertable", "covering").make
    factors = {f"a{axis}": sorted(set(column)) for axis, column in enumerate(levels.T.tolist())}
    constraints = [_constraint(*term) for term in terms]
    for salt in range(tries):
        rows = make(factors, strength=strength, salt=f"{seed}-{salt}", tolerance=0, constraints=constraints)
        yield [tuple(row[name] for name in factors) for row in rows]


def forbidden(levels: Levels) -> list[Forbidden] | None:
    """The smallest combinations of the points' values that no point has; together they leave exactly the points.

    Args:
        levels: (points, axes), no point twice.

    Returns:
        None when there are more than `MOST_TERMS`: the points are scattered, not a grid with something taken out.
    """
    values = [sorted(set(column)) for column in levels.T.tolist()]
    if len(levels) == prod(map(len, values)):
        return []
    left = np.array(list(product(*values)), np.int64)
    forbidden: list[Forbidden] = []
    for size in range(2, len(values) + 1):
        for axes in combinations(range(len(values)), size):
            if len(left) == len(levels) or len(forbidden) > MOST_TERMS:
                return forbidden if len(forbidden) <= MOST_TERMS else None
            radix = np.array([prod(max(values[axis]) + 1 for axis in axes[i + 1 :]) for i in range(size)])
            missing = ~np.isin(left[:, axes] @ radix, levels[:, axes] @ radix)
            forbidden += [(axes, tuple(row)) for row in np.unique(left[missing][:, axes], axis=0).tolist()]
            left = left[~missing]
    return forbidden if len(forbidden) <= MOST_TERMS else None


def _constraint(axes: tuple[int, ...], places: tuple[int, ...]) -> dict[str, Any]:
    """Not all of these values together, in the library's words."""
    return {
        "operator": "or",
        "conditions": [{"operator": "ne", "left": f"a{a}", "value": v} for a, v in zip(axes, places, strict=True)],
    }


def _whole(rows: list[int], codes: Ids, wanted: NDArray[np.bool_]) -> list[int]:
    """The rows without those that the others make superfluous, and with what they may lack, greedily."""
    kept = list(dict.fromkeys(rows))
    times = np.bincount(codes[kept].ravel(), minlength=len(wanted))
    for row in reversed(kept.copy()):
        if (times[codes[row]] > 1).all():
            times[codes[row]] -= 1
            kept.remove(row)
    open_ = wanted & (times == 0)
    while open_.any():
        kept.append(int(open_[codes].sum(axis=1).argmax()))
        open_[codes[kept[-1]]] = False
    return kept


"""The p of (p, t)-completeness."""


_Strength = Annotated[int, Choices([str(strength) for strength in STRENGTHS])]
_Total = Annotated[Ratio, About("combinations of values of {} axes")]
_Complete = Annotated[Completeness, About("choices of {} axes, by that share (0..1)")]
_Realised = Annotated[
    Ratio, About("situations where its value came true in a baseline flight, of those with such a flight")
]
_Triggered = Annotated[
    Ratio, About("situations where a baseline flight put it to the test, of those with such a flight")
]


@dataclass(frozen=True)
class Coverage:
    """How much of the situations the flights cover.

    A number drawn from a range covers its bin: bins count, not drawn numbers.

    Attributes:
        situations: distinct situations flown, of the grid.
        draws: test cases flown: a situation with a seed each.
        pool: those of them in which the baseline alone was flown, to decide by.
        combinations: per strength t, the combinations of values of t axes that were flown, of all that situations have.
        realised: situations whose every value came true in a baseline flight, of the grid.
        states: safety pairs (a situation flown, a safety requirement) by what the baseline pool says of them; a
            situation with drawn numbers has pairs of its own.
        by_axis: by axis.
        requirements: by requirement; in the other situations it was vacuous or left open, and nothing was tested by it.
    """

    KEYS = (
        *("situations", "draws", "pool", "t_way", "complete", "realised", "realised_by_axis=by_axis", "steady"),
        *("states", "requirements"),
    )
    situations: Ratio
    draws: int
    pool: int
    combinations: tuple[TWay, ...]
    realised: Ratio
    states: Mapping[State, Annotated[int, About("pairs that are {}")]]
    by_axis: Annotated[tuple[tuple[str, _Realised], ...], ByName()]
    requirements: Annotated[tuple[tuple[str, _Triggered], ...], ByName()]

    @property
    def t_way(self) -> Annotated[tuple[tuple[_Strength, _Total], ...], ByName()]:
        """By the number of axes t, the combinations of values of t axes that were flown, of all."""
        return tuple((one.strength, one.total) for one in self.combinations)

    @property
    def complete(self) -> Annotated[tuple[tuple[_Strength, _Complete], ...], ByName()]:
        """By the number of axes t, the choices of t axes of which at least a share of the combinations was flown."""
        return tuple((one.strength, one.completeness) for one in self.combinations)

    @property
    def steady(self) -> Ratio:
        """Safety pairs that put a fault to the test, of those with ten baseline flights."""
        return Ratio(self.states[State.STEADY], sum(self.states.values()) - self.states[State.UNKNOWN])


def coverage(outcomes: Iterable[Outcome], space: Space) -> Coverage:
    """Coverage by the flights that count; a flight outside the grid or an invalid one covers nothing."""
    clean, flown = apart(outcomes)
    return coverage_of(clean, {(outcome.situation, outcome.seed) for outcome in flown if not outcome.invalid}, space)


def coverage_of(clean: Iterable[Outcome], draws: Collection[tuple[str, int]], space: Space) -> Coverage:
    """The same of the baselines `clean` and of the `draws` in which mutants were flown."""
    valid = [outcome for outcome in clean if not outcome.invalid]
    keys = {outcome.situation for outcome in valid} | {situation for situation, _ in draws}
    covered = {key: place for key in keys if (place := space.rank(key)[0]) < len(space.points)}
    by_draw = {(outcome.situation, outcome.seed): outcome for outcome in valid if outcome.situation in covered}
    baselines, beside = list(by_draw.values()), {draw for draw in draws if draw[0] in covered}
    alone = by_draw.keys() - beside
    judged = {covered[outcome.situation] for outcome in baselines}
    flown = set(covered.values())
    came_true = {(covered[outcome.situation], axis) for outcome in baselines for axis, true in outcome.realised if true}
    all_true = (one for one in baselines if one.realised and all(true for _, true in one.realised))
    whole, pool = {covered[one.situation] for one in all_true}, Pool.of(baselines)
    pairs = Counter(
        pool.states.get((key, name), State.UNKNOWN) for key in covered for name in pool.requirements(Kind.SAFETY)
    )
    return Coverage(
        situations=Ratio(len(flown), len(space.points)),
        draws=len(beside) + len(alone),
        pool=len(alone),
        combinations=t_ways(covered, space, STRENGTHS),
        realised=Ratio(len(whole), len(space.points)),
        states={state: pairs[state] for state in State},
        by_axis=tuple(
            (axis, Ratio(sum((place, axis) in came_true for place in judged), len(judged))) for axis in space.axes
        ),
        requirements=_requirements(baselines, covered, len(judged)),
    )


def _requirements(
    baselines: Iterable[Outcome], covered: Mapping[str, int], judged: int
) -> tuple[tuple[str, Ratio], ...]:
    triggered: dict[str, set[int]] = {}
    for outcome in baselines:
        for reading in outcome.readings:
            situations = triggered.setdefault(reading.requirement, set())
            if reading.compliance in (Compliance.HELD, Compliance.VIOLATED):
                situations.add(covered[outcome.situation])
    return tuple((name, Ratio(len(situations), judged)) for name, situations in triggered.items())
