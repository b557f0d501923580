"""The limits that requirements set to signals, read from their formulas, to be drawn where the signals are."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from typing import Any

from scaloft_fi.judge.requirement import Requirement

COMPARISON = re.compile(
    r"(?P<signal>[A-Za-z_]\w*)\s*(?:/\s*(?P<unit>\d+(?:\.\d+)?)\s*)?(?P<sense><=|>=|<|>)\s*(?P<bound>-?\d+(?:\.\d+)?)"
)


def limits(requirements: Iterable[Requirement], signals: Collection[str]) -> list[dict[str, Any]]:
    """Each comparison of one of `signals` with a number; role: `demands`, or `when` the requirement applies.

    A signal that is divided by a number first, as formulas that join units do, has its limit in its own unit.
    """
    limits: list[dict[str, Any]] = []
    for requirement in requirements:
        when = [requirement.trigger, *(text for _, text in requirement.definitions)]
        for role, texts in (("demands", [requirement.text]), ("when", when)):
            for signal, sense, bound in (entry for text in texts for entry in _comparisons(text)):
                entry = {
                    "signal": signal,
                    "sense": sense,
                    "bound": bound,
                    "role": role,
                    "requirement": requirement.name,
                }
                if signal in signals and entry not in limits:
                    limits.append(entry)
    return limits


def _comparisons(text: str) -> Iterator[tuple[str, str, float]]:
    for match in COMPARISON.finditer(text):
        yield match["signal"], match["sense"], bound_of(match)


def bound_of(match: re.Match[str]) -> float:
    """The bound of a comparison, in its signal's own unit."""
    return round(float(match["bound"]) * float(match["unit"] or 1), 9)
