"""The four questions that a score answers, each in a sentence or two: what is shown, what not, how sure, what next."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.scoring.detection import Verdict
from scaloft_fi.analysis.scoring.mutant_score import MutantScore
from scaloft_fi.analysis.scoring.pool import LEAST
from scaloft_fi.analysis.scoring.score import Score

SHOWN, NOT_SHOWN, HOW_SURE, NEXT = NAMES = ("Shown", "Not shown", "How sure", "What next")
MOST_NAMED = 4
"""Mutants that a command names one by one."""


class Answer(NamedTuple):
    """One of the four: its name and the sentences."""

    name: str
    text: str


def answers(scored: Score, roster: Roster, campaign: str = "default") -> tuple[Answer, ...]:
    """The four answers.

    Args:
        scored: the campaign's score.
        roster: which mutants count: the default of each credible cell; where none was flown, all are told.
        campaign: its name, for the commands.
    """
    counted = [mutant for mutant in scored.mutants if roster.counts(mutant.subject) and mutant.flown]
    faults = counted or [mutant for mutant in scored.mutants if mutant.flown]
    told = (_shown, _not_shown, _how_sure, _next) if scored.pooled else (_seen, _unknown, _not_sure, _next)
    return tuple(Answer(name, tell(scored, faults, campaign)) for name, tell in zip(NAMES, told, strict=True))


def _shown(_scored: Score, faults: Sequence[MutantScore], _campaign: str) -> str:
    if not faults:
        return "nothing: no mutant was flown."
    safety = Ratio(sum(mutant.detected for mutant in faults), len(faults))
    operability = sum(mutant.operability.detected for mutant in faults)
    either = sum(mutant.detected or mutant.operability.detected for mutant in faults)
    said = f"{_of(safety)} would have been shown by your safety requirements"
    if operability:
        said += f"; {operability} by operability, {either} by either"
    return f"{said}."


def _not_shown(_scored: Score, faults: Sequence[MutantScore], _campaign: str) -> str:
    fates = Counter(mutant.verdict for mutant in faults)
    parts = {
        Verdict.NOT_DETECTED: "put to the test, and nothing was seen",
        Verdict.UNDECIDED: "undecided: something was seen, or too few flights were flown",
        Verdict.NOT_TESTED: "never put to the test",
    }
    told = "; ".join(f"{fates[verdict]} {words}" for verdict, words in parts.items() if fates[verdict])
    return f"{told or 'none'}."


def _how_sure(scored: Score, faults: Sequence[MutantScore], _campaign: str) -> str:
    tested = sum(mutant.tested for mutant in faults)
    found = sum(mutant.detected for mutant in faults)
    chance = f"{scored.alpha * tested:.2g} ({scored.alpha:g} x {tested} tested)"
    said = f"of the {found} shown, chance explains at most {chance}"
    drawn = scored.redraw
    if drawn.seeds:
        said += f"; of {drawn.safety.whole} redraws of the unmutated drone {drawn.safety.part} would have been shown"
    flown = {pair.flights for pair in scored.pool.pairs.values() if pair.flights >= LEAST}
    seeds = max((result.flown for mutant in faults for result in mutant.results), default=0)
    beside = f"{min(flown)}" + (f" to {max(flown)}" if len(flown) > 1 else "") if flown else "0"
    said += f".  {seeds} seed{'s' * (seeds != 1)} beside {beside} baseline flights a situation"
    return f"{said}; mutants share seeds, so false ones come in groups." if len(faults) > 1 else f"{said}."


def _seen(_scored: Score, faults: Sequence[MutantScore], _campaign: str) -> str:
    if not faults:
        return "nothing: no mutant was flown."
    revealed = sum(mutant.status.value == "revealed" for mutant in faults)
    return (
        f"not known: there is no baseline pool.  {revealed} of {_faults(len(faults))} violated a safety requirement "
        "in a flight whose own baseline held it."
    )


def _unknown(_scored: Score, _faults: Sequence[MutantScore], _campaign: str) -> str:
    return "not known: without a pool nobody can tell a fault from a lucky baseline."


def _not_sure(_scored: Score, _faults: Sequence[MutantScore], _campaign: str) -> str:
    return f"not at all: {LEAST} baseline flights in each situation where a mutant infects would tell what chance does."


def _next(scored: Score, faults: Sequence[MutantScore], campaign: str) -> str:
    if scored.lacking:
        seeds = max((result.flown for mutant in faults for result in mutant.results), default=1)
        where = f"in {len(scored.lacking)} situations"
        return f"`{command(campaign, faults, seeds)}` flies the baseline pool that is missing {where}."
    undecided = [mutant for mutant in faults if mutant.verdict is Verdict.UNDECIDED]
    looks = [mutant for mutant in undecided if mutant.safety.needed and not mutant.safety.anew]
    if looks:
        most = max(mutant.safety.needed or 0 for mutant in looks)
        return f"`{command(campaign, looks, most)}` would decide {len(looks)} of the {len(undecided)} undecided."
    silent = [mutant for mutant in faults if not mutant.detected]
    if silent:
        where = f" --campaign {campaign}" * (campaign != "default")
        told = f"`scaloft-fi kills{where} --show survivors`"
        return f"{told} says of each fault not shown where it stopped, and what to change."
    if faults:
        return f"`scaloft-fi margin {faults[0].subject.id}` finds the smallest magnitude that is still shown."
    return "`scaloft-fi run --mutant ID` flies a mutant; `scaloft-fi mutants` lists them."


def command(campaign: str, mutants: Sequence[MutantScore], seeds: int) -> str:
    """The `run` that flies these mutants; of many all that the study has."""
    words = ["scaloft-fi run"]
    if campaign != "default":
        words.append(f"--campaign {campaign}")
    if len(mutants) <= MOST_NAMED:
        words += [f"--mutant {mutant.subject.id}" for mutant in mutants]
    if seeds > 1:
        words.append(f"--seeds {seeds}")
    return " ".join(words)


def _of(ratio: Ratio) -> str:
    share = "" if ratio.whole < 2 else f" ({100 * ratio.part / ratio.whole:.0f} %)"
    return f"{ratio.part} of {_faults(ratio.whole)}{share}"


def _faults(count: int) -> str:
    return f"{count} fault{'s' * (count != 1)}"
