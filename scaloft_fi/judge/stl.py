"""Formulas of signal temporal logic over the signals of a flight log: words, tree, parser, text, robustness.

Operators bind as in RTAMT (`BINDING`).  Where that is not what a reader expects, or readers expect different things,
the parser asks for brackets: `a - b + c`, `a / b * c`, `a < b < c`, `a implies b implies c`.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from itertools import accumulate, pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.errors import did_you_mean
from scaloft_fi.stack.declaration import TICK_S

SAMPLE_MS = round(1000 * TICK_S)
"""Sampling period of the flight log [ms]."""
LARGEST = 1e9
"""Greatest absolute robustness: the robustness of an empty window is infinite, which JSON cannot hold."""
PAST = frozenset({"historically", "once", "since"})
FUTURE = frozenset({"always", "eventually", "until"})
LOGIC = frozenset({"not", "and", "or", "implies", "iff"})
MEAN = "mean"
"""The word of the mean of a window of the past."""
ARITHMETIC = frozenset({"abs", "sqrt", MEAN})
"""Words whose operand stands in brackets: `mean[0:1](a) - b` is the mean less `b`."""
WORDS = PAST | FUTURE | LOGIC | ARITHMETIC
"""The words of a formula; every other name is a signal or a definition."""
CHANGES = ("rise", "fall", "prev")
"""Words of RTAMT with a bracket, which are names without one: comes true, comes to be false, was true a sample ago."""
EXTREMES = ("historically", "once", "always", "eventually")
"""Words of the worst or the best sample of a window of the past or the future."""
COMPARATORS = ("<", "<=", ">", ">=", "==")
BINDING: Sequence[tuple[str, ...]] = (
    ("*",),
    ("/",),
    ("+",),
    ("-",),
    COMPARATORS,
    ("until",),
    ("since",),
    ("and",),
    ("or",),
    ("implies", "->"),
    ("iff",),
)
"""The operators, those that bind strongest first; of equal ones the left binds first."""
LEVEL = {operator: len(BINDING) - place for place, operators in enumerate(BINDING) for operator in operators}
AFTER_WORD = LEVEL["<"]
"""Least level of an operator in the operand of `not`, `once` and the like: `not a > b` is `not (a > b)`."""
LONGEST, DEEPEST = 2_000, 20
"""Most characters of a formula and deepest brackets."""
LONGEST_S = 600
"""Longest interval [s]."""
MOST_NESTED = 200
"""Most operators inside one another; `a + b + c` counts as two."""
SHORT = 3
"""Words as short as `abs` are near to many names of signals."""
LISTED = "; `scaloft-fi signals` lists those there are"
_APART = {
    ("/", "*"): "a / b * c is read as a / (b * c)",
    ("-", "+"): "a - b + c is read as a - (b + c)",
    ("<", "<"): "a < b < c compares the robustness of a < b with c; for two limits write a < b and b < c",
    ("->", "->"): "a implies b implies c is read as (a implies b) implies c",
}
_ALIKE = dict.fromkeys(COMPARATORS, "<") | {"implies": "->"}
_WINDOWED = (*EXTREMES, MEAN, "since", "until")
_OF_TWO_TIMES = f"must be of two times in seconds, after {', '.join(_WINDOWED)}, as historically[0:2]( ... )"
_TOKEN = re.compile(
    r"\s*(?:(?P<name>[A-Za-z_]\w*)|"
    r"(?P<number>(?:[0-9]+\.?[0-9]*(?:[eE][-+]?[0-9]+)?|\.[0-9]+)(?:\s*[A-Za-z]+(?=\s*[:,\]]))?)|"
    r"(?P<mark>->|<=|>=|!==|!=|==|&&|\|\||[-+*/()<>\[\]:,&|!]))"
)
_UNITS_S = {"s": Fraction(1), "ms": Fraction(1, 1_000), "us": Fraction(1, 10**6), "ns": Fraction(1, 10**9)}
_TIME = re.compile(r"([0-9]+\.?[0-9]*|\.[0-9]+)([A-Za-z]+)?")
"""A time of an interval, with its unit; without one it is in seconds, as in RTAMT."""
_FUTURE = "refers to the future; use historically, once or since"
FOREIGN: Mapping[str, str] = {
    "xor": "RTAMT's is never below 0, so nothing violates it; write (a or b) and not (a and b)",
    "!==": "RTAMT's is never below 0, so nothing violates it; write a < b - margin or a > b + margin",
    "!=": "write a < b - margin or a > b + margin",
    **{word: f"write {word}(a)" for word in CHANGES},
    "next": _FUTURE,
    "weak": _FUTURE,
    "unless": _FUTURE,
    "&": "write and",
    "&&": "write and",
    "|": "write or",
    "||": "write or",
    "!": "write not",
}
"""Words and marks of RTAMT and others that are no formula here, each with its remedy."""


class RootError(ValueError):
    """A root of a negative number."""


class FormulaError(ValueError):
    """The text is not a formula of the language; the message continues `file:line: name ...`."""


def tokenize(text: str) -> list[str]:
    """Split `text` into names, numbers and marks.

    >>> tokenize("always(a/3<=1)")
    ['always', '(', 'a', '/', '3', '<=', '1', ')']

    Raises:
        FormulaError: a character belongs to no name, number or mark, or the text is too long or too deep.
    """
    tokens: list[str] = []
    at = depth = 0
    text = text.strip()
    if len(text) > LONGEST:
        raise FormulaError(f"must have at most {LONGEST:,} characters; name parts of it in definitions")
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            near = text[at : at + 12].strip()
            raise FormulaError(
                f"has {near!r}; allowed: names, numbers, {', '.join(sorted(WORDS))}, -> < <= > >= + - * /"
            )
        tokens.append("".join(match.group().split()))
        at = match.end()
        depth += (tokens[-1] == "(") - (tokens[-1] == ")")
        if depth > DEEPEST:
            raise FormulaError(f"has brackets more than {DEEPEST} deep; name parts of it in definitions")
    return tokens


def inside_always(text: str) -> str | None:
    """The text in the brackets of `always( ... )`; None if the text has another form.

    Raises:
        FormulaError: it begins so, and a bracket is missing or left over.

    >>> inside_always("always((a > 0) and (b > 0))")
    '( a > 0 ) and ( b > 0 )'
    >>> inside_always("always(a > 0) and (b > 0)")
    """
    tokens = tokenize(text)
    if tokens[:2] != ["always", "("]:
        return None
    depth = tokens.count("(") - tokens.count(")")
    if depth:
        flaw = f"lacks {')' * depth!r}" if depth > 0 else f"has {')' * -depth!r} too many"
        raise FormulaError(f"has brackets that do not match: it {flaw}")
    if tokens[-1] != ")":
        return None
    for position, token in enumerate(tokens):
        depth += (token == "(") - (token == ")")
        if depth == 0 and 0 < position < len(tokens) - 1:
            return None
    return " ".join(tokens[2:-1])


def is_name(token: str) -> bool:
    """Whether a token is the name of a signal or a definition."""
    return (token[:1].isalpha() or token[:1] == "_") and token not in WORDS


@dataclass(frozen=True, slots=True)
class Signal:
    """The samples of a signal, or the robustness of a definition."""

    name: str


@dataclass(frozen=True, slots=True)
class Number:
    """The same number at each sample."""

    value: float


@dataclass(frozen=True, slots=True)
class Interval:
    """Nearest and farthest sample of a window, counted from the present one, both included."""

    first: int
    last: int


@dataclass(frozen=True, slots=True)
class Prefix:
    """`not`, `abs`, `sqrt`, `rise` or `fall` of each sample, or the worst, best or mean sample of a window.

    The worst and the best are those of `EXTREMES`; without an interval their window reaches to the flight's end.
    """

    word: str
    of: Node
    interval: Interval | None = None


@dataclass(frozen=True, slots=True)
class Infix:
    """An operator of `BINDING` between two parts; the robustness of a comparison is the margin between its sides.

    `since`, `until`: `right` holds at a sample of the window, and `left` at every sample between it and now.
    """

    operator: str
    left: Node
    right: Node
    interval: Interval | None = None


Node = Signal | Number | Prefix | Infix
"""A part of a formula's syntax tree; every part has a robustness at each sample."""


def parts(node: Node) -> tuple[Node, ...]:
    """The parts of a node, none to two."""
    if isinstance(node, Prefix):
        return (node.of,)
    return (node.left, node.right) if isinstance(node, Infix) else ()


def apart(left: str, right: str) -> str | None:
    """The reason why two operators, `left` before `right` in the text, need brackets; None where they need none."""
    return _APART.get((_ALIKE.get(left, left), _ALIKE.get(right, right)))


def parse(tokens: Sequence[str]) -> Node:
    """The syntax tree of a formula, by precedence climbing.

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
    level, depth = [node], -1
    while level:
        depth += 1
        if depth > MOST_NESTED:
            raise _too_deep()
        level = [part for inner in level for part in parts(inner)]
    return node


def _check_constants(node: Node) -> bool:
    """Whether a part reads no signal; a FormulaError says which such part has no value."""
    constant = [_check_constants(part) for part in parts(node)]
    tried = node
    if isinstance(node, Infix) and node.operator == "/" and constant[1]:
        tried = Infix("/", Number(1.0), node.right)
    elif isinstance(node, Signal) or not all(constant):
        return False
    try:
        robustness(tried, {"": [0.0]})
    except ZeroDivisionError:
        raise FormulaError(f"divides by 0 in '{written(node)}'") from None
    except RootError:
        raise FormulaError(f"has a root of a negative number in '{written(node)}'") from None
    return all(constant)


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
        return self._wrong(f"{', '.join(LEVEL)}, ')', the end")

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
        while LEVEL.get(self.token, -1) >= level:
            operator = self.token
            for left in (outside, before):
                if reason := apart(left, operator):
                    raise FormulaError(f"needs brackets at {operator!r} {self.place}: {reason}")
            self._take()
            interval = self._interval(operator)
            right = self.expression(LEVEL[operator] + 1, operator)
            node = Infix("implies" if operator == "->" else operator, node, right, interval)
            before = operator
        self._nested -= 1
        return node

    def _operand(self) -> Node:
        token = self.token
        if token in CHANGES and self._tokens[self._at + 1 : self._at + 2] == ["("]:
            self._take()
            of = self._bracketed()
            if token != "prev":
                return Prefix(token, of)
            if LEVEL.get(self.token, -1) >= AFTER_WORD:  # RTAMT reads its operand as that of `not`
                read = f"prev(a) {self.token} b is read as prev(a {self.token} b)"
                raise FormulaError(f"needs brackets at {self.token!r} {self.place}: {read}")
            return Prefix("historically", of, Interval(1, 1))
        if is_name(token):
            return Signal(self._take())
        if token[:1] in _DIGITS:
            return Number(self._number())
        if token == "(":
            return self._bracketed()
        if token == "-":
            self._take()
            if self.token[:1] not in _DIGITS:
                raise self._wrong("a number; the negative of a signal is 0 - signal")
            return Number(-self._number())
        if token in ARITHMETIC:
            place = self.place
            self._take()
            interval = self._interval(token)
            if token == MEAN and (interval is None or interval.first or not interval.last):
                raise FormulaError(f"has a mean {place} without a window from 0 to a later time, as mean[0:2]( ... )")
            if self.token != "(":
                raise self._wrong("'('")
            return Prefix(token, self._bracketed(), interval)
        if token == "not" or token in EXTREMES:
            self._take()
            interval = self._interval(token)
            return Prefix(token, self.expression(AFTER_WORD, token), interval)
        raise self._wrong(f"a signal, a number, '(', {', '.join((*sorted(ARITHMETIC), 'not', *EXTREMES))}")

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

    def _number(self) -> float:
        try:
            value = float(self.token)
        except ValueError:
            raise self._wrong("a number; only the times of an interval have a unit") from None
        if math.isinf(value):
            raise FormulaError(f"has the number {self.token} {self.place}, which must be at most 1e308")
        self._take()
        return value

    def _interval(self, operator: str) -> Interval | None:
        """Read the interval of an operator; None without one."""
        if operator not in _WINDOWED or self.token != "[":
            return None
        _, first, between, last, closing = (*self._tokens[self._at : self._at + 5], *[""] * 4)[:5]
        times = [_TIME.fullmatch(time) for time in (first, last)]
        if between not in (":", ",") or closing != "]" or None in times:
            raise FormulaError(f"has an interval {self.place} that {_OF_TWO_TIMES}")
        told = [(Fraction(time[1]), time[2]) for time in times if time]
        if unknown := [unit for _, unit in told if unit and unit not in _UNITS_S]:
            allowed = f"a time has {', '.join(_UNITS_S)}, or none, which is s"
            raise FormulaError(f"has an interval {self.place} with the unit {unknown[0]!r}; {allowed}")
        if len({unit for time, unit in told if time}) > 1 and not all(unit for time, unit in told if time):
            raise FormulaError(f"has an interval {self.place} with one unit; give the unit of both times, or of none")
        self._at += 5
        first_s, last_s = (time * _UNITS_S[unit or "s"] for time, unit in told)
        return _samples(f"{operator}[{first}{between}{last}]", first_s, last_s)

    def _take(self) -> str:
        self._at += 1
        return self._tokens[self._at - 1]

    def _wrong(self, allowed: str) -> FormulaError:
        what = f"has {self.token!r}" if self.token else "ends"
        return FormulaError(f"is not a formula: it {what} {self.place}, where is allowed: {allowed}")


_DIGITS = frozenset("0123456789.")


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


def _too_deep() -> FormulaError:
    return FormulaError(f"has more than {MOST_NESTED} operators inside one another; name parts of it in definitions")


def written(node: Node) -> str:
    """The text of a tree, with no more brackets than it needs; `parse` reads the same tree from it.

    >>> written(Infix("<", Infix("/", Signal("a"), Number(2.0)), Prefix("abs", Signal("b"))))
    'a / 2 < abs(b)'
    """
    if isinstance(node, Signal):
        return node.name
    if isinstance(node, Number):
        return f"{node.value:g}" if float(f"{node.value:g}") == node.value else repr(node.value)
    window = node.interval
    times = f"[{window.first * SAMPLE_MS / 1000:g}:{window.last * SAMPLE_MS / 1000:g}]" if window else ""
    if isinstance(node, Prefix):
        return f"{node.word}{times}{' ' * (node.word == 'not')}({written(node.of)})"
    return f"{_side(node.operator, node.left)} {node.operator}{times} {_side(node.operator, node.right, right=True)}"


def _side(operator: str, side: Node, *, right: bool = False) -> str:
    """The text of an operand of `operator`, in brackets where it would be read otherwise without them."""
    loose = True
    if isinstance(side, Infix):
        pair = (operator, side.operator) if right else (side.operator, operator)
        loose = LEVEL[side.operator] >= LEVEL[operator] + right and apart(*pair) is None
    elif isinstance(side, Prefix) and side.word not in (*ARITHMETIC, *CHANGES):
        loose = LEVEL[operator] < AFTER_WORD
    return written(side) if loose else f"({written(side)})"


Column = NDArray[np.float64]
"""(T,) numbers, one for each sample.

The functions below are the plain definitions over whole arrays.  Of two equal numbers (0.0 and -0.0) and beside a
number that is none, the one stands that Python's `min` and `max` would return over the samples in the order of time.
"""


def robustness(node: Node, signals: Mapping[str, Any], largest: float = LARGEST) -> list[float]:
    """The robustness of a tree at each sample, (T,), from -`largest` to `largest`.

    Args:
        node: the tree.
        signals: (T,) samples of each signal in the tree.
        largest: stands for an infinite robustness, which is that of an empty window.

    Raises:
        ValueError: a sample is not finite, or the lengths differ or are 0.
        ZeroDivisionError: a divisor is 0.
        RootError: a root is of a negative number.
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
    if isinstance(node, Signal):
        return columns[node.name]
    if isinstance(node, Number):
        return np.full(length, node.value)
    if not isinstance(node, Infix):
        values = _evaluate(node.of, columns, length)
        if node.word == MEAN and node.interval:
            return mean(values, node.interval.last)
        return _window(node.word, values, node.interval) if node.word in EXTREMES else _FUNCTION[node.word](values)
    left, right = _evaluate(node.left, columns, length), _evaluate(node.right, columns, length)
    if node.operator in ("since", "until"):
        way = 1 if node.operator == "since" else -1
        return _since(left[::way], right[::way], node.interval)[::way]
    return _INFIX[node.operator](left, right)


def _less(first: Column, second: Column) -> Column:
    return np.where(second < first, second, first)


def _greater(first: Column, second: Column) -> Column:
    return np.where(second > first, second, first)


def _root(values: Column) -> Column:
    if (values < 0).any():
        raise RootError(f"sqrt of {values[values < 0][0]:g} at sample {np.argmax(values < 0)}")
    return np.sqrt(values)


def _quotient(left: Column, right: Column) -> Column:
    if (right == 0).any():
        raise ZeroDivisionError(f"division by 0 at sample {np.argmax(right == 0)}")
    return left / right


def _before(values: Column, at_first: float) -> Column:
    return np.concatenate(([at_first], values[:-1]))


_FUNCTION: Mapping[str, Callable[[Column], Column]] = {
    "not": np.negative,
    "abs": np.abs,
    "sqrt": _root,
    "rise": lambda values: _less(-_before(values, -np.inf), values),
    "fall": lambda values: _less(_before(values, np.inf), -values),
}
_INFIX: Mapping[str, Callable[[Column, Column], Column]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": _quotient,
    "<": lambda left, right: right - left,
    "<=": lambda left, right: right - left,
    ">": np.subtract,
    ">=": np.subtract,
    "==": lambda left, right: -np.abs(left - right),
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


def mean(values: Column, last: int) -> Column:
    """The mean of each sample and the `last` before it (T,), of fewer at the beginning; in the unit of the samples.

    The samples are equally far apart in time, so each weighs the same.  Taking them in one by one keeps every mean
    between the least and the greatest sample, to the bit, which a quotient of sums does not.  Source: Welford, "Note on
    a method for calculating corrected sums of squares and products", Technometrics 4, 1962.
    """
    means = values.copy()
    for lag in range(1, min(last, len(values) - 1) + 1):
        means[lag:] += (values[:-lag] - means[lag:]) / (lag + 1)
    return means


def _so_far(values: Column, worst: bool) -> Column:
    """The extreme of each sample and all before it; of equal ones the latest."""
    kept = operator.lt if worst else operator.gt
    return np.array(list(accumulate(values.tolist(), lambda before, now: before if kept(before, now) else now)))


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


class Samples(Protocol):
    """Samples of a signal, (T,): a list or an array of numbers."""

    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Any]: ...
    def __getitem__(self, place: int, /) -> Any: ...


Signals = Mapping[str, Samples]
"""Samples by name of the signal, all of the same length, 20 Hz."""


@dataclass(frozen=True)
class Formula:
    """A formula over signals.

    Attributes:
        text: the formula, such as `person_range_m <= 3 and historically[0:2](speed_mps > 0.25)`.
        names: names of the signals in the formula, sorted.
        tree: its syntax tree.
    """

    text: str
    names: tuple[str, ...]
    tree: Node = field(repr=False, compare=False)

    @classmethod
    def parse(cls, text: str, signals: Collection[str]) -> Formula:
        """Parse `text` as a formula over `signals`.

        Raises:
            FormulaError: the text is not a formula over these signals; the message says what is wrong.
        """
        tokens = tokenize(text)
        names = [token for token, after in pairwise((*tokens, "")) if not (token in CHANGES and after == "(")]
        for token in names:
            if token in FOREIGN and token not in signals:
                raise FormulaError(f"has {token!r}, which is no word or mark here: {FOREIGN[token]}")
        used = [token for token in names if is_name(token)]
        for name in used:
            if name not in signals:
                near = did_you_mean(name, [*signals, *(word for word in WORDS if len(word) > SHORT)])
                raise FormulaError(f"names the unknown signal {name!r}{near or LISTED}")
        if not used:
            raise FormulaError("reads no signal")
        spaced = " ".join(tokens)
        return cls(spaced, tuple(sorted(set(used))), _tree(spaced))

    def robustness(self, signals: Signals) -> list[float]:
        """Robustness at each sample, (T,); a sample below 0 violates the formula.

        Args:
            signals: (T,) samples of at least the signals in `names`, 20 Hz.

        Raises:
            ValueError: a sample is not finite, the lengths differ or are 0, or a root is of a negative number.
            ZeroDivisionError: a divisor is 0.
        """
        return robustness(self.tree, {name: signals[name] for name in self.names})


@lru_cache(maxsize=256)
def _tree(text: str) -> Node:
    """The tree of a text, once per process."""
    tree = parse(text.split(" "))
    _check_constants(tree)
    return tree
