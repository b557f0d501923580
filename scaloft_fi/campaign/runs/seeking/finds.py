"""Write `sim/found.yaml`: the finds of a search, beside those that earlier searches found for other mutants."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import yaml

from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import PLACEBO
from scaloft_fi.output import write_whole
from scaloft_fi.sim.found import FILE, Find, Finds, read_finds

HEADER = """\
# Situations that `scaloft-fi seek` found.  Each shows mutants that the study's own grid does not detect: the mutant
# violates a safety requirement there that the unmutated drone holds.  Evidence: flights with the seeds 0, 1, ..., which
# the search never flew, by the score's own test.  `scaloft-fi run --grid NAME+found` flies them, NAME being the study's
# own grid.  They were chosen because of verdicts: a score that uses them is called selected.
"""
DIGITS = 4
"""Significant digits of numbers."""


def saver(folder: Path, grid: str) -> Callable[[Sequence[Find]], None]:
    """Returns a function that writes the finds of a search over `grid`.

    Finds of earlier searches stay, but for those of the same names.

    Args:
        folder: the study's `sim` folder.
        grid: name of the grid that is searched.

    Raises:
        InputError: the file that is there cannot be read, or has finds of another grid.
    """
    before = read_finds(folder)
    if before is not None and before.grid != grid:
        sentence = f"{folder / FILE}: grid={before.grid!r} must be {grid!r}, the grid that is searched"
        raise InputError(f"{sentence}; move the file away to begin another one")
    earlier = before.finds if before is not None else ()

    def save(finds: Sequence[Find]) -> None:
        finds = [find for find in finds if find.mutant != PLACEBO]  # a false find is told, and flown by nobody
        names = {find.name for find in finds}
        kept = [find for find in earlier if find.name not in names]
        content = text(Finds(grid, tuple(sorted((*kept, *finds), key=lambda find: find.name))))
        path = folder / FILE
        try:
            write_whole(path, content.encode())
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}") from error

    return save


def text(finds: Finds) -> str:
    """The content of the file."""
    plain = {"grid": finds.grid, "finds": {find.name: _plain(find) for find in finds.finds}}
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


def _short(values: dict[str, Any]) -> dict[str, Any]:
    """Floats with few digits; what is empty left out."""
    short = {key: float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value for key, value in values.items()}
    return {key: value for key, value in short.items() if value != ""}
