"""Without any extra every module is imported."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
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


def test_without_extras_every_module_is_imported() -> None:
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
