"""The syntax tree of a formula: every part has a robustness at each sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from scaloft_fi.stack.declaration import TICK_S

SAMPLE_MS = round(1000 * TICK_S)
"""Sampling period of the flight log [ms]."""

Sign = Literal["+", "-", "*", "/"]
Comparator = Literal["<", "<=", ">", ">="]
Extreme = Literal["historically", "once", "always", "eventually"]
"""Words of the worst or the best sample of a window of the past or the future."""


@dataclass(frozen=True, slots=True)
class Signal:
    """The samples of a signal, or the robustness of a definition."""

    name: str


@dataclass(frozen=True, slots=True)
class Number:
    """The same number at each sample."""

    value: float


@dataclass(frozen=True, slots=True)
class Function:
    """`abs`, `sqrt` or `not` of each sample."""

    word: Literal["abs", "sqrt", "not"]
    of: Node


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """A sum, difference, product or quotient."""

    sign: Sign
    left: Node
    right: Node


@dataclass(frozen=True, slots=True)
class Comparison:
    """A comparison; its robustness is the margin between its sides."""

    sign: Comparator
    left: Node
    right: Node


@dataclass(frozen=True, slots=True)
class Logic:
    """Two parts joined by a word."""

    word: Literal["and", "or", "implies", "iff"]
    left: Node
    right: Node


@dataclass(frozen=True, slots=True)
class Interval:
    """Nearest and farthest sample of a window, counted from the present one, both included."""

    first: int
    last: int


@dataclass(frozen=True, slots=True)
class Window:
    """The worst or the best of a part within a window; without an interval the window reaches to the flight's end."""

    word: Extreme
    of: Node
    interval: Interval | None = None


@dataclass(frozen=True, slots=True)
class Hold:
    """`since` or `until`: `right` holds at a sample of the window, and `left` at every sample between it and now."""

    word: Literal["since", "until"]
    left: Node
    right: Node
    interval: Interval | None = None


Node = Signal | Number | Function | Arithmetic | Comparison | Logic | Window | Hold


def parts(node: Node) -> tuple[Node, ...]:
    """The parts of a node, none to two."""
    match node:
        case Signal() | Number():
            return ()
        case Function(of=of) | Window(of=of):
            return (of,)
        case _:
            return node.left, node.right
