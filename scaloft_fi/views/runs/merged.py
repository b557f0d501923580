"""What a merge of campaigns came to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from scaloft_fi.campaign.runs.merge import Merged
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import count, text, texts

MERGE = Output(
    "merge",
    "1.0",
    "what a merge of campaigns added",
    {
        "campaign": text("folder of the campaign that got the flights"),
        "added": count("flights added to it"),
        "known": count("flights that it held already"),
        "warnings": texts("what a reader must know of the platforms of the flights"),
    },
    rows="summary",
)


def merge_values(folder: Path, merged: Merged) -> dict[str, Any]:
    """Plain JSON values of the form `MERGE`; `folder` of the campaign that got the flights."""
    return {
        "campaign": str(folder),
        "added": merged.added,
        "known": merged.known,
        "warnings": list(merged.warnings),
    }
