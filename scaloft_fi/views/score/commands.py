"""The commands that texts tell a reader to call next."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Sequence

from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.sim.situation import Situation

MOST_NAMED = 4
"""Of more mutants than these a command leaves out the names where `run` flies the same without."""


def in_campaign(campaign: str) -> str:
    """The option that names a campaign, with a space before it; empty for the default campaign.

    >>> in_campaign("wide"), in_campaign("default"), in_campaign("a b")
    (' --campaign wide', '', " --campaign 'a b'")
    """
    return f" --campaign {shlex.quote(campaign)}" if campaign != CAMPAIGN else ""


def command(
    campaign: str, mutants: Sequence[MutantScore], seeds: int, defaults: Collection[str] = (), grid: str = ""
) -> str:
    """The `run` that flies these mutants, and no others; drawn numbers are of no grid, so their situations are named.

    Args:
        campaign: its name.
        mutants: those to fly.
        seeds: of each.
        defaults: ids of the mutants that `run` flies when none is named; exactly these need no name.
        grid: the further grid of a campaign that is still to be made.
    """
    words = [f"scaloft-fi run{in_campaign(campaign)}", *([f"--grid {grid}"] if grid else [])]
    ids = [mutant.subject.id for mutant in mutants]
    if len(ids) <= MOST_NAMED or set(ids) != set(defaults):
        words += [f"--mutant {id_}" for id_ in ids]
    flown = dict.fromkeys(result.situation for mutant in mutants for result in mutant.results)
    if any((situation := Situation.parse(key)) and situation.numbers for key in flown):
        words += [f"--situation {key}" for key in flown]
    if seeds > 1:
        words.append(f"--seeds {seeds}")
    return " ".join(words)
