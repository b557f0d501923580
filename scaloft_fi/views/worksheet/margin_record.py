"""Margins as plain JSON values: what `margin` and `matrix --margins` print for programs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from scaloft_fi.analysis.margin import Margin, When, lowest, margins
from scaloft_fi.analysis.score import Score
from scaloft_fi.analysis.survivor import PhasedFault, Reaction, Tried, detection_of, phased_fault
from scaloft_fi.hazop.matrix import Cell, CellStatus, Matrix
from scaloft_fi.hazop.name import parse
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import (
    Shape,
    by_name,
    count,
    flag,
    listing,
    number,
    optional,
    ratio,
    record,
    text,
    texts,
)
from scaloft_fi.views.score.score_form import VERDICTS
from scaloft_fi.views.worksheet.margin_text import finite

FAULT = text("a fault with its phase, as an id without the magnitude")


def magnitude(about: str) -> Shape:
    """A magnitude: a number in the fault's unit, or a text where it is infinite."""
    return {
        "type": ["number", "string"],
        "pattern": "^-?inf$",
        "description": f"{about} [the fault's unit]; the text inf where it is infinite",
    }


ENDS: Mapping[str, Shape] = {
    "known": flag("whether the flights bound the margin from either side"),
    "survives": optional(magnitude("the strongest magnitude that survives, below the others"), "none is known"),
    "seen": optional(magnitude("the mildest at which most flights violate, with too few to decide"), "there is none"),
    "kills": optional(magnitude("the mildest that is killed"), "none is"),
    "monotone": flag("whether no magnitude survives where a milder one is killed or seen"),
    "again": listing("the magnitudes that do", magnitude("a magnitude")),
}
"""What bounds a margin."""
_FAULT = {
    "fault": FAULT,
    "cell": text("name of its cell"),
    "unit": text("unit of its magnitudes"),
    "phase_s": number("its shift in time", "s"),
    "event": text("the event at which it strikes; empty for none"),
}
MARGIN = Output(
    "margin",
    "1.0",
    "the smallest magnitude of each fault that is killed; with --when, where in the flight it is",
    {
        "faults": listing(
            "the faults, each over all situations; with --when empty", record("a fault", {**_FAULT, **ENDS})
        ),
        "situations": listing(
            "each fault in each situation; with --when empty",
            record(
                "a fault in a situation",
                {
                    "fault": FAULT,
                    "situation": text("key of the situation"),
                    **ENDS,
                    "requirements": texts("that are violated at the killed magnitude, else at the seen one"),
                },
            ),
        ),
        "tried": listing(
            "each magnitude that was flown; with --when empty",
            record(
                "a magnitude in a situation",
                {
                    "fault": FAULT,
                    "situation": text("key of the situation"),
                    "magnitude": magnitude("the magnitude"),
                    "answer": text("what its flights show together", [reaction.value for reaction in Reaction]),
                    "flown": count("flights that count"),
                    "violated": by_name("by requirement", count("flights that violate it")),
                    "rho": by_name(
                        "by requirement that was put to the test",
                        optional(number("the least robustness, in the requirement's unit"), "it is not finite"),
                    ),
                    "needed": optional(count("of `seen`, seeds that would decide"), "nothing to decide, or none would"),
                    "anew": flag("whether that takes a campaign of its own"),
                },
            ),
        ),
        "phases": listing(
            "with --when: each phase at which a fault was flown; else empty",
            record(
                "a phase",
                {
                    "id": text("id of the mutant"),
                    "fault": text("its id without the phase"),
                    "phase": text("the phase as in the id; empty for phase 0"),
                    "at_event": flag("whether it is an event of the flight, not a time"),
                    "acts_first_s": optional(number("earliest first altered sample", "s from take-off"), "none was"),
                    "acts_median_s": optional(number("median first altered sample", "s from take-off"), "none was"),
                    "acts_last_s": optional(number("latest first altered sample", "s from take-off"), "none was"),
                    "kills": ratio("situations with a kill, of those that put it to the test"),
                    "verdict": text("on the mutant", VERDICTS),
                    "lasts_s": number("median duration of the baselines in these situations", "s"),
                },
            ),
        ),
    },
    rows="situations",
)
CELL_MARGINS: Shape = optional(
    listing(
        "with --margins: the margins of its faults, over all situations",
        record(
            "a fault",
            {
                "unit": text("unit of its magnitudes; empty where it has none"),
                **ENDS,
                "verdicts": by_name(
                    "of a fault without an order, by magnitude or form that was flown", text("on the mutant", VERDICTS)
                ),
            },
        ),
    ),
    "not asked for",
)


def margin_values(by_fault: Mapping[PhasedFault, Sequence[Margin]]) -> dict[str, Any]:
    """The plain JSON values of the form `MARGIN`."""
    each = [
        (fault, margin, key) for fault, listed in by_fault.items() for margin in listed for key in margin.situations
    ]
    return {
        "faults": [
            {
                "fault": str(fault),
                "cell": fault.cell,
                "unit": fault.unit,
                "phase_s": fault.phase_s,
                "event": fault.event,
                **_ends(lowest(listed)),
            }
            for fault, listed in by_fault.items()
        ],
        "situations": [
            {"fault": str(fault), "situation": key, **_ends(margin), "requirements": _requirements(margin)}
            for fault, margin, key in each
        ],
        "tried": [
            {"fault": str(fault), "situation": key, **_tried(entry)}
            for fault, margin, key in each
            for entry in margin.tried
        ],
        "phases": [],
    }


def when_values(found: Iterable[When]) -> dict[str, Any]:
    """The plain JSON values of the form `MARGIN` for `margin --when`."""
    phases = [
        {
            "id": strike.id,
            "fault": when.fault,
            "phase": strike.phase,
            "at_event": strike.at_event,
            **dict(zip(("acts_first_s", "acts_median_s", "acts_last_s"), strike.acts_s or [None] * 3, strict=True)),
            "kills": {"part": strike.kills.part, "whole": strike.kills.whole},
            "verdict": strike.verdict.value,
            "lasts_s": when.lasts_s,
        }
        for when in found
        for strike in when.strikes
    ]
    return {"faults": [], "situations": [], "tried": [], "phases": phases}


def cell_margin_values(
    outcomes: Iterable[Outcome], scored: Score, matrix: Matrix, kind: Kind = Kind.SAFETY
) -> dict[str, list[dict[str, Any]]]:
    """The margins of each credible cell, a record for each fault, by the cell's name.

    Args:
        outcomes: of a campaign.
        scored: their score.
        matrix: whose cells.
        kind: of the requirements whose violation kills.
    """
    by_fault = margins(outcomes, scored, matrix, kind)
    verdicts = {mutant.subject.id: detection_of(mutant, kind).verdict.value for mutant in scored.mutants}
    return {cell.name: _of_cell(cell, by_fault, verdicts) for cell in matrix}


def _of_cell(
    cell: Cell, by_fault: Mapping[PhasedFault, Sequence[Margin]], verdicts: Mapping[str, str]
) -> list[dict[str, Any]]:
    if cell.status is not CellStatus.CREDIBLE:
        return []
    found = []
    for fault in cell.faults:
        listed = by_fault.get(phased_fault(cell.name, fault), ())
        ids = [] if listed else [cell.mutant_ids(fault, rung)[0] for rung in fault.rungs]
        own = {parse(id_).magnitude or id_: verdicts[id_] for id_ in ids if id_ in verdicts}
        unit = fault.magnitude.unit if fault.magnitude else ""
        found.append({"unit": unit, **_ends(lowest(listed)), "verdicts": own})
    return found


def _ends(margin: Margin | None) -> dict[str, Any]:
    if margin is None:
        return {"known": False, "survives": None, "seen": None, "kills": None, "monotone": True, "again": []}
    return {
        "known": margin.known,
        "survives": finite(margin.survives),
        "seen": finite(margin.seen),
        "kills": finite(margin.kills),
        "monotone": not margin.again,
        "again": [finite(again) for again in margin.again],
    }


def _requirements(margin: Margin) -> list[str]:
    strong = margin.seen if margin.kills is None else margin.kills
    return next((list(entry.requirements) for entry in margin.tried if entry.magnitude == strong), [])


def _tried(entry: Tried) -> dict[str, Any]:
    return {
        "magnitude": finite(entry.magnitude),
        "answer": entry.reaction.value,
        "flown": entry.flown,
        "violated": dict(entry.violated),
        "rho": {name: value if math.isfinite(value) else None for name, value in entry.rho},
        "needed": entry.needed,
        "anew": entry.anew,
    }
