"""The other supported Python with the newest libraries: the catalogue loads, each operator takes its seam."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
OTHER = "3.12" if sys.version_info[:2] == (3, 11) else "3.11"
BUILT = "pybullet"
"""Has wheels for some interpreters only; what is tried here flies nothing."""


def _interpreter() -> str | None:
    """A Python of that version that starts, on the path or among pyenv's."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    found = [shutil.which(f"python{OTHER}"), *sorted(map(str, pyenv.glob(f"versions/{OTHER}.*/bin/python{OTHER}")))]
    for candidate in filter(None, found):
        if subprocess.run([candidate, "-c", ""], capture_output=True, check=False).returncode == 0:
            return candidate
    return None


def _call(*words: str | Path) -> str:
    clean = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "PIP_TARGET"))}
    environment = clean | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(list(map(str, words)), cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


def _needed() -> list[str]:
    """What the package declares that it needs."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared: list[str] = project["dependencies"]
    return declared


def _venv(python: str, folder: Path, *packages: str) -> Path:
    """The interpreter of a new venv with these packages."""
    _call(python, "-m", "venv", folder)
    own = folder / "bin" / "python"
    _call(own, "-m", "pip", "install", "--quiet", "--no-compile", *packages)
    return own


@pytest.mark.release
def test_the_matrix_and_the_operators_load_on_the_other_python_with_the_newest_libraries(tmp_path: Path) -> None:
    python = _interpreter()
    if python is None:
        pytest.skip(f"there is no Python {OTHER} on this machine")
    needed = [name for name in _needed() if not name.startswith(BUILT)]
    own = _venv(python, tmp_path / "venv", *needed, "hypothesis", "pytest")
    tests = ("tests/hazop/test_reference_study.py", "tests/mutants/test_mutants.py")
    options = ("-q", "-m", "not flight", "-p", "no:cacheprovider", "-W", "ignore::DeprecationWarning")
    assert " passed" in _call(own, "-m", "pytest", *options, *tests)


@pytest.mark.flight
@pytest.mark.release
def test_it_flies_as_published_with_the_oldest_libraries_that_it_declares(tmp_path: Path) -> None:
    if sys.version_info[:2] != (3, 11):
        pytest.skip("the oldest libraries have no wheels for this Python")
    oldest = [re.sub(r">=([\d.]+).*", r"==\1", name) for name in _needed()]
    own = _venv(sys.executable, tmp_path / "venv", *oldest)
    assert "Known flight" in _call(own, "-m", "scaloft_fi", "doctor")
