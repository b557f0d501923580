"""What the verbs that list what a study has share: which study and grid, which entries, which format."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.cli.answer import answer

if TYPE_CHECKING:
    from scaloft_fi.study import Study
    from scaloft_fi.views.lists.listing import Listing


def tell_listing(
    make: Callable[[Study], Listing],
    names: Sequence[str],
    style: str,
    study: Path | None,
    grid: str | None = None,
    *,
    tables: Path | None,
) -> None:
    """Write a list of a study to standard output.

    Args:
        make: makes the list.
        names: names and patterns of the entries to show whole; none for the overview.
        style: `--format`.
        study: folder of the study, as for `Study.open`.
        grid: name of one of its grids.
        tables: `--tables`.

    Raises:
        InputError: the study cannot be read, or a name fits nothing.
    """
    from scaloft_fi.study import Study
    from scaloft_fi.views.lists.listing import shown
    from scaloft_fi.views.outputs.answer import Answer

    listing = make(Study.open(study, grid))
    chosen = listing.chosen(names) if names else listing
    told = Answer(chosen.form, lambda: chosen.values, told=lambda how: shown(chosen, how, whole=bool(names)))
    answer(told, style, tables)
