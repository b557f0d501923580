"""Operators on the pose estimate (message `PoseEstimate`)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from scaloft_fi.mutants.operator import TOLERANCE_S, Example, Seconds, Tap, TapContext, operator, the
from scaloft_fi.stack.messages import Array
from scaloft_fi.stack.reference.messages import PoseEstimate


def _pose(x: float, y: float, yaw_rad: float = 0.0) -> PoseEstimate:
    attitude = np.array([0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)])
    return PoseEstimate(0.0, np.array([x, y, 1.65]), np.zeros(3), yaw_rad, attitude)


def turned(attitude: Array, angle_rad: float) -> Array:
    """`attitude` (4,) quaternion x, y, z, w, turned about the world's z axis by `angle_rad` [rad]."""
    s, c = math.sin(angle_rad / 2), math.cos(angle_rad / 2)
    x, y, z, w = attitude
    return np.array([c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z])


@dataclass
class _Hold:
    component: str
    held: float | None = None

    def __call__(self, _t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        if self.component == "yaw":
            self.held = sample.yaw_rad if self.held is None else self.held
            return sample._replace(yaw_rad=self.held, attitude=turned(sample.attitude, self.held - sample.yaw_rad))
        axis = "xyz".index(self.component)
        self.held = float(sample.position[axis]) if self.held is None else self.held
        position = sample.position.copy()
        position[axis] = self.held
        return sample._replace(position=position)


@operator(
    "hold_component",
    need=the(PoseEstimate),
    example=Example(
        PoseEstimate,
        {"component": "yaw"},
        (_pose(0.0, 0.0, 1.5), None, _pose(0.0, 1.0, 0.5)),
        (_pose(0.0, 0.0, 1.5), None, _pose(0.0, 1.0, 1.5)),
    ),
)
def hold_component(_context: TapContext, *, component: Literal["x", "y", "z", "yaw"]) -> Tap:
    """Keep one component of the position [m, world], or the heading, at its first value: one measurement is not fused.

    A held heading turns the attitude too, so that all consumers receive the same heading.
    """
    return _Hold(component)


@dataclass
class _ResetOrigin:
    at_s: float
    origin: Array | None = None

    def __call__(self, t_s: float, sample: Any | None) -> Any | None:
        if sample is None or t_s < self.at_s - TOLERANCE_S:
            return sample
        if self.origin is None:
            self.origin = sample.position * np.array([1.0, 1.0, 0.0])
        return sample._replace(position=sample.position - self.origin)


@operator(
    "reset_origin",
    need=the(PoseEstimate),
    example=Example(
        PoseEstimate,
        {"at_s": 0.05},
        (_pose(1.0, 2.0), _pose(1.0, 3.0), _pose(1.0, 4.0)),
        (_pose(1.0, 2.0), _pose(0.0, 0.0), _pose(0.0, 1.0)),
    ),
)
def reset_origin(_context: TapContext, *, at_s: Seconds = 20.0) -> Tap:
    """From `at_s` [s] on, count x and y from where the vehicle was then.

    An estimator that restarts in flight; height is kept.
    """
    return _ResetOrigin(at_s)
