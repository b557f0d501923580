"""The reference study's simulation, and folders to spoil."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from scaloft_fi.sim.load import SimConfig, load

SIM = Path(__file__).parents[2] / "sim"


@pytest.fixture(scope="session")
def config() -> SimConfig:
    return load(SIM)


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
    pybullet = pytest.importorskip("pybullet")
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(physicsClientId=number)
