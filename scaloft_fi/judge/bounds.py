"""Bounds of a formula's robustness in any flight: a comparison that is true or false in every flight tests nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from itertools import product
from typing import Any

from scaloft_fi.judge.ranges import ANY, Ranges, Span
from scaloft_fi.judge.stl import Formula

MOST_SPANS = 32
"""With more spans, one span stands for all of them."""
_UPPER = ("<", "<=")
_SIGNS = {"Addition": "+", "Subtraction": "-", "Multiplication": "*", "Division": "/"}
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
        if type(node).__name__ == "Predicate":
            always = verdict(_bounds(node, ranges))
            if always is not None:
                yield _text(node), always
        else:
            waiting += reversed(_children(node))


def _children(node: Any) -> list[Any]:
    """The one or two children of a node; RTAMT lists those of some nodes twice."""
    return list(node.children[:2])


def _text(node: Any, *, inner: bool = False) -> str:
    """A comparison or a sum as a user writes it."""
    kind = type(node).__name__
    if kind == "Variable":
        return str(node.var)
    if kind == "Constant":
        return f"{float(node.val):g}"
    if len(_children(node)) == 1:
        return f"{kind.lower()}({_text(_children(node)[0])})"
    sign = _SIGNS.get(kind) or str(node.operator)
    text = f" {sign} ".join(_text(child, inner=True) for child in _children(node))
    return f"({text})" if inner else text


def _bounds(node: Any, ranges: Ranges) -> Spans:
    kind = type(node).__name__
    if kind == "Variable":
        return ranges.get(node.var, ANY)
    if kind == "Constant":
        return ((float(node.val), float(node.val)),)
    inner = [_bounds(child, ranges) for child in _children(node)]
    if kind == "Predicate":
        left, right = inner[::-1] if str(node.operator) in _UPPER else inner
        return _pairs(_minus, left, right)
    if kind in _ONE:
        return _few([_ONE[kind](span) for span in inner[0]])
    if kind in _TWO:
        return _pairs(_TWO[kind], *inner)
    return _temporal(kind, node, inner)


def _temporal(kind: str, node: Any, inner: list[Spans]) -> Spans:
    """Past and future: an extreme of what stands inside; a window that begins later may be empty at first."""
    low, high = min(low for spans in inner for low, _ in spans), max(high for _, high in inner[-1])
    late = getattr(node, "begin", 0) not in (0, None)
    if kind.endswith(("Historically", "Always")):
        return ((low, math.inf if late else high),)
    if kind.endswith(("Once", "Eventually")):
        return ((-math.inf if late else low, high),)
    return ((-math.inf, high),)  # since, until


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


_ONE: Mapping[str, Callable[[Span], Span]] = {
    "Neg": lambda span: (-span[1], -span[0]),
    "Abs": _absolute,
    "Sqrt": _root,
}
_TWO: Mapping[str, Callable[[Span, Span], Span]] = {
    "Addition": lambda one, other: _span(one[0] + other[0], one[1] + other[1]),
    "Subtraction": _minus,
    "Multiplication": _times,
    "Division": _over,
    "Conjunction": lambda one, other: (min(one[0], other[0]), min(one[1], other[1])),
    "Disjunction": lambda one, other: (max(one[0], other[0]), max(one[1], other[1])),
    "Implies": lambda one, other: (max(-one[1], other[0]), max(-one[0], other[1])),
    "Iff": lambda _one, _other: (-math.inf, 0.0),
}
