"""How far a search came with a mutant: the stage of reach, infect, propagate, reveal at which the fault stopped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from scaloft_fi.analysis.seeking.aim import WORST, is_of_use, nearest
from scaloft_fi.judge.outcome import Outcome


@dataclass(frozen=True)
class Effort:
    """What the flights with the first seed of a search say of a mutant.

    Attributes:
        situations: in which it was flown, tries of shrinking included, where the baseline does its mission and holds a
            safety requirement with room.
        reached: those in which its seam carried a sample.
        infected: those in which it changed one.
        diverged: those in which the drone then flew otherwise than the baseline.
        showed: those in which it violates what the baseline holds with room.
        nearest: least share of the baseline's robustness that it kept; `WORST` where it changed no sample.
        requirement, situation: where that was; empty where it changed no sample.
    """

    situations: int = 0
    reached: int = 0
    infected: int = 0
    diverged: int = 0
    showed: int = 0
    nearest: float = WORST
    requirement: str = ""
    situation: str = ""


def effort_of(flights: Iterable[Outcome], baselines: Mapping[str, Outcome], *, anyhow: bool = False) -> Effort:
    """The effort for a mutant.

    Args:
        flights: of the mutant, with the first seed of the search.
        baselines: with that seed, by situation.
        anyhow: whether situations count where the baseline does not do its mission.
    """
    pairs = [
        (one, baseline)
        for one in flights
        if not one.invalid
        and is_of_use(baseline := baselines.get(one.situation), anyhow=anyhow)
        and baseline is not None
    ]
    far = [(*nearest(one, baseline), one.situation) for one, baseline in pairs]
    least = min((each for each in far if each[1]), default=(WORST, "", ""))
    return Effort(
        len(pairs),
        sum(one.carried > 0 for one, _ in pairs),
        sum(one.altered > 0 for one, _ in pairs),
        sum(one.altered > 0 and one.digest != baseline.digest for one, baseline in pairs),
        sum(distance < 0.0 for distance, _, _ in far),
        *least,
    )
