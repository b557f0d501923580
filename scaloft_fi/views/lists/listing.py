"""A list of what a study has: an overview of all entries, or some of them whole, in every format of tables."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.views.lists.forms import FORMS
from scaloft_fi.views.tables.table import Format, Table, csv_text, render

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
        notes: under the overview.
    """

    noun: str
    title: str
    overview: Mapping[str, str]
    records: tuple[Record, ...]
    sheet: Sheet
    notes: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the entries."""
        return tuple(str(record["name"]) for record in self.records)

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of every record, in order."""
        return tuple(self.records[0]) if self.records else ("name",)

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


def shown(listing: Listing, patterns: Sequence[str], how: Format) -> str:
    """The list as a text that ends in a line break: the overview, or with patterns these entries whole.

    JSON and CSV always have whole entries.

    Raises:
        InputError: as `Listing.chosen`.
    """
    chosen = listing.chosen(patterns) if patterns else listing
    if how is Format.JSON:
        form = FORMS[chosen.noun]
        return form.json({form.verb: [dict(record) for record in chosen.records]})
    if how is Format.CSV:
        return csv_text(chosen.keys, (map(plain, record.values()) for record in chosen.records))
    if not patterns:
        columns = listing.overview
        rows = tuple(tuple(plain(record[key]) for key in columns.values()) for record in chosen.records)
        return render((Table(listing.title, tuple(columns), rows, listing.notes),), how)
    sheets = (Table(str(record["name"]), ("what", ""), _rows(listing.sheet(record))) for record in chosen.records)
    return render(tuple(sheets), how)


def plain(value: Any) -> str | int | float | None:
    """A JSON value as the cell of a table: the parts of a list after each other, of a mapping with their keys.

    >>> plain([{"name": "a", "unit": "m"}, "b"])
    'a (unit m); b'
    """
    if value is None or isinstance(value, str | int | float):
        return {True: "yes", False: "no"}[value] if isinstance(value, bool) else value
    if isinstance(value, Mapping):
        rest = ", ".join(
            f"{key} {plain(entry)}" for key, entry in value.items() if key != "name" and entry not in ("", None, [])
        )
        return f"{value['name']} ({rest})" if "name" in value and rest else str(value.get("name", rest))
    return "; ".join(str(plain(entry)) for entry in value)


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
