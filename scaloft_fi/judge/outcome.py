"""The stored outcome of one flight, pure data, with its trajectory; statuses and scores follow from outcomes."""

from __future__ import annotations

import math
import zlib
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scaloft_fi.judge.requirement import Kind, Reading, Requirement, judge_signals
from scaloft_fi.judge.stl import Signals

if TYPE_CHECKING:
    from scaloft_fi.judge.space import Realisation
    from scaloft_fi.mutants.mutant import Mutant
    from scaloft_fi.sim.log import FlightLog


TRACK: Mapping[str, Callable[[Sequence[float]], float]] = {
    **dict.fromkeys(("elapsed_s", "x_m", "y_m", "z_m"), lambda values: values[-1]),
    "speed_mps": max,
    "clearance_m": min,
    "person_sight_m": min,
}
"""The stored signals; each with the function that reduces the samples since the last stored one to one value."""
TRACK_COLUMNS = tuple(TRACK)
TRACK_EVERY = 4
"""Every fourth sample of 20 Hz is stored: 5 Hz."""
MOST_ROWS = 24 * 3600 * 5
"""Greatest number of rows of a track that is unpacked: a day."""
_ROW_BYTES = 4 * len(TRACK_COLUMNS)


def pack_track(signals: Signals) -> bytes:
    """Pack the trajectory at 5 Hz as single floats; it always includes the first and the last sample.

    Args:
        signals: (T,) samples at 20 Hz of at least the signals in `TRACK_COLUMNS`.
    """
    columns = [list(map(float, signals[name])) for name in TRACK_COLUMNS]
    length = len(columns[0])
    kept = sorted({*range(0, length, TRACK_EVERY), length - 1})
    spans = list(zip([-1, *kept], kept, strict=False))
    pairs = list(zip(columns, TRACK.values(), strict=True))
    rows = (stands(column[last + 1 : now + 1]) for last, now in spans for column, stands in pairs)
    return zlib.compress(array("f", rows).tobytes(), 6)


def unpack_track(track: bytes) -> list[tuple[float, ...]]:
    """Unpack the rows of `TRACK_COLUMNS`; an empty track has no rows.

    Raises:
        ValueError: the track is damaged, or has more than `MOST_ROWS` rows.
    """
    values, width = track_values(track), len(TRACK_COLUMNS)
    return [tuple(values[i : i + width]) for i in range(0, len(values), width)]


def track_values(track: bytes, most_rows: int = MOST_ROWS) -> array[float]:
    """Unpack the values of a track, row by row; an empty track has none.

    Args:
        track: a packed track, from anywhere.
        most_rows: greatest number of rows; no more memory is used, however many the track has.

    Raises:
        ValueError: the track is damaged, has more rows, or has a number that is not finite.
    """
    values = array("f")
    if not track:
        return values
    unpacking = zlib.decompressobj()
    try:
        content = unpacking.decompress(track, most_rows * _ROW_BYTES + 1)
    except zlib.error as error:
        raise ValueError("damaged") from error
    if len(content) > most_rows * _ROW_BYTES:
        raise ValueError(f"longer than {most_rows} rows")
    if not unpacking.eof or unpacking.unused_data or len(content) % _ROW_BYTES:
        raise ValueError("damaged")
    values.frombytes(content)
    if not math.isfinite(sum(values)):
        raise ValueError("not finite")
    return values


BASELINE, PLACEBO_ID = "baseline", "PLACEBO"


@dataclass(frozen=True)
class Subject:
    """The subject of a flight: the baseline, PLACEBO or a mutant.

    Attributes:
        id: canonical id.
        guideword: its guideword; empty where it has none, as PLACEBO.
        parameter: its parameter; empty where it has none.
        magnitude: its magnitude with the unit, as in the id; empty where there is none.
    """

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
        subject: subject of the flight.
        situation: key of the situation.
        seed: seed of the flight.
        ending: how the flight ended; empty when invalid.
        invalid: why the harness failed; empty for a valid flight.
        readings: what each requirement says of it, in the study's order.
        violations: first violation of each violated requirement.
        carried: number of samples that crossed the patched seams.
        altered: number of samples that the fault altered.
        infected_at_s: first altered sample [s from take-off]; null: no sample was altered.
        struck: body of the contact that ended the flight.
        duration_s: how long it lasted in simulated time [s].
        digest: SHA-256 over the ground truth of the log.
        perceived_digest: digest of the stack's beliefs.
        stack_error: exception of the stack, after which the fail-safe flew.
        realised: for a baseline, by axis whether the flight met the situation's value.
        track: trajectory at 5 Hz, packed by `pack_track`.
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
        """`baseline`, `PLACEBO` or the id of the mutant."""
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
        if (at := judgement.sample) is not None:
            t_s, x, y, z = (float(signals[name][at]) for name in ("elapsed_s", "x_m", "y_m", "z_m"))
            struck = log.struck if float(signals["clearance_m"][at]) <= 0 else ""
            violations.append(Violation(requirement.name, requirement.kind, t_s, x, y, z, struck))
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
