"""Survivors by the stage where they stopped (reach, infect, propagate, reveal), each with the next thing to do.

A survivor is a mutant that is not detected.  A fault that stops at reach or infect asks for a situation, at propagate
for a magnitude, at reveal for a magnitude, an oracle or more flights (after the RIPR model of Ammann and Offutt; that a
survivor should say where it stopped is this project's proposal).  Every rule reads flights, their score and what the
matrix says of a cell; none knows a mutant by name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import KillMatrix, Loss
from scaloft_fi.analysis.pool import LEAST, State
from scaloft_fi.analysis.score import Score
from scaloft_fi.analysis.survivor import Background, Campaign, Case
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.hazop.matrix import class_of, worst_first
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Requirement
from scaloft_fi.judge.status import Status
from scaloft_fi.study import NO_FINDS, KnownFinds
from scaloft_fi.views.kills import survivor_words as words
from scaloft_fi.views.score.commands import in_campaign
from scaloft_fi.views.score.finds import facts, flies, flown_in_vain, next_find
from scaloft_fi.views.score.next_step import Next, infecting, next_steps

NEAR = 0.5
"""A flight that lost half its baseline's margin is a near miss: a somewhat larger fault may be detected."""
ASTRAY_M = 0.5
"""A flight is far off its baseline's path from here [m]: as near as the study asks a waypoint to be passed."""
SILENT = "Judge whether that is a hazard; if it is, a requirement is missing."


class Stage(StrEnum):
    """Where a survivor stopped."""

    HARNESS = "harness"
    """No flight of it counts."""
    REACH = "reach"
    """The seam carried no sample."""
    INFECT = "infect"
    """No sample was changed."""
    PROPAGATE = "propagate"
    """Samples were changed, the drone flew the same to the bit."""
    REVEAL = "reveal"
    """The drone flew otherwise, and violated no safety requirement more often than chance explains."""


_STAGE = dict.fromkeys(Status, Stage.REVEAL) | {
    Status.INVALID: Stage.HARNESS,
    Status.NOT_REACHED: Stage.REACH,
    Status.NOT_INFECTED: Stage.INFECT,
    Status.MASKED: Stage.PROPAGATE,
}


@dataclass(frozen=True)
class Survivor:
    """A mutant that is not detected.

    Attributes:
        mutant: id.
        verdict: on it; never `detected`.
        stage: where it stopped.
        next: what to change.
        why: the facts that say so, and what to do, in a few sentences.
        loss: where it lost most of a baseline's margin in a steady pair; None where it cannot be measured.
        off_path_m: how far it was off its baseline's path at the most, over flights that put it to the test and have a
            trajectory [m]; None without such a flight.
        find: name of the find that is to be flown; empty without one.
        severity: class of its cell; None where the cell has none.
    """

    mutant: str
    verdict: Verdict
    stage: Stage
    next: Next
    why: str
    loss: Loss | None = None
    off_path_m: float | None = None
    find: str = ""
    severity: str | None = None


def survivors(
    outcomes: Iterable[Outcome],
    scored: Score,
    matrix: KillMatrix,
    backgrounds: Mapping[str, Background],
    units: Mapping[str, str] | None = None,
    name: str = CAMPAIGN,
    finds: KnownFinds = NO_FINDS,
) -> tuple[Survivor, ...]:
    """Every mutant that is not detected, the worst class first, by stage, then in the matrix's order; no controls.

    Args:
        outcomes: of the campaign, with the trajectories of a seed if distances off the path are wanted.
        scored: their score.
        matrix: its kill matrix, or those rows of it that are asked for.
        backgrounds: of every mutant in it.
        units: of the requirements' robustness, by name.
        name: of the campaign.
        finds: of the study.
    """
    campaign = Campaign.of(outcomes, scored, matrix, backgrounds, units or {}, name)
    cases = [Case(campaign, row, backgrounds[row.id]) for row in matrix.mutants if row.verdict is not Verdict.DETECTED]
    cases.sort(key=lambda case: list(Stage).index(_STAGE[case.row.status]))
    ordered = worst_first(cases, lambda case: case.score.severity)
    told = [(_told(case, scored, finds), class_of(case.score.severity) or None) for case in ordered]
    return tuple(replace(survivor, severity=severity) for survivor, severity in told)


def short_units(requirements: Iterable[Requirement]) -> dict[str, str]:
    """The unit of each requirement's robustness, without what the study says beside it."""
    return {requirement.name: requirement.unit.split(" (")[0].split(";")[0] for requirement in requirements}


def _say(case: Case, next_: Next, *sentences: str) -> Survivor:
    why = " ".join(sentence[:1].upper() + sentence[1:] for sentence in sentences if sentence)
    return Survivor(case.row.id, case.row.verdict, _STAGE[case.row.status], next_, why, case.loss, case.off_path_m)


def _told(case: Case, scored: Score, finds: KnownFinds) -> Survivor:
    """The survivor: its find is to be flown, or what its flights say."""
    find = next_find(case.score, finds)
    if find is not None:
        command = flies(find, case.row.id, finds, case.campaign.name, case.campaign.space.grid)
        return replace(_say(case, Next.FIND, facts(find, case.row.id), f"`{command}` flies it."), find=find.name)
    first, *others = next_steps(case.score, scored, case.background)
    survivor = _not_shown(case) if others else _judge(case, scored, first)
    vain = flown_in_vain(case.score, finds)
    return replace(survivor, why=f"{survivor.why} {words.in_vain(case, vain)}") if vain else survivor


def _judge(case: Case, scored: Score, step: Next) -> Survivor:
    """The survivor whose score asks for one step."""
    stage = _STAGE[case.row.status]
    if stage is Stage.HARNESS:
        return _say(case, step, "no flight of it counts: fly it again.")
    if step is Next.EXPECTED:
        return _say(case, step, f"declared beforehand: {case.background.expected}.")
    if stage is Stage.REACH:
        return _not_reached(case, step)
    if stage is Stage.INFECT:
        return _not_infected(case, scored, step)
    if step is Next.POOL:
        return _not_pooled(case, step)
    if case.row.verdict is Verdict.NOT_TESTED:
        return _nowhere_steady(case, step)
    if stage is Stage.PROPAGATE:
        return _masked(case, step)
    if case.row.verdict is Verdict.UNDECIDED:
        return _say(case, step, words.rates(case), words.seeds(case))
    if case.score.operability.detected:
        return _operable(case, step)
    return _say(case, step, words.untested(case), words.only_unsteady(case), words.margin(case))


def _not_reached(case: Case, step: Next) -> Survivor:
    seam, campaign = case.background.seam, case.campaign
    missed = campaign.carrying.get(seam, frozenset()) - case.flown
    if missed:
        first = min(missed, key=campaign.space.rank)
        return _say(case, step, f"the seam `{seam}` carries samples where it was not flown: fly {first}.")
    return _say(
        case,
        step,
        f"the seam `{seam}` carried no sample in {words.situations(len(case.flown))} flown; {words.left(case)}",
    )


def _not_infected(case: Case, scored: Score, step: Next) -> Survivor:
    if step is Next.MAGNITUDE:
        stronger, *_ = infecting(scored, case.background.stronger)
        return _say(case, step, f"it changes no sample, {stronger} does: too small to be seen.")
    reached = {result.situation for result in case.score.results if result.reached}
    where = words.in_(case.campaign.where(reached.__contains__, case.flown))
    carries = f"the seam `{case.background.seam}` carries samples {where}, none of which the fault changes;"
    return _say(case, step, f"{carries} {words.left(case)}")


def _not_pooled(case: Case, step: Next) -> Survivor:
    flies = f"`scaloft-fi run{in_campaign(case.campaign.name)} --mutant {case.row.id}` flies them."
    return _say(
        case,
        step,
        f"{words.violate(sum(bool(flight.revealed) for flight in case.flights))}.",
        f"A verdict takes {LEAST} baselines in each situation where it infects, and {len(case.lacking)} of "
        f"{len(case.infected)} have fewer: {flies}",
    )


def _nowhere_steady(case: Case, step: Next) -> Survivor:
    states = {name: case.campaign.states(name, case.infected) for name in case.campaign.safety}
    present = set().union(*states.values())
    listed = "; ".join(f"{name} is {words.states_in_words(counts)}" for name, counts in states.items())
    mend = ", or mend the unmutated drone there" if present & {State.RED, State.UNSTEADY} else ""
    return _say(
        case,
        step,
        f"it infects {words.in_(case.infected_where)}, and no safety requirement is steady there: "
        f"{listed or 'the study has none'}.",
        f"Add a situation where it infects and a safety requirement is steady{mend}.",
    )


def _masked(case: Case, step: Next) -> Survivor:
    masked = f"it changes samples {words.in_(case.infected_where)}, and the drone flies the same to the bit."
    if step is Next.MAGNITUDE:
        return _say(case, step, masked, words.larger(case), words.seeds(case))
    missing = "A situation is missing where the drone acts on what the fault changes."
    return _say(case, step, masked, missing, words.seeds(case))


def _operable(case: Case, step: Next) -> Survivor:
    tests = [result for result in case.score.results if result.steady_operability]
    killing = sum(bool(result.operability_kills) for result in tests)
    safety = [name for name in case.background.at_risk if name in case.campaign.safety]
    by = words.listed(case.score.operability.by)
    return _say(
        case,
        step,
        f"by {by} it is detected, and killed in {killing} of {words.situations(len(tests))} where {by} is steady; "
        "no safety requirement detects it.",
        f"Its cell puts {words.listed(safety) or 'none'} at risk.",
        SILENT if safety else "Operability has a score of its own.",
        words.only_unsteady(case),
        words.margin(case),
    )


def _not_shown(case: Case) -> Survivor:
    """The survivor that was put to the test by what its cell puts at risk: margins and paths say what to change."""
    lucky, stronger = words.only_unsteady(case), case.background.stronger
    if case.loss is not None and case.loss.share >= NEAR:
        near = f"near miss: {words.margin(case)}"
        if stronger:
            return _say(case, Next.MAGNITUDE, near, lucky, words.larger(case))
        return _say(
            case, Next.SITUATION, near, lucky, f"{words.no_more(case)}: a situation with less room may show it."
        )
    if case.off_path_m is not None and case.off_path_m >= ASTRAY_M:
        astray = f"it takes the drone {case.off_path_m:.2f} m off its path, and no requirement detects it."
        return _say(case, Next.ORACLE, astray, SILENT, lucky, words.margin(case))
    if stronger:
        return _say(case, Next.MAGNITUDE, words.path(case), lucky, words.margin(case), words.larger(case))
    missing = f"{words.no_more(case)}: a situation is missing in which what it changes matters."
    return _say(case, Next.SITUATION, words.path(case), lucky, words.margin(case), missing)
