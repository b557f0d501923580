"""Robustness for tables and records, only where a flight tested the requirement."""

from __future__ import annotations

from scaloft_fi.judge.requirement import Reading


def measured_rho(reading: Reading) -> float | None:
    """The robustness of a reading in the requirement's unit; None where the flight did not test the requirement.

    Without a trigger and without a violation the number measures the distance to the trigger, or the cap of a signal,
    in another unit.  This holds for vacuous readings, and for `open` readings of a flight that was cut short before its
    first trigger.
    """
    return reading.rho if reading.triggered or reading.violated else None


def rho_text(rho: float | None) -> str:
    """Format a robustness for tables.

    >>> rho_text(0.25), rho_text(None)
    ('0.250', 'n/a')
    """
    return "n/a" if rho is None else f"{rho:.3f}"
