"""The text of a syntax tree, with no more brackets than it needs."""

from __future__ import annotations

from scaloft_fi.judge.stl.binding import AFTER_WORD, LEVEL, apart
from scaloft_fi.judge.stl.tree import (
    SAMPLE_MS,
    Arithmetic,
    Comparison,
    Function,
    Hold,
    Interval,
    Logic,
    Node,
    Number,
    Signal,
    Window,
)


def written(node: Node) -> str:
    """The text of a tree; `parse` reads the same tree from it.

    >>> written(Comparison("<", Arithmetic("/", Signal("a"), Number(2.0)), Function("abs", Signal("b"))))
    'a / 2 < abs(b)'
    """
    match node:
        case Signal(name):
            return name
        case Number(value):
            return f"{value:g}" if float(f"{value:g}") == value else repr(value)
        case Function(word, of):
            return f"not ({written(of)})" if word == "not" else f"{word}({written(of)})"
        case Window(extreme, of, interval):
            return f"{extreme}{_interval(interval)}({written(of)})"
    operator = _operator(node)
    interval = node.interval if isinstance(node, Hold) else None
    return f"{_side(operator, node.left)} {operator}{_interval(interval)} {_side(operator, node.right, right=True)}"


def _operator(node: Arithmetic | Comparison | Logic | Hold) -> str:
    return node.sign if isinstance(node, Arithmetic | Comparison) else node.word


def _side(operator: str, side: Node, *, right: bool = False) -> str:
    """The text of an operand of `operator`, in brackets where it would be read otherwise without them."""
    match side:
        case Signal() | Number() | Function("abs" | "sqrt"):
            loose = True
        case Function() | Window():
            loose = LEVEL[operator] < AFTER_WORD
        case _:
            inner = _operator(side)
            pair = (operator, inner) if right else (inner, operator)
            loose = LEVEL[inner] >= LEVEL[operator] + right and apart(*pair) is None
    return written(side) if loose else f"({written(side)})"


def _interval(interval: Interval | None) -> str:
    if interval is None:
        return ""
    return f"[{interval.first * SAMPLE_MS / 1000:g}:{interval.last * SAMPLE_MS / 1000:g}]"
