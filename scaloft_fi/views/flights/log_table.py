"""One flight as CSV: a line for each sample, a column for each signal, every number with all its digits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scaloft_fi.views.tables.table import csv_text

if TYPE_CHECKING:
    from scaloft_fi.sim.log import FlightLog


def log_table(log: FlightLog) -> bytes:
    """The signals of the log; `judge` reads them back bit for bit."""
    columns = [values.tolist() for values in log.signals.values()]
    return csv_text(log.signals, zip(*columns, strict=True)).encode()
