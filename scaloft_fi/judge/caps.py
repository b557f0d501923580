"""Caps of signals, and the check that no formula compares a signal with a threshold beyond its cap.

Beyond its cap a signal is constant.  A comparison with a threshold there is true in every flight, or false in every
flight, or equals the comparison with the cap: `person_sight_m < 8` equals `person_sight_m < 6`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from types import MappingProxyType

from scaloft_fi.judge.requirement import Check
from scaloft_fi.judge.stl import ARITHMETIC, WORDS, Formula, FormulaError, tokenize
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
    """Check each comparison of a signal with a number against the cap of the signal; other comparisons pass.

    Raises:
        FormulaError: a threshold lies beyond the cap, or a character belongs to no word.
    """
    for written, signal, threshold in comparisons(text):
        cap = cap_of(signal, beliefs)
        if cap and not cap.allows(threshold):
            allowed = f"{'at most' if cap.itself else 'less than'} {cap.most_m:g} m"
            raise FormulaError(
                f"compares {signal} with {threshold:g} m in '{written}', but it is measured up to {cap.most_m:g} m and"
                f" reads {cap.beyond}; it must be compared with {allowed}"
            )


def comparisons(text: str) -> Iterator[tuple[str, str, float]]:
    """Yield each comparison of one signal with a number: its text, the signal, the threshold in the signal's unit.

    >>> list(comparisons("always(a / 3 <= 1 and 2 > b - 0.5)"))
    [('a / 3 <= 1', 'a', 3.0), ('2 > b - 0.5', 'b', 2.5)]

    Raises:
        FormulaError: a character belongs to no word.
    """
    tokens = tokenize(text)
    for place, token in enumerate(tokens):
        if token[0] not in "<>":
            continue
        left = _operand(tokens[:place][::-1], ")", "(")[::-1]
        right = _operand(tokens[place + 1 :], "(", ")")
        whole = _difference(_line(left), _line(right))
        factors = [(name, factor) for name, factor in whole[0].items() if factor] if whole else []
        if whole and len(factors) == 1:
            ((name, factor),) = factors
            yield " ".join([*left, token, *right]), name, round(-whole[1] / factor, 9)


def _operand(tokens: Sequence[str], opens: str, closes: str) -> list[str]:
    """The leading tokens that are arithmetic or stand in brackets."""
    depth = 0

    def belongs(token: str) -> bool:
        nonlocal depth
        depth += (token == opens) - (token == closes)
        return depth > 0 or (depth == 0 and (token == closes or _is_arithmetic(token)))

    return list(takewhile(belongs, tokens))


def _is_arithmetic(token: str) -> bool:
    return token in _MARKS or token[0] in ".0123456789" or _is_name(token) or token in ARITHMETIC


def _is_name(token: str) -> bool:
    return (token[0].isalpha() or token[0] == "_") and token not in WORDS


_MARKS = "-+/*"
"""Operators from the lowest to the highest precedence."""
_Line = tuple[Mapping[str, float], float]
"""A linear expression: factor of each signal, and a constant."""


def _line(tokens: Sequence[str]) -> _Line | None:
    """Parse a linear expression; None for any other arithmetic."""
    for mark in _MARKS:
        place = _last(tokens, mark)
        if place:
            return _joined(mark, _line(tokens[:place]), _line(tokens[place + 1 :]))
    if len(tokens) == 1:
        (token,) = tokens
        return ({token: 1.0}, 0.0) if _is_name(token) else _number(token)
    if len(tokens) == 2 and tokens[0] == "-":
        return _number(tokens[1], -1.0)
    return _line(tokens[1:-1]) if tokens and tokens[0] == "(" and tokens[-1] == ")" else None


def _number(token: str, sign: float = 1.0) -> _Line | None:
    return ({}, sign * float(token)) if token[0] in ".0123456789" else None


def _last(tokens: Sequence[str], mark: str) -> int:
    """Index of the last `mark` between two operands outside brackets; 0 = none."""
    depth, last = 0, 0
    for place, token in enumerate(tokens):
        depth += (token == "(") - (token == ")")
        if token == mark and depth == 0 and place and tokens[place - 1] not in _MARKS:
            last = place
    return last


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
