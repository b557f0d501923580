"""The four questions that a score answers, each in a sentence or two: what is shown, what not, how sure, what next."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from typing import NamedTuple

from scaloft_fi.analysis.detection import Firmness, Verdict
from scaloft_fi.analysis.pool import LEAST
from scaloft_fi.analysis.roster import Ratio, Roster
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.study import NO_FINDS, KnownFinds
from scaloft_fi.views.score.commands import command, in_campaign
from scaloft_fi.views.score.finds import effect, flies, next_find, words

NOT_COMPARED = (
    "Scores of two studies do not compare: whoever writes easier cells, or fewer hard ones, scores higher.  Compare "
    "two stacks or versions by the same matrix."
)
SHOWN, NOT_SHOWN, HOW_SURE, NEXT = NAMES = ("Shown", "Not shown", "How sure", "What next")


class Line(NamedTuple):
    """A line of the first screen, such as one of the four answers: its name and the sentences."""

    name: str
    text: str


class Asked(NamedTuple):
    """What the answers are about.

    Attributes:
        scored: the campaign's score.
        faults: the mutants that the answers count.
        campaign: its name.
        defaults: ids of the mutants that `run` flies when none is named.
        finds: of the study.
        grid: name of the campaign's grid, where that is a further grid of the study.
    """

    scored: Score
    faults: Sequence[MutantScore]
    campaign: str
    defaults: Collection[str]
    finds: KnownFinds
    grid: str


def answers(
    scored: Score, roster: Roster, campaign: str = CAMPAIGN, finds: KnownFinds = NO_FINDS, grid: str = ""
) -> tuple[Line, ...]:
    """The four answers.

    Args:
        scored: the campaign's score.
        roster: which mutants count: the default of each credible cell; where none was flown, all do.
        campaign: its name, for the commands.
        finds: of the study.
        grid: name of the campaign's grid, where that is a further grid of the study.
    """
    faults = scored.counted or [mutant for mutant in scored.mutants if mutant.flown]
    sentences = (_shown, _not_shown, _how_sure, _next) if scored.pooled else (_seen, _unknown, _not_sure, _next)
    asked = Asked(scored, faults, campaign, frozenset(roster.defaults.values()), finds, grid)
    return tuple(Line(name, answer(asked)) for name, answer in zip(NAMES, sentences, strict=True))


def _shown(asked: Asked) -> str:
    if not asked.faults:
        return "nothing: no mutant was flown."
    safety = Ratio(sum(mutant.detected for mutant in asked.faults), len(asked.faults))
    operability = sum(mutant.operability.detected for mutant in asked.faults)
    either = sum(mutant.detected or mutant.operability.detected for mutant in asked.faults)
    shown = f"{_of(safety)} would have been shown by your safety requirements{_firmly(asked.faults)}"
    if operability:
        shown += f".  By operability {operability}, by either {either}"
    if found := len(asked.scored.selected):
        were = "situation was" if found == 1 else "situations were"
        return f"{shown}.  Selected: {found} {were} found by a search for faults that were not shown."
    return f"{shown}."


def _firmly(faults: Sequence[MutantScore]) -> str:
    """How many of the detected are firm."""
    known = Counter(mutant.firmness for mutant in faults if mutant.firmness is not None)
    detected, firm = known.total(), sum(count for firmness, count in known.items() if firmness.firm)
    if not detected:
        return ""
    if detected == 1:
        (firmness,) = known
        return f", {firmness.words if firmness.firm else 'not firmly: ' + firmness.words}"
    alone = known[Firmness.FIRM_BY_POOL]
    by_pool = "" if not alone else " by the pool alone" if alone == firm else f", {alone} of these by the pool alone"
    return f", {firm} firmly{by_pool}"


def _not_shown(asked: Asked) -> str:
    idle = sum(mutant.without_effect for mutant in asked.faults)
    fates = Counter(mutant.verdict for mutant in asked.faults if not mutant.without_effect)
    parts = {
        Verdict.NOT_DETECTED: "put to the test, and nothing was seen",
        Verdict.UNDECIDED: "undecided: something was seen, or too few flights were flown",
        Verdict.NOT_TESTED: "never put to the test",
    }
    counts = [f"{fates[verdict]} {words}" for verdict, words in parts.items() if fates[verdict]]
    if idle:
        counts.append(f"{idle} without effect here: every flight equals the baseline's to the bit")
    return f"{'; '.join(counts) or 'none'}."


def _how_sure(asked: Asked) -> str:
    tested = sum(mutant.tested for mutant in asked.faults)
    drawn = asked.scored.redraw
    sure = false_detections(asked.scored.alpha, tested)
    if drawn.seeds:
        sure += f"  Of {drawn.safety.whole} redraws of the unmutated drone {drawn.safety.part} were called shown."
    flown = {pair.flights for pair in asked.scored.pool.pairs.values() if pair.flights >= LEAST}
    seeds = max((result.flown for mutant in asked.faults for result in mutant.results), default=0)
    beside = f"{min(flown)}" + (f" to {max(flown)}" if len(flown) > 1 else "") if flown else "0"
    sure += f"  {seeds} seed{'s' * (seeds != 1)} beside {beside} baseline flights a situation"
    if any(mutant.detected for mutant in asked.faults):
        sure += "; firm: shown whichever one seed is left out"
    return f"{sure}."


def false_detections(alpha: float, tested: int) -> str:
    """What the test would do to faults without effect: no probability of being wrong about one that is shown."""
    if not tested:
        return "No fault was put to the test, so there is nothing to be sure of."
    if tested == 1:
        return f"A fault without effect would be called shown with a probability of {alpha:g} at most."
    return (
        f"If none of the {tested} faults put to the test had any effect, {alpha * tested:.2g} at most would still be "
        f"called shown, on average ({alpha:g} x {tested}); as mutants share seeds, then several at once."
    )


def _seen(asked: Asked) -> str:
    if not asked.faults:
        return "nothing: no mutant was flown."
    revealed = sum(mutant.status.value == "revealed" for mutant in asked.faults)
    return (
        f"not known: there is no baseline pool.  {revealed} of {_faults(len(asked.faults))} violated a safety "
        "requirement in a flight whose own baseline held it."
    )


def _unknown(_asked: Asked) -> str:
    return "not known: without a baseline pool a fault cannot be told from chance."


def _not_sure(_asked: Asked) -> str:
    return f"not at all: {LEAST} baseline flights in each situation where a mutant infects would show what chance does."


def _next(asked: Asked) -> str:
    if asked.scored.lacking:
        seeds = max((result.flown for mutant in asked.faults for result in mutant.results), default=1)
        flies = command(asked.campaign, asked.faults, seeds, asked.defaults)
        count = len(asked.scored.lacking)
        return f"`{flies}` flies the baseline pool that is missing in {count} situation{'s' * (count != 1)}."
    if found := _found(asked):
        return found
    undecided = [mutant for mutant in asked.faults if mutant.verdict is Verdict.UNDECIDED]
    looks = [mutant for mutant in undecided if mutant.safety.needed and not mutant.safety.anew]
    if looks:
        most = max(mutant.safety.needed or 0 for mutant in looks)
        flies = command(asked.campaign, looks, most, asked.defaults)
        return f"`{flies}` would decide {len(looks)} of the {len(undecided)} undecided."
    silent = [mutant for mutant in asked.faults if not mutant.detected]
    if silent:
        survivors = f"`scaloft-fi kills{in_campaign(asked.campaign)} --show survivors`"
        return f"{survivors} says of each fault not shown where it stopped, and what to change."
    if asked.faults:
        where = in_campaign(asked.campaign)
        return (
            f"`scaloft-fi margin{where} {asked.faults[0].subject.id}` finds the smallest magnitude that is still shown."
        )
    return "`scaloft-fi run --mutant ID` flies a mutant; `scaloft-fi mutants` lists them."


def _found(asked: Asked) -> str:
    """The command that flies the find of the first fault that has one; empty where none has."""
    finds = [(mutant.subject.id, find) for mutant in asked.faults if (find := next_find(mutant, asked.finds))]
    if not finds:
        return ""
    (mutant, find), *others = finds
    flown = f"`{flies(find, mutant, asked.finds, asked.campaign, asked.grid)}`"
    shows = f"{flown} flies the situation that a search found for it: {words(find)} ({effect(find.shows[mutant])})."
    if not others:
        return shows
    survivors = f"`scaloft-fi kills{in_campaign(asked.campaign)} --show survivors`"
    more = "1 more fault has a find" if len(others) == 1 else f"{len(others)} more faults have a find"
    return f"{shows}  {more}: {survivors}."


def _of(ratio: Ratio) -> str:
    share = "" if ratio.whole < 2 else f" ({100 * ratio.part / ratio.whole:.0f} %)"
    return f"{ratio.part} of {_faults(ratio.whole)}{share}"


def _faults(count: int) -> str:
    return f"{count} fault{'s' * (count != 1)}"
