"""What the verdict on a mutant rests on, in a line, and what would decide one that is open."""

from __future__ import annotations

from collections.abc import Collection

from scaloft_fi.analysis.detection import LARGER, Verdict
from scaloft_fi.analysis.pool import LEAST
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.judge.status import Status
from scaloft_fi.study import NO_FINDS, KnownFinds
from scaloft_fi.views.score.commands import command, in_campaign
from scaloft_fi.views.score.finds import flies, next_find

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
