"""A depth camera, poses and the study's settings, for the tests of the companion's stages."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from items import build

from scaloft_fi.stack.messages import DepthCamera, DepthFrame
from scaloft_fi.stack.reference.memory import MemoryConfig
from scaloft_fi.stack.reference.messages import PoseEstimate
from scaloft_fi.stack.reference.planner import PlannerConfig
from scaloft_fi.stack.reference.proximity import ProximityConfig

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def settings():
    return yaml.safe_load((ROOT / "sim" / "stack.yaml").read_text())


@pytest.fixture(scope="session")
def memory_config(settings):
    return build(MemoryConfig, settings["memory"])


@pytest.fixture(scope="session")
def planner_config(settings):
    return build(PlannerConfig, settings["planner"])


@pytest.fixture(scope="session")
def proximity_config(settings):
    return build(ProximityConfig, settings["proximity"])


@pytest.fixture(scope="session")
def camera():
    return DepthCamera.pinhole(64, 48, 1.02974, ahead_m=0.1)


@pytest.fixture(scope="session")
def pose_at():
    def make(x=0.0, y=0.0, z=1.5, yaw=0.0, pitch=0.0, stamp_s=0.0):
        cy, sy, cp, sp = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(pitch / 2), math.sin(pitch / 2)
        attitude = np.array([-sy * sp, cy * sp, sy * cp, cy * cp])
        return PoseEstimate(stamp_s, np.array([x, y, z], dtype=float), np.zeros(3), yaw, attitude)

    return make


@pytest.fixture(scope="session")
def wall_at():
    def make(depth_m, stamp_s=0.0):
        return DepthFrame(stamp_s, np.full((48, 64), float(depth_m)))

    return make
