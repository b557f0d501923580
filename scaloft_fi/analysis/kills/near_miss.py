"""How near a flight came to a violation: margin lost beside its baseline, way off the baseline's path."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

from scaloft_fi.analysis.plain import by_field
from scaloft_fi.judge.outcome import TRACK_COLUMNS, unpack_track
from scaloft_fi.judge.requirement import Compliance, Reading
from scaloft_fi.judge.status import JudgedFlight

_T, _X, _Y, _Z = (TRACK_COLUMNS.index(name) for name in ("elapsed_s", "x_m", "y_m", "z_m"))


@dataclass(frozen=True)
class Loss:
    """Robustness of a requirement in a flight beside its baseline's, in the requirement's unit.

    Attributes:
        requirement: name.
        situation, seed: of the flight.
        baseline: robustness of the baseline, above 0.
        flown: robustness of the flight.
    """

    requirement: str
    situation: str
    seed: int
    baseline: float
    flown: float

    @property
    def share(self) -> float:
        """Share of the baseline's margin that the fault took; below 0 where it gained some."""
        return (self.baseline - self.flown) / self.baseline

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {**by_field(self), "share": self.share}


def losses(flight: JudgedFlight, steady: Collection[str]) -> tuple[Loss, ...]:
    """What a flight lost of each requirement, steady there, that it and its baseline held to their ends, triggered."""
    if flight.baseline is None:
        return ()
    lost = []
    for reading in flight.outcome.readings:
        clean = flight.baseline.reading(reading.requirement)
        if clean is not None and reading.requirement in steady and _held(reading) and _held(clean) and clean.rho > 0:
            place = flight.outcome.situation, flight.outcome.seed
            lost.append(Loss(reading.requirement, *place, clean.rho, reading.rho))
    return tuple(lost)


def _held(reading: Reading) -> bool:
    return reading.compliance is Compliance.HELD


def off_path_m(flight: JudgedFlight) -> float | None:
    """How far the flight was off its baseline's path at the most [m]: second by second, to the nearest point of it.

    Time does not enter: a flight that goes the same way later is not off it.  None without both trajectories.
    """
    flown = unpack_track(flight.outcome.track)
    path = unpack_track(flight.baseline.track) if flight.baseline else []
    if not flown or not path:
        return None
    import numpy as np

    # a published track may be thinner than a stored one
    apart_s = flown[1][_T] - flown[0][_T] if len(flown) > 1 else 0.0
    each = max(1, round(1 / apart_s)) if apart_s > 0 else 1
    points, others = (np.array([[row[_X], row[_Y], row[_Z]] for row in rows]) for rows in (flown[::each], path))
    apart = np.linalg.norm(points[:, None, :] - others[None, :, :], axis=2)
    return float(apart.min(axis=1).max())
