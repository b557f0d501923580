"""Random formulas of signal temporal logic, their text, and their robustness by plain definition."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import reduce

import pytest
from hypothesis import strategies as st

from scaloft_fi.judge.stl import (
    COMPARATORS,
    EXTREMES,
    LARGEST,
    MEAN,
    Infix,
    Interval,
    Node,
    Number,
    Prefix,
    Signal,
    robustness,
)

NAMES = ("a", "b", "c")
Column = list[float]

intervals = st.tuples(st.integers(0, 9), st.integers(0, 9)).map(lambda ends: Interval(min(ends), max(ends)))
numbers = st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.25, 3.0, 1e300]).map(Number)
leaves = st.one_of(st.sampled_from(NAMES).map(Signal), st.sampled_from(NAMES).map(Signal), numbers)


def _grown(inner: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
    optional = st.one_of(st.none(), intervals)
    return st.one_of(
        st.builds(Prefix, st.sampled_from(["abs", "sqrt", "rise", "fall", "not", "not", "not"]), inner),
        st.builds(Prefix, st.sampled_from(EXTREMES), inner, optional),
        *(
            st.builds(Infix, st.sampled_from(words), inner, inner)
            for words in (tuple("+-*/"), COMPARATORS, ("and", "or", "implies", "iff"))
        ),
        st.builds(Infix, st.sampled_from(["since", "until"]), inner, inner, optional),
    )


trees: st.SearchStrategy[Node] = st.recursive(leaves, _grown, max_leaves=8)
"""Trees over the signals of `NAMES`, of operators that RTAMT has too."""
_means = st.integers(1, 9).map(lambda last: Interval(0, last))
all_trees: st.SearchStrategy[Node] = st.recursive(
    leaves, lambda inner: st.one_of(_grown(inner), st.builds(Prefix, st.just(MEAN), inner, _means)), max_leaves=8
)
"""Trees over the signals of `NAMES`, of every operator."""

_values = st.one_of(
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 2.0]),
    st.floats(-100, 100, allow_nan=False),
    st.sampled_from([1e308, -1e308]),
)


ZEROS = {"a": [0.0, -0.0, 1.0, 0.0], "b": [-0.0, 0.0, -0.0, 0.0], "c": [-0.0, -0.0, 0.0, 2.0]}
_A, _B, _C = map(Signal, NAMES)
_NONE = Infix("-", Prefix("once", _A, Interval(1, 2)), Prefix("once", _B, Interval(1, 2)))
"""No number at the first sample, nor the next at the last: infinity less infinity."""
_NONE_LAST = Infix(
    "-",
    Prefix("eventually", Infix("and", _A, _B), Interval(1, 2)),
    Prefix("eventually", Infix("and", _A, _B), Interval(1, 2)),
)
EDGES: Mapping[str, Node] = {
    "equal zeros in a window of the past": Prefix("once", Infix("and", _A, _B), Interval(0, 2)),
    "equal zeros in a window of the future": Prefix("always", Infix("or", _B, _A), Interval(0, 2)),
    "equal zeros in all the past": Prefix("historically", _B),
    "equal zeros in all the future": Prefix("eventually", _C),
    "equal zeros since": Infix("since", _A, _B, Interval(0, 3)),
    "equal zeros held": Infix("since", Infix("and", _B, _C), Number(3.0), Interval(0, 3)),
    "equal zeros until": Infix("until", _B, _C, Interval(1, 2)),
    "equal zeros implied": Infix("implies", _A, _B),
    "equal zeros rising": Prefix("rise", _C),
    "equal zeros falling": Prefix("fall", Infix("or", _B, _A)),
    "no number in a window": Prefix("historically", _NONE, Interval(0, 2)),
    "no number in all the past": Prefix("once", _NONE),
    "no number in all the future": Prefix("always", _NONE),
    "no number held": Infix("since", _NONE, _B, Interval(0, 2)),
    "no number held to the last": Infix("since", _NONE_LAST, _C, Interval(0, 2)),
    "no number until": Infix("until", _A, _NONE),
    "no number since": Infix("since", _A, _NONE, Interval(0, 2)),
    "a window before the flight": Prefix("historically", _A, Interval(4, 9)),
    "a window after the flight": Prefix("eventually", Infix("and", _A, _B), Interval(4, 9)),
    "a window longer than the flight": Prefix("once", _A, Interval(1, 9)),
    "since longer than the flight": Infix("since", _A, _B, Interval(1, 9)),
    "division by zero": Infix("/", _A, _B),
    "root of a negative number": Prefix("sqrt", Infix("-", _B, Number(1.0))),
    "overflow": Infix("*", Number(1e300), Infix("*", Number(1e300), _A)),
}
"""Trees whose robustness over `ZEROS` asks which of two equal numbers, or of none, stands."""


def traces(least: int) -> st.SearchStrategy[dict[str, Column]]:
    """Signals of `NAMES`, of at least so many samples."""
    return st.integers(least, 25).flatmap(
        lambda length: st.fixed_dictionaries(
            {name: st.lists(_values, min_size=length, max_size=length) for name in NAMES}
        )
    )


def bracketed(node: Node) -> str:
    """The text of a tree, every part in brackets."""
    match node:
        case Signal(name):
            return name
        case Number(value):
            return repr(value)
        case Prefix(word, of, interval):
            return f"{word}{_interval(interval)} ({bracketed(of)})"
        case Infix(operator, left, right, interval):
            return f"({bracketed(left)}) {operator}{_interval(interval)} ({bracketed(right)})"


def _interval(interval: Interval | None) -> str:
    return f" [{interval.first / 20}:{interval.last / 20}]" if interval else ""


def defined(node: Node, signals: Mapping[str, Column]) -> Column:
    """The robustness of a tree by the definition of each of its parts, sample by sample.

    Raises:
        ZeroDivisionError: a divisor is 0.
        ValueError: a root is of a negative number.
    """
    (length,) = {len(column) for column in signals.values()}
    match node:
        case Signal(name):
            return signals[name]
        case Number(value):
            return [value] * length
        case Prefix(word, of, interval):
            values = defined(of, signals)
            if word in ("rise", "fall"):
                sign = 1 if word == "rise" else -1
                return [
                    min(-sign * then, sign * now)
                    for now, then in zip(values, [-sign * math.inf, *values], strict=False)
                ]
            if word == MEAN and interval:
                return [_mean(values, place, interval.last) for place in range(length)]
            return _extremes(word, values, interval) if word in EXTREMES else [_ONE[word](value) for value in values]
    left, right = defined(node.left, signals), defined(node.right, signals)
    if node.operator in ("since", "until"):
        way = 1 if node.operator == "since" else -1
        return _since(left[::way], right[::way], node.interval)[::way]
    return [_TWO[node.operator](one, other) for one, other in zip(left, right, strict=True)]


_ONE: Mapping[str, Callable[[float], float]] = {"abs": abs, "sqrt": math.sqrt, "not": lambda value: -value}
_TWO: Mapping[str, Callable[[float, float], float]] = {
    "+": lambda one, other: one + other,
    "-": lambda one, other: one - other,
    "*": lambda one, other: one * other,
    "/": lambda one, other: one / other,
    "<": lambda one, other: other - one,
    "<=": lambda one, other: other - one,
    ">": lambda one, other: one - other,
    ">=": lambda one, other: one - other,
    "==": lambda one, other: -abs(one - other),
    "and": min,
    "or": max,
    "implies": lambda one, other: max(-one, other),
    "iff": lambda one, other: -abs(one - other),
}


def _extremes(word: str, column: Column, interval: Interval | None) -> Column:
    worst = word in ("historically", "always")
    pick, empty = (min, math.inf) if worst else (max, -math.inf)
    past = word in ("historically", "once")
    if interval is None:
        ordered = column if past else column[::-1]
        found = [
            reduce(lambda before, now: pick(now, before), ordered[: place + 1], empty) for place in range(len(column))
        ]
        return found if past else found[::-1]
    lags = range(interval.first, interval.last + 1)
    return [
        pick([_at(column, place + lag * (-1 if past else 1), empty) for lag in (reversed(lags) if past else lags)])
        for place in range(len(column))
    ]


def _mean(column: Column, place: int, last: int) -> float:
    """The mean of the samples of a window, taken in one by one from the present into the past."""
    found = column[place]
    for number, sample in enumerate(reversed(column[max(0, place - last) : place]), 2):
        found += (sample - found) / number
    return found


def _since(left: Column, right: Column, interval: Interval | None) -> Column:
    if interval is None:
        found, before = [], -math.inf
        for held, now in zip(left, right, strict=True):
            before = max(min(held, before), now)
            found.append(before)
        return found
    lags = range(interval.last, interval.first - 1, -1)
    return [max(-math.inf, *(_held(left, right, place, lag) for lag in lags)) for place in range(len(left))]


def _held(left: Column, right: Column, place: int, lag: int) -> float:
    """`right` `lag` samples before `place`, and `left` at every sample after it."""
    between = (_at(left, later, math.inf) for later in range(place - lag + 1, place + 1))
    return min(min(math.inf, math.inf, *between), _at(right, place - lag, -math.inf))


def _at(column: Sequence[float], place: int, empty: float) -> float:
    return column[place] if 0 <= place < len(column) else empty


def agrees(tree: Node, signals: Mapping[str, Column], oracle: Callable[[Node, Mapping[str, Column]], Column]) -> None:
    """Hold the robustness of a tree to the bits, or the error, of an oracle's."""
    try:
        expected = [min(LARGEST, max(-LARGEST, value)) for value in oracle(tree, signals)]
    except (ZeroDivisionError, ValueError) as error:
        with pytest.raises(type(error)):
            robustness(tree, signals, LARGEST)
    else:
        assert list(map(repr, robustness(tree, signals, LARGEST))) == list(map(repr, expected))
