"""What is installed: wheel and bare checkout, extras, interpreters, the citation."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from processes import ROOT, built, checkout_in, fresh, pip_install, shell

import scaloft_fi


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return checkout_in(tmp_path_factory.mktemp("clone") / "checkout")


@pytest.fixture(scope="module")
def wheel(checkout: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(checkout, tmp_path_factory.mktemp("wheel"))


def test_the_wheel_installs_one_top_level_package(wheel: Path):
    shell(sys.executable, "-m", "check_wheel_contents", wheel, cwd=wheel.parent)
    with zipfile.ZipFile(wheel) as archive:
        tops = {name.split("/")[0] for name in archive.namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"scaloft_fi"}


def test_the_wheel_carries_the_reference_study_the_schemas_the_templates_of_new_and_the_examples(wheel: Path):
    with zipfile.ZipFile(wheel) as archive:
        names = {name.removeprefix("scaloft_fi/_") for name in archive.namelist() if name.startswith("scaloft_fi/_")}
    files = {
        "study": [path for name in ("hazop", "mutants", "sim") for path in (ROOT / name).rglob("*")],
        "schemas": list((ROOT / "docs" / "schemas" / "study").iterdir()),
        **{name: list((ROOT / name).rglob("*")) for name in ("templates", "examples")},
    }
    above = {"study": ROOT, "schemas": ROOT / "docs" / "schemas" / "study"}
    for part, paths in files.items():
        ours = {
            str(one.relative_to(above.get(part, ROOT / part)))
            for one in paths
            if one.is_file() and one.parent.name != "__pycache__"
        }
        assert {name.removeprefix(f"{part}/") for name in names if name.startswith(f"{part}/")} == ours


def test_the_matrix_comes_out_of_a_bare_checkout_and_of_the_installed_wheel(
    checkout: Path, wheel: Path, tmp_path: Path
):
    python = fresh(tmp_path / "venv")
    assert "LATE" in shell(python, "-m", "scaloft_fi", "matrix", cwd=checkout)
    pip_install(python, wheel)
    assert "LATE" in shell(python.parent / "scaloft-fi", "matrix", cwd=tmp_path)


PROGRAM = """
import importlib, pkgutil, sys
sys.modules.update(dict.fromkeys(sys.argv[1:]))  # None: as if it were not installed
import scaloft_fi
for module in pkgutil.walk_packages(scaloft_fi.__path__, "scaloft_fi."):
    if not module.name.endswith("__main__"):
        try:
            importlib.import_module(module.name)
        except ImportError:
            print(module.name)
"""


def _with_what_they_need(names: Iterable[str]) -> set[str]:
    """The distributions, and all that they require here."""
    found: set[str] = set()
    waiting = [Requirement(name) for name in names]
    while waiting:
        one = waiting.pop()
        if one.name in found or (one.marker is not None and not one.marker.evaluate({"extra": ""})):
            continue
        try:
            waiting += [Requirement(text) for text in requires(one.name) or ()]
        except PackageNotFoundError:
            continue
        found.add(one.name.lower().replace("_", "-"))
    return found


@pytest.mark.release
def test_without_extras_every_module_is_imported():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    needed = _with_what_they_need(project["dependencies"])
    extra = _with_what_they_need(name for names in project["optional-dependencies"].values() for name in names) - needed
    modules = {
        module
        for module, owners in packages_distributions().items()
        if {owner.lower().replace("_", "-") for owner in owners} <= extra and module.isidentifier()
    }
    assert {"distributed", "msgpack", "optuna"} <= modules
    words = [sys.executable, "-c", PROGRAM, *sorted(modules)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == ""


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
def test_the_matrix_and_the_operators_load_on_the_other_python_with_the_newest_libraries(tmp_path: Path):
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
def test_it_flies_as_published_with_the_oldest_libraries_that_it_declares(tmp_path: Path):
    if sys.version_info[:2] != (3, 11):
        pytest.skip("the oldest libraries have no wheels for this Python")
    oldest = [re.sub(r">=([\d.]+).*", r"==\1", name) for name in _needed()]
    own = _venv(sys.executable, tmp_path / "venv", *oldest)
    assert "Known flight" in _call(own, "-m", "scaloft_fi", "doctor")


TOLD = yaml.safe_load((Path(__file__).resolve().parents[2] / "CITATION.cff").read_text())
NEEDED = {"cff-version", "message", "title", "authors"}
USED = NEEDED | {"type", "abstract", "version", "license", "keywords", "references"}
"""Keys of the format: those that every file has, and those of this one."""


def test_it_has_what_the_format_needs():
    assert TOLD["cff-version"] == "1.2.0"
    assert NEEDED < set(TOLD) == USED
    assert TOLD["type"] in ("software", "dataset")
    for entry in (TOLD, *TOLD["references"]):
        assert entry["title"]
        assert entry["authors"]
        assert all("name" in author or {"family-names", "given-names"} <= set(author) for author in entry["authors"])


def test_it_names_this_version():
    assert TOLD["version"] == scaloft_fi.__version__


def test_it_names_the_paper_and_who_wrote_it():
    (paper,) = TOLD["references"]
    assert paper["title"].startswith("SCALOFT: ")
    assert [author["family-names"] for author in paper["authors"]] == ["Proma", "Hodge", "Alexander"]
    assert all(
        re.fullmatch(r"https://orcid\.org/(\d{4}-){3}\d{3}[\dX]", author["orcid"]) for author in paper["authors"]
    )
