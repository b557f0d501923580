"""A depth camera, poses and the study's settings, for the tests of the stages."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from studies import build

from scaloft_fi.stack.messages import DepthCamera, DepthFrame
from scaloft_fi.stack.reference.messages import PoseEstimate
from scaloft_fi.stack.reference.stack import ReferenceConfig

STACK = Path(__file__).resolve().parents[2] / "sim" / "stack.yaml"


@pytest.fixture(scope="session")
def config():
    return build(ReferenceConfig, {key: one for key, one in yaml.safe_load(STACK.read_text()).items() if key != "name"})


@pytest.fixture(scope="session")
def camera():
    return DepthCamera.pinhole(64, 48, 1.02974, ahead_m=0.1)


def pose_at(x=0.0, y=0.0, z=1.5, yaw=0.0, pitch=0.0, stamp_s=0.0, velocity=(0.0, 0.0, 0.0)):
    cy, sy, cp, sp = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    attitude = np.array([-sy * sp, cy * sp, sy * cp, cy * cp])
    return PoseEstimate(stamp_s, np.array([x, y, z], dtype=float), np.array(velocity), yaw, attitude)


def wall_at(depth_m, stamp_s=0.0):
    return DepthFrame(stamp_s, np.full((48, 64), float(depth_m)))
