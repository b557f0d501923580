"""Caps of signals, and the check that no formula compares a signal with a threshold beyond its cap.

Beyond its cap a signal is constant.  A comparison with a threshold there is true in every flight, or false in every
flight, or equals the comparison with the cap: `person_sight_m < 8` equals `person_sight_m < 6`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from scaloft_fi.judge.requirement import Check
from scaloft_fi.judge.stl import Formula, FormulaError, tokenize
from scaloft_fi.judge.stl.parse import parse
from scaloft_fi.judge.stl.tree import Arithmetic, Comparison, Node, Number, Signal, parts
from scaloft_fi.judge.stl.write import written
from scaloft_fi.sim.signals import CLEARANCE_CAP_M, FAR_M

SIGHT_M = 6.0
"""Greatest distance of a person in sight [m]; equals `SIGHT_M` of `sim/observer.py`, which imports the compiler."""


@dataclass(frozen=True)
class Cap:
    """The cap of a signal.

    Attributes:
        most_m: greatest measured value [m].
        beyond: the value beyond the cap, in words.
        itself: whether a threshold may equal `most_m`.
    """

    most_m: float
    beyond: str
    itself: bool = False

    def allows(self, threshold_m: float) -> bool:
        """Whether a formula may compare the signal with `threshold_m` [m]."""
        return threshold_m < self.most_m or (self.itself and threshold_m == self.most_m)


_CLEARANCE = re.compile(r"clearance_(\w+_)?m")
_CLEAR = Cap(CLEARANCE_CAP_M, f"{CLEARANCE_CAP_M:g} m beyond")
_NOBODY = Cap(FAR_M, f"{FAR_M:g} m without a person")
NO_BELIEFS: Mapping[str, float] = MappingProxyType({})
_CAPS: Mapping[str, Cap] = {
    "waypoint_wall_m": _CLEAR,
    "person_sight_m": Cap(SIGHT_M, f"{FAR_M:g} m beyond", itself=True),
    "person_range_m": _NOBODY,
}


def cap_of(signal: str, beliefs: Mapping[str, float] = NO_BELIEFS) -> Cap | None:
    """The cap of a signal; None for a signal without a cap.

    Args:
        signal: name of the signal.
        beliefs: cap of each belief that has one (`stack.belief.Belief.most`).

    >>> cap_of("clearance_wall_m").most_m
    1.0
    """
    if signal in beliefs:
        return Cap(beliefs[signal], f"{beliefs[signal]:g} m beyond")
    return _CLEAR if _CLEARANCE.fullmatch(signal) else _CAPS.get(signal)


def within_caps(check: Check, beliefs: Mapping[str, float] = NO_BELIEFS) -> Check:
    """Extend `check`: first compare the thresholds of the text with the caps of its signals."""

    def checked(text: str, signals: Collection[str]) -> Formula:
        check_caps(text, beliefs)
        return check(text, signals)

    return checked


def check_caps(text: str, beliefs: Mapping[str, float] = NO_BELIEFS) -> None:
    """Check each comparison of a signal with a number against the cap of the signal.

    Other comparisons pass, and so do words that are no formula, which `Formula.parse` refuses.

    Raises:
        FormulaError: a threshold lies beyond the cap, or a character belongs to no word.
    """
    tokens = tokenize(text)
    try:
        tree = parse(tokens)
    except FormulaError:
        return
    for shown, signal, threshold in comparisons(tree):
        cap = cap_of(signal, beliefs)
        if cap and not cap.allows(threshold):
            allowed = f"{'at most' if cap.itself else 'less than'} {cap.most_m:g} m"
            raise FormulaError(
                f"compares {signal} with {threshold:g} m in '{shown}', but it is measured up to {cap.most_m:g} m and"
                f" reads {cap.beyond}; it must be compared with {allowed}"
            )


def comparisons(tree: Node) -> Iterator[tuple[str, str, float]]:
    """Yield each comparison of one signal with a number: its text, the signal, the threshold in the signal's unit.

    >>> list(comparisons(parse(tokenize("always(a / 3 <= 1 and 2 > b - 0.5)"))))
    [('a / 3 <= 1', 'a', 3.0), ('2 > b - 0.5', 'b', 2.5)]
    """
    if isinstance(tree, Comparison):
        whole = _difference(_line(tree.left), _line(tree.right))
        factors = [(name, factor) for name, factor in whole[0].items() if factor] if whole else []
        if whole and len(factors) == 1:
            ((name, factor),) = factors
            yield written(tree), name, round(-whole[1] / factor, 9)
    for part in parts(tree):
        yield from comparisons(part)


_Line = tuple[Mapping[str, float], float]
"""A linear expression: factor of each signal, and a constant."""


def _line(node: Node) -> _Line | None:
    """A part as a linear expression; None for any other."""
    match node:
        case Signal(name):
            return {name: 1.0}, 0.0
        case Number(value):
            return {}, value
        case Arithmetic(sign, left, right):
            return _joined(sign, _line(left), _line(right))
        case _:
            return None


def _joined(mark: str, left: _Line | None, right: _Line | None) -> _Line | None:
    if left is None or right is None:
        return None
    if mark in "+-":
        return _difference(left, right if mark == "-" else _scaled(right, -1.0))
    if mark == "/":
        return _scaled(left, 1.0 / right[1]) if not right[0] and right[1] else None
    if not left[0]:
        return _scaled(right, left[1])
    return _scaled(left, right[1]) if not right[0] else None


def _difference(left: _Line | None, right: _Line | None) -> _Line | None:
    if left is None or right is None:
        return None
    names = left[0].keys() | right[0].keys()
    return {name: left[0].get(name, 0.0) - right[0].get(name, 0.0) for name in names}, left[1] - right[1]


def _scaled(line: _Line, factor: float) -> _Line:
    return {name: factor * own for name, own in line[0].items()}, factor * line[1]
