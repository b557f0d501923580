"""How the looks of a sequential run went."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.campaign.runs.request import Look
from scaloft_fi.views.tables.table import Table


def look_table(looks: Sequence[Look]) -> Table:
    """How the looks went."""
    rows = tuple(
        (look.seeds, look.mutants, look.flights, *(look.fates[verdict] for verdict in Verdict)) for look in looks
    )
    headers = ("seeds", "mutants", "flights", *(verdict.words for verdict in Verdict))
    notes = (
        "Only the undecided fly on, where the pool has a steady pair.  Each look spends a quarter of alpha.",
        "Flights: of mutants, planned for the look; PLACEBO and baselines fly beside them.",
    )
    return Table("Looks", headers, rows, notes)


def look_record(look: Look) -> dict[str, Any]:
    """A look as plain JSON values."""
    fates = {verdict.value: look.fates[verdict] for verdict in Verdict}
    return {"seeds": look.seeds, "mutants": look.mutants, "flights": look.flights, **fates}
