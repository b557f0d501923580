"""The stored outcome of one flight, pure data; statuses and scores follow from outcomes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scaloft_fi.judge.requirement import Kind, Reading, Requirement, judge_signals
from scaloft_fi.judge.stl import Signals
from scaloft_fi.judge.track import pack_track

if TYPE_CHECKING:
    from scaloft_fi.judge.space import Realisation
    from scaloft_fi.mutants.mutant import Mutant
    from scaloft_fi.sim.log import FlightLog

BASELINE, PLACEBO = "baseline", "PLACEBO"


@dataclass(frozen=True)
class Subject:
    """The subject of a flight: the baseline, PLACEBO or a mutant.  id: canonical; magnitude: as written in the id."""

    id: str
    guideword: str = ""
    parameter: str = ""
    magnitude: str = ""

    @classmethod
    def of(cls, mutant: Mutant | None) -> Subject:
        """The subject of a flight with this mutant; None is the baseline."""
        if mutant is None:
            return cls(BASELINE)
        return cls(mutant.id, mutant.guideword, mutant.parameter, mutant.magnitude)


@dataclass(frozen=True, slots=True)
class Violation:
    """First violation of a requirement in a flight: time [s], position [m, world], body struck at that moment."""

    requirement: str
    kind: Kind
    t_s: float
    x: float
    y: float
    z: float
    struck: str


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of one flight.

    Attributes:
        subject, situation, seed: subject, key of the situation and seed of the flight.
        ending: how the flight ended; empty when invalid.
        invalid: why the harness failed; empty for a valid flight.
        readings: one reading per requirement, in the study's order.
        violations: first violation of each violated requirement.
        carried, altered: number of samples that crossed the patched seams, and that the fault altered there.
        infected_at_s: time of the first altered sample [s].
        struck: body of the contact that ended the flight.
        duration_s: simulated time [s].
        digest, perceived_digest: digests of the log's ground truth and of the stack's beliefs.
        stack_error: exception of the stack, after which the fail-safe flew.
        realised: for a baseline, by axis whether the flight met the situation's value.
        track: trajectory at 5 Hz, packed by `judge/track.py`.
    """

    subject: Subject
    situation: str
    seed: int
    ending: str = ""
    invalid: str = ""
    readings: tuple[Reading, ...] = ()
    violations: tuple[Violation, ...] = ()
    carried: int = 0
    altered: int = 0
    infected_at_s: float | None = None
    struck: str = ""
    duration_s: float = 0.0
    digest: str = ""
    perceived_digest: str = ""
    stack_error: str = ""
    realised: tuple[tuple[str, bool], ...] = ()
    track: bytes = b""

    @property
    def mutant(self) -> str:
        """Id of the subject."""
        return self.subject.id

    @property
    def name(self) -> str:
        """`MUTANT/SITUATION/SEED`, the argument of `replay`."""
        return f"{self.subject.id}/{self.situation}/{self.seed}"

    def reading(self, requirement: str) -> Reading | None:
        """The reading of a requirement; None without one."""
        return next((reading for reading in self.readings if reading.requirement == requirement), None)

    @property
    def first_violation(self) -> Violation | None:
        """The earliest safety violation."""
        safety = [violation for violation in self.violations if violation.kind is Kind.SAFETY]
        return min(safety, key=lambda violation: violation.t_s, default=None)


def outcome_of(
    log: FlightLog,
    subject: Subject,
    situation: str,
    seed: int,
    *,
    requirements: Sequence[Requirement],
    realisation: Realisation | None = None,
) -> Outcome:
    """Judge a flight log.

    Args:
        log: the recorded flight, with the counts of the patched seams.
        subject: the subject of the flight.
        situation: key of the situation.
        seed: seed of the noise.
        requirements: requirements of the study.
        realisation: predicates of the grid, for a baseline.

    Raises:
        ValueError: a sample of the log is not finite.
    """
    signals = log.signals
    readings, violations = [], []
    for requirement in requirements:
        judgement = judge_signals(requirement, signals, cut_short=log.ending.cut_short)
        readings.append(judgement.reading)
        if judgement.sample is not None:
            violations.append(_violation(requirement, signals, judgement.sample, log.struck))
    counts = list(log.counts.values())
    first = [count.first_altered_s for count in counts if count.first_altered_s is not None]
    return Outcome(
        subject=subject,
        situation=situation,
        seed=seed,
        ending=log.ending.value,
        readings=tuple(readings),
        violations=tuple(violations),
        carried=sum(count.carried for count in counts),
        altered=sum(count.altered for count in counts),
        infected_at_s=min(first, default=None),
        struck=log.struck,
        duration_s=float(log.duration_s),
        digest=log.digest,
        perceived_digest=log.perceived_digest,
        stack_error=log.stack_error,
        realised=realisation.of(situation, signals) if realisation else (),
        track=pack_track(signals),
    )


def _violation(requirement: Requirement, signals: Signals, sample: int, struck: str) -> Violation:
    t_s, x, y, z = (float(signals[name][sample]) for name in ("elapsed_s", "x_m", "y_m", "z_m"))
    in_contact = float(signals["clearance_m"][sample]) <= 0
    return Violation(requirement.name, requirement.kind, t_s, x, y, z, struck if in_contact else "")
