"""The situations that a search found, and those that break the unmutated drone, for the page."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.sim.found import Break, Find
from scaloft_fi.study import KnownFinds, Study
from scaloft_fi.verbs.report.flights import record, rows_of, scene
from scaloft_fi.verbs.seek import belief, place
from scaloft_fi.verbs.verdict import flies, words
from scaloft_fi.views.output import by_field

STEP_M = 0.1
"""Between two places of a path that is drawn [m]: five pixels of the page's map."""
KEPT = ("mutant", "seed", "ending", "infected_at_s", "violations")
"""What the map needs of a flight beside its path."""
DIGITS = 4
"""Significant digits of numbers."""


def found(study: Study, campaign: str, outcomes: Iterable[Outcome], mines: list[dict[str, Any]]) -> dict[str, Any]:
    """The finds of the study, and the names of those that do not fit it any more.

    Args:
        study: the study, with the grid of the campaign.
        campaign: its name.
        outcomes: of the campaign, with their tracks.
        mines: those that the page has; new ones are added.
    """
    finds, names = study.finds, [requirement.name for requirement in study.requirements]
    # another further grid may use the same keys for other situations
    same = study.grid_name in (None, finds.grid, finds.searched.name if finds.searched else None)
    flown: dict[str, list[Outcome]] = {find.situation: [] for find in finds.finds}
    for outcome in outcomes:
        if same and not outcome.invalid and outcome.situation in flown:
            flown[outcome.situation].append(outcome)
    listed, misfits = [], list(finds.misfits)
    for find in finds.finds:
        stands = _scene(find, finds, mines)
        if stands is None:
            misfits.append(find.name)
            continue
        shows = [
            {"mutant": mutant}
            | {
                name: float(f"{one:.{DIGITS}g}") if isinstance(one, float) else one
                for name, one in asdict(told).items()
            }
            for mutant, told in find.shows.items()
        ]
        listed.append(
            by_field(find, "name", "situation", "mutant")
            | {"words": words(find), "shows": shows, "scene": stands}
            | {"command": flies(find, find.mutant, finds, campaign, study.grid_name or "")}
            | {"flights": _pair(find, flown[find.situation], names)}
        )
    return {"grid": finds.grid, "finds": listed, "misfits": misfits}


def _scene(one: Find | Break, finds: KnownFinds, mines: list[dict[str, Any]]) -> dict[str, Any] | None:
    """What stands in a found situation; None where its values do not go together any more."""
    assert finds.searched is not None
    try:
        return scene(finds.searched.world(finds.searched.situation(one.situation)), mines)
    except InputError:
        return None


def _pair(find: Find, outcomes: Sequence[Outcome], requirements: Sequence[str]) -> list[dict[str, Any]] | None:
    """A flight of a mutant that the find shows, and the baseline's of that seed where there is one.

    The mutant that the find was made for is taken first, and of its flights the first that violates the requirement.

    Returns:
        None where no such mutant was flown there.
    """
    baselines = {outcome.seed: outcome for outcome in outcomes if outcome.mutant == BASELINE}

    def rank(outcome: Outcome) -> tuple[bool, bool, str, int]:
        violated = {violation.requirement for violation in outcome.violations}
        silent = find.shows[outcome.mutant].requirement not in violated
        return outcome.mutant != find.mutant, silent, outcome.mutant, outcome.seed

    flown = min((outcome for outcome in outcomes if outcome.mutant in find.shows), key=rank, default=None)
    if flown is None:
        return None
    clean = baselines.get(flown.seed)
    pair = [(one, record(one, clean, requirements)) for one in (flown, clean) if one is not None]
    return [{name: told[name] for name in KEPT} | {"rows": _path(one.track)} for one, told in pair]


def _path(track: bytes) -> list[list[float]]:
    """Time [s] and place [m, world] along a track, `STEP_M` apart, with the first row and the last."""
    rows, kept = rows_of(track), list[list[float]]()
    for row in rows:
        x, y = row[1:3]
        if not kept or row is rows[-1] or math.dist((x, y), kept[-1][1:]) >= STEP_M:
            kept.append([round(row[0], 2), round(x, 2), round(y, 2)])
    return kept


def broken(finds: KnownFinds, mines: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The breaks of a study, without those whose values do not go together any more.

    Args:
        finds: of the study.
        mines: those that the page has; new ones are added.
    """
    listed = []
    for one in finds.breaks:
        if (stands := _scene(one, finds, mines)) is None or finds.searched is None:
            continue
        # with the seeds that confirmed the break
        named = f"--mutant PLACEBO --situation {shlex.quote(one.name)} --baseline-seeds {one.flights}"
        told = by_field(one, "name", "situation", "requirement", "struck", "violated", "flights", "alike", "t_s")
        told |= {"words": ", ".join(one.words) or "every value benign", "where": place(one), "belief": belief(one)}
        told |= {"place": list(one.place[:2]), "scene": stands}
        told |= {"command": f"scaloft-fi run --grid {finds.searched.name} {named}"}
        listed.append(told)
    return listed
