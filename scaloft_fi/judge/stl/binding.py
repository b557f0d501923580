"""How strongly the operators between two operands bind, and where brackets must say it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import get_args

from scaloft_fi.judge.stl.tree import Comparator

BINDING: Sequence[tuple[str, ...]] = (
    ("*",),
    ("/",),
    ("+",),
    ("-",),
    get_args(Comparator),
    ("until",),
    ("since",),
    ("and",),
    ("or",),
    ("implies", "->"),
    ("iff",),
)
"""The operators, those that bind strongest first; of equal ones the left binds first."""
LEVEL: Mapping[str, int] = {
    operator: len(BINDING) - place for place, operators in enumerate(BINDING) for operator in operators
}
AFTER_WORD = LEVEL["<"]
"""Least level of an operator in the operand of `not`, `once` and the like: `not a > b` is `not (a > b)`."""
_APART = {
    ("/", "*"): "a / b * c is read as a / (b * c)",
    ("-", "+"): "a - b + c is read as a - (b + c)",
    ("<", "<"): "a < b < c compares the robustness of a < b with c; for two limits write a < b and b < c",
    ("->", "->"): "a implies b implies c is read as (a implies b) implies c",
}
_ALIKE = dict.fromkeys(get_args(Comparator), "<") | {"implies": "->"}


def apart(left: str, right: str) -> str | None:
    """The reason why two operators, `left` before `right` in the text, need brackets; None where they need none."""
    return _APART.get((_ALIKE.get(left, left), _ALIKE.get(right, right)))
