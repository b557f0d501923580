"""What to call about a mutant that is not detected: the flight to look at, and what would show it or bound it."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from scaloft_fi.analysis.margin import Scale
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.hazop.matrix import Cell
from scaloft_fi.judge.requirement import Kind, measured_rho
from scaloft_fi.judge.status import JudgedFlight
from scaloft_fi.views.score.commands import in_campaign


class Step(NamedTuple):
    """A command, and what it does."""

    name: str
    does: str
    command: str


def steps(
    mutant: MutantScore, flights: Sequence[JudgedFlight], following: str, cell: Cell, campaign: str, *, searchable: bool
) -> list[Step]:
    """The steps for a mutant that is not detected, the first to take first.

    Args:
        mutant: the mutant.
        flights: its flights in the campaign.
        following: the command that the verdict on it asks for next.
        cell: the cell that it comes from.
        campaign: name of the campaign.
        searchable: whether the study can be searched for a situation that shows the mutant.
    """
    known = in_campaign(campaign)
    found = [Step("next", "Next", following)]
    shown = telling(flights)
    if shown is not None:
        outcome = shown.outcome
        name = shlex.quote(f"{outcome.mutant}/{outcome.situation}/{outcome.seed}")
        found.insert(0, Step("replay", "Fly its most telling flight again", f"scaloft-fi replay {name}{known}"))
    if any(fault.magnitude and Scale.of(fault.magnitude) for fault in cell.faults):
        margin = f"scaloft-fi margin {cell.name}{known}"
        found.append(Step("margin", "Find the smallest magnitude that is killed", margin))
    if searchable:
        seek = f"scaloft-fi seek {shlex.quote(mutant.subject.id)}"
        found.append(Step("seek", "Search for a situation that shows it", seek))
    return found


def telling(flights: Iterable[JudgedFlight]) -> JudgedFlight | None:
    """The flight that says most: where the fault got furthest, and of these the one nearest to a safety violation."""
    return max(flights, key=lambda flight: (flight.status.stage, -_nearest(flight)), default=None)


def _nearest(flight: JudgedFlight) -> float:
    """The least robustness of the safety requirements that the flight puts to the test."""
    measured = [measured_rho(one) for one in flight.outcome.readings if one.kind is Kind.SAFETY]
    return min((rho for rho in measured if rho is not None), default=float("inf"))
