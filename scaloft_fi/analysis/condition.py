"""In which situations a mutant dies, as a short condition: `human & light`.

Quine and McCluskey's method for axes of any number of values: a term is a box (a set of values per axis), the prime
terms are the largest boxes without a surviving situation, and the fewest of them that cover every kill are printed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import lru_cache, reduce
from itertools import combinations, product
from math import prod
from operator import and_, getitem

from scaloft_fi.judge.space import Point, Space

Term = tuple[frozenset[str], ...]
"""Per axis the values a term admits."""

MOST_BOXES = 60_000
"""Beyond this many boxes only boxes with one or all values on each axis are looked at."""
MOST_EXACT = 16
"""Up to this many prime terms the smallest cover is searched for exactly; beyond, greedily."""


def condition(space: Space, killing: Collection[str], surviving: Collection[str]) -> str:
    """The shortest condition that is true in every killing situation and in no surviving one.

    Situations in neither (nothing is known there) may fall on either side.  Numbers drawn from a range count as their
    bin, and a bin with a kill counts as killing.

    Args:
        space: the grid.
        killing: keys of the situations where the mutant is killed.
        surviving: keys of those where it was put to the test and is not.

    Raises:
        ValueError: a situation is in both.
    """
    terms = cover(space, killing, surviving)
    if not terms:
        return ""
    texts = [term_text(space, term) for term in terms]
    if texts == [""]:
        return "everywhere" if len({space.point[key] for key in killing}) == len(space.points) else "wherever tested"
    return " or ".join(f"({text})" if len(texts) > 1 and " & " in text else text for text in texts)


def cover(space: Space, killing: Collection[str], surviving: Collection[str]) -> tuple[Term, ...]:
    """The terms of the condition: every killing point is in one of them, no surviving point in any.

    Raises:
        ValueError: a situation is in both.
    """
    both = set(killing) & set(surviving)
    if both:
        raise ValueError(f"both killing and surviving: {sorted(both)}")
    on, off = sides(space, killing, surviving)
    primes = _primes(space, on, off)
    return tuple(sorted(_fewest(space, primes, on), key=lambda term: _order(space, term)))


def sides(space: Space, killing: Collection[str], surviving: Collection[str]) -> tuple[list[Point], list[Point]]:
    """The points with a kill and those with survival only, each once, in the grid's order."""
    on = dict.fromkeys(space.point[key] for key in sorted(killing, key=space.rank))
    off = dict.fromkeys(space.point[key] for key in sorted(surviving, key=space.rank))
    return list(on), [point for point in off if point not in on]


def admits(term: Term, point: Point) -> bool:
    """Whether a point is in the box."""
    return all(value in allowed for value, allowed in zip(point, term, strict=True))


def _primes(space: Space, on: Sequence[Point], off: Sequence[Point]) -> list[Term]:
    """The boxes with a killing point and no surviving one that no other such box contains, largest first."""
    if not on:
        return []
    if not off:
        return [tuple(frozenset(values) for values in space.values)]
    if prod(2 ** len(values) - 1 for values in space.values) > MOST_BOXES:
        return _primes_around(space, on, off)
    bits = {point: 1 << place for place, (_, point) in enumerate(space.points)}
    killing, surviving = (sum(bits[point] for point in points) for points in (on, off))
    primes: list[Term] = []
    for term, inside in _boxes(space):
        contained = (all(map(frozenset.issubset, term, larger)) for larger in primes)
        if inside & killing and not inside & surviving and not any(contained):
            primes.append(term)
    return primes


@lru_cache(maxsize=8)
def _boxes(space: Space) -> tuple[tuple[Term, int], ...]:
    """Every box, largest first, with the points of the grid in it, one bit each: a campaign has hundreds of mutants."""
    sides = [
        {
            frozenset(chosen): sum(1 << i for i, (_, point) in enumerate(space.points) if point[axis] in chosen)
            for size in range(1, len(values) + 1)
            for chosen in combinations(values, size)
        }
        for axis, values in enumerate(space.values)
    ]
    every = (1 << len(space.points)) - 1
    boxes = sorted(product(*sides), key=lambda term: _order(space, term))
    return tuple((term, reduce(and_, map(getitem, sides, term), every)) for term in boxes)


def _primes_around(space: Space, on: Sequence[Point], off: Sequence[Point]) -> list[Term]:
    """The same among boxes with one or all values on each axis.

    Such a box around a killing point fixes some axes to its values, and leaves a surviving point out when they differ
    on one of them: so the largest boxes are the smallest sets of axes that meet every set of differing axes.
    """
    every = [frozenset(values) for values in space.values]
    terms: set[Term] = set()
    for point in on:
        differing = {
            frozenset(axis for axis, (a, b) in enumerate(zip(point, other, strict=True)) if a != b) for other in off
        }
        for axes in _smallest_meeting(differing):
            terms.add(tuple(frozenset([v]) if i in axes else every[i] for i, v in enumerate(point)))
    return sorted(terms, key=lambda term: _order(space, term))


def _smallest_meeting(sets: Iterable[frozenset[int]]) -> set[frozenset[int]]:
    """The smallest sets that meet each of `sets` (its minimal transversals), set by set after Berge (1989).

    >>> sorted(map(sorted, _smallest_meeting([frozenset({0, 1}), frozenset({1, 2})])))
    [[0, 2], [1]]
    """
    transversals: set[frozenset[int]] = {frozenset()}
    for met in sorted(sets, key=lambda members: (len(members), sorted(members))):
        enough = {chosen for chosen in transversals if chosen & met}
        grown = {chosen | {axis} for chosen in transversals - enough for axis in met}
        transversals = enough | {chosen for chosen in grown if not any(smaller <= chosen for smaller in enough)}
    return transversals


def _order(space: Space, term: Term) -> tuple[int, int, list[list[int]]]:
    """Fewest literals first, then fewest values left out, then the grid's order: ties always break the same way."""
    left_out = [len(values) - len(allowed) for values, allowed in zip(space.values, term, strict=True)]
    places = [
        sorted(values.index(value) for value in allowed) for values, allowed in zip(space.values, term, strict=True)
    ]
    return sum(count > 0 for count in left_out), sum(left_out), places


def _fewest(space: Space, primes: Sequence[Term], on: Sequence[Point]) -> list[Term]:
    covered = {term: frozenset(i for i, point in enumerate(on) if admits(term, point)) for term in primes}
    everything = frozenset(range(len(on)))
    essential = {holders[0] for i in everything if len(holders := [term for term in primes if i in covered[term]]) == 1}
    chosen = [term for term in primes if term in essential]
    missing = everything.difference(*(covered[term] for term in chosen))
    others = [term for term in primes if term not in essential and covered[term] & missing]
    if len(others) <= MOST_EXACT:
        for size in range(len(others) + 1):
            fits = [
                pick for pick in combinations(others, size) if missing <= frozenset().union(*(covered[t] for t in pick))
            ]
            if fits:
                return [*chosen, *min(fits, key=lambda pick: sum(_order(space, term)[0] for term in pick))]
    while missing:
        best = max(others, key=lambda term: len(covered[term] & missing))
        chosen.append(best)
        missing -= covered[best]
    # a greedy choice may be made superfluous by later ones
    for term in list(chosen):
        rest = [covered[other] for other in chosen if other != term]
        if everything <= frozenset().union(*rest):
            chosen.remove(term)
    return chosen


def term_text(space: Space, term: Term) -> str:
    """`human & light`: the axes in reverse order of the grid read best, the person before the light."""
    factors = []
    for axis in reversed(range(len(space.axes))):
        allowed = [value for value in space.values[axis] if value in term[axis]]
        if len(allowed) < len(space.values[axis]):
            factors.append([space.word(axis, value) for value in allowed])
    alone = len(factors) == 1
    return " & ".join(
        " or ".join(names) if alone or len(names) == 1 else f"({' or '.join(names)})" for names in factors
    )
