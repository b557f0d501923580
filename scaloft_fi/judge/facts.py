"""The facts of a flight, which two platforms should share where their last bits differ: status, ending, violations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from scaloft_fi.judge.flights import flights_of
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.status import Status, baseline_status
from scaloft_fi.judge.track import TRACK_COLUMNS, unpack_track

APART_M = 0.001
"""Distance of two positions at which two tracks part [m]; a track of single floats resolves 1e-5 m in a mine."""
_TIME, _PLACE = TRACK_COLUMNS.index("elapsed_s"), slice(TRACK_COLUMNS.index("x_m"), TRACK_COLUMNS.index("z_m") + 1)


@dataclass(frozen=True)
class Facts:
    """The facts of a flight.

    Attributes:
        status: status beside the baseline of the same situation, seed and platform; of a baseline, held or violated.
        ending: how the flight ended; empty when invalid.
        violated: the violated requirements, in the study's order.
    """

    status: str
    ending: str
    violated: tuple[str, ...]

    def __str__(self) -> str:
        return ", ".join(filter(None, (f"{self.status} {' '.join(self.violated)}".strip(), self.ending)))


@dataclass(frozen=True)
class Agreement:
    """What two sets of outcomes say of the flights that both have.

    Attributes:
        equal: flights with equal digests.
        bits: flights with other digests and the same facts.
        facts: flights with other facts, with the facts of the first set and of the second set.
    """

    equal: tuple[str, ...]
    bits: tuple[str, ...]
    facts: Mapping[str, tuple[Facts, Facts]]

    def named(self, most: int = 3) -> str:
        """The first `most` flights with other facts, each with its facts, and the number of the others."""
        told = [f"{name} ({second} here, {first} there)" for name, (first, second) in self.facts.items()]
        return ", ".join(told[:most]) + (f" and {len(told) - most} more" if len(told) > most else "")


def digests(outcome: Outcome) -> tuple[str, str]:
    """The digests that decide whether two flights are equal, bit for bit."""
    return outcome.digest, outcome.perceived_digest


def facts_of(outcomes: Iterable[Outcome]) -> dict[str, Facts]:
    """The facts of each flight by name; a mutant is judged beside its baseline among the same `outcomes`."""
    listed = list(outcomes)
    statuses = {flight.outcome.name: flight.status.value for flight in flights_of(listed)}
    return {
        outcome.name: Facts(
            baseline_status(outcome) if outcome.mutant == BASELINE else statuses[outcome.name],
            outcome.ending,
            tuple(reading.requirement for reading in outcome.readings if reading.violated),
        )
        for outcome in listed
    }


def parting_s(first: bytes, second: bytes) -> float | None:
    """The first time at which two tracks are more than `APART_M` apart; None if they never are [s from take-off]."""
    for one, other in zip(unpack_track(first), unpack_track(second), strict=False):
        if math.dist(one[_PLACE], other[_PLACE]) > APART_M:
            return one[_TIME]
    return None


def in_step(first: bytes, second: bytes) -> bool:
    """Whether two tracks have samples at the same times as long as both last."""
    pairs = zip(unpack_track(first), unpack_track(second), strict=False)
    return all(one[_TIME] == other[_TIME] for one, other in pairs)


def agreement(first: Iterable[Outcome], second: Iterable[Outcome]) -> Agreement:
    """Compare the valid flights that both sets have, in the order of `second`; each set has its own baselines.

    The status of a mutant is compared only where both sets have a valid baseline of its situation and seed.
    """
    ours, theirs = list(first), list(second)
    known = {outcome.name: outcome for outcome in ours if not outcome.invalid}
    mine, other = facts_of(ours), facts_of(theirs)
    equal, bits, facts = [], [], {}
    for outcome in theirs:
        if outcome.invalid or outcome.name not in known:
            continue
        one, two = mine[outcome.name], other[outcome.name]
        judged = Status.INVALID.value not in (one.status, two.status)
        if digests(known[outcome.name]) == digests(outcome):
            equal.append(outcome.name)
        elif (one.ending, one.violated) == (two.ending, two.violated) and (one.status == two.status or not judged):
            bits.append(outcome.name)
        else:
            facts[outcome.name] = one, two
    return Agreement(tuple(equal), tuple(bits), facts)
