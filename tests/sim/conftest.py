"""The reference study's simulation, and folders to spoil."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from scaloft_fi.sim.build import physics_server
from scaloft_fi.sim.load import Scenario, SimConfig, load

SIM = Path(__file__).parents[2] / "sim"


@pytest.fixture(scope="session")
def config() -> SimConfig:
    return load(SIM)


@pytest.fixture(scope="session")
def scenario(config: SimConfig) -> Callable[[str], Scenario]:
    """The scenario of a key."""
    return lambda key: config.scenario(config.grid.situation(key))


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """A copy of the reference study's `sim` folder."""
    return Path(shutil.copytree(SIM, tmp_path / "sim", ignore=shutil.ignore_patterns("found.yaml")))


@pytest.fixture
def edited(study: Path) -> Callable[[str, str, str], Path]:
    """Replace a text in one file of the copy; the copy is returned."""

    def edit(name: str, old: str, new: str) -> Path:
        path = study / name
        text = path.read_text(encoding="utf-8")
        assert old in text, f"{old!r} is not in {name}"
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        return study

    return edit


@pytest.fixture
def client():
    """An empty physics server."""
    with physics_server() as number:
        yield number


def turned_by(q):
    """The rotation matrix of a quaternion x, y, z, w, body to world, beside those of the kernels."""
    x, y, z, w = q
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * across + 2 * across @ across


def state_at(position=(0, 0, 0), attitude=(0, 0, 0, 1), velocity=(0, 0, 0), rate=(0, 0, 0)):
    """The state of a vehicle, (13,)."""
    return np.array([*position, *np.array(attitude) / np.linalg.norm(attitude), *velocity, *rate], dtype=float)
