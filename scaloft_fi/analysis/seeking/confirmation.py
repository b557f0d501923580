"""Whether seeds that a search never flew confirm a situation that it found.

**The test is the score's own** (`analysis/scoring/detection.py`), in the one situation, beside a pool of ten baselines.

**A search may try again.**  The j-th candidate of a mutant is tested at alpha * 2^-j, j = 1, 2, ...; these shares sum
to alpha, so the chance that a fault which does nothing is ever confirmed is at most alpha, however long the search.
A candidate spends its share before its pool is looked at.
The number of seeds follows from the share and the pool alone, before the mutant flies: as many as decide though one
flight does not violate.

**No knife edges.**  At least nine of ten baselines must hold the requirement with a robustness above the standard
deviation of the robustness over the baselines.

**The unmutated drone does its mission there.**  At least nine of ten baselines must hold each operability requirement,
and the value of each axis must come true in nine of ten, unless the search was told to take any situation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import stdev

from scaloft_fi.analysis.scoring.detection import Sample, Spending, detect
from scaloft_fi.analysis.scoring.pool import LEAST, Pool
from scaloft_fi.analysis.seeking.aim import misses
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.sim.found import Evidence

FEWEST, MOST = 3, 20
"""Seeds of the mutant, at least and at most."""
HOLD = 0.9
"""Share of the baselines that must hold the requirement with room to spare."""


@dataclass(frozen=True)
class Room:
    """How safely the baselines hold a requirement in a situation.

    Attributes:
        held: baselines whose robustness is above `spread`.
        of: baselines.
        margin: robustness that nine in ten of the baselines reach [unit of the requirement].
        spread: standard deviation of the robustness over the baselines.
    """

    held: int
    of: int
    margin: float
    spread: float

    @property
    def enough(self) -> bool:
        """Whether this is no knife edge."""
        return self.held >= HOLD * self.of


def share_of(alpha: float, candidate: int) -> float:
    """What of alpha the test of the j-th candidate may spend.

    >>> share_of(0.01, 1), share_of(0.01, 3)
    (0.005, 0.00125)
    """
    return float(alpha * 2.0**-candidate)


def room(requirement: str, baselines: Sequence[Outcome]) -> Room:
    """How safely the baselines hold a requirement."""
    readings = [reading for baseline in baselines if (reading := baseline.reading(requirement))]
    rhos = sorted(reading.rho for reading in readings)
    if len(rhos) < 2:
        return Room(0, len(baselines), 0.0, 0.0)
    spread = stdev(rhos)
    held = sum(not (one.violated or one.open) and one.rho > spread for one in readings)
    return Room(held, len(baselines), rhos[len(rhos) - round(HOLD * len(rhos))], spread)


def safely_held(pool: Pool, situation: str, names: Iterable[str], baselines: Sequence[Outcome]) -> tuple[str, ...]:
    """Those of the requirements that are steady in the pool of the situation, and no knife edge."""
    steady = pool.steady(situation, Kind.SAFETY)
    return tuple(name for name in names if name in steady and room(name, baselines).enough)


def does_mission(baselines: Sequence[Outcome]) -> bool:
    """Whether nine of ten baselines hold each operability requirement, and meet the value of each axis."""
    counted = [baseline for baseline in baselines if not baseline.invalid]
    missed = Counter(name for baseline in counted for name in misses(baseline))
    return all(len(counted) - times >= HOLD * len(counted) for times in missed.values())


def seeds_for(pool: Pool, situation: str, names: Sequence[str], alpha: float) -> int | None:
    """The number of seeds of a mutant that decide by one of the requirements though one flight does not violate.

    None where more than `MOST` would be needed.
    """
    for seeds in range(FEWEST, MOST + 1):
        for name in names:
            sample = Sample(situation, ((), *((name,) for _ in range(seeds - 1))), infected=True)
            if detect("", [sample], pool, Spending(alpha), Kind.SAFETY).detected:
                return seeds
    return None


def confirmed(
    flown: Sequence[Outcome], baselines: Sequence[Outcome], names: Sequence[str], candidate: int, alpha: float
) -> Evidence | None:
    """The evidence of the flights of a mutant in a situation; None where they do not confirm it.

    Args:
        flown: flights of the mutant in the situation, on seeds that no search flew.
        baselines: flights of the baseline there, ten or more.
        names: the requirements by which it may be confirmed.
        candidate: which candidate of the mutant the situation is, from 1.
        alpha: what p is compared with.
    """
    counted = [outcome for outcome in flown if not outcome.invalid]
    held = [baseline for baseline in baselines if not baseline.invalid]
    if len(counted) < FEWEST or len(held) < LEAST:
        return None
    violated = tuple(tuple(violation.requirement for violation in outcome.violations) for outcome in counted)
    sample = Sample(counted[0].situation, violated, any(outcome.altered for outcome in counted))
    told = detect(counted[0].mutant, [sample], Pool.of(held), Spending(alpha), Kind.SAFETY)
    by = [name for name in names if name in told.by and 2 * sample.count(name) > len(counted)]
    if not told.detected or not by:
        return None
    name = by[0]
    violations = [one for outcome in counted for one in outcome.violations if one.requirement == name]
    safely = room(name, held)
    return Evidence(
        requirement=name,
        candidate=candidate,
        p=told.p[name],
        alpha=alpha,
        violated=sample.count(name),
        flights=len(counted),
        struck=next((one.struck for one in violations if one.struck), ""),
        held=safely.held,
        baselines=safely.of,
        margin=safely.margin,
        spread=safely.spread,
        mission=sum(not misses(baseline) for baseline in held),
    )
