"""All flights of a campaign as a JSON list."""

from __future__ import annotations

from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import export_format
from scaloft_fi.views.flights.export import to_json


@export_format("json", "one row per flight, a list")
def json_rows(dossier: Dossier) -> str:
    """One flight a line."""
    return to_json(dossier.rows)
