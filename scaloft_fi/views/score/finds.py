"""The find to fly next for a fault that the flights do not show: which one, in words, and its command."""

from __future__ import annotations

import shlex

from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.sim.found import Evidence, Find
from scaloft_fi.study import KnownFinds
from scaloft_fi.views.score.commands import in_campaign


def next_find(mutant: MutantScore, finds: KnownFinds) -> Find | None:
    """The find to fly next for a mutant; every text that says what to do next asks here.

    None for a mutant that is detected, that has no flight that counts, or whose finds were flown in this campaign.
    """
    if mutant.detected or not mutant.flown:
        return None
    return next((find for find in finds.of(mutant.subject.id) if not _flown(mutant, find)), None)


def flown_in_vain(mutant: MutantScore, finds: KnownFinds) -> tuple[Find, ...]:
    """The finds of a mutant that were flown in this campaign with as many seeds, and did not show it."""
    return () if mutant.detected else tuple(find for find in finds.of(mutant.subject.id) if _flown(mutant, find))


def _flown(mutant: MutantScore, find: Find) -> bool:
    seeds = find.shows[mutant.subject.id].flights
    return any(result.situation == find.situation and result.flown >= seeds for result in mutant.results)


def words(find: Find) -> str:
    """The situation in words.

    >>> words(Find("shows-A", "T0H2Cs=0.8", ("human walks", "cruise speed 0.8 m/s"), "A", {}, 0))
    'human walks, cruise speed 0.8 m/s'
    """
    return ", ".join(find.words) or "every value benign"


def effect(evidence: Evidence) -> str:
    """What the mutant does there: `violates SR2 and strikes person`."""
    return f"violates {evidence.requirement}" + f" and strikes {evidence.struck}" * bool(evidence.struck)


def facts(find: Find, mutant: str) -> str:
    """The find in a sentence, with its evidence."""
    shown = find.shows[mutant]
    return (
        f"a search found a situation that shows it, {find.name} ({words(find)}): it {effect(shown)} there, in "
        f"{shown.violated} of {shown.flights} flights (p = {shown.p:.2g}); the unmutated drone holds "
        f"{shown.requirement} in {shown.held} of {shown.baselines} by more than its spread." + _replicated(shown)
    )


def _replicated(shown: Evidence) -> str:
    if shown.again is None:
        return "  It is not replicated yet (`scaloft-fi seek --replicate`)."
    again = shown.again
    return (
        f"  On seeds that nothing before used it held again: {again.violated} of {again.flights} (p = {again.p:.2g})."
    )


def flies(find: Find, mutant: str, finds: KnownFinds, campaign: str, grid: str = "") -> str:
    """The command that flies a find for a mutant.

    Args:
        find: one of `finds`.
        mutant: id of a mutant that it shows.
        finds: of the study.
        campaign: name of the campaign that asks; one over the grid of the finds gets the flights itself.
        grid: name of its grid, where that is a further grid of the study.
    """
    where = in_campaign(campaign) if grid == finds.grid != campaign else ""
    named = f"--mutant {mutant} --situation {shlex.quote(find.name)}"
    return f"scaloft-fi run --grid {finds.grid}{where} {named} --seeds {find.shows[mutant].flights}"
