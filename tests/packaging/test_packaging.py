"""Wheel, editable install and bare checkout: each shows the matrix from a fresh environment."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

import pytest
from wheels import ROOT, built, checkout_in, fresh, install, shell


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return checkout_in(tmp_path_factory.mktemp("clone") / "checkout")


@pytest.fixture(scope="module")
def wheel(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(checkout, tmp_path_factory.mktemp("wheel"))


def test_the_wheel_installs_one_top_level_package(wheel: Path) -> None:
    shell(sys.executable, "-m", "check_wheel_contents", wheel, cwd=wheel.parent)
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


def test_the_wheel_carries_the_templates_of_new(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        inside = {name.removeprefix("scaloft_fi/_") for name in archive.namelist() if "/_templates/" in name}
    ours = {path for path in (ROOT / "templates").rglob("*") if path.is_file() and "__pycache__" not in path.parts}
    assert inside == {str(path.relative_to(ROOT)) for path in ours}


def test_the_matrix_comes_out_of_the_installed_wheel(wheel: Path, tmp_path: Path) -> None:
    python = fresh(tmp_path / "venv")
    install(python, wheel)
    assert "LATE" in shell(python.parent / "scaloft-fi", "matrix", cwd=tmp_path)


def test_the_matrix_comes_out_of_an_editableinstall(checkout: Path, tmp_path: Path) -> None:
    python = fresh(tmp_path / "venv")
    install(python, "-e", checkout)
    assert "LATE" in shell(python.parent / "scaloft-fi", "matrix", cwd=tmp_path)


def test_the_matrix_comes_out_of_a_bare_checkout(checkout: Path, tmp_path: Path) -> None:
    assert "LATE" in shell(fresh(tmp_path / "venv"), "-m", "scaloft_fi", "matrix", cwd=checkout)
