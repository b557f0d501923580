"""The YAML files of a study: each is read, and none stands where no verb reads it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from scaloft_fi.checks.finding import Findings
from scaloft_fi.document import load
from scaloft_fi.errors import did_you_mean
from scaloft_fi.hazop.load import SHEETS
from scaloft_fi.sim.found import FILE as FOUND
from scaloft_fi.sim.grids import FOLDER as GRIDS
from scaloft_fi.sim.grids import is_grid_name
from scaloft_fi.sim.load import DOCUMENTS

NEEDED = {"hazop": ("guidewords", "parameters"), "sim": (*DOCUMENTS, "requirements")}
OPTIONAL = {"hazop": ("score", "severities", "dispositions"), "sim": ("sources", Path(FOUND).stem, "flyer", "record")}


def check_documents(folder: Path, findings: Findings) -> int:
    """Read every YAML file of the study; returns how many there are.

    Args:
        folder: the study.
        findings: takes the findings.
    """
    paths = list(_read_by_verbs(folder))
    for path in paths:
        with findings.collecting():
            load(path)
    for path in _stray(folder, paths):
        near = did_you_mean(path.stem, (*NEEDED[path.parent.name], *OPTIONAL[path.parent.name]))
        findings.note(f"{path}:1", "no verb reads this file", f"name it as one that is read{near}")
    for path in sorted((folder / "sim" / GRIDS).glob("*.y*ml")):
        if path.suffix != ".yaml" or not is_grid_name(path.stem):
            allowed = "letters, digits, - and _, and end it in .yaml"
            findings.wrong(f"{path}:1", "no verb reads this grid", f"name the file with {allowed}")
    for path in sorted((folder / "hazop" / SHEETS).glob("*.yml")):
        findings.wrong(f"{path}:1", "no verb reads this file", "end its name in .yaml")
    return len(paths)


def _read_by_verbs(folder: Path) -> Iterator[Path]:
    for part, names in NEEDED.items():
        yield from (folder / part / f"{name}.yaml" for name in names)
    for part, names in OPTIONAL.items():
        yield from (path for name in names if (path := folder / part / f"{name}.yaml").exists())
    yield from sorted((folder / "hazop" / SHEETS).glob("*.yaml"))
    yield from sorted(path for path in (folder / "sim" / GRIDS).glob("*.yaml") if is_grid_name(path.stem))


def _stray(folder: Path, known: list[Path]) -> Iterator[Path]:
    for part in NEEDED:
        yield from (path for path in sorted((folder / part).glob("*.y*ml")) if path not in known)
