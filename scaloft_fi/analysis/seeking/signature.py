"""How the unmutated drone violates a requirement: what it strikes, where, and which stage was wrong before.

Two violations are the same finding when their signatures are equal.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any

from scaloft_fi.errors import ScaloftError
from scaloft_fi.judge.outcome import Violation
from scaloft_fi.judge.requirement import Requirement
from scaloft_fi.judge.stl import tokenize
from scaloft_fi.sim.log import SAMPLE_HZ
from scaloft_fi.stack.declaration import Claim, Instant

if TYPE_CHECKING:
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.sim.world import World

BEFORE_S = 1.0
"""How long before a violation a wrong belief counts [s]; in about that time the drone reacts and brakes."""

Samples = Mapping[str, Sequence[tuple[float, Any]]]
"""What a seam delivered: time [s] and sample, by seam."""


@dataclass(frozen=True)
class Signature:
    """What makes two violations the same finding.

    Attributes:
        requirement: the requirement.
        struck: the body struck at the violation; "" for none.
        leg: between which places of the route the drone flies, such as `corner to end`.
        near: the body that is struck, which tells the place; the nearer of the two where none is.
        belief: the stage whose belief was the most wrong; "" where none was wrong.
    """

    requirement: str
    struck: str
    leg: str
    near: str
    belief: str

    @property
    def name(self) -> str:
        """A name of letters, digits, _ and -.

        >>> Signature("SR1", "wall", "corner to end", "end", "").name
        'breaks-SR1-wall-corner_to_end-near_end-no_belief'
        >>> Signature("SR1", "bar", "corner to end", "bar", "obstacle map").name
        'breaks-SR1-bar-corner_to_end-obstacle_map'
        """
        near = () if self.near == self.struck else (f"near {self.near}",)
        parts = (self.requirement, self.struck or "nothing", self.leg, *near, self.belief or "no belief")
        return "-".join(("breaks", *(re.sub(r"\W+", "_", part, flags=re.ASCII) for part in parts)))


@dataclass(frozen=True)
class Breach:
    """A moment at which the unmutated drone begins to violate a safety requirement, or several.

    Attributes:
        signature: what makes it the same finding as another; of several requirements the study's first one.
        requirements: all of them.
        t_s: when [s from take-off].
        place: (3,) centre of the vehicle [m, world].
        error: how far the wrong belief was from the truth at most, in `unit`; 0 where none was wrong.
        unit: of the error.
    """

    signature: Signature
    requirements: tuple[str, ...]
    t_s: float
    place: tuple[float, float, float]
    error: float
    unit: str


def breaches(
    log: FlightLog,
    violations: Sequence[Violation],
    requirements: Sequence[Requirement],
    world: World,
    claims: Sequence[Claim],
    samples: Samples,
) -> tuple[Breach, ...]:
    """The moments at which a flight begins to violate safety requirements, the earliest first.

    Args:
        log: the flight, at least up to the last of the violations.
        violations: of the flight.
        requirements: of the study.
        world: of its situation.
        claims: of the stack.
        samples: what the seams of the claims delivered.

    Raises:
        ScaloftError: a claim raises, or its error is no finite number.
    """
    spoken_of = {requirement.name: _words(requirement) for requirement in requirements}
    told = []
    for _, together in groupby(sorted(violations, key=_time), key=_time):
        first, *others = together  # who is struck, may be so against several requirements: that is one finding
        names = (first.requirement, *(one.requirement for one in others))
        words = frozenset().union(*(spoken_of[name] for name in names))
        matter = [claim for claim in claims if not claim.about or words.intersection(claim.about)]
        stage, error, unit = _most_wrong(log, first, matter, samples)
        signature = Signature(first.requirement, first.struck, *_where(log, first, world), stage)
        told.append(Breach(signature, names, first.t_s, (first.x, first.y, first.z), error, unit))
    return tuple(told)


def _time(violation: Violation) -> float:
    return violation.t_s


def _words(requirement: Requirement) -> frozenset[str]:
    """The names in the formulas of a requirement."""
    texts = (requirement.text, requirement.trigger, *(text for _, text in requirement.definitions))
    return frozenset(word for text in texts for word in tokenize(text))


def _where(log: FlightLog, violation: Violation, world: World) -> tuple[str, str]:
    """The leg of the route by the ground truth, and what is near."""
    route = world.mission.route
    left = round(float(log.signals["waypoints_left"][log.at(violation.t_s)]))
    goal = max(0, min(len(route) - left, len(route) - 1))
    ends = ("home" if goal == 0 else route[goal - 1], route[goal])
    nearer = min(ends, key=lambda name: math.dist(world.waypoints[name][:2], (violation.x, violation.y)))
    return f"{ends[0]} to {ends[1]}", violation.struck if violation.struck in world.bodies else nearer


def _most_wrong(
    log: FlightLog, violation: Violation, claims: Sequence[Claim], samples: Samples
) -> tuple[str, float, str]:
    """The stage whose belief was the most wrong in the second before, as a multiple of what is allowed; error, unit.

    All is empty where no belief was wrong.
    """
    last = log.at(violation.t_s)
    place = (violation.x, violation.y, violation.z)
    worst, told = 1.0, ("", 0.0, "")
    for claim in claims:
        for sample in range(max(0, last - round(BEFORE_S * SAMPLE_HZ)), last):  # at a strike itself, estimates jump
            signals = {name: values[: sample + 1] for name, values in log.signals.items()}
            delivered = _delivered(samples.get(claim.seam, ()), float(signals["elapsed_s"][-1]))
            error = _error(claim, Instant(signals, delivered, place, violation.struck))
            if error > worst * claim.within:
                worst, told = error / claim.within, (claim.stage, error, claim.unit)
    return told


def _error(claim: Claim, now: Instant) -> float:
    try:
        error = float(claim.error(now))
    except Exception as problem:
        raise ScaloftError(f"claim {claim.stage!r}: {type(problem).__name__}: {problem}") from problem
    if not math.isfinite(error):
        raise ScaloftError(f"claim {claim.stage!r}: error={error} must be a finite number")
    return error


def _delivered(samples: Sequence[tuple[float, Any]], now_s: float) -> Any:
    """The newest sample that was delivered before a sample of the log, which is recorded before the stack runs."""
    count = bisect_left(samples, now_s, key=lambda one: one[0])
    return samples[count - 1][1] if count else None
