"""How sure a detection is, in three steps that the page shades and marks."""

from __future__ import annotations

from scaloft_fi.analysis.score import MutantScore

STEPS = (1.0, 0.1, 0.001)
"""Parts of alpha; the p of a surer detection is at most the smaller ones."""
DIGITS = 3
"""Significant digits of the printed steps."""


def steps(alpha: float) -> list[float]:
    """The largest p of each step.

    >>> steps(0.01)
    [0.01, 0.001, 1e-05]
    """
    return [float(f"{alpha * part:.{DIGITS}g}") for part in STEPS]


def certainty(mutant: MutantScore, alpha: float) -> int:
    """How many steps the smallest p of the safety requirements that detect a mutant reaches; 0 where none does."""
    p = min((mutant.safety.p[name] for name in mutant.safety.by), default=None)
    return 0 if p is None else max(1, sum(p <= step for step in steps(alpha)))
