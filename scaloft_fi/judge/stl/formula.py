"""A formula of signal temporal logic over the signals of a flight log."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Protocol

from scaloft_fi.errors import did_you_mean
from scaloft_fi.judge.stl.parse import parse
from scaloft_fi.judge.stl.tree import Node
from scaloft_fi.judge.stl.words import WORDS, FormulaError, is_name, tokenize

LARGEST = 1e9
"""Greatest absolute robustness: the robustness of an empty window is infinite, which JSON cannot hold."""


class Samples(Protocol):
    """Samples of a signal, (T,): a list or an array of numbers."""

    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Any]: ...
    def __getitem__(self, place: int, /) -> Any: ...


Signals = Mapping[str, Samples]
"""Samples by name of the signal, all of the same length, 20 Hz."""

SHORT = 3
"""Words as short as `abs` are near to many names of signals."""
LISTED = "; `scaloft-fi signals` lists those there are"


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
        used = [token for token in tokens if is_name(token)]
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
        from scaloft_fi.judge.stl.evaluate import robustness

        return robustness(self.tree, {name: signals[name] for name in self.names}, LARGEST)


@lru_cache(maxsize=256)
def _tree(text: str) -> Node:
    """The tree of a text, once per process."""
    return parse(text.split(" "))
