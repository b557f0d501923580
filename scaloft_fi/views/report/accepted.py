"""Survivors beside the dispositions that accept them, for the page."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import date
from typing import Any

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import Score
from scaloft_fi.analysis.survivor import Disposition, Judged, judge


def accepted(scored: Score, roster: Roster, known: Iterable[Disposition], today: date | None) -> dict[str, Any]:
    """Every counted survivor and every disposition with how it stands.

    Args:
        scored: of the campaign.
        roster: says which mutants count.
        known: the dispositions of the study.
        today: by which last days are judged; None = none is, so that the page never depends on a clock.
    """
    judged = judge(scored, roster, known, today)
    return {"today": today.isoformat() if today else None, "judged": [_entry(one) for one in judged]}


def _entry(judged: Judged) -> dict[str, Any]:
    disposition = judged.disposition
    entry: dict[str, Any] = {"mutant": judged.mutant, "state": judged.state.value, "surviving": list(judged.surviving)}
    if disposition is None:
        return entry
    return entry | {
        "owner": disposition.owner,
        "reason": disposition.reason,
        "until": disposition.expires.isoformat(),
        "situations": list(disposition.situations),
        "unnamed": [key for key in judged.surviving if disposition.situations and key not in disposition.situations],
    }
