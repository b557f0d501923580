"""Robustness for tables and records: only of what was put to the test."""

from __future__ import annotations

from scaloft_fi.judge.requirement import Reading


def measured_rho(reading: Reading) -> float | None:
    """The robustness of a reading, in the requirement's unit; None where the flight put nothing to the test.

    Where no trigger came true and nothing was violated the number says how far the trigger was from coming true, or
    where a signal ends, in the unit of something else.  That is so of vacuous readings, and of those that are `open`
    only because the flight was cut short before its first trigger.
    """
    return reading.rho if reading.triggered or reading.violated else None


def rho_text(rho: float | None) -> str:
    """A robustness as tables have it.

    >>> rho_text(0.25), rho_text(None)
    ('0.250', 'n/a')
    """
    return "n/a" if rho is None else f"{rho:.3f}"
