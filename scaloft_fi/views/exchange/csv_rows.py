"""All flights of a campaign as CSV."""

from __future__ import annotations

from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import export_format
from scaloft_fi.views.flights.export import to_csv


@export_format("csv", "one row per flight, the columns of json")
def csv_rows(dossier: Dossier) -> str:
    """One flight a line, below a line of names."""
    return to_csv(dossier.rows, dossier.columns)
