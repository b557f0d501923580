"""Accepted survivors in words: who accepted each, why and until when, and the score without them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from scaloft_fi.analysis.score import Score
from scaloft_fi.analysis.survivor import Accepted, Disposition, score_without
from scaloft_fi.views.outputs.shape import listing, record, text

SHAPE = listing(
    "the survivors that somebody accepted, of the mutants that the ratios count",
    record(
        "an accepted survivor",
        {
            "mutant": text("canonical id"),
            "owner": text("who accepted it"),
            "reason": text("why"),
            "expires": {**text("last day of the acceptance"), "format": "date"},
        },
    ),
)


def acceptance(disposition: Disposition) -> str:
    """Who accepted a survivor, where, until when and why."""
    where = f" in {', '.join(disposition.situations)}" if disposition.situations else ""
    until = disposition.expires.isoformat()
    return f"accepted{where} by {disposition.owner} until {until}: {disposition.reason}"


def accepted_values(accepted: Sequence[Accepted]) -> list[dict[str, Any]]:
    """Plain JSON values of `SHAPE`."""
    return [
        {"mutant": id_, "owner": known.owner, "reason": known.reason, "expires": known.expires.isoformat()}
        for id_, known in accepted
    ]


def accepted_line(scored: Score, accepted: Sequence[Accepted]) -> str:
    """How many survivors were accepted and by whom, and the score with and without them, in a sentence."""
    owners = Counter(known.owner for _, known in accepted)
    by = ", ".join(f"{owner} {number}" if len(owners) > 1 else owner for owner, number in owners.items())
    score, without = scored.mutation_score, score_without(scored, accepted)
    share = f" ({100 * without.value:.0f} %)" if without.value is not None else ""
    return (
        f"{len(accepted)} of the {score.whole - score.part} faults not shown (by {by}).  Shown: {score.part} of "
        f"{score.whole} with them, {without.part} of {without.whole}{share} without them; "
        "`scaloft-fi dispositions` lists them."
    )
