"""How near a situation is to showing a fault: robustness, the mutant's down and the baseline's kept up."""

from __future__ import annotations

from collections.abc import Iterator

from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind, measured_rho

ROOM = 0.02
"""Robustness that the search asks of the baseline [unit of the requirement: m, or share of the limit]."""
WORST = 1.5
"""Distance of a situation that says nothing: the fault changes no sample, or no requirement is put to the test."""
BEYOND = 2.5
"""Distance of a situation whose baseline violates by far; no distance is greater."""
UNFIT = 2.0
"""Distance of a situation where the unmutated drone does not do its mission."""
REJECTED = 0.5
"""Distance of a situation that shows something with the first seed only, or that fresh seeds do not confirm."""


def misses(baseline: Outcome) -> tuple[str, ...]:
    """What of its mission the unmutated drone does not do: operability requirements, and axes whose value is not met.

    A flight cut short before a requirement is judged does not hold it.
    """
    names = (
        f"requirement {one.requirement}"
        for one in baseline.readings
        if one.kind is Kind.OPERABILITY and (one.violated or one.open)
    )
    return (*names, *(f"axis {axis}" for axis, met in baseline.realised if not met))


def distance(mutant: Outcome | None, baseline: Outcome | None, *, anyhow: bool = False) -> float:
    """How far a situation is from showing a fault; below 0 it shows the fault with this seed.

    Per safety requirement the share of the baseline's robustness that the mutant keeps: 1 where the fault does nothing,
    0 at the limit, negative beyond it.  A difference would favour requirements with large numbers, and the mutant's
    robustness alone situations that are hard for every drone.  Where the baseline has less than `ROOM` left, the
    distance is greater than `WORST` by what it lacks.  The least over the requirements counts.

    Args:
        mutant: outcome of the mutant; None without one.
        baseline: outcome of the baseline of the same situation and seed; None without one.
        anyhow: whether a situation counts where the baseline does not do its mission.
    """
    far = min((far for _, far in _distances(mutant, baseline)), default=WORST)
    return far if anyhow or _fits(baseline) else max(UNFIT, far)


def nearest(mutant: Outcome, baseline: Outcome) -> tuple[float, str]:
    """The distance and the requirement that has it; no requirement where none that is held with room tells anything."""
    told = [(far, name) for name, far in _distances(mutant, baseline) if far < WORST]
    return min(told, default=(WORST, ""))


def breaking(baseline: Outcome | None, requirement: str) -> float:
    """How far a situation is from breaking a requirement: the robustness that the unmutated drone has.

    `WORST` where the requirement is not put to the test.  Requirements are not compared: the robustness of one may be
    small wherever it is held, and would keep the search from the others.

    Args:
        baseline: outcome of the baseline; None without one.
        requirement: its name.
    """
    reading = baseline.reading(requirement) if baseline is not None and not baseline.invalid else None
    rho = measured_rho(reading) if reading is not None and not reading.open else None
    return WORST if rho is None else max(-WORST, min(WORST, rho))


def shown_by(mutant: Outcome | None, baseline: Outcome | None, *, anyhow: bool = False) -> tuple[str, ...]:
    """The safety requirements by which the situation shows the fault with this seed."""
    counts = anyhow or _fits(baseline)
    return tuple(name for name, far in _distances(mutant, baseline) if counts and far < 0.0)


def is_of_use(baseline: Outcome | None, *, anyhow: bool = False) -> bool:
    """Whether the baseline does its mission and holds a requirement with room; else no mutant need fly beside it."""
    return (anyhow or _fits(baseline)) and any(far <= WORST for _, far in _distances(None, baseline))


def _fits(baseline: Outcome | None) -> bool:
    return baseline is None or not misses(baseline)


def _distances(mutant: Outcome | None, baseline: Outcome | None) -> Iterator[tuple[str, float]]:
    """The distance by each safety requirement that the baseline puts to the test."""
    for theirs in baseline.readings if baseline is not None and not baseline.invalid else ():
        held = measured_rho(theirs)
        if theirs.kind is not Kind.SAFETY or theirs.open or held is None:
            continue
        left = _left(mutant, theirs.requirement)
        if held <= ROOM:
            yield theirs.requirement, min(BEYOND, WORST + ROOM - held)
        else:
            yield theirs.requirement, WORST if left is None else max(-WORST, min(WORST, left / held))


def _left(mutant: Outcome | None, requirement: str) -> float | None:
    """The robustness that a mutant leaves; None where it changes no sample or is not put to the test."""
    if mutant is None or mutant.invalid or not mutant.altered:
        return None
    reading = mutant.reading(requirement)
    return measured_rho(reading) if reading else None
