"""Signal temporal logic over sampled signals: text is checked here word by word and evaluated to robustness by RTAMT.

RTAMT (discrete time, 20 Hz) parses and evaluates.  What it lets pass in silence is refused here first: text after a
complete formula (it drops it), names nobody declared (it invents them), `a/3` without spaces (it reads one name),
intervals that run backwards (they evaluate to infinity).
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

LARGEST = 1e9
"""Robustness is cut off here: an infinite one (nothing was in the window) is no number of JSON."""

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
"""Samples by name of the signal, all of one length, 20 Hz."""


class FormulaError(ValueError):
    """The text is not a formula of the language; the message completes the sentence `file:line: name ...`."""


@dataclass(frozen=True)
class Formula:
    """A formula and what its names stand for.

    Attributes:
        text: the formula, as `person_range_m <= 3 and historically[0:2](speed_mps > 0.25)`.
        names: the signals it reads, sorted.
    """

    text: str
    names: tuple[str, ...]

    @classmethod
    def spelt(cls, text: str, signals: Collection[str]) -> Formula:
        """Check the words of `text` and the names in `signals`, and not how they are put together.

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
        """Check `text` against the language and the names in `signals`.

        Raises:
            FormulaError: it is not a formula over those signals; the message says what is wrong.
        """
        formula = cls.spelt(text, signals)
        try:
            _specification(formula.text, formula.names)
        except Exception as error:
            reason = " ".join(str(error).removeprefix("RTAMT Exception:").split())
            raise FormulaError(f"is not a formula (put sums and comparisons in brackets): {reason[:120]}") from error
        return formula

    def robustness(self, signals: Signals) -> list[float]:
        """Robustness at each sample, (T,); below 0 the formula is violated there.

        Args:
            signals: (T,) samples of at least the signals named, 20 Hz.

        Raises:
            ValueError: a sample is not finite, or the lengths differ.
        """
        columns = {name: _column(name, signals[name]) for name in self.names}
        lengths = {len(column) for column in columns.values()}
        if len(lengths) != 1:
            raise ValueError(f"signals of one formula differ in length: {sorted(lengths)}")
        (length,) = lengths
        if length < 2:  # RTAMT needs two samples; one is as good as the same one twice
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
        FormulaError: a character belongs to none of them.
    """
    tokens, at = [], 0
    text = text.strip()
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            near = text[at : at + 12].strip()
            raise FormulaError(
                f"has {near!r}; allowed: names, numbers, {', '.join(sorted(WORDS))}, -> < <= > >= + - * /"
            )
        tokens.append(match.group().strip())
        at = match.end()
    return tokens


def inside_always(text: str) -> str | None:
    """What stands in the brackets of `always( ... )`, or None when the text is not of that shape.

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
    """Times of the samples [s]: the same for all formulas of a flight."""
    return tuple(SAMPLE_MS / 1000 * place for place in range(length))


@contextmanager
def _silence() -> Iterator[None]:
    """RTAMT's parser logs to the root logger, which is no concern of the user's."""
    previous = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(previous)


@lru_cache(maxsize=256)
def _specification(text: str, names: tuple[str, ...]) -> Any:
    """The parsed formula, once a process."""
    with _silence():
        from scaloft_fi.judge import monitor

        return monitor.specification(text, names, SAMPLE_MS)
