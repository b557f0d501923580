"""Write `sim/found.yaml`: what a search found, beside what earlier searches found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import yaml

from scaloft_fi.analysis.seeking import Replica
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import PLACEBO
from scaloft_fi.output import write_whole
from scaloft_fi.sim.found import FILE, Break, Find, Finds, read_finds

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.sim.situation import Situation

HEADER = """\
# Situations that `scaloft-fi seek` found, named for the grid that was searched.
#
# finds: each shows mutants that the study's own grid does not detect: the mutant violates a safety requirement there
# that the unmutated drone holds.  Evidence: flights with the seeds 0, 1, ..., which the search never flew, by the
# score's own test; again: flights of `scaloft-fi seek --replicate`, with seeds that nothing before used.
# `scaloft-fi run --grid NAME+found` flies them, NAME being the study's own grid.  They were chosen because of verdicts:
# a score that uses them is called selected.
#
# breaks: in each the unmutated drone violates a safety requirement in most of its flights with the seeds 0, 1, ...
# They put no mutant to the test, so NAME+found leaves them out.
"""
NAMED = "shows-"
"""The name of a find is this and the mutant that it was found for."""
DIGITS = 4
"""Significant digits of numbers."""


def saver(folder: Path, grid: str) -> Callable[[Sequence[Find]], None]:
    """Returns a function that writes the situations that show mutants, found by a search over `grid`.

    Finds of earlier searches stay, but for those of the same names.

    Args:
        folder: the study's `sim` folder.
        grid: name of the grid that is searched.

    Raises:
        InputError: the file that is there cannot be read, or has finds of another grid.
    """
    earlier = _earlier(folder, grid)

    def save(finds: Sequence[Find]) -> None:
        told = [find for find in finds if find.mutant != PLACEBO]  # a false find is told, and flown by nobody
        _write(folder, replace(earlier, finds=_merged(earlier.finds, told)))

    return save


def break_saver(folder: Path, grid: str) -> Callable[[Sequence[Break]], None]:
    """Returns a function that writes the situations that break the unmutated drone; all else is as for `saver`."""
    earlier = _earlier(folder, grid)
    return lambda breaks: _write(folder, replace(earlier, breaks=_merged(earlier.breaks, breaks)))


def keep(folder: Path, grid: str, finds: Sequence[Find]) -> None:
    """Write these situations that show mutants in the place of all that the file has.

    Raises:
        InputError: as `saver`.
    """
    _write(folder, replace(_earlier(folder, grid), finds=tuple(finds)))


def holding(finds: Sequence[Find], replicas: Sequence[Replica]) -> tuple[Find, ...]:
    """The finds after a replication: without the mutants that did not hold; what was not replicated stays.

    A find whose own mutant did not hold is named for the first one that did, unless that name is taken.
    """
    told = {(one.find, one.mutant): one for one in replicas}
    taken = {find.name for find in finds}
    kept = []
    for find in finds:
        shows = {
            mutant: replace(evidence, again=replica.again) if replica else evidence
            for mutant, evidence in find.shows.items()
            if (replica := told.get((find.name, mutant))) is None or replica.holds
        }
        if not shows:
            continue
        mutant = find.mutant if find.mutant in shows else next(iter(shows))
        name = NAMED + mutant
        same = mutant == find.mutant or name in taken
        taken.add(name)
        kept.append(replace(find, name=find.name if same else name, mutant=mutant, shows=shows))
    return tuple(sorted(kept, key=lambda find: find.name))


def _earlier(folder: Path, grid: str) -> Finds:
    earlier = read_finds(folder) or Finds(grid, ())
    if earlier.grid != grid:
        sentence = f"{folder / FILE}: grid={earlier.grid!r} must be {grid!r}, the grid that is searched"
        raise InputError(f"{sentence}; move the file away to begin another one")
    return earlier


def _write(folder: Path, finds: Finds) -> None:
    path = folder / FILE
    try:
        write_whole(path, text(finds).encode())
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error


_Named = TypeVar("_Named", Find, Break)


def _merged(earlier: Sequence[_Named], newer: Sequence[_Named]) -> tuple[_Named, ...]:
    """All of them in the order of their names."""
    by_name = {one.name: one for one in chain(earlier, newer)}
    return tuple(by_name[name] for name in sorted(by_name))


def words_of(situation: Situation, grid: Grid) -> tuple[str, ...]:
    """The values of a situation that are not benign, in words."""
    numbers = dict(situation.numbers)
    values = grid.values(situation).items()
    return tuple(value.title for axis, value in values if axis in numbers or value.id != 0)


def text(finds: Finds) -> str:
    """The content of the file."""
    plain = {
        "grid": finds.grid,
        "finds": {find.name: _plain(find) for find in finds.finds},
        "breaks": {one.name: _broken(one) for one in finds.breaks},
    }
    dumped: str = yaml.safe_dump(plain, sort_keys=False, allow_unicode=False, width=110)
    return f"{HEADER}\n{dumped}"


def _plain(find: Find) -> dict[str, Any]:
    shows = {mutant: _short(asdict(evidence)) for mutant, evidence in find.shows.items()}
    return {
        "situation": find.situation,
        "words": list(find.words),
        "mutant": find.mutant,
        "seed": find.seed,
        "shows": shows,
    }


def _broken(one: Break) -> dict[str, Any]:
    values = asdict(one) | {"words": list(one.words), "place": [float(f"{metres:.3f}") for metres in one.place]}
    return {key: value for key, value in _short(values).items() if key != "name"}


def _short(values: dict[str, Any]) -> dict[str, Any]:
    """Floats with few digits; what is empty left out."""
    short = {key: float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value for key, value in values.items()}
    short |= {key: _short(value) for key, value in values.items() if isinstance(value, dict)}
    return {key: value for key, value in short.items() if value not in ("", None)}
