"""The HAZOP worksheet as plain JSON values: what `worksheet` prints for programs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from scaloft_fi.analysis.roster import plain
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.judge.status import Status
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import (
    by_name,
    count,
    flag,
    inner,
    listing,
    optional,
    ratio,
    record,
    text,
    texts,
)
from scaloft_fi.views.score.score_form import FIRM, VERDICTS, P
from scaloft_fi.views.stale import KEYS as STALE
from scaloft_fi.views.worksheet.margin_record import CELL_MARGINS
from scaloft_fi.views.worksheet.matrix_record import CELL, cell_values
from scaloft_fi.views.worksheet.worksheet import TEAM, SheetRow, p_of

_RESULTS = record(
    "what the flights of the default mutant say",
    {
        "situations_flown": count("situations with a flight that counts"),
        "reached": count("situations where the fault's seam carried a sample"),
        "infected": count("situations where it changed a sample"),
        "status": text("the furthest stage that a flight reached", [status.value for status in Status]),
        "verdict": text("by safety requirements", VERDICTS),
        "firm": FIRM,
        "operability": text("by operability requirements", VERDICTS),
        "p": P,
        "needed": optional(count("seeds that would decide an undecided mutant"), "decided, or none would"),
        "anew": flag("whether that takes a campaign of its own"),
        "kill_rate": ratio("situations with a kill, of those that put it to the test"),
        "kill_rate_flown": ratio("situations with a kill, of those flown"),
        "requirements": by_name(
            "by requirement that kills it", ratio("situations with such a kill, of those that test it by it")
        ),
        "where": text("shortest condition for the situations with a kill, else for those with a violation seen"),
        "killing": texts("keys of the situations with a kill"),
        "stopped_at": record(
            "situations without a kill, by the stage that flights reached",
            {status.value: count(f"situations with {status.value}") for status in Status},
        ),
    },
)
WORKSHEET = Output(
    "worksheet",
    "2.0",
    "the HAZOP worksheet with the findings",
    {
        "rows": listing(
            "every deviation, in the order of the matrix",
            record(
                "a deviation",
                {
                    **CELL,
                    "node": text("the stages between which the parameter flows"),
                    "design_intent": text("what every deviation deviates from"),
                    "margins": inner(CELL_MARGINS),
                    "results": optional(_RESULTS, "not flown"),
                    "disposition": optional(
                        record(
                            "of a survivor that somebody accepted",
                            {
                                "owner": text("who"),
                                "reason": text("why"),
                                "expires": {**text("last day"), "format": "date"},
                                "situations": texts("keys of the situations for which; empty for all"),
                            },
                        ),
                        "nobody has accepted it",
                    ),
                    "find": optional(text("a situation that a search found, which shows the survivor, in words")),
                    "flies_find": optional(text("the command that flies it")),
                    "team": record(
                        "what only people can fill in", {one.key: optional(text(one.title)) for one in TEAM}
                    ),
                },
            ),
        ),
        **STALE,
    },
    rows="rows",
)


def worksheet_values(rows: Sequence[SheetRow]) -> dict[str, Any]:
    """Plain JSON values of the form `WORKSHEET`."""
    return {"rows": [_row(row) for row in rows]}


def _row(row: SheetRow) -> dict[str, Any]:
    known = row.disposition
    accepted = None
    if known is not None:
        days = known.expires.isoformat()
        accepted = {"owner": known.owner, "reason": known.reason, "expires": days, "situations": list(known.situations)}
    return {
        **cell_values(row.cell, row.severity),
        **{key: row.values[key] for key in ("node", "design_intent", "find", "flies_find")},
        "margins": list(row.margins),
        "results": None if row.score is None else _results(row, row.score),
        "disposition": accepted,
        "team": {column.key: None for column in TEAM},
    }


def _results(row: SheetRow, score: MutantScore) -> dict[str, Any]:
    stopped = Counter(result.status for result in score.results if not result.kills)
    return {
        **{key: row.values[key] for key in ("situations_flown", "reached", "infected", "where")},
        "status": score.status.value,
        "verdict": score.verdict.value,
        "firm": score.firmness.value if score.firmness else None,
        "operability": score.operability.verdict.value,
        "p": dict(p_of(score)),
        "needed": score.safety.needed,
        "anew": score.safety.anew,
        "kill_rate": plain(score.kill_rate),
        "kill_rate_flown": plain(score.kill_rate_flown),
        "requirements": plain(dict(score.requirements)),
        "killing": list(score.killing),
        "stopped_at": {status.value: stopped[status] for status in Status},
    }
