"""Margins for readers: a table for each fault, and the deviation matrix with a margin in every cell."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from scaloft_fi.analysis.detection import LARGER, Verdict
from scaloft_fi.analysis.margin import Margin, Scale, lowest, margins
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.survivor import PhasedFault, Reaction, Tried, detection_of, phased_fault
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.hazop.matrix import Cell, CellStatus, Fault, Matrix
from scaloft_fi.hazop.name import parse
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.views.score.commands import in_campaign
from scaloft_fi.views.tables.table import Table
from scaloft_fi.views.worksheet.margin_text import UNKNOWN, magnitude_text, margin_text

HEADERS = ("situation", "margin", "survives", "seen", "killed", "violated", "robustness", "flown at", "again")
ENDS = (
    "Survives: the strongest magnitude that does, below the others.  Killed: the mildest at which the mutant is "
    "detected and most flights violate a steady requirement; seen: the mildest at which most do, but too few to detect "
    "it.  Violated: flights at the killed magnitude, else at the seen one; robustness: at the surviving one and there, "
    "below 0 it is violated."
)
_NOTHING = Tried(math.nan, Reaction.UNTESTED)
LEGEND_AT = 11
"""Where the meanings begin in the legend [characters]."""
LEGEND = (
    "1.4 s      the smallest magnitude that is killed in any situation, known to a tenth; nothing milder flown is",
    "1-3 s      1 s survives, 3 s is killed; nothing between is decided (scaloft-fi margin CELL bisects)",
    "> 5 s      even the strongest magnitude flown has no kill;  < 0.1 m: the same where smaller is worse",
    "<= 0.5 s   is killed, and nothing milder was flown;  >= 60 s: the same where smaller is worse",
    "seen 1-3 s 1 s survives, at 3 s most flights violate, too few to call the mutant detected: more seeds decide",
    "!          not monotone: a stronger magnitude survives where a milder one is killed or seen",
    "detected   a fault without magnitudes is detected (or not detected, or undecided); y detected: in this form",
    "?          not known yet (a situation takes ten baselines);   -  not meaningful;  CONTROL  has no margin",
)


def margin_tables(
    by_fault: Mapping[PhasedFault, Sequence[Margin]],
    requirements: Sequence[Requirement],
    seeds: int,
    campaign: str = CAMPAIGN,
    grid: str = "",
) -> tuple[Table, ...]:
    """A table for each fault: a row for each situation, the smallest margin and the requirements' limits below.

    Args:
        by_fault: the margins.
        requirements: of the study.
        seeds: number of seeds that were asked for.
        campaign: name of the campaign, for commands.
        grid: name of its grid, where that is a further grid of the study.
    """
    where = in_campaign(campaign), f" --campaign NAME{f' --grid {grid}' if grid else ''}"
    return tuple(_table(fault, listed, requirements, seeds, where) for fault, listed in by_fault.items())


def _table(
    fault: PhasedFault,
    listed: Sequence[Margin],
    requirements: Sequence[Requirement],
    seeds: int,
    where: tuple[str, str],
) -> Table:
    least = lowest(listed)
    violated = {name for margin in listed for name in _strong(margin).requirements}
    notes = [_smallest(listed, least), ENDS, *_seen(fault, listed, *where)]
    if least and least.again:
        notes.append("Not monotone (!): magnitudes under `again` survive although a milder one is killed or seen.")
    if any(not margin.known for margin in listed):
        notes.append("?: no requirement that the cell puts at risk is steady by ten baselines, or no sample changes.")
    notes += [f"{r.name}: {r.title}  {_limit(r)}" for r in requirements if r.name in violated]
    if seeds == 1:
        notes.append("One seed: a threshold of these flights, not of the fault; fly more with --seeds.")
    return Table(f"Margin of {fault}", HEADERS, tuple(_row(margin) for margin in listed), tuple(notes))


def _smallest(listed: Sequence[Margin], least: Margin | None) -> str:
    of = f"Smallest over {sum(margin.known for margin in listed)} of {len(listed)} situations"
    if least is None:
        return f"{of}: none is known."
    ends = (("survives", least.survives), ("is seen", least.seen), ("is killed", least.kills))
    where = ", ".join(f"{_magnitude(least, end)} {what}" for what, end in ends if end is not None)
    return f"{of}: {margin_text(least)} ({where})."


def _seen(fault: PhasedFault, listed: Sequence[Margin], where: str, anew_in: str) -> list[str]:
    """How many seeds would decide what is seen below every kill, with the command in this campaign or in a new one."""
    groups: dict[tuple[int, bool], dict[float, str]] = {}
    for margin in listed:
        if margin.seen is not None:
            entry = _at(margin, margin.seen)
            many = (entry.needed or LARGER[-1] + 1, entry.anew)
            groups.setdefault(many, {})[margin.seen] = magnitude_text(margin.scale, margin.seen)
    notes = []
    for (seeds, anew), seen in sorted(groups.items()):
        at = ", ".join(seen[magnitude] for magnitude in sorted(seen))
        mutant = fault.at(f"{min(seen):g}{fault.unit}")
        if seeds > LARGER[-1]:
            notes.append(f"Seen, too seldom for {LARGER[-1]} seeds to decide: {at}.")
        elif anew:
            command = f"scaloft-fi margin{anew_in} {mutant} --seeds {seeds}"
            notes.append(f"Seen, decided by {seeds} seeds in a campaign of its own: {at} (`{command}`).")
        else:
            notes.append(f"Seen, decided by {seeds} seeds: {at} (`scaloft-fi margin{where} {mutant} --seeds {seeds}`).")
    return notes


def _row(margin: Margin) -> tuple[str, ...]:
    strong, survivor = _strong(margin), _at(margin, margin.survives)
    rho = [
        (name, dict(survivor.rho).get(name, math.nan), value)
        for name, value in strong.rho
        if name in strong.requirements
    ]
    return (
        ", ".join(margin.situations),
        margin_text(margin),
        _magnitude(margin, margin.survives),
        _magnitude(margin, margin.seen),
        _magnitude(margin, margin.kills),
        ", ".join(f"{name} {count}/{strong.flown}" for name, count in strong.violated if name in strong.requirements),
        ", ".join(f"{name} {_number(before)} / {_number(after)}" for name, before, after in rho),
        " ".join(f"{entry.magnitude:g}" for entry in margin.tried),
        " ".join(f"{magnitude:g}" for magnitude in margin.again),
    )


def _strong(margin: Margin) -> Tried:
    """What was flown at the magnitude that is killed, else at the one that is seen."""
    return _at(margin, margin.seen if margin.kills is None else margin.kills)


def _at(margin: Margin, magnitude: float | None) -> Tried:
    return next((entry for entry in margin.tried if entry.magnitude == magnitude), _NOTHING)


def _magnitude(margin: Margin, magnitude: float | None) -> str:
    return "" if magnitude is None or not margin.known else magnitude_text(margin.scale, magnitude)


def _number(value: float) -> str:
    return "?" if math.isnan(value) else f"{value:.2g}"


def _limit(requirement: Requirement) -> str:
    """The requirement's own limit: its formula, and what its trigger asks."""
    trigger = f"; trigger: {requirement.trigger}" if requirement.trigger else ""
    named = {name: text for name, text in requirement.definitions if name in requirement.text + requirement.trigger}
    where = "".join(f"; {name}: {text}" for name, text in named.items())
    return f"{requirement.text}{trigger}{where} [{requirement.unit}]"


def cell_margins(
    outcomes: Iterable[Outcome], scored: Score, matrix: Matrix, kind: Kind = Kind.SAFETY
) -> Mapping[str, str]:
    """What each cell of the matrix shows: its faults' smallest margins over all situations, unshifted in time.

    Args:
        outcomes: of a campaign.
        scored: their score.
        matrix: whose cells.
        kind: of the requirements whose violation kills.

    Returns:
        By the cell's name.
    """
    by_fault = margins(outcomes, scored, matrix, kind)
    scores = {mutant.subject.id: mutant for mutant in scored.mutants}
    return {cell.name: _cell_margin(cell, by_fault, scores, kind) for cell in matrix}


def _cell_margin(
    cell: Cell, by_fault: Mapping[PhasedFault, Sequence[Margin]], scores: Mapping[str, MutantScore], kind: Kind
) -> str:
    if cell.status is not CellStatus.CREDIBLE:
        return "-" if cell.status is CellStatus.NOT_MEANINGFUL else "CONTROL"
    texts = []
    for fault in cell.faults:
        if fault.magnitude and Scale.of(fault.magnitude):
            least = lowest(by_fault.get(phased_fault(cell.name, fault), ()))
            texts.append(margin_text(least) if least else UNKNOWN)
        else:
            texts.append(_named(cell, fault, scores, kind))
    return "; ".join(text for text in texts if text != UNKNOWN) or UNKNOWN


def _named(cell: Cell, fault: Fault, scores: Mapping[str, MutantScore], kind: Kind) -> str:
    """Which forms of a fault without an order are detected; else the verdict that says most."""
    ids = [cell.mutant_ids(fault, rung)[0] for rung in fault.rungs]
    verdicts = {id_: detection_of(scores[id_], kind).verdict for id_ in ids if id_ in scores}
    for verdict in (Verdict.DETECTED, Verdict.UNDECIDED, Verdict.NOT_DETECTED):
        forms = [parse(id_).magnitude for id_, own in verdicts.items() if own is verdict]
        if forms:
            return " ".join([*filter(None, forms if verdict is Verdict.DETECTED else ()), verdict.words])
    return UNKNOWN
