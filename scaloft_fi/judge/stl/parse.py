"""The parser of formulas: precedence climbing over the tokens.

Operators bind as in RTAMT (`BINDING`).  Where that is not what a reader expects, or readers expect
different things, the parser asks for brackets: `a - b + c`, `a / b * c`, `a < b < c`, `a implies b implies c`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, get_args

from scaloft_fi.judge.stl.tree import (
    SAMPLE_MS,
    Arithmetic,
    Comparator,
    Comparison,
    Extreme,
    Function,
    Hold,
    Interval,
    Logic,
    Node,
    Number,
    Sign,
    Signal,
    Window,
    parts,
)
from scaloft_fi.judge.stl.words import ARITHMETIC, FormulaError, is_name, is_number

LONGEST_S = 600
"""Longest interval [s]."""
MOST_NESTED = 200
"""Most operators inside one another; `a + b + c` counts as two."""

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
"""The operators between two operands, those that bind strongest first; of equal ones the left binds first."""
_LEVEL = {operator: len(BINDING) - place for place, operators in enumerate(BINDING) for operator in operators}
_EXTREMES = get_args(Extreme)
_AFTER_WORD = _LEVEL["<"]
"""Least level of an operator in the operand of `not`, `once` and the like: `not a > b` is `not (a > b)`."""
_WINDOWED = (*_EXTREMES, "since", "until")
_APART = {
    ("/", "*"): "a / b * c is read as a / (b * c)",
    ("-", "+"): "a - b + c is read as a - (b + c)",
    ("<", "<"): "a < b < c compares the robustness of a < b with c; for two limits write a < b and b < c",
    ("->", "->"): "a implies b implies c is read as (a implies b) implies c",
}
"""Pairs of operators that need brackets, in the order of the text; each with the reason."""
_ALIKE = dict.fromkeys(get_args(Comparator), "<") | {"implies": "->"}
_DIGITS = frozenset("0123456789.")


def parse(tokens: Sequence[str]) -> Node:
    """The syntax tree of a formula.

    Args:
        tokens: of the formula, as `tokenize` splits it.

    Raises:
        FormulaError: the tokens are no formula; the message says where, and what is allowed there.
    """
    reader = _Reader(tokens)
    node = reader.expression(0, "")
    if reader.token == ")":
        raise FormulaError(f"has brackets that do not match: ')' {reader.place} closes none")
    if reader.token:
        raise reader.unexpected()
    _check_depth(node)
    return node


class _Reader:
    """Tokens, and how many of them are read."""

    def __init__(self, tokens: Sequence[str]) -> None:
        self._tokens, self._at, self._nested = tokens, 0, 0

    @property
    def token(self) -> str:
        """The next token; empty at the end."""
        return self._tokens[self._at] if self._at < len(self._tokens) else ""

    @property
    def place(self) -> str:
        """Where the next token stands."""
        before = self._tokens[max(0, self._at - 4) : self._at]
        return f"after '{'... ' if self._at > 4 else ''}{' '.join(before)}'" if before else "at the beginning"

    def unexpected(self) -> FormulaError:
        """The error of a token after a complete operand."""
        if self.token == "[":
            return FormulaError(f"has an interval {self.place}; an interval {_OF_TWO_TIMES}")
        return self._wrong(f"{', '.join(_LEVEL)}, ')', the end")

    def expression(self, level: int, outside: str) -> Node:
        """Read an operand and the operators after it that bind at least as strongly as `level`.

        Args:
            level: least level.
            outside: the operator before, whose operand this is; empty without one.
        """
        self._nested += 1
        if self._nested > MOST_NESTED:
            raise _too_deep()
        node, before = self._operand(), ""
        while _LEVEL.get(self.token, -1) >= level:
            operator = self.token
            for left in (outside, before):
                reason = _APART.get((_ALIKE.get(left, left), _ALIKE.get(operator, operator)))
                if reason:
                    raise FormulaError(f"needs brackets at {operator!r} {self.place}: {reason}")
            self._take()
            interval = self._interval(operator)
            node = _joined(operator, node, self.expression(_LEVEL[operator] + 1, operator), interval)
            before = operator
        self._nested -= 1
        return node

    def _operand(self) -> Node:
        if is_name(self.token):
            return Signal(self._take())
        if is_number(self.token):
            return Number(self._number())
        if self.token == "(":
            return self._bracketed()
        if self.token == "-":
            return self._negative()
        if self.token in ARITHMETIC:
            word: Any = self._take()
            if self.token != "(":
                raise self._wrong("'('")
            return Function(word, self._bracketed())
        if self.token == "not":
            return Function("not", self.expression(_AFTER_WORD, self._take()))
        if self.token in _EXTREMES:
            extreme: Any = self._take()
            interval = self._interval(extreme)
            return Window(extreme, self.expression(_AFTER_WORD, extreme), interval)
        raise self._wrong(f"a signal, a number, '(', {', '.join((*sorted(ARITHMETIC), 'not', *_EXTREMES))}")

    def _bracketed(self) -> Node:
        opened = self.place
        self._take()
        node = self.expression(0, "")
        if not self.token:
            raise FormulaError(f"has brackets that do not match: '(' {opened} is not closed")
        if self.token != ")":
            raise self.unexpected()
        self._take()
        return node

    def _negative(self) -> Number:
        self._take()
        if not is_number(self.token):
            raise self._wrong("a number; the negative of a signal is 0 - signal")
        return Number(-self._number())

    def _number(self) -> float:
        value = float(self.token)
        if math.isinf(value):
            raise FormulaError(f"has the number {self.token} {self.place}, which must be at most 1e308")
        self._take()
        return value

    def _interval(self, operator: str) -> Interval | None:
        """Read the interval of an operator; None without one."""
        if operator not in _WINDOWED or self.token != "[":
            return None
        _, first, colon, last, closing = (*self._tokens[self._at : self._at + 5], *[""] * 4)[:5]
        if colon != ":" or closing != "]" or not (_is_time(first) and _is_time(last)):
            raise FormulaError(f"has an interval {self.place} that {_OF_TWO_TIMES}")
        self._at += 5
        return _samples(f"{operator}[{first}:{last}]", Fraction(first), Fraction(last))

    def _take(self) -> str:
        self._at += 1
        return self._tokens[self._at - 1]

    def _wrong(self, allowed: str) -> FormulaError:
        what = f"has {self.token!r}" if self.token else "ends"
        return FormulaError(f"is not a formula: it {what} {self.place}, where is allowed: {allowed}")


_OF_TWO_TIMES = f"must be of two times in seconds, after {', '.join(_WINDOWED)}, as historically[0:2]( ... )"


def _is_time(token: str) -> bool:
    return bool(token) and _DIGITS.issuperset(token)


def _samples(shown: str, first_s: Fraction, last_s: Fraction) -> Interval:
    """The interval in samples; `shown` is the interval in messages."""
    first, last = (time_s * 1000 / SAMPLE_MS for time_s in (first_s, last_s))
    if first.denominator != 1 or last.denominator != 1:
        raise FormulaError(f"has {shown}, which must be of two times that are multiples of {SAMPLE_MS / 1000:g} s")
    if last_s > LONGEST_S:
        raise FormulaError(f"has {shown}, which must end within {LONGEST_S} s; without times it has no end")
    if first > last:
        raise FormulaError(f"has {shown}, which must not end before it begins")
    return Interval(int(first), int(last))


def _joined(operator: Any, left: Node, right: Node, interval: Interval | None) -> Node:
    if operator in get_args(Sign):
        return Arithmetic(operator, left, right)
    if operator in get_args(Comparator):
        return Comparison(operator, left, right)
    if operator in ("since", "until"):
        return Hold(operator, left, right, interval)
    return Logic("implies" if operator == "->" else operator, left, right)


def _check_depth(node: Node) -> None:
    level, depth = [node], 0
    while level:
        level = [part for inner in level for part in parts(inner)]
        depth += 1
        if depth > MOST_NESTED + 1:
            raise _too_deep()


def _too_deep() -> FormulaError:
    return FormulaError(f"has more than {MOST_NESTED} operators inside one another; name parts of it in definitions")
