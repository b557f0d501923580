"""Situation spaces of any shape, for the tests of what is counted over them."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

from hypothesis import strategies as st

from scaloft_fi.judge.space import Point, Space


def space_of(sizes: list[int], allowed: Callable[[Point], bool] = lambda _: True) -> Space:
    """Axes with so many values each, without the points that are not allowed."""
    axes = tuple(f"A{chr(97 + number)}" for number in range(len(sizes)))
    values = tuple(tuple(map(str, range(size))) for size in sizes)
    points = [point for point in product(*values) if allowed(point)]
    keyed = tuple(("".join(a + v for a, v in zip(axes, point, strict=True)), point) for point in points)
    return Space(axes, values, values, keyed)


def keys_of(space: Space) -> list[str]:
    return [key for key, _ in space.points]


FIVE = space_of([2] * 5)


@st.composite
def spaces(draw: st.DrawFn, most: int = 40) -> Space:
    """Small grids, some with points taken out."""
    sizes = draw(st.lists(st.integers(2, 3), min_size=2, max_size=4).filter(lambda s: len(s) < 4 or sum(s) < 11))
    whole = space_of(sizes)
    left = draw(st.lists(st.sampled_from(whole.points), min_size=2, max_size=most, unique=True))
    if draw(st.booleans()):
        return whole
    chosen = {point for _, point in left}
    return space_of(sizes, lambda point: point in chosen)
