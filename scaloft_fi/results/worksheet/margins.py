"""How margins are told: a table for each fault, plain JSON, and the deviation matrix with a margin in every cell."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from scaloft_fi.hazop.cell import Cell, CellStatus, Fault
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants.mutant import parse
from scaloft_fi.results.flights import Flight, flights_of
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.requirement import Kind, Requirement
from scaloft_fi.results.status import Status
from scaloft_fi.results.telling.table import Table
from scaloft_fi.results.worksheet.margin import (
    Answer,
    Margin,
    Scale,
    Subject,
    Tried,
    kills_of,
    lowest,
    margins,
    subject_of,
)

HEADERS = ("situation", "margin", "survives", "kills", "by", "robustness", "flights killed", "flown at", "again")
ENDS = (
    "Survives: the severest magnitude below the kill that does; kills: the mildest that does.  Robustness: at both, of "
    "the requirement that kills; below 0 it is violated."
)
NOT_TOLD = "?"
_NOTHING = Tried(math.nan, Answer.UNTESTED)
LEGEND = (
    "1.4 s      the smallest magnitude that kills in any situation, known to a tenth; nothing milder flown does",
    "1-3 s      1 s survives, 3 s kills; nothing between was flown (scaloft-fi margin CELL bisects)",
    "> 5 s      the severest magnitude flown kills nowhere;  < 0.1 m: the same where smaller is worse",
    "<= 0.5 s   kills, and nothing milder was flown;  >= 60 s: the same where smaller is worse",
    "!          not monotone: a severer magnitude survives where a milder one kills",
    "kills      a fault without magnitudes kills (survives: it does not); y kills: of its named forms, these do",
    "?          nothing flown tells;   -  not meaningful;   CONTROL  must be seen, has no margin",
)


def margin_tables(
    found: Mapping[Subject, Sequence[Margin]], requirements: Sequence[Requirement], seeds: int
) -> tuple[Table, ...]:
    """A table for each fault: a row for each situation, the smallest margin and the requirements' limits below."""
    return tuple(_table(subject, listed, requirements, seeds) for subject, listed in found.items())


def _table(subject: Subject, listed: Sequence[Margin], requirements: Sequence[Requirement], seeds: int) -> Table:
    least = lowest(listed)
    killers = {name for margin in listed for name in _killing(margin).requirements}
    notes = [_smallest(listed, least), ENDS]
    if least and least.again:
        notes.append("Not monotone (!): magnitudes under `again` survive although a milder one kills.")
    if any(not margin.told for margin in listed):
        notes.append("?: the baseline holds no requirement that the cell puts at risk, or the fault changes nothing.")
    notes += [f"{r.name}: {r.title}  {_limit(r)}" for r in requirements if r.name in killers]
    if seeds == 1:
        notes.append("One seed: a threshold of these flights, not of the fault; fly more with --seeds.")
    return Table(f"Margin of {subject}", HEADERS, tuple(_row(margin) for margin in listed), tuple(notes))


def _smallest(listed: Sequence[Margin], least: Margin | None) -> str:
    of = f"Smallest over {sum(margin.told for margin in listed)} of {len(listed)} situations"
    if least is None:
        return f"{of}: nothing is told."
    ends = (("survives", least.survives), ("kills", least.kills))
    return f"{of}: {least} ({', '.join(f'{what} at {_said(least, m)}' for what, m in ends if m is not None)})."


def _row(margin: Margin) -> tuple[str, ...]:
    kill, survivor = _killing(margin), _at(margin, margin.survives)
    rho = [
        (name, dict(survivor.rho).get(name, math.nan), value) for name, value in kill.rho if name in kill.requirements
    ]
    return (
        ", ".join(margin.situations),
        str(margin),
        _said(margin, margin.survives),
        _said(margin, margin.kills),
        ", ".join(kill.requirements),
        ", ".join(f"{name} {_number(before)} / {_number(after)}" for name, before, after in rho),
        f"{kill.kills}/{kill.flown}" if margin.kills is not None else "",
        " ".join(f"{entry.magnitude:g}" for entry in margin.tried),
        " ".join(f"{magnitude:g}" for magnitude in margin.again),
    )


def _killing(margin: Margin) -> Tried:
    return _at(margin, margin.kills)


def _at(margin: Margin, magnitude: float | None) -> Tried:
    return next((entry for entry in margin.tried if entry.magnitude == magnitude), _NOTHING)


def _said(margin: Margin, magnitude: float | None) -> str:
    return "" if magnitude is None or not margin.told else margin.scale.said(magnitude)


def _number(value: float) -> str:
    return "?" if math.isnan(value) else f"{value:.2g}"


def _limit(requirement: Requirement) -> str:
    """The requirement's own limit: its formula, and what its trigger asks."""
    trigger = f"; trigger: {requirement.trigger}" if requirement.trigger else ""
    named = {name: text for name, text in requirement.definitions if name in requirement.text + requirement.trigger}
    where = "".join(f"; {name}: {text}" for name, text in named.items())
    return f"{requirement.text}{trigger}{where} [{requirement.unit}]"


def margin_json(found: Mapping[Subject, Sequence[Margin]]) -> list[dict[str, Any]]:
    """The margins as plain JSON values; an infinite magnitude is the text `inf`."""
    return [
        {
            "cell": subject.cell,
            "phase_s": subject.phase_s,
            "unit": subject.unit,
            "least": _ends(least) if (least := lowest(listed)) else None,
            "situations": [
                {
                    "situation": ", ".join(margin.situations),
                    **_ends(margin),
                    "requirements": list(_killing(margin).requirements),
                    "tried": [
                        {
                            "magnitude": _plain(entry.magnitude),
                            "answer": entry.answer.value,
                            "kills": entry.kills,
                            "flown": entry.flown,
                            "rho": {name: _plain(value) for name, value in entry.rho},
                        }
                        for entry in margin.tried
                    ],
                }
                for margin in listed
            ],
        }
        for subject, listed in found.items()
    ]


def _ends(margin: Margin) -> dict[str, Any]:
    return {
        "margin": str(margin),
        "survives": _plain(margin.survives),
        "kills": _plain(margin.kills),
        "monotone": not margin.again,
        "again": [_plain(magnitude) for magnitude in margin.again],
    }


def _plain(value: float | None) -> float | str | None:
    if value is None or math.isfinite(value):
        return value
    return f"{value:g}"


def cell_margins(outcomes: Iterable[Outcome], matrix: Matrix, kind: Kind = Kind.SAFETY) -> Mapping[str, str]:
    """What each cell of the matrix shows: its faults' smallest margins over all situations, unshifted in time.

    Args:
        outcomes: of a campaign.
        matrix: whose cells.
        kind: of the requirements whose violation kills.

    Returns:
        By the cell's name.
    """
    listed = list(outcomes)
    found = margins(listed, matrix, kind)
    told: dict[str, list[Flight]] = {}
    for flight in flights_of(listed):
        if flight.status is not Status.INVALID:
            told.setdefault(flight.outcome.mutant, []).append(flight)
    return {cell.name: _cell_margin(cell, found, told, kind) for cell in matrix}


def _cell_margin(
    cell: Cell, found: Mapping[Subject, Sequence[Margin]], told: Mapping[str, Sequence[Flight]], kind: Kind
) -> str:
    if cell.status is not CellStatus.CREDIBLE:
        return "-" if cell.status is CellStatus.NOT_MEANINGFUL else "CONTROL"
    texts = []
    for fault in cell.faults:
        if fault.magnitude and Scale.of(fault.magnitude):
            least = lowest(found.get(subject_of(cell.name, fault), ()))
            texts.append(str(least) if least else NOT_TOLD)
        else:
            texts.append(_named(cell, fault, told, kind))
    return "; ".join(text for text in texts if text != NOT_TOLD) or NOT_TOLD


def _named(cell: Cell, fault: Fault, told: Mapping[str, Sequence[Flight]], kind: Kind) -> str:
    """Which forms of a fault without an order kill."""
    ids = [cell.mutant_ids(fault, rung)[0] for rung in fault.rungs]
    tested = [id_ for id_ in ids if any(_tested(flight, kind) for flight in told.get(id_, ()))]
    killing = [id_ for id_ in ids if any(kills_of(flight, kind) for flight in told.get(id_, ()))]
    if killing:
        return " ".join([*filter(None, (parse(id_).magnitude for id_ in killing)), "kills"])
    return "survives" if tested else NOT_TOLD


def _tested(flight: Flight, kind: Kind) -> bool:
    return flight.eligible if kind is Kind.SAFETY else flight.operability_eligible
