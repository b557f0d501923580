"""Samples of messages as short texts, and an operator's example as one line for each poll."""

from __future__ import annotations

from typing import Any

import numpy as np

from scaloft_fi.mutants.operator import Operator

NOTHING = "nothing"
MOST_NUMBERS = 8
"""Arrays with more numbers are told by their shape and the first row."""


def sample_text(sample: Any) -> str:
    """A sample by its fields; `nothing` where none is sent.

    >>> from scaloft_fi.mutants.sample import Reading
    >>> sample_text(Reading(0.05, 1.0)), sample_text(None)
    ('stamp_s=0.05, value=1', 'nothing')
    """
    if sample is None:
        return NOTHING
    return ", ".join(f"{name}={_value(value)}" for name, value in zip(sample._fields, sample, strict=True))


def _value(value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, int | float | np.number):
        return f"{float(value) + 0.0:.4g}"  # -0.0 + 0.0 is 0.0
    if isinstance(value, np.ndarray):
        if value.size <= MOST_NUMBERS:
            return f"[{', '.join(map(_value, value.tolist()))}]"
        first = f"[{', '.join(map(_value, np.atleast_2d(value)[0].tolist()[:MOST_NUMBERS]))}]"
        return f"{' x '.join(map(str, value.shape))}, first row {first}"
    if hasattr(value, "_fields"):
        return f"({sample_text(value)})"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return str(value)


def example_of(operator: Operator) -> list[dict[str, Any]]:
    """The polls of an operator's example: time [s], what is sent, what arrives; of a random operator one draw."""
    example = operator.example
    tap = operator.tap(example.context(), example.arguments)
    polls = ((place / example.rate_hz, sample) for place, sample in enumerate(example.before))
    return [
        {"t_s": round(t_s, 6), "sent": sample_text(sample), "arrives": sample_text(tap(t_s, sample))}
        for t_s, sample in polls
    ]
