"""Signal temporal logic over sampled signals: this module checks the words of a formula, RTAMT evaluates robustness.

RTAMT (discrete time, 20 Hz) parses and evaluates.  Some errors pass RTAMT in silence; this module refuses them first:
text after a complete formula (RTAMT drops it), undeclared names (RTAMT declares them), `a/3` without spaces (RTAMT
reads one name), intervals that end before they begin (RTAMT evaluates them to infinity).
"""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

from scaloft_fi.errors import did_you_mean
from scaloft_fi.stack.rates import TICK_S

SAMPLE_MS = round(1000 * TICK_S)
"""Sampling period of the flight log [ms]."""

PAST = frozenset({"historically", "once", "since"})
FUTURE = frozenset({"always", "eventually", "until"})
LOGIC = frozenset({"not", "and", "or", "implies", "iff"})
ARITHMETIC = frozenset({"abs", "sqrt"})
WORDS = PAST | FUTURE | LOGIC | ARITHMETIC
"""The words of a formula; every other name is a signal or a definition."""

LONGEST, DEEPEST, LONGEST_S = 2_000, 20, 600
"""Most characters of a formula, deepest brackets and longest interval [s]: the time of RTAMT grows with each."""

LARGEST = 1e9
"""Greatest absolute robustness: the robustness of an empty window is infinite, which JSON cannot hold."""

_TOKEN = re.compile(
    r"\s*(?:(?P<name>[A-Za-z_]\w*)|(?P<number>\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+)|(?P<mark>->|<=|>=|[-+*/()<>\[\]:]))"
)
_INTERVAL = re.compile(r"(historically|once|since|always|eventually|until) \[ ([\d.]+) : ([\d.]+) \]")


class Samples(Protocol):
    """Samples of a signal, (T,): a list or an array of numbers."""

    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Any]: ...
    def __getitem__(self, place: int, /) -> Any: ...


Signals = Mapping[str, Samples]
"""Samples by name of the signal, all of the same length, 20 Hz."""


class FormulaError(ValueError):
    """The text is not a formula of the language; the message continues `file:line: name ...`."""


@dataclass(frozen=True)
class Formula:
    """A formula over signals.

    Attributes:
        text: the formula, such as `person_range_m <= 3 and historically[0:2](speed_mps > 0.25)`.
        names: names of the signals in the formula, sorted.
    """

    text: str
    names: tuple[str, ...]

    @classmethod
    def unparsed(cls, text: str, signals: Collection[str]) -> Formula:
        """Check words, names, brackets and intervals of `text`, but not its grammar, which would start RTAMT.

        Raises:
            FormulaError: a word, a name, a bracket or an interval is wrong; the message says which.
        """
        tokens = tokenize(text)
        used = [token for token in tokens if _is_name(token) and token not in WORDS]
        for name in used:
            if name not in signals:
                raise FormulaError(f"names the unknown signal {name!r}{did_you_mean(name, [*signals, *WORDS])}")
        if not used:
            raise FormulaError("reads no signal")
        _check_nesting(tokens)
        spaced = " ".join(tokens)
        _check_intervals(spaced)
        return cls(spaced, tuple(sorted(set(used))))

    @classmethod
    def parse(cls, text: str, signals: Collection[str]) -> Formula:
        """Parse `text` as a formula over `signals`.

        Raises:
            FormulaError: the text is not a formula over these signals; the message says what is wrong.
        """
        formula = cls.unparsed(text, signals)
        try:
            _specification(formula.text, formula.names)
        except Exception as error:
            reason = " ".join(str(error).removeprefix("RTAMT Exception:").split())
            raise FormulaError(f"is not a formula (put sums and comparisons in brackets): {reason[:120]}") from error
        return formula

    @property
    def tree(self) -> Any:
        """The root of RTAMT's syntax tree of a formula that `parse` has read."""
        return _specification(self.text, self.names).ast.specs[0]

    def robustness(self, signals: Signals) -> list[float]:
        """Robustness at each sample, (T,); a sample below 0 violates the formula.

        Args:
            signals: (T,) samples of at least the signals in `names`, 20 Hz.

        Raises:
            ValueError: a sample is not finite, or the lengths differ.
        """
        columns = {name: _column(name, signals[name]) for name in self.names}
        lengths = {len(column) for column in columns.values()}
        if len(lengths) != 1:
            raise ValueError(f"signals of one formula differ in length: {sorted(lengths)}")
        (length,) = lengths
        if length < 2:  # RTAMT needs at least two samples, so a single sample is repeated
            columns = {name: column * 2 for name, column in columns.items()}
        times = _times_s(max(2, length))
        pairs = _specification(self.text, self.names).evaluate({"time": times, **columns})[:length]
        values = [float(value) for _, value in pairs]
        if math.isfinite(sum(values)) and min(values) >= -LARGEST and max(values) <= LARGEST:
            return values
        return [min(LARGEST, max(-LARGEST, value)) for value in values]


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
        tokens.append(match.group().strip())
        at = match.end()
        depth += (tokens[-1] == "(") - (tokens[-1] == ")")
        if depth > DEEPEST:
            raise FormulaError(f"has brackets more than {DEEPEST} deep; name parts of it in definitions")
    return tokens


def inside_always(text: str) -> str | None:
    """The text in the brackets of `always( ... )`; None if the text has another form.

    >>> inside_always("always((a > 0) and (b > 0))")
    '( a > 0 ) and ( b > 0 )'
    >>> inside_always("always(a > 0) and (b > 0)")
    """
    tokens = tokenize(text)
    if tokens[:2] != ["always", "("] or tokens[-1] != ")":
        return None
    depth = 0
    for position, token in enumerate(tokens):
        depth += (token == "(") - (token == ")")
        if depth == 0 and position > 0 and position < len(tokens) - 1:
            return None
    return " ".join(tokens[2:-1])


def _is_name(token: str) -> bool:
    return token[0].isalpha() or token[0] == "_"


def _check_nesting(tokens: Sequence[str]) -> None:
    depth = 0
    for token in tokens:
        depth += (token == "(") - (token == ")")
        if depth < 0:
            break
    if depth:
        raise FormulaError("has brackets that do not match")


def _check_intervals(spaced: str) -> None:
    intervals = _INTERVAL.findall(spaced)
    if len(intervals) != spaced.count("["):
        raise FormulaError("has an interval that must be of two times in seconds, as historically[0:2]( ... )")
    for operator, *bounds in intervals:
        low, high = (float(bound) * 1000 / SAMPLE_MS for bound in bounds)
        shown = f"{operator}[{bounds[0]}:{bounds[1]}]"
        if any(abs(bound - round(bound)) > 1e-6 for bound in (low, high)):
            raise FormulaError(f"has {shown}, which must be of two times that are multiples of {SAMPLE_MS / 1000:g} s")
        if high > 1000 * LONGEST_S / SAMPLE_MS:
            raise FormulaError(f"has {shown}, which must end within {LONGEST_S} s; without times it has no end")
        if low > high:
            raise FormulaError(f"has {shown}, which must not end before it begins")


def _column(name: str, samples: Any) -> list[float]:
    column: list[float] = samples.tolist() if hasattr(samples, "tolist") else list(samples)
    if not all(map(math.isfinite, column)):
        place, value = next((place, value) for place, value in enumerate(column) if not math.isfinite(value))
        raise ValueError(f"signal {name} is {value} at sample {place}")
    return column


@lru_cache(maxsize=8)
def _times_s(length: int) -> tuple[float, ...]:
    """Times of the samples [s], shared by all formulas of a flight."""
    return tuple(SAMPLE_MS / 1000 * place for place in range(length))


@contextmanager
def _silence() -> Iterator[None]:
    """Silence the root logger, to which RTAMT's parser writes."""
    previous = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(previous)


@lru_cache(maxsize=256)
def _specification(text: str, names: tuple[str, ...]) -> Any:
    """The parsed formula, once per process."""
    with _silence():
        from scaloft_fi.judge import monitor

        return monitor.specification(text, names, SAMPLE_MS)
