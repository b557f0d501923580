"""Survivors by the stage where they stopped (reach, infect, propagate, reveal), each with the next thing to do.

A survivor is a mutant that is not detected.  A fault that stops at reach or infect asks for a situation, at propagate
for a magnitude, at reveal for a magnitude, an oracle or more flights (after the RIPR model of Ammann and Offutt; that a
survivor should say where it stopped is this project's proposal).  Every rule reads flights, their score and what the
matrix says of a cell; none knows a mutant by name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import KillMatrix, Loss
from scaloft_fi.analysis.pool import LEAST, State
from scaloft_fi.analysis.score import Score
from scaloft_fi.analysis.survivor import Background, CampaignFacts, Case
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.hazop.matrix import class_of, worst_first
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Requirement
from scaloft_fi.judge.status import Status
from scaloft_fi.sim.found import Find
from scaloft_fi.study import NO_FINDS, KnownFinds
from scaloft_fi.verbs.verdict import (
    Next,
    facts,
    flies,
    flies_seeds,
    flown_in_vain,
    in_campaign,
    infecting,
    next_find,
    next_steps,
    would_decide,
)

NAMED = 3
"""How many situations a sentence names before it counts the rest."""


def rates(case: Case) -> str:
    """What was seen of an undecided mutant, and why that does not decide."""
    safety, sentences = case.score.safety, []
    for name in case.campaign.safety:
        tests = [result for result in case.score.results if name in result.steady]
        violated = {result.situation: count for result in tests if (count := dict(result.violated).get(name))}
        if violated:
            sentences.append(
                f"{sum(violated.values())} of {sum(result.flown for result in tests)} flights where {name} is steady "
                f"violate it, in {_some(list(violated))}: chance may explain that (p = {safety.p[name]:.2g}, alpha "
                f"{safety.share:g})."
            )
    flown = len(case.tested)
    return " ".join(sentences) or (
        f"no steady requirement is violated in {flown} flight{'s' * (flown != 1)}: too few to decide, whatever they do."
    )


def seeds(case: Case) -> str:
    """How many seeds would decide an undecided mutant, with the command; empty for any other."""
    decides = would_decide(case.score, case.lacking)
    if not decides:
        return ""
    rate = "At that rate" if case.score.seen_in else "If every flight violated,"
    if case.score.safety.needed is None:
        return f"{rate} {decides} would decide: add a situation where it shows more often."
    flies = flies_seeds(case.score, case.campaign.name, case.campaign.space.grid)
    return f"{rate} {decides} would decide: `{flies}`."


def only_unsteady(case: Case) -> str:
    """Where flights violate what the baselines of their seeds hold, if none of it is steady; empty if none do."""
    revealing = [flight for flight in case.flights if flight.revealed]
    where: dict[str, set[str]] = {}
    for flight in revealing:
        for name in flight.revealed:
            where.setdefault(name, set()).add(flight.outcome.situation)
    unsteady = [f"{name} is {states_in_words(case.campaign.states(name, keys))}" for name, keys in where.items()]
    return f"{violate(len(revealing))}, but only where that is not steady: {'; '.join(unsteady)}." if unsteady else ""


def path(case: Case) -> str:
    """How far it takes the drone off its path."""
    if case.off_path_m is None:
        return "how far the drone flies off its path is not known: no trajectory."
    return f"it takes the drone at most {case.off_path_m:.2f} m off its path."


def violate(flights: int) -> str:
    """How many flights violate a safety requirement, each beside its own baseline."""
    if flights == 1:
        return "1 flight violates what the baseline of its seed holds"
    return f"{flights or 'no'} flights violate what the baselines of their seeds hold"


def untested(case: Case) -> str:
    """Why no flight could have violated what the cell puts at risk; empty when one could."""
    campaign = case.campaign
    at_risk = [name for name in case.background.at_risk if name in campaign.safety]
    states = {name: campaign.states(name, case.infected) for name in at_risk}
    if not at_risk or any(State.STEADY in counts for counts in states.values()):
        return ""
    sentences = []
    for name, counts in states.items():
        steady = {key for key in campaign.pool.flown if campaign.pool.states.get((key, name)) is State.STEADY}
        where = campaign.where(steady.__contains__, campaign.pool.flown)
        sentences.append(
            f"{name}, which the cell puts at risk, is {states_in_words(counts)} where it infects; "
            f"it is steady {in_(where)}."
        )
    return " ".join(sentences)


def margin(case: Case) -> str:
    """As in: SR1 fell from 0.31 to 0.12 m in T0O0W0D0H1 (61 % of the margin)."""
    loss = case.loss
    if loss is None:
        return ""
    if loss.share <= 0:
        return "No margin fell."
    unit = case.campaign.units.get(loss.requirement, "")
    at = f"in {loss.situation}" + (f", seed {loss.seed}" if loss.seed else "")
    change = f"from {loss.baseline:.2g} to {loss.flown:.2g}{' ' * bool(unit)}{unit}"
    return f"{loss.requirement} fell {change} {at} ({100 * loss.share:.0f} % of the margin)."


def left(case: Case) -> str:
    """What of the grid is left to fly."""
    space = case.campaign.space
    count = len(space.points) - len({space.point[key] for key in case.flown if key in space.point})
    if not count:
        return "the whole grid was flown: add a situation."
    return f"{situations(count)} of the grid {'was' if count == 1 else 'were'} not flown."


def larger(case: Case) -> str:
    """What to do where a larger fault may be detected."""
    searches = f"`scaloft-fi margin{in_campaign(case.campaign.name)} {case.row.id}` searches"
    return f"The next rung is {case.background.stronger[0]}; {searches} for the least magnitude that is killed."


def no_more(case: Case) -> str:
    """Why no larger magnitude is asked for."""
    return "its ladder ends here" if case.background.laddered else "the fault has no magnitude to raise"


def states_in_words(states: Mapping[State, int]) -> str:
    """As in: `vacuous in 1 and red in 2 situations`."""
    present = {state: states[state] for state in State if states.get(state)}
    last = next(reversed(present.values()), 0)
    return (
        " and ".join(f"{state.value} in {count}" for state, count in present.items()) + f" situation{'s' * (last != 1)}"
    )


def in_vain(case: Case, finds: Sequence[Find]) -> str:
    """That finds were flown and did not show it; the study has changed since, or other situations drown them."""
    names = listed(find.name for find in finds)
    flown = f"{names} {'was' if len(finds) == 1 else 'were'} flown here with as many seeds"
    return f"{flown}, and it is not detected all the same: `scaloft-fi seek {case.row.id}` seeks another situation."


def situations(count: int) -> str:
    """As in: `1 situation`."""
    return f"{count} situation{'s' * (count != 1)}"


def in_(where: str) -> str:
    """As in: `in human & light`, `everywhere`."""
    return where if where in ("everywhere", "nowhere", "wherever tested") else f"in {where}"


def listed(names: Iterable[str]) -> str:
    """As in: `SR1 and SR2`."""
    return " and ".join(names)


def _some(keys: Sequence[str]) -> str:
    rest = f" and {len(keys) - NAMED} more" if len(keys) > NAMED else ""
    return ", ".join(keys[:NAMED]) + rest


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
        mutant: id of the mutant.
        verdict: on the mutant; never `detected`.
        stage: where it stopped.
        next: what to change.
        why: the facts, and what to do, in a few sentences.
        loss: where it took most of a baseline's margin in a steady pair; null: it cannot be measured.
        off_path_m: how far it was off its baseline's path at the most [m]; null: no flight that put it to the test has
            a trajectory.
        find: name of the find that is to be flown; empty without one.
        severity: class of severity, one of the study's own; in no ratio; null: it has none.
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
    campaign = CampaignFacts.of(outcomes, scored, matrix, backgrounds, units or {}, name)
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
    return replace(survivor, why=f"{survivor.why} {in_vain(case, vain)}") if vain else survivor


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
        return _say(case, step, rates(case), seeds(case))
    if case.score.operability.detected:
        return _operable(case, step)
    return _say(case, step, untested(case), only_unsteady(case), margin(case))


def _not_reached(case: Case, step: Next) -> Survivor:
    seam, campaign = case.background.seam, case.campaign
    missed = campaign.carrying.get(seam, frozenset()) - case.flown
    if missed:
        first = min(missed, key=campaign.space.rank)
        return _say(case, step, f"the seam `{seam}` carries samples where it was not flown: fly {first}.")
    return _say(case, step, f"the seam `{seam}` carried no sample in {situations(len(case.flown))} flown; {left(case)}")


def _not_infected(case: Case, scored: Score, step: Next) -> Survivor:
    if step is Next.MAGNITUDE:
        stronger, *_ = infecting(scored, case.background.stronger)
        return _say(case, step, f"it changes no sample, {stronger} does: too small to be seen.")
    reached = {result.situation for result in case.score.results if result.reached}
    where = in_(case.campaign.where(reached.__contains__, case.flown))
    carries = f"the seam `{case.background.seam}` carries samples {where}, none of which the fault changes;"
    return _say(case, step, f"{carries} {left(case)}")


def _not_pooled(case: Case, step: Next) -> Survivor:
    flies = f"`scaloft-fi run{in_campaign(case.campaign.name)} --mutant {case.row.id}` flies them."
    return _say(
        case,
        step,
        f"{violate(sum(bool(flight.revealed) for flight in case.flights))}.",
        f"A verdict takes {LEAST} baselines in each situation where it infects, and {len(case.lacking)} of "
        f"{len(case.infected)} have fewer: {flies}",
    )


def _nowhere_steady(case: Case, step: Next) -> Survivor:
    states = {name: case.campaign.states(name, case.infected) for name in case.campaign.safety}
    present = set().union(*states.values())
    listed = "; ".join(f"{name} is {states_in_words(counts)}" for name, counts in states.items())
    mend = ", or mend the unmutated drone there" if present & {State.RED, State.UNSTEADY} else ""
    return _say(
        case,
        step,
        f"it infects {in_(case.infected_where)}, and no safety requirement is steady there: "
        f"{listed or 'the study has none'}.",
        f"Add a situation where it infects and a safety requirement is steady{mend}.",
    )


def _masked(case: Case, step: Next) -> Survivor:
    masked = f"it changes samples {in_(case.infected_where)}, and the drone flies the same to the bit."
    if step is Next.MAGNITUDE:
        return _say(case, step, masked, larger(case), seeds(case))
    missing = "A situation is missing where the drone acts on what the fault changes."
    return _say(case, step, masked, missing, seeds(case))


def _operable(case: Case, step: Next) -> Survivor:
    tests = [result for result in case.score.results if result.steady_operability]
    killing = sum(bool(result.operability_kills) for result in tests)
    safety = [name for name in case.background.at_risk if name in case.campaign.safety]
    by = listed(case.score.operability.by)
    return _say(
        case,
        step,
        f"by {by} it is detected, and killed in {killing} of {situations(len(tests))} where {by} is steady; "
        "no safety requirement detects it.",
        f"Its cell puts {listed(safety) or 'none'} at risk.",
        SILENT if safety else "Operability has a score of its own.",
        only_unsteady(case),
        margin(case),
    )


def _not_shown(case: Case) -> Survivor:
    """The survivor that was put to the test by what its cell puts at risk: margins and paths say what to change."""
    lucky, stronger = only_unsteady(case), case.background.stronger
    if case.loss is not None and case.loss.share >= NEAR:
        near = f"near miss: {margin(case)}"
        if stronger:
            return _say(case, Next.MAGNITUDE, near, lucky, larger(case))
        return _say(case, Next.SITUATION, near, lucky, f"{no_more(case)}: a situation with less room may show it.")
    if case.off_path_m is not None and case.off_path_m >= ASTRAY_M:
        astray = f"it takes the drone {case.off_path_m:.2f} m off its path, and no requirement detects it."
        return _say(case, Next.ORACLE, astray, SILENT, lucky, margin(case))
    if stronger:
        return _say(case, Next.MAGNITUDE, path(case), lucky, margin(case), larger(case))
    missing = f"{no_more(case)}: a situation is missing in which what it changes matters."
    return _say(case, Next.SITUATION, path(case), lucky, margin(case), missing)
