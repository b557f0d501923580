"""Packages of other authors, installed into a folder for a process of their own, without network and without pip."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
GROUP = "scaloft_fi.plugins"


def install(site: Path, package: str, entries: Mapping[str, str]) -> None:
    """Write what `importlib.metadata` reads of an installed package: its name, and its entry points."""
    info = site / f"{package}-1.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Name: {package}\nVersion: 1\n")
    lines = [f"{name} = {module}" for name, module in entries.items()]
    (info / "entry_points.txt").write_text("\n".join([f"[{GROUP}]", *lines, ""]))


def install_project(site: Path, project: Path) -> None:
    """Install a project's folder as it stands: its packages by path, its entry points from its `pyproject.toml`."""
    declared = tomllib.loads((project / "pyproject.toml").read_text())["project"]
    install(site, declared["name"], declared["entry-points"][GROUP])
    for package in project.glob("*/__init__.py"):
        (site / package.parent.name).symlink_to(package.parent, target_is_directory=True)


def call(site: Path, *words: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Python with these words, in a process that sees the packages of `site`."""
    path = os.pathsep.join([str(site), str(ROOT), *filter(None, sys.path)])
    environment = os.environ | {"PYTHONPATH": path}
    command = [sys.executable, *map(str, words)]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)


_RUNNER = """
import contextlib, io, json, sys
from scaloft_fi.cli import main

told = []
for words in json.loads(sys.argv[1]):
    printed = io.TextIOWrapper(io.BytesIO(), write_through=True)
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        try:
            main.main(words)
        except SystemExit as ended:
            told.append([ended.code, printed.buffer.getvalue().decode()])
print("told", json.dumps(told))
"""


def called(site: Path, *verbs: Sequence[str], cwd: Path) -> list[tuple[int, str]]:
    """Exit code and output of each verb, called one after another in one process that sees the packages of `site`."""
    done = call(site, "-c", _RUNNER, json.dumps(verbs), cwd=cwd)
    last = next((line for line in done.stdout.splitlines() if line.startswith("told ")), None)
    assert last, done.stdout + done.stderr
    return [(code, printed) for code, printed in json.loads(last.removeprefix("told "))]
