"""Wheel, editable install and bare checkout: each shows the matrix from a fresh environment."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def _call(*words: str | Path, cwd: Path) -> str:
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "PIP_TARGET"))}
    done = subprocess.run(list(map(str, words)), cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _fresh(folder: Path) -> Path:
    """A new environment that sees the installed dependencies, but no editable install of ours; returns its python."""
    venv.create(folder, with_pip=False, symlinks=True)
    site = next(folder.glob("lib/python*/site-packages"))
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder / "bin" / "python"


def _install(python: Path, *what: str | Path) -> None:
    _call(sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-deps", *what, cwd=python.parent)


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files a clone would hold."""
    folder = tmp_path_factory.mktemp("checkout")
    for name in ("pyproject.toml", "README.md", "LICENSE", ".gitignore"):
        shutil.copy(ROOT / name, folder / name)
    for name in ("scaloft_fi", "hazop", "mutants", "sim", "docs/schemas"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


@pytest.fixture(scope="module")
def wheel(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    _call(sys.executable, "-m", "build", "--wheel", "--outdir", folder, checkout, cwd=folder)
    (built,) = folder.glob("*.whl")
    return built


def test_the_wheel_installs_one_top_level_package(wheel: Path) -> None:
    _call(sys.executable, "-m", "check_wheel_contents", wheel, cwd=wheel.parent)
    with zipfile.ZipFile(wheel) as archive:
        tops = {name.split("/")[0] for name in archive.namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"scaloft_fi"}


def test_the_wheel_carries_the_reference_study(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        inside = {name.removeprefix("scaloft_fi/_study/") for name in archive.namelist() if "/_study/" in name}
    ours = [path for folder in ("hazop", "mutants", "sim") for path in (ROOT / folder).rglob("*") if path.is_file()]
    assert inside == {str(path.relative_to(ROOT)) for path in ours}


def test_the_wheel_carries_the_schemas_of_the_documents_of_a_study(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        inside = {Path(name).name for name in archive.namelist() if name.startswith("scaloft_fi/_schemas/")}
    assert inside == {path.name for path in (ROOT / "docs" / "schemas" / "study").iterdir()}


def test_the_matrix_comes_out_of_the_installed_wheel(wheel: Path, tmp_path: Path) -> None:
    python = _fresh(tmp_path / "venv")
    _install(python, wheel)
    assert "LATE" in _call(python.parent / "scaloft-fi", "matrix", cwd=tmp_path)


def test_the_matrix_comes_out_of_an_editable_install(checkout: Path, tmp_path: Path) -> None:
    python = _fresh(tmp_path / "venv")
    _install(python, "-e", checkout)
    assert "LATE" in _call(python.parent / "scaloft-fi", "matrix", cwd=tmp_path)


def test_the_matrix_comes_out_of_a_bare_checkout(checkout: Path, tmp_path: Path) -> None:
    assert "LATE" in _call(_fresh(tmp_path / "venv"), "-m", "scaloft_fi", "matrix", cwd=checkout)
