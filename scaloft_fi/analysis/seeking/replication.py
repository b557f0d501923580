"""Whether the finds of a search hold again, on seeds that nothing before used.

A search picks its finds because of their flights, so those flights tell too good a tale of them.  A replication flies
each pair of find and mutant on seeds of its own, and asks of each the one requirement that the find names: does the
mutant violate it more often than the unmutated drone, by the exact test of the score (`stratified.py`)?
Holm's adjustment over all pairs that are replicated together (Scand. J. Statist. 6, 1979) bounds by alpha the chance
that any pair without an effect holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from scaloft_fi.analysis.scoring.detection import Sample, adjusted, holm, reaches
from scaloft_fi.analysis.scoring.pool import Pool
from scaloft_fi.analysis.seeking.aim import misses
from scaloft_fi.analysis.seeking.confirmation import does_mission, room
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.sim.found import Again, Find

SEEDS, POOL = 10, 30
"""Seeds of the mutant and of the baseline."""

Place = tuple[str, str]
"""A find and a mutant that it shows, by their names."""


@dataclass(frozen=True)
class Replica:
    """A pair of find and mutant, flown again.

    Attributes:
        find, mutant, requirement: what is claimed.
        holds: whether the claim holds.
        why: why it does not; empty where it does.
        again: the evidence.
    """

    find: str
    mutant: str
    requirement: str
    holds: bool
    why: str
    again: Again


def replicas(
    finds: Sequence[Find],
    flown: Mapping[Place, Sequence[Outcome]],
    baselines: Mapping[str, Sequence[Outcome]],
    first: int,
    alpha: float,
    *,
    anyhow: bool = False,
) -> tuple[Replica, ...]:
    """What the flights say of each pair that was flown, in the order of the finds.

    Args:
        finds: the finds.
        flown: flights of the mutant by pair.
        baselines: flights of the baseline by key of the situation.
        first: first seed of all flights.
        alpha: the study's.
        anyhow: whether a pair may hold where the unmutated drone does not do its mission.
    """
    claims = {
        (find.name, mutant): (find.situation, evidence.requirement)
        for find in finds
        for mutant, evidence in find.shows.items()
        if (find.name, mutant) in flown
    }
    whys, raw = {}, {}
    for place, (situation, requirement) in claims.items():
        pool = [one for one in baselines[situation] if not one.invalid]
        whys[place] = _unfit(pool, situation, requirement, anyhow=anyhow)
        raw[place] = 1.0 if whys[place] else _p(flown[place], pool, situation, requirement)
    p = holm(raw)
    told = []
    for place, (situation, requirement) in claims.items():
        holds = not whys[place] and reaches(p[place], alpha)
        why = whys[place] or ("" if holds else f"p={p[place]:.2g} is above alpha={alpha:g}")
        again = _again(flown[place], baselines[situation], requirement, first, p[place])
        told.append(Replica(*place, requirement, holds, why, again))
    return tuple(told)


def _unfit(pool: Sequence[Outcome], situation: str, requirement: str, *, anyhow: bool) -> str:
    """Why no fault can be shown by a requirement in a situation; empty where one can."""
    if requirement not in Pool.of(pool).steady(situation, Kind.SAFETY):
        return f"the unmutated drone does not hold {requirement} steadily"
    return "" if anyhow or does_mission(pool) else "the unmutated drone does not do its mission"


def _p(flown: Sequence[Outcome], pool: Sequence[Outcome], situation: str, requirement: str) -> float:
    counted = [one for one in flown if not one.invalid]
    violated = tuple(tuple(violation.requirement for violation in one.violations) for one in counted)
    sample = Sample(situation, violated, any(one.altered for one in counted))
    return adjusted([sample], Pool.of(pool), [requirement])[requirement] if sample.infected else 1.0


def _again(flown: Sequence[Outcome], baselines: Sequence[Outcome], requirement: str, first: int, p: float) -> Again:
    counted, held = ([one for one in flights if not one.invalid] for flights in (flown, baselines))
    violated = sum(any(own.requirement == requirement for own in one.violations) for one in counted)
    mission = sum(not misses(baseline) for baseline in held)
    return Again(first, p, violated, len(counted), room(requirement, held).held, len(held), mission)
