"""The situations that break the unmutated drone, for the page: how, where, after which wrong belief, the command."""

from __future__ import annotations

import shlex
from typing import Any

from scaloft_fi.errors import InputError
from scaloft_fi.sim.found import Break
from scaloft_fi.study import KnownFinds
from scaloft_fi.views.report.scenes import scene
from scaloft_fi.views.runs.breaks import belief, place


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
        listed.append({**_told(one), "command": _flies(one, finds.searched.name), "scene": stands})
    return listed


def _told(one: Break) -> dict[str, Any]:
    return {
        "name": one.name,
        "situation": one.situation,
        "words": ", ".join(one.words) or "every value benign",
        "requirement": one.requirement,
        "struck": one.struck,
        "where": place(one),
        "belief": belief(one),
        "violated": one.violated,
        "flights": one.flights,
        "alike": one.alike,
        "t_s": one.t_s,
        "place": list(one.place[:2]),
    }


def _flies(one: Break, grid: str) -> str:
    """The command that flies the unmutated drone there, with the seeds that confirmed the break."""
    named = f"--mutant PLACEBO --situation {shlex.quote(one.name)} --baseline-seeds {one.flights}"
    return f"scaloft-fi run --grid {grid} {named}"
