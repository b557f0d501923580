"""The grids of a study: its own, further ones in `sim/grids/`, and its own with the situations that a search found."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from scaloft_fi.document import is_file, is_there, load
from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.sim.found import FILE as FOUND_FILE
from scaloft_fi.sim.found import Finds, read_finds
from scaloft_fi.sim.grid import ALL, Grid, assembled, read_grid
from scaloft_fi.sim.patch import PARTS
from scaloft_fi.sim.situation import Situation

FILE, FOLDER = "situations.yaml", "grids"
"""The file of the study's own grid, and the folder of further grids, in `sim/`."""
_NAME = re.compile(r"[A-Za-z0-9_-]{1,100}")
WITH_FOUND = "+found"
"""What the name of the study's own grid with the found situations ends with."""


def is_grid_name(name: str) -> bool:
    """Whether a file of this name, without its ending, is a further grid."""
    return _NAME.fullmatch(name) is not None


def own_name(folder: Path) -> str:
    """The name of the grid of `situations.yaml`; `situations` when it has none.

    Args:
        folder: the study's `sim` folder.
    """
    name = load(folder / FILE).get("name")
    if name is not None and not is_grid_name(name.text()):
        raise name.error("a name of letters, digits, - and _")
    return name.text() if name else Path(FILE).stem


def grid_names(folder: Path) -> tuple[str, ...]:
    """The names of a study's grids, its own first.

    Raises:
        InputError: a further grid has the name of the own grid.
    """
    own = own_name(folder)
    paths = sorted(path for path in (folder / FOLDER).glob("*.yaml") if is_grid_name(path.stem) and is_file(path))
    further = [path.stem for path in paths]
    if own in further:
        raise InputError(f"{folder / FOLDER / own}.yaml: the grid of {FILE} is called {own!r} already; rename one")
    return own, *further, *([own + WITH_FOUND] if is_there(folder / FOUND_FILE) else [])


def load_grid(folder: Path, name: str | None = None, *, proved: bool = True) -> Grid:
    """Read a grid of a study's `sim` folder and the documents that it changes.

    Args:
        folder: the `sim` folder.
        name: name of a file in `grids/`, or of the own grid with `+found`; None for the study's own grid.
        proved: whether the axes may not contradict each other; who only looks up situations need not make worlds.

    Raises:
        InputError: as `read_grid`, or a file cannot be read.
    """
    documents = {part: load(folder / f"{part}.yaml") for part in PARTS}
    read = read_grid if proved else assembled
    if name is None:
        return read(load(folder / FILE), documents)
    found = read_finds(folder)
    if found is not None and name.endswith(WITH_FOUND):
        return _with_found(load_grid(folder), searched_grid(folder, found), found, name, folder / FOUND_FILE)
    grid = read(load(folder / FOLDER / f"{name}.yaml"), documents, name)
    if found is None or found.grid != name:
        return grid
    named = {name: key for name, key in found.named.items() if _has(grid, key)}
    return replace(grid, aliases={**grid.aliases, **named}, selected=_selected(found, load_grid(folder, proved=proved)))


def _has(grid: Grid, key: str) -> bool:
    """Whether a find still has its situation; a new search goes on without those that the study has outgrown."""
    try:
        grid.situation(key)
    except InputError:
        return False
    return True


def searched_grid(folder: Path, found: Finds, *, proved: bool = True) -> Grid:
    """The grid that was searched; arguments as `load_grid`.

    Raises:
        InputError: the study has no such grid.
    """
    own, *further = grid_names(folder)
    if found.grid not in (own, *further) or found.grid.endswith(WITH_FOUND):
        place = f"{folder / FOUND_FILE}: grid={shown(found.grid)}"
        raise InputError(f"{place} must be a grid of the study{did_you_mean(found.grid, (own, *further))}")
    return load_grid(folder, None if found.grid == own else found.grid, proved=proved)


def _with_found(own: Grid, searched: Grid, found: Finds, name: str, place: Path) -> Grid:
    """The situations of the study's own grid, then those that show mutants, in the axes of the grid that was searched.

    Those that break the unmutated drone are left out: a situation whose baseline is red puts no mutant to the test.

    Raises:
        InputError: one of them is no situation of that grid.
    """
    aliases = {find.name: find.situation for find in found.finds}
    listed = _situations((*own.by_key, *aliases.values()), searched, place)
    given = {alias: key for alias, key in own.aliases.items() if key in listed}
    return replace(
        searched,
        name=name,
        choose=ALL,
        aliases=given | aliases,
        listed=tuple(listed.values()),
        selected=_selected(found, own),
    )


def _situations(keys: Iterable[str], searched: Grid, place: Path) -> Mapping[str, Situation]:
    """The situations by key, each once.

    Raises:
        InputError: one of them is no situation of the grid that was searched.
    """
    try:
        return {key: searched.situation(key) for key in keys}
    except InputError as error:
        raise InputError(f"{place}: grid {searched.name!r}: {error}") from None


def _selected(found: Finds, own: Grid) -> frozenset[str]:
    """The found situations that the study's own grid does not have."""
    return frozenset(found.named.values()).difference(own.by_key)
