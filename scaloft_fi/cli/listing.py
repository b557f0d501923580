"""What the verbs that list what a study has share: which study and grid, which entries, which format."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.console import tell

if TYPE_CHECKING:
    from scaloft_fi.study import Study
    from scaloft_fi.views.lists.listing import Listing


def tell_listing(
    make: Callable[[Study], Listing], names: Sequence[str], style: str, folder: Path | None, grid: str | None = None
) -> None:
    """Write a list of the study to standard output.

    Args:
        make: makes the list.
        names: names and patterns of the entries to show whole; none for the overview.
        style: format of the tables.
        folder: the study, as for `Study.open`.
        grid: name of one of its grids.

    Raises:
        InputError: the study cannot be read, or a name fits nothing.
    """
    from scaloft_fi.study import Study
    from scaloft_fi.views.lists.listing import shown
    from scaloft_fi.views.tables.table import Format

    tell(shown(make(Study.open(folder, grid)), names, Format(style)))
