"""Wheel and bare checkout: each shows the matrix from a fresh environment; README's test command installs the clone."""

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


def test_the_wheel_carries_the_reference_study_the_schemas_and_the_templates_of_new(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = {name.removeprefix("scaloft_fi/_") for name in archive.namelist() if name.startswith("scaloft_fi/_")}
    files = {
        "study": [path for name in ("hazop", "mutants", "sim") for path in (ROOT / name).rglob("*")],
        "schemas": list((ROOT / "docs" / "schemas" / "study").iterdir()),
        "templates": list((ROOT / "templates").rglob("*")),
    }
    above = {"study": ROOT, "schemas": ROOT / "docs" / "schemas" / "study", "templates": ROOT / "templates"}
    for part, paths in files.items():
        ours = {
            str(one.relative_to(above[part])) for one in paths if one.is_file() and one.parent.name != "__pycache__"
        }
        assert {name.removeprefix(f"{part}/") for name in names if name.startswith(f"{part}/")} == ours


def test_the_matrix_comes_out_of_a_bare_checkout_and_of_the_installed_wheel(
    checkout: Path, wheel: Path, tmp_path: Path
) -> None:
    python = fresh(tmp_path / "venv")
    assert "LATE" in shell(python, "-m", "scaloft_fi", "matrix", cwd=checkout)
    install(python, wheel)
    assert "LATE" in shell(python.parent / "scaloft-fi", "matrix", cwd=tmp_path)
