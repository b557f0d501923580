"""The robustness of a syntax tree at every sample of a flight.

Each function is the plain definition over whole arrays, (T,).  Of two equal numbers (0.0 and -0.0) and beside a number
that is none, the one stands that Python's `min` and `max` would return over the samples in the order of their time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import accumulate
from typing import Any, assert_never

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.judge.stl.tree import (
    Arithmetic,
    Comparison,
    Function,
    Hold,
    Interval,
    Logic,
    Node,
    Number,
    Sign,
    Signal,
    Window,
)

Column = NDArray[np.float64]
"""(T,) numbers, one for each sample."""


def robustness(node: Node, signals: Mapping[str, Any], largest: float) -> list[float]:
    """The robustness of a tree at each sample, (T,), from -`largest` to `largest`.

    Args:
        node: the tree.
        signals: (T,) samples of each signal in the tree.
        largest: stands for an infinite robustness, which is that of an empty window.

    Raises:
        ValueError: a sample is not finite, the lengths differ or are 0, or a root is of a negative number.
        ZeroDivisionError: a divisor is 0.
    """
    columns = {name: _column(name, samples) for name, samples in signals.items()}
    lengths = sorted({len(column) for column in columns.values()})
    if len(lengths) != 1:
        raise ValueError(f"signals of one formula differ in length: {lengths}")
    if lengths == [0]:
        raise ValueError("signals of a formula have no sample")
    with np.errstate(all="ignore"):
        values = _evaluate(node, columns, lengths[0])
    bounded: list[float] = _less(np.full(1, largest), _greater(np.full(1, -largest), values)).tolist()
    return bounded


def _column(name: str, samples: Any) -> Column:
    column = np.asarray(samples, dtype=np.float64)
    if not np.isfinite(column).all():
        place = np.argmin(np.isfinite(column))
        raise ValueError(f"signal {name} is {column[place]} at sample {place}")
    return column


def _evaluate(node: Node, columns: Mapping[str, Column], length: int) -> Column:
    match node:
        case Signal(name):
            return columns[name]
        case Number(value):
            return np.full(length, value)
        case Function(word, of):
            values = _evaluate(of, columns, length)
            return -values if word == "not" else np.abs(values) if word == "abs" else _root(values)
        case Window(word, of, interval):
            return _window(word, _evaluate(of, columns, length), interval)
    left, right = _evaluate(node.left, columns, length), _evaluate(node.right, columns, length)
    match node:
        case Arithmetic(sign):
            return _ARITHMETIC[sign](left, right)
        case Comparison(sign):
            return left - right if sign in (">", ">=") else right - left
        case Logic(join):
            return _LOGIC[join](left, right)
        case Hold("since", interval=interval):
            return _since(left, right, interval)
        case Hold(interval=interval):
            return _since(left[::-1], right[::-1], interval)[::-1]
        case _:
            assert_never(node)


def _less(first: Column, second: Column) -> Column:
    return np.where(second < first, second, first)


def _greater(first: Column, second: Column) -> Column:
    return np.where(second > first, second, first)


def _root(values: Column) -> Column:
    if (values < 0).any():
        raise ValueError(f"sqrt of {values[values < 0][0]:g} at sample {np.argmax(values < 0)}")
    return np.sqrt(values)


def _quotient(left: Column, right: Column) -> Column:
    if (right == 0).any():
        raise ZeroDivisionError(f"division by 0 at sample {np.argmax(right == 0)}")
    return left / right


_ARITHMETIC: Mapping[Sign, Callable[[Column, Column], Column]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": _quotient,
}
_LOGIC: Mapping[str, Callable[[Column, Column], Column]] = {
    "and": _less,
    "or": _greater,
    "implies": lambda condition, consequence: _greater(-condition, consequence),
    "iff": lambda left, right: -np.abs(left - right),
}


def _window(word: str, values: Column, interval: Interval | None) -> Column:
    worst = word in ("historically", "always")
    past = word in ("historically", "once")
    if interval is None:
        return _so_far(values, worst) if past else _so_far(values[::-1], worst)[::-1]
    length = len(values)
    first, last = min(interval.first, length), min(interval.last, length)
    empty = np.full(last, np.inf if worst else -np.inf)
    if past:
        return _extremes(np.concatenate((empty, values)), last - first + 1, worst)[:length]
    return _extremes(np.concatenate((values, empty)), last - first + 1, worst)[first : first + length]


def _so_far(values: Column, worst: bool) -> Column:
    """The extreme of each sample and all before it; of equal ones the latest."""
    if worst:
        return np.array(list(accumulate(values.tolist(), lambda before, now: before if before < now else now)))
    return np.array(list(accumulate(values.tolist(), lambda before, now: before if before > now else now)))


def _extremes(values: Column, width: int, worst: bool) -> Column:
    """The extreme of each sample and the `width` - 1 after it; of equal ones the first.

    Spans double until one more would be too long, so the time grows with the logarithm of the width.
    """
    better = _less if worst else _greater
    extremes = np.where(np.isnan(values), np.inf if worst else -np.inf, values)
    span = 1
    while span < width:
        step = min(span, width - span)
        extremes = better(extremes[:-step], extremes[step:])
        span += step
    return np.where(np.isnan(values[: len(extremes)]), np.nan, extremes)


def _since(left: Column, right: Column, interval: Interval | None) -> Column:
    if interval is None:
        return _since_ever(left, right)
    length = len(left)
    left, right = (np.where(np.isnan(column), np.inf, column) for column in (left, right))
    held, best = np.full(length, np.inf), np.full(length, -np.inf)
    for lag in range(min(interval.last, length - 1) + 1):
        there = length - lag
        if lag >= interval.first:
            best[lag:] = _greater(_less(held[lag:], right[:there]), best[lag:])
        held[lag:] = _less(left[:there], held[lag:])
    return best


def _since_ever(left: Column, right: Column) -> Column:
    values, before = [], -np.inf
    for held, now in zip(left.tolist(), right.tolist(), strict=True):
        before = max(min(held, before), now)
        values.append(before)
    return np.array(values)
