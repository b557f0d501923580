"""A list of what a study has: an overview of all entries, or some of them whole, in every format of tables."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.tables.table import Format, Table, render

Record = Mapping[str, Any]
"""An entry as plain JSON values; it has the key `name`, and all entries of a list have the same keys."""
Sheet = Callable[[Record], Sequence[tuple[str, str]]]
"""An entry whole, as pairs of a heading and a text; an empty heading goes on with the one above."""


@dataclass(frozen=True)
class Listing:
    """A list of what a study has.

    Attributes:
        noun: what an entry is, such as "signal".
        title: of the overview.
        overview: column of the overview -> key of the record.
        records: the entries.
        sheet: an entry whole.
        form: the form of the list as JSON; `values` of the form are the records.
        notes: under the overview.
    """

    noun: str
    title: str
    overview: Mapping[str, str]
    records: tuple[Record, ...]
    sheet: Sheet
    form: Output
    notes: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the entries."""
        return tuple(str(record["name"]) for record in self.records)

    @property
    def values(self) -> dict[str, Any]:
        """The plain JSON values of the form."""
        return {self.form.rows: [dict(record) for record in self.records]}

    def chosen(self, patterns: Sequence[str]) -> Listing:
        """The entries that have one of these names, or match one of these patterns with `*`, `?` or `[`.

        Raises:
            InputError: a name or pattern fits nothing; the message names the nearest name.
        """
        wanted: set[str] = set()
        for pattern in patterns:
            fits = [pattern] if pattern in self.names else fnmatch.filter(self.names, pattern)
            if not fits:
                raise InputError(f"no {self.noun} {pattern!r}{did_you_mean(pattern, self.names)}")
            wanted.update(fits)
        return replace(self, records=tuple(record for record in self.records if record["name"] in wanted))


def shown(listing: Listing, how: Format, *, whole: bool) -> str:
    """The list as a text for people that ends in a line break: the overview, or each entry whole."""
    if whole:
        sheets = (Table(str(record["name"]), ("what", ""), _rows(listing.sheet(record))) for record in listing.records)
        return render(tuple(sheets), how)
    columns = listing.overview
    rows = tuple(tuple(plain(record[key]) for key in columns.values()) for record in listing.records)
    return render((Table(listing.title, tuple(columns), rows, listing.notes),), how)


def plain(value: Any) -> str | int | float | None:
    """A JSON value as the cell of a table.

    >>> plain(["a", "b"]), plain(True)
    ('a; b', 'yes')
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "; ".join(map(str, value)) if isinstance(value, list) else value


def number_range(least: float | None, most: float | None) -> str:
    """A range in words.

    >>> number_range(0.0, 1.0), number_range(0.0, None), number_range(None, None)
    ('0 to 1', 'from 0', '')
    """
    if least is None or most is None:
        return f"from {least:g}" if least is not None else f"up to {most:g}" if most is not None else ""
    return f"{least:.4g} to {most:.4g}"


def _rows(pairs: Sequence[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    """Without what is empty; a heading stands once."""
    rows: list[tuple[str, str]] = []
    last = ""
    for heading, text in pairs:
        if text:
            rows.append(("" if heading == last else heading, text))
            last = heading
    return tuple(rows)
