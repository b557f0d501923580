"""The situations that a search found, and those that break the unmutated drone, for the page."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

from scaloft_fi.analysis.roster import by_field
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.sim.found import Break, Evidence, Find
from scaloft_fi.study import KnownFinds, Study
from scaloft_fi.verbs.report.flights import record, rows_of, scene
from scaloft_fi.verbs.seek import belief, place
from scaloft_fi.verbs.verdict import flies, words

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
        try:
            told = _find(find, finds, mines)
        except InputError:  # its values do not go together any more
            misfits.append(find.name)
            continue
        command = flies(find, find.mutant, finds, campaign, study.grid_name or "")
        listed.append({**told, "command": command, "flights": _pair(find, flown[find.situation], names)})
    return {"grid": finds.grid, "finds": listed, "misfits": misfits}


def _find(find: Find, finds: KnownFinds, mines: list[dict[str, Any]]) -> dict[str, Any]:
    assert finds.searched is not None
    return by_field(find, "name", "situation", "mutant") | {
        "words": words(find),
        "shows": [{"mutant": mutant, **_short(evidence)} for mutant, evidence in find.shows.items()],
        "scene": scene(finds.searched.world(finds.searched.situation(find.situation)), mines),
    }


def _short(evidence: Evidence) -> dict[str, Any]:
    return {
        name: float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value
        for name, value in asdict(evidence).items()
    }


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
    return [_flight(outcome, clean, requirements) for outcome in (flown, clean) if outcome is not None]


def _flight(outcome: Outcome, baseline: Outcome | None, requirements: Sequence[str]) -> dict[str, Any]:
    told = record(outcome, baseline, requirements)
    return {**{name: told[name] for name in KEPT}, "rows": _path(outcome.track)}


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
        assert finds.searched is not None
        try:
            stands = scene(finds.searched.world(finds.searched.situation(one.situation)), mines)
        except InputError:
            continue
        told = by_field(one, "name", "situation", "requirement", "struck", "violated", "flights", "alike", "t_s")
        told |= {"words": ", ".join(one.words) or "every value benign", "where": place(one), "belief": belief(one)}
        told |= {"place": list(one.place[:2]), "command": _flies(one, finds.searched.name), "scene": stands}
        listed.append(told)
    return listed


def _flies(one: Break, grid: str) -> str:
    """The command that flies the unmutated drone there, with the seeds that confirmed the break."""
    named = f"--mutant PLACEBO --situation {shlex.quote(one.name)} --baseline-seeds {one.flights}"
    return f"scaloft-fi run --grid {grid} {named}"
