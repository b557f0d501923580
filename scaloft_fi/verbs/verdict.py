"""A verdict in words: what it rests on, what would decide an open one, and the command to call next."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Collection, Sequence
from enum import StrEnum
from typing import NamedTuple

from scaloft_fi.analysis.detection import LARGER, Firmness, Noise, Verdict
from scaloft_fi.analysis.pool import LEAST, State
from scaloft_fi.analysis.roster import Ratio, Roster
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.survivor import Background, Disposition, score_without
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import Status
from scaloft_fi.sim.found import Evidence, Find
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import NO_FINDS, KnownFinds

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


NO_POOL = (
    f"no situation in which a mutant changes a sample has {LEAST} baseline flights to decide by; `scaloft-fi run` with "
    "the same mutants flies them"
)
"""Why a campaign without a pool has no verdict, and what flies one."""


def verdict(mutant: MutantScore, lacking: Collection[str]) -> str:
    """The verdict by safety requirements and what it rests on: `detected: killed in 8 of 23 situations ...`.

    Args:
        mutant: of a score.
        lacking: situations where the pool has too few flights, as the score names them.
    """
    return f"{mutant.verdict.words}: {why(mutant, lacking)}"


def why(mutant: MutantScore, lacking: Collection[str]) -> str:
    """What the verdict rests on; detection by operability requirements behind it."""
    if mutant.verdict is Verdict.UNDECIDED:
        text = _undecided(mutant, lacking)
    elif mutant.detected:
        text = _detected(mutant)
    else:
        text = f"nothing seen in {_tests(mutant)}; {_unseen(mutant)}" if mutant.tested else _untested(mutant)
    return text + ("; by operability it is detected" if mutant.operability.detected else "")


def would_decide(mutant: MutantScore, lacking: Collection[str]) -> str:
    """What would decide an undecided mutant; empty for any other."""
    safety = mutant.safety
    if mutant.verdict is not Verdict.UNDECIDED:
        return ""
    if lacks_pool(mutant, lacking):
        return f"{LEAST} baseline flights in each situation"
    if safety.needed is None:
        return f"no number of seeds up to {LARGER[-1]}"
    return f"{safety.needed} seeds" + (" in a campaign of its own" if safety.anew else "")


def next_command(
    mutant: MutantScore, lacking: Collection[str], campaign: str, grid: str = "", finds: KnownFinds = NO_FINDS
) -> str:
    """What to call next for a mutant that is not detected: its find, else what would decide, else what is known.

    Args:
        mutant: the mutant.
        lacking: situations without a baseline pool.
        campaign: name of the campaign.
        grid: name of its grid, where that is a further grid of the study.
        finds: of the study.
    """
    find = next_find(mutant, finds)
    if find is not None:
        return flies(find, mutant.subject.id, finds, campaign, grid)
    if mutant.verdict is Verdict.UNDECIDED and lacks_pool(mutant, lacking):
        return command(campaign, [mutant], max((result.flown for result in mutant.results), default=1))
    if mutant.safety.needed and not mutant.without_effect:
        return flies_seeds(mutant, campaign, grid)
    return f"scaloft-fi kills{in_campaign(campaign)} {mutant.subject.id} --show survivors"


def flies_seeds(mutant: MutantScore, campaign: str, grid: str = "") -> str:
    """The command that flies as many seeds as would decide an undecided mutant; the arguments of `next_command`."""
    safety = mutant.safety
    if not safety.anew:
        return command(campaign, [mutant], safety.needed or 1)
    return command("ANOTHER", [mutant], safety.needed or 1, grid=grid)


def lacks_pool(mutant: MutantScore, lacking: Collection[str]) -> bool:
    """Whether an undecided mutant changes samples in a situation where the pool has too few flights."""
    return not mutant.tested or any(result.infected and result.situation in lacking for result in mutant.results)


def _detected(mutant: MutantScore) -> str:
    if mutant.kills:
        names = {kill.requirement for kill in mutant.kills}
        by = ", ".join(
            f"{name} in {ratio.part} of {ratio.whole}" for name, ratio in mutant.requirements if name in names
        )
        return f"killed in {len(mutant.killing)} of {_tests(mutant)} ({by}); {_firm(mutant)}"
    by = ", ".join(f"{name} (p = {mutant.safety.p[name]:.2g})" for name in mutant.safety.by)
    seen = f"; seen in {len(mutant.seen_in)} of {_tests(mutant)}" if mutant.seen_in else ""
    often = f"it violates {by} more often than chance explains, but nowhere in most of its flights{seen}"
    return f"{often}; {_firm(mutant)}"


def _firm(mutant: MutantScore) -> str:
    return mutant.firmness.words if mutant.firmness else ""


def _undecided(mutant: MutantScore, lacking: Collection[str]) -> str:
    decides = f"{would_decide(mutant, lacking)} would decide"
    if mutant.seen_in:
        names = " and ".join(dict.fromkeys(name for result in mutant.results for name in result.seen))
        rate = f"{len(mutant.seen_in)} of {_tests(mutant)}"
        p = f"p = {min(mutant.safety.p.values()):.2g}"
        return f"it violates {names} in {rate}, which chance may explain ({p}); {decides}, if this goes on"
    if mutant.tested:
        same = "; samples changed, no flight did" if mutant.without_effect else ""
        nothing = f"nothing seen in {_tests(mutant)}{same}"
        if lacks_pool(mutant, lacking):
            return f"{nothing}, and others have too few baseline flights to tell; {decides}"
        return f"{nothing}, with too few flights to tell; {decides}"
    counts = dict(mutant.statuses)
    revealed, flown = counts.get(Status.REVEALED, 0), sum(result.flown for result in mutant.results)
    seen = f"{revealed} of its {flown} flights violate a safety requirement that the baseline beside them holds"
    return f"too few baseline flights to tell; {seen}; {decides}"


def _unseen(mutant: MutantScore) -> str:
    if mutant.status is Status.MASKED:
        return "samples changed, no flight did"
    if {Status.REVEALED, Status.BASELINE_RED} & dict(mutant.statuses).keys():
        return "violations only where the unmutated drone does not hold the requirement steadily"
    return "the flights that changed violate no safety requirement"


def _untested(mutant: MutantScore) -> str:
    if not mutant.flown:
        return "the harness failed in every flight"
    if mutant.infected:
        return "it changes no sample where the unmutated drone holds a safety requirement steadily"
    if any(result.reached for result in mutant.results):
        return "it changes no sample in any situation flown"
    return "no sample crosses the patched interface in any situation flown"


def _tests(mutant: MutantScore) -> str:
    count = mutant.kill_rate.whole
    return f"{count} situation that tests it" if count == 1 else f"{count} situations that test it"


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


class Next(StrEnum):
    """What would make a survivor say something."""

    REPEAT = "repeat"
    FIND = "find"
    """The situation that a search found for it, which is to be flown."""
    POOL = "pool"
    """The baselines that are lacking to decide."""
    SEEDS = "seeds"
    SITUATION = "situation"
    MAGNITUDE = "magnitude"
    ORACLE = "oracle"
    OPERABILITY = "operability"
    """Nothing: an operability requirement detects it, and its cell puts no other at risk."""
    EXPECTED = "expected"
    """The study declares, with a reason, that it alters nothing in this grid."""


def next_steps(
    mutant: MutantScore, scored: Score, background: Background | None, finds: KnownFinds = NO_FINDS
) -> tuple[Next, ...]:
    """The step that the score of a mutant asks for; of two, its flights say which.

    Args:
        mutant: not detected.
        scored: of the campaign.
        background: what the study knows of the mutant; None where it knows nothing.
        finds: of the study.
    """
    known = background or Background("")
    stronger = Next.MAGNITUDE if known.stronger else Next.SITUATION
    if next_find(mutant, finds) is not None:
        return (Next.FIND,)
    if not mutant.flown:
        return (Next.REPEAT,)
    if known.expected and not mutant.infected:
        return (Next.EXPECTED,)
    if not mutant.infected:
        reached = any(result.reached for result in mutant.results)
        return (Next.MAGNITUDE if reached and infecting(scored, known.stronger) else Next.SITUATION,)
    if any(result.infected and result.situation in scored.lacking for result in mutant.results):
        return (Next.POOL,)
    if mutant.verdict is Verdict.NOT_TESTED:
        return (Next.SITUATION,)
    if mutant.status is Status.MASKED:
        return (stronger,)
    if mutant.verdict is Verdict.UNDECIDED:
        return (Next.SEEDS if mutant.safety.needed else Next.SITUATION,)
    safety = [name for name in known.at_risk if name in scored.pool.requirements(Kind.SAFETY)]
    if mutant.operability.detected:
        return (Next.ORACLE if safety else Next.OPERABILITY,)
    infected = [result.situation for result in mutant.results if result.infected]
    states = {scored.pool.states.get((key, name)) for key in infected for name in safety}
    return (Next.SITUATION,) if safety and State.STEADY not in states else (stronger, Next.ORACLE)


def infecting(scored: Score, ids: Sequence[str]) -> list[str]:
    """Those of some mutants that change a sample."""
    scores = {mutant.subject.id: mutant for mutant in scored.mutants}
    return [id_ for id_ in ids if id_ in scores and scores[id_].infected]


SHORT = {
    Next.REPEAT: "fly it again",
    Next.FIND: "fly its find",
    Next.POOL: "a baseline pool",
    Next.SITUATION: "another situation",
    Next.ORACLE: "an oracle",
    Next.OPERABILITY: "nothing: operability",
    Next.EXPECTED: "nothing: expected",
}
"""The steps in a few words; magnitude and seeds are named by `short_step`."""


def short_step(mutant: MutantScore, steps: Sequence[Next], background: Background | None) -> str:
    """The steps in a few words, for a row of a table."""
    words = dict(SHORT)
    words[Next.SEEDS] = f"--seeds {mutant.safety.needed}" + ", anew" * mutant.safety.anew
    words[Next.MAGNITUDE] = f"try {background.stronger[0]}" if background and background.stronger else ""
    return " or ".join(words[step] for step in steps)


def noise_line(noise: Sequence[Noise]) -> str:
    """What the stack alone does to the robustness of each requirement, beside what the seeds do.

    >>> noise_line([Noise("SR1", 6, 0.0123, 0.2, 0), Noise("SR2", 0, None, None, 0)])
    'one flight varies by the stack alone (and between seeds): SR1 0.012 (0.2) by 6 pairs, SR2 not measured.'
    """
    told = ", ".join(_one(one) for one in noise)
    apart = [f"{one.requirement} in {one.apart} of {one.pairs}" for one in noise if one.apart]
    verdicts = f"  A pair has two verdicts: {', '.join(apart)}." if apart else ""
    return f"one flight varies by the stack alone (and between seeds): {told}.{verdicts}"


def _one(one: Noise) -> str:
    if one.stack is None:
        return f"{one.requirement} not measured"
    seeds = f" ({one.seeds:.2g})" if one.seeds is not None else ""
    return f"{one.requirement} {one.stack:.2g}{seeds} by {one.pairs} pairs"


def acceptance(disposition: Disposition) -> str:
    """Who accepted a survivor, where, until when and why."""
    where = f" in {', '.join(disposition.situations)}" if disposition.situations else ""
    until = disposition.expires.isoformat()
    return f"accepted{where} by {disposition.owner} until {until}: {disposition.reason}"


def accepted_line(scored: Score, accepted: Sequence[Disposition]) -> str:
    """How many survivors were accepted and by whom, and the score with and without them, in a sentence."""
    owners = Counter(known.owner for known in accepted)
    by = ", ".join(f"{owner} {number}" if len(owners) > 1 else owner for owner, number in owners.items())
    score, without = scored.mutation_score, score_without(scored, accepted)
    share = f" ({100 * without.value:.0f} %)" if without.value is not None else ""
    return (
        f"{len(accepted)} of the {score.whole - score.part} faults not shown (by {by}).  Shown: {score.part} of "
        f"{score.whole} with them, {without.part} of {without.whole}{share} without them; "
        "`scaloft-fi dispositions` lists them."
    )


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
