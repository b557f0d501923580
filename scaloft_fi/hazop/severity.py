"""The severity of a hazard: a study's own ordered list of classes, one of which a credible cell may have.

SeverityClass orders and groups.  It enters no ratio and no verdict.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from scaloft_fi.document import load
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.cell import CellStatus
from scaloft_fi.item import Item
from scaloft_fi.reading import is_there

SEVERITIES = "severities.yaml"
"""File of the classes in `hazop/`; a study without it has no severity."""
UNCLASSED = "no class"
"""Heading of what has no class; no class can have this id."""

Entry = TypeVar("Entry")


@dataclass(frozen=True)
class SeverityClass:
    """A class of severity.

    Attributes:
        rank: its place in the study's list; 0 is the worst.
        id: name of the class, small letters.
        title: the class as people call it.
        meaning: which consequences belong to it.
    """

    rank: int
    id: str
    title: str
    meaning: str


def load_severities(path: Path) -> tuple[SeverityClass, ...]:
    """Read the classes, worst first; none where the study has no such file.

    Raises:
        InputError: an id is not in small letters, a key is missing or unknown.
    """
    classes = []
    for rank, (name, item) in enumerate(load(path).mapping().items() if is_there(path) else ()):
        if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
            raise InputError(f"{item.place}: name {name!r} must be small letters, digits and _")
        classes.append(SeverityClass(rank, name, item.need("title").text(), item.need("meaning").text()))
        item.close()
    return tuple(classes)


def read_severity(cell: Item, classes: Iterable[SeverityClass]) -> SeverityClass | None:
    """Read the class of a cell; None where the cell has none.

    Args:
        cell: entry of the cell in the file of a parameter.
        classes: of the study.

    Raises:
        InputError: the class is unknown, the study has no classes, or the cell is not credible.
    """
    entry = cell.get("severity")
    if entry is None:
        return None
    if cell.need("status").value != CellStatus.CREDIBLE:
        raise entry.error("left out where the cell is not credible")
    by_id = {one.id: one for one in classes}
    if not by_id:
        raise entry.error(f"left out in a study without classes: hazop/{SEVERITIES} lists them")
    return by_id[entry.choice(tuple(by_id))]


def worst_first(entries: Iterable[Entry], severity: Callable[[Entry], SeverityClass | None]) -> list[Entry]:
    """The entries by class, the worst first and those without a class last; within a class the order stays.

    >>> worst_first("ba", {"a": SeverityClass(0, "injury", "", "")}.get)
    ['a', 'b']
    """

    def place(entry: Entry) -> tuple[bool, int]:
        found = severity(entry)
        return found is None, found.rank if found else 0

    return sorted(entries, key=place)


def class_of(severity: SeverityClass | None) -> str:
    """The id of a class as tables show it; empty where there is none."""
    return severity.id if severity else ""
