"""The baseline's own findings: what the unmutated drone violates, and which requirements its flights never tested."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from scaloft_fi.judge.outcome import BASELINE, Outcome, Violation
from scaloft_fi.judge.requirement import Compliance, Kind, Reading, measured_rho
from scaloft_fi.judge.space import Space


@dataclass(frozen=True)
class Finding:
    """A situation's baseline over the seeds.

    Attributes:
        situation: key.
        flown: baseline flights that count.
        violated: requirements that any of them violates, in the study's order.
        open: requirements left open by a flight cut short, and violated in none.
        vacuous: requirements whose trigger never came true in any.
        first: the earliest safety violation and its seed.
        red: flights that violate a safety requirement.
    """

    situation: str
    flown: int
    violated: tuple[str, ...]
    open: tuple[str, ...]
    vacuous: tuple[str, ...]
    first: tuple[Violation, int] | None
    red: int


def findings(outcomes: Iterable[Outcome], space: Space) -> tuple[Finding, ...]:
    """One finding per situation with a baseline that counts, in the grid's order."""
    flown: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        if outcome.mutant == BASELINE and not outcome.invalid:
            flown.setdefault(outcome.situation, []).append(outcome)
    return tuple(_finding(key, flown[key]) for key in sorted(flown, key=space.rank))


def _finding(situation: str, baselines: list[Outcome]) -> Finding:
    shown: dict[str, set[Compliance]] = {}
    for outcome in baselines:
        for reading in outcome.readings:
            shown.setdefault(reading.requirement, set()).add(reading.compliance)
    firsts = [(v, outcome.seed) for outcome in baselines if (v := outcome.first_violation)]
    return Finding(
        situation=situation,
        flown=len(baselines),
        violated=tuple(name for name, own in shown.items() if Compliance.VIOLATED in own),
        open=tuple(name for name, own in shown.items() if Compliance.OPEN in own and Compliance.VIOLATED not in own),
        vacuous=tuple(name for name, own in shown.items() if own == {Compliance.VACUOUS}),
        first=min(firsts, key=lambda pair: (pair[0].t_s, pair[1]), default=None),
        red=len(firsts),
    )


@dataclass(frozen=True)
class Tally:
    """A requirement over flights: how many of each compliance, how often it was triggered, the least robustness.

    The robustness is that of flights that put it to the test; None when none did.
    """

    requirement: str
    kind: Kind
    compliances: tuple[tuple[Compliance, int], ...]
    triggered: int
    least_rho: float | None


def tallies(outcomes: Iterable[Outcome]) -> tuple[Tally, ...]:
    """One tally per requirement over the baseline flights that count, in the study's order."""
    read: dict[str, list[Reading]] = {}
    for outcome in outcomes:
        if outcome.mutant == BASELINE and not outcome.invalid:
            for reading in outcome.readings:
                read.setdefault(reading.requirement, []).append(reading)
    return tuple(_tally(name, readings) for name, readings in read.items())


def _tally(name: str, readings: list[Reading]) -> Tally:
    compliances = [reading.compliance for reading in readings]
    return Tally(
        requirement=name,
        kind=readings[0].kind,
        compliances=tuple((compliance, compliances.count(compliance)) for compliance in Compliance),
        triggered=sum(reading.triggered for reading in readings),
        least_rho=min((rho for r in readings if (rho := measured_rho(r)) is not None), default=None),
    )
