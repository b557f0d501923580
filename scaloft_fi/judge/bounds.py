"""Bounds of a formula's robustness in any flight: a comparison that is true or false in every flight tests nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from itertools import product
from typing import assert_never

from scaloft_fi.judge.ranges import ANY, Ranges, Span
from scaloft_fi.judge.stl import Formula
from scaloft_fi.judge.stl.tree import (
    Arithmetic,
    Comparison,
    Extreme,
    Function,
    Hold,
    Logic,
    Node,
    Number,
    Signal,
    Window,
    parts,
)

MOST_SPANS = 32
"""With more spans, one span stands for all of them."""
Spans = tuple[Span, ...]


def verdict(spans: Spans) -> bool | None:
    """Whether a formula with this robustness holds in every flight (True) or in none (False); None = it depends."""
    if all(low >= 0.0 for low, _ in spans):
        return True
    return False if all(high < 0.0 for _, high in spans) else None


def bounds_of(formula: Formula, ranges: Ranges) -> Spans:
    """What the robustness of a formula can be at a sample; wider than it is where one signal occurs twice.

    Args:
        formula: the formula.
        ranges: by name what each signal, and the robustness of each definition in it, can be.
    """
    return _bounds(formula.tree, ranges)


def constants(formula: Formula, ranges: Ranges) -> Iterator[tuple[str, bool]]:
    """The comparisons in a formula that are true, or false, at every sample of every flight."""
    waiting = [formula.tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, Comparison):
            always = verdict(_bounds(node, ranges))
            if always is not None:
                yield f"{_text(node.left)} {node.sign} {_text(node.right)}", always
        else:
            waiting += reversed(parts(node))


def _text(node: Node) -> str:
    """A side of a comparison as a user writes it."""
    match node:
        case Signal(name):
            return name
        case Number(value):
            return f"{value:g}"
        case Function(word, of):
            return f"{word}({_text(of)})"
        case Window(word, of):
            return f"{word}( ... )"
        case Arithmetic(operator, left, right) | Comparison(operator, left, right):
            return f"({_text(left)} {operator} {_text(right)})"
        case _:
            return f"({_text(node.left)} {node.word} {_text(node.right)})"


def _bounds(node: Node, ranges: Ranges) -> Spans:
    match node:
        case Signal(name):
            return ranges.get(name, ANY)
        case Number(value):
            return ((value, value),)
        case Function(word, of):
            return _few([_FUNCTION[word](span) for span in _bounds(of, ranges)])
        case Window(word, of, interval):
            return _window(word, _bounds(of, ranges), late=interval is not None and interval.first > 0)
        case Hold(right=right):
            return ((-math.inf, max(high for _, high in _bounds(right, ranges))),)
        case Comparison("<" | "<=", left, right):
            return _pairs(_minus, _bounds(right, ranges), _bounds(left, ranges))
        case Comparison(left=left, right=right):
            return _pairs(_minus, _bounds(left, ranges), _bounds(right, ranges))
        case Arithmetic(operator, left, right) | Logic(operator, left, right):
            return _pairs(_JOIN[operator], _bounds(left, ranges), _bounds(right, ranges))
        case _:
            assert_never(node)


def _window(word: Extreme, spans: Spans, *, late: bool) -> Spans:
    """An extreme of what stands inside; a window that begins later may be empty."""
    low, high = min(low for low, _ in spans), max(high for _, high in spans)
    if word in ("historically", "always"):
        return ((low, math.inf if late else high),)
    return ((-math.inf if late else low, high),)


def _few(spans: list[Span]) -> Spans:
    ordered = sorted(spans)
    return tuple(ordered) if len(ordered) <= MOST_SPANS else ((ordered[0][0], max(high for _, high in ordered)),)


def _pairs(join: Callable[[Span, Span], Span], left: Spans, right: Spans) -> Spans:
    return _few([join(one, other) for one, other in product(left, right)])


def _minus(one: Span, other: Span) -> Span:
    return _span(one[0] - other[1], one[1] - other[0])


def _span(low: float, high: float) -> Span:
    """The span; nothing is known of an end that is infinity - infinity."""
    return (-math.inf if math.isnan(low) else low, math.inf if math.isnan(high) else high)


def _times(one: Span, other: Span) -> Span:
    ends = [0.0 if 0.0 in (a, b) else a * b for a, b in product(one, other)]
    return min(ends), max(ends)


def _over(one: Span, other: Span) -> Span:
    if other[0] <= 0.0 <= other[1]:
        return -math.inf, math.inf
    ends = [_quotient(a, b) for a, b in product(one, other)]
    return min(ends), max(ends)


def _quotient(a: float, b: float) -> float:
    if math.isinf(b):
        return 0.0 if math.isfinite(a) else math.copysign(math.inf, a * b)
    return a / b


def _absolute(span: Span) -> Span:
    ends = sorted(map(abs, span))
    return (0.0 if span[0] <= 0.0 <= span[1] else ends[0]), ends[1]


def _root(span: Span) -> Span:
    low, high = (math.sqrt(max(end, 0.0)) for end in span)
    return low, high


_FUNCTION: Mapping[str, Callable[[Span], Span]] = {
    "not": lambda span: (-span[1], -span[0]),
    "abs": _absolute,
    "sqrt": _root,
}
_JOIN: Mapping[str, Callable[[Span, Span], Span]] = {
    "+": lambda one, other: _span(one[0] + other[0], one[1] + other[1]),
    "-": _minus,
    "*": _times,
    "/": _over,
    "and": lambda one, other: (min(one[0], other[0]), min(one[1], other[1])),
    "or": lambda one, other: (max(one[0], other[0]), max(one[1], other[1])),
    "implies": lambda one, other: (max(-one[1], other[0]), max(-one[0], other[1])),
    "iff": lambda _one, _other: (-math.inf, 0.0),
}
