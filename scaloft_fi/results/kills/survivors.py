"""Survivors by the rung where they stopped (reach, infect, propagate, reveal), each with the next thing to do.

A fault that stops at reach or infect asks for a situation, at propagate for a magnitude, at reveal for a magnitude or
an oracle (after the RIPR model of Ammann and Offutt; that a survivor should say where it stopped is this project's
proposal).  Every rule reads flights and what the matrix says of a cell; none knows a mutant by name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from scaloft_fi.results.kills.background import Background
from scaloft_fi.results.kills.kill_matrix import KillMatrix
from scaloft_fi.results.kills.near_miss import Loss
from scaloft_fi.results.kills.survivor_case import Campaign, Case
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.requirement import Kind, Requirement, Verdict
from scaloft_fi.results.status import Status

NEAR = 0.5
"""A flight that lost half its baseline's margin is a near miss: a somewhat larger fault may kill."""
ASTRAY_M = 0.5
"""A flight is far off its baseline's path from here [m]: as near as the study asks a waypoint to be passed."""
SILENT = "Judge whether that is a hazard; if it is, a requirement is missing."


class Rung(StrEnum):
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
    """The drone flew otherwise, and no safety requirement was violated that its baseline held."""


_RUNG = {
    Status.INVALID: Rung.HARNESS,
    Status.NOT_REACHED: Rung.REACH,
    Status.NOT_INFECTED: Rung.INFECT,
    Status.MASKED: Rung.PROPAGATE,
    Status.BASELINE_RED: Rung.REVEAL,
    Status.SURVIVED: Rung.REVEAL,
    Status.KILLED: Rung.REVEAL,
}


class Next(StrEnum):
    """What would make a survivor say something."""

    REPEAT = "repeat"
    SITUATION = "situation"
    MAGNITUDE = "magnitude"
    ORACLE = "oracle"
    OPERABILITY = "operability"
    """Nothing: an operability requirement reveals it, and its cell puts no other at risk."""
    EXPECTED = "expected"
    """The study said beforehand, with a reason, that it alters nothing in this grid."""


@dataclass(frozen=True)
class Survivor:
    """A mutant that no eligible flight kills.

    Attributes:
        mutant: id.
        rung: where it stopped.
        next: what to change.
        why: the facts that say so, and what to do, in a sentence or two.
        loss: where it lost most of a baseline's margin; None where it cannot be told.
        off_path_m: how far it was off its baseline's path at the most, over eligible flights with a trajectory [m].
    """

    mutant: str
    rung: Rung
    next: Next
    why: str
    loss: Loss | None = None
    off_path_m: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "mutant": self.mutant,
            "rung": self.rung.value,
            "next": self.next.value,
            "why": self.why,
            "loss": self.loss.to_json() if self.loss else None,
            "off_path_m": self.off_path_m,
        }


def survivors(
    outcomes: Iterable[Outcome],
    matrix: KillMatrix,
    backgrounds: Mapping[str, Background],
    units: Mapping[str, str] | None = None,
) -> tuple[Survivor, ...]:
    """Every mutant that no eligible flight kills, by rung, then in the matrix's order; controls are left out.

    Args:
        outcomes: of the campaign, with the trajectories of a seed if ways are to be told.
        matrix: its kill matrix.
        backgrounds: of every mutant in it.
        units: of the requirements' robustness, by name.
    """
    campaign = Campaign.of(outcomes, matrix, backgrounds, units or {})
    found = [_judge(Case(campaign, row, backgrounds[row.id])) for row in matrix.mutants if not row.kills]
    return tuple(sorted(found, key=lambda survivor: list(Rung).index(survivor.rung)))


def short_units(requirements: Iterable[Requirement]) -> dict[str, str]:
    """The unit of each requirement's robustness, without what the study says beside it."""
    return {requirement.name: requirement.unit.split(" (")[0].split(";")[0] for requirement in requirements}


def _say(case: Case, next_: Next, *sentences: str) -> Survivor:
    why = " ".join(said[:1].upper() + said[1:] for said in sentences if said)
    return Survivor(case.row.id, _RUNG[case.row.status], next_, why, case.loss, case.off_path_m)


def _judge(case: Case) -> Survivor:
    rung = _RUNG[case.row.status]
    if rung is Rung.HARNESS:
        return _say(case, Next.REPEAT, "no flight of it counts: fly it again.")
    if case.background.expected and not case.infected:
        return _say(case, Next.EXPECTED, f"declared beforehand: {case.background.expected}.")
    if rung is Rung.REACH:
        return _not_reached(case)
    if rung is Rung.INFECT:
        return _not_infected(case)
    if not case.eligible:
        return _say(
            case,
            Next.SITUATION,
            f"it infects only where the unmutated drone holds no safety requirement to its end: {case.infected_where}.",
            "Repair the drone there, or add a situation that infects and whose baseline holds.",
        )
    if rung is Rung.PROPAGATE:
        return _masked(case)
    return _not_revealed(case)


def _not_reached(case: Case) -> Survivor:
    seam, campaign = case.background.seam, case.campaign
    missed = campaign.carrying.get(seam, frozenset()) - case.flown
    if missed:
        first = min(missed, key=campaign.space.rank)
        return _say(case, Next.SITUATION, f"the seam `{seam}` carries samples where it was not flown: fly {first}.")
    return _say(
        case,
        Next.SITUATION,
        f"the seam `{seam}` carried no sample in the {len(case.flown)} situations flown; {case.left}",
    )


def _not_infected(case: Case) -> Survivor:
    flights, stronger = case.campaign.flights, case.background.stronger
    infecting = [id_ for id_ in stronger if any(flight.status.infected for flight in flights.get(id_, ()))]
    if infecting:
        return _say(case, Next.MAGNITUDE, f"it changes no sample, {infecting[0]} does: too small to be seen.")
    reached = case.campaign.where(
        {flight.outcome.situation for flight in case.flights if flight.outcome.carried}.__contains__, case.flown
    )
    return _say(
        case,
        Next.SITUATION,
        f"the seam `{case.background.seam}` carries samples {_in(reached)}, none of which the fault changes; "
        f"{case.left}",
    )


def _masked(case: Case) -> Survivor:
    said = f"it changes samples {_in(case.infected_where)}, and the drone flies the same to the bit."
    if case.background.stronger:
        return _say(case, Next.MAGNITUDE, said, case.larger)
    return _say(case, Next.SITUATION, said, "A situation is missing where the drone acts on what the fault changes.")


def _not_revealed(case: Case) -> Survivor:
    broken = {f.outcome.situation for f in case.eligible if f.operability_eligible and f.operability_kills}
    if broken:
        names = sorted({name for flight in case.eligible for name in flight.operability_kills})
        whole = len({flight.outcome.situation for flight in case.eligible})
        safety = [name for name in case.background.at_risk if case.campaign.kinds.get(name) is Kind.SAFETY]
        return _say(
            case,
            Next.ORACLE if safety else Next.OPERABILITY,
            f"it breaks {', '.join(names)} in {len(broken)} of {whole} eligible situations and no safety requirement "
            f"speaks; its cell puts {', '.join(safety) or 'none'} at risk.",
            SILENT if safety else "Operability has a score of its own.",
            _margin(case),
        )
    untested = _untested(case)
    if untested:
        return _say(case, Next.SITUATION, untested, _margin(case))
    if case.loss is not None and case.loss.share >= NEAR:
        near = f"near miss: {_margin(case)}"
        if case.background.stronger:
            return _say(case, Next.MAGNITUDE, near, case.larger)
        return _say(case, Next.SITUATION, near, f"{_no_more(case)}: a situation with less room may kill.")
    if case.off_path_m >= ASTRAY_M:
        astray = f"it takes the drone {case.off_path_m:.2f} m off its path and no requirement speaks."
        return _say(case, Next.ORACLE, astray, SILENT, _margin(case))
    small = f"it takes the drone at most {case.off_path_m:.2f} m off its path."
    if case.background.stronger:
        return _say(case, Next.MAGNITUDE, small, _margin(case), case.larger)
    missing = f"{_no_more(case)}: a situation is missing in which what it changes matters."
    return _say(case, Next.SITUATION, small, _margin(case), missing)


def _no_more(case: Case) -> str:
    return "its ladder ends here" if case.background.laddered else "the fault has no magnitude to raise"


def _untested(case: Case) -> str:
    """Why no eligible flight could have violated what the cell puts at risk; empty when one could."""
    at_risk = [name for name in case.background.at_risk if case.campaign.kinds.get(name) is Kind.SAFETY]
    if not at_risk:
        return ""
    verdicts: dict[str, list[Verdict]] = {name: [] for name in at_risk}
    for flight in case.eligible:
        for name in at_risk:
            reading = flight.baseline.reading(name) if flight.baseline else None
            if reading is not None:
                verdicts[name].append(reading.verdict)
    if any(Verdict.HELD in said for said in verdicts.values()):
        return ""
    told = []
    for name, said in verdicts.items():
        if set(said) <= {Verdict.VACUOUS}:
            triggered = {b.situation for b in case.campaign.baselines if (r := b.reading(name)) and r.triggered}
            flown = {baseline.situation for baseline in case.campaign.baselines}
            where = case.campaign.where(triggered.__contains__, flown)
            told.append(f"{name}, which the cell puts at risk, is vacuous wherever it infects (triggered: {where}).")
        else:
            told.append(f"{name}, which the cell puts at risk, is held by no baseline where it infects.")
    return " ".join(told)


def _margin(case: Case) -> str:
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


def _in(where: str) -> str:
    return where if where in ("everywhere", "nowhere", "wherever tested") else f"in {where}"
