"""The situations that a search found, the accepted survivors, and the sources of the numbers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.checks.finding import Findings
from scaloft_fi.document import Item, is_there, load
from scaloft_fi.sim.found import FILE
from scaloft_fi.study import read_disposition

if TYPE_CHECKING:
    from collections.abc import Collection

    from scaloft_fi.hazop.matrix import Matrix
    from scaloft_fi.study import Study


def check_found(study: Study, findings: Findings) -> int:
    """The finds and breaks of the study; returns how many there are.  Those that no longer fit are notes."""
    path = study.folder / "sim" / FILE
    if not is_there(path):
        return 0
    count = 0
    with findings.collecting():
        known, places = study.finds, _places(path)
        count = len(known.finds) + len(known.breaks) + len(known.misfits)
        for name, why in known.misfits.items():
            what = f"{name} does not fit the study any more, so every verb leaves it out: {why}"
            findings.note(places.get(name, f"{path}:1"), what.replace("; ", ", "), "seek anew, or remove the entry")
    return count


def _places(path: Path) -> dict[str, str]:
    document = load(path)
    parts = [document.get(key) for key in ("finds", "breaks")]
    return {name: entry.place for part in parts if part is not None for name, entry in part.mapping().items()}


def check_dispositions(study: Study, matrix: Matrix, situations: Collection[str], findings: Findings) -> int:
    """Every accepted survivor; returns how many there are.

    Args:
        study: the study.
        matrix: its matrix.
        situations: keys of its grids.
        findings: takes the findings.
    """
    path = study.dispositions_path
    if not is_there(path):
        return 0

    def read(entry: tuple[str, Item]) -> None:
        read_disposition(*entry, matrix, situations)

    entries: tuple[tuple[str, Item], ...] = ()
    with findings.collecting():
        entries = tuple(load(path).mapping().items())
        findings.each(read, entries)
        _ = study.dispositions  # tells what is there twice
    return len(entries)


def check_sources(study: Study, findings: Findings) -> None:
    """Sources of numbers that the study does not have."""
    path = study.folder / "sim" / "sources.yaml"
    if not is_there(path):
        return
    with findings.collecting():
        numbers, document = study.sim.numbers, load(path)
        for name, item in document.mapping().items():
            if not any(f"{number}.".startswith(f"{name}.") for number in numbers):
                findings.note(item.place, f"{name!r} is no number of the study", "name the dotted path of one")
