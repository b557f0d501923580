"""Stacks of a third party that do nothing, flown: no campaign of theirs is green."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
pytestmark = pytest.mark.flight

PLUGIN = """
from dataclasses import replace

from scaloft_fi.api import declare_stack
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.stack import ReferenceStack


class Raising(ReferenceStack):
    def autopilot(self, now_s, frames):
        raise RuntimeError("no bus")


class Standing(ReferenceStack):
    def __init__(self, task, wire):
        super().__init__(task, wire)
        self.fast_path = None

    def step(self, now_s, imu):
        return None


declare_stack(replace(REFERENCE, name="raising", make=Raising))
declare_stack(replace(REFERENCE, name="standing", make=Standing))
"""


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """A folder of packages with the plugin installed in it."""
    folder = tmp_path / "site"
    (folder / "dead_stacks-1.dist-info").mkdir(parents=True)
    (folder / "dead_stacks.py").write_text(PLUGIN)
    (folder / "dead_stacks-1.dist-info" / "METADATA").write_text("Name: dead-stacks\nVersion: 1\n")
    entry = "[scaloft_fi.plugins]\ndead = dead_stacks\n"
    (folder / "dead_stacks-1.dist-info" / "entry_points.txt").write_text(entry)
    return folder


BASELINE = "baseline/T0O0W0D0H0/0"
RAISES = f"the stack raises without any fault: {BASELINE} (autopilot at 0.000 s: RuntimeError: no bus)"
STANDS = f"the drone never leaves the ground without any fault: {BASELINE}"


@pytest.mark.parametrize(
    ("stack", "sentences"),
    [pytest.param("raising", [RAISES, STANDS], marks=pytest.mark.release), ("standing", [STANDS])],
)
def test_a_stack_that_does_nothing_fails_its_gate_flown_and_resumed(
    site: Path, tmp_path: Path, stack: str, sentences: list[str]
) -> None:
    study = tmp_path / "study"
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(ROOT / name, study / name)
    settings = study / "sim" / "stack.yaml"
    settings.write_text(settings.read_text().replace("name: reference", f"name: {stack}"))
    path = os.pathsep.join([str(site), *filter(None, sys.path)])
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H0", "--jobs", "1", "--quiet")
    for _ in range(2):
        call = [sys.executable, "-m", "scaloft_fi", *words, "--study", str(study)]
        environment = {**os.environ, "PYTHONPATH": path}
        done = subprocess.run(call, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 4, done.stderr
        assert done.stdout == ""
        assert all(sentence in done.stderr for sentence in sentences)
