"""Samples for every seam, and the reference study's matrix."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scaloft_fi.mutants.reference  # noqa: F401 - declares the operators of the reference stack
from scaloft_fi.document import load
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants.catalogue import with_events
from scaloft_fi.sim.events import events_in
from scaloft_fi.stack import messages as m
from scaloft_fi.stack.reference import messages as own
from scaloft_fi.stack.reference.declaration import REFERENCE

STUDY = Path(__file__).parents[2]


def _person(k: int) -> m.Detections:
    near = m.Person("person", 0.9 - 0.01 * k, 0.02 * k, 3.0 + 0.1 * k)
    return m.Detections(k / 20, (near, m.Person("person", 0.55, -0.45, 7.0)))


def _proximity(k: int) -> own.Proximity:
    sectors = np.array([0.2 + 0.1 * k, 1.0, 0.3, np.inf])
    return own.Proximity(k / 20, sectors, np.full(4, True), np.array([0.6, 0.2, -0.2, -0.6]), 0.4, touched=k % 3 == 0)


def _map(k: int) -> own.ObstacleMap:
    points = np.array([[1.0, 2.0 + 0.1 * k, 1.6], [-1.0, 1.0, 1.6], [0.2, -2.0, 1.6]])
    return own.ObstacleMap(k / 20, points, 1.0, np.array([0.0, 0.1 * k, 1.65]))


def _pose(k: int) -> own.PoseEstimate:
    attitude = np.array([0.0, 0.0, np.sin(0.05 * k), np.cos(0.05 * k)])
    return own.PoseEstimate(k / 20, np.array([0.1, 0.2 * k, 1.65]), np.array([0.0, 0.5, 0.01 * k]), 0.1 * k, attitude)


MAKERS: dict[str, Callable[[int], Any]] = {
    "imu": lambda k: m.Imu(k / 240, np.array([0.1, 0.2, 0.01 * k]), np.array([0.3, 0.1 * k, 9.81])),
    "stamps": lambda k: m.Stamps(k / 20, k / 20, k / 20),
    "fix": lambda k: m.Fix(k / 20, np.array([0.0, 0.1 * k, 1.65]), 1.5),
    "depth": lambda k: m.DepthFrame(k / 20, np.array([[0.0, 1.0, 2.0 + 0.1 * k, 3.0, 1.5, 4.0]] * 4)),
    "metering": lambda k: m.Metering(k / 20, 0.5 - 0.1 * k),
    "exposure": lambda k: m.Exposure(0.1 * k + 0.1, 2.0, 0.1),
    "person": _person,
    "battery": lambda k: m.Battery(k / 20, 0.9 - 0.01 * k, 16.0, 4),
    "failsafe": lambda k: own.Failsafe(k / 20, "return" if k % 2 else "land"),
    "bumper": lambda k: m.Bumper(k / 20, hull=False, gear=k % 2 == 1),
    "pose": _pose,
    "proximity": _proximity,
    "collision": lambda k: own.CollisionFlag(k / 20, 0.1 * k),
    "route": lambda k: own.Route(((0.0, 7.0, 1.65), (-3.0, 8.0 + 0.1 * k, 1.65), (0.0, 7.0, 1.65), (0.0, 0.0, 1.65))),
    "goal": lambda k: own.GoalCheck(k // 4, (0.0, 0.5 - 0.1 * (k % 4), 0.1), (1.0, 1.0, 0.0), 0.3, 0.5),
    "target": lambda k: own.Target(k // 4, (0.0, 7.0 - k // 4, 1.65)),
    "speedlimit": lambda k: own.SpeedLimit(k / 20, 0.2 if k % 5 in (1, 2) else 0.5, "euclidean"),
    "clearing": lambda k: own.Clearing(k / 20, np.array([k, k + 1]), np.array([k, k + 1, k + 2])),
    "map": _map,
    "velcmd": lambda k: own.VelocityCommand(k / 20, np.array([0.1, 0.5, 0.01 * k]), 1.5),
    "thrust": lambda k: m.Thrust(np.full(4, 3.0 + 0.1 * k)),
}


def _frozen(sample: Any) -> Any:
    """`sample` with every array read-only: writing into it raises."""
    if isinstance(sample, np.ndarray):
        sample.setflags(write=False)
    elif isinstance(sample, tuple):
        for entry in sample:
            _frozen(entry)
    return sample


@pytest.fixture(scope="session")
def stream() -> Callable[[str], list[tuple[float, Any]]]:
    """By seam: (time, sample or None) for forty polls, every fourth without a sample; the arrays are read-only."""

    def of(seam: str) -> list[tuple[float, Any]]:
        rate_hz = REFERENCE.by_name[seam].rate_hz
        return [(k / rate_hz, None if k % 4 == 3 else _frozen(MAKERS[seam](k))) for k in range(40)]

    return of


@pytest.fixture(scope="session")
def sample_of() -> Callable[[str, int], Any]:
    """The k-th sample of a seam."""
    return lambda seam, k: MAKERS[seam](k)


@pytest.fixture(scope="session")
def matrix() -> Matrix:
    """The reference study's matrix."""
    events = events_in(load(STUDY / "sim" / "world.yaml"), REFERENCE.beliefs)
    return with_events(load_matrix(STUDY / "hazop", REFERENCE.by_name), events)
