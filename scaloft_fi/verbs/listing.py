"""A list of what a study has, for the verbs that list: an overview of all entries, or some of them whole."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args, get_origin

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.stack.declaration import UNITS, Seam
from scaloft_fi.stack.messages import (
    Point,
    field_names,
    field_type,
    image_fields,
    number_fields,
    stamp_fields,
    vector_fields,
)
from scaloft_fi.verbs.options import answer
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Format, Table, render

if TYPE_CHECKING:
    from scaloft_fi.study import Study


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


_PLAIN = {float: "number", int: "whole number", str: "text", bool: "true or false"}


def fields_of(seam: Seam) -> list[dict[str, str]]:
    """Name, kind and unit of each field of a seam's message."""
    return [
        {"name": name, "kind": kind_of(seam.message, name), "unit": _unit(seam, name)}
        for name in field_names(seam.message)
    ]


def _unit(seam: Seam, name: str) -> str:
    if name in stamp_fields(seam.message):
        return "s"
    if name in number_fields(seam.message):
        return seam.unit(name)
    return ""


def kind_of(message: type, name: str) -> str:
    """The kind of a field in words.

    >>> from scaloft_fi.stack.messages import Detections, Imu
    >>> kind_of(Imu, "rate"), kind_of(Imu, "stamp_s")
    ('3 numbers x, y, z', 'time stamp')
    >>> kind_of(Detections, "persons")
    'Person, any number of: label text, score number, bearing_rad number [rad], range_m number [m]'
    """
    if name in stamp_fields(message):
        return "time stamp"
    if name in image_fields(message):
        return "image"
    hint = field_type(message, name)
    if hint == Point or name in vector_fields(message):
        return "3 numbers x, y, z"
    return _said(hint)


def _said(hint: Any) -> str:
    if hint in _PLAIN:
        return _PLAIN[hint]
    if get_origin(hint) is tuple:
        first, *rest = get_args(hint)
        if rest == [Ellipsis]:
            return (
                f"{_inner(first)}, any number of"
                if not field_names(first)
                else f"{first.__name__}, any number of: {_whole(first)}"
            )
        return f"{len(rest) + 1} values"
    if field_names(hint):
        return f"{hint.__name__}: {_whole(hint)}"
    return "numbers" if "float" in str(hint) else "true or false, any number of" if "bool" in str(hint) else "values"


def _inner(hint: Any) -> str:
    return "3 numbers x, y, z" if hint == Point else _said(hint)


def _whole(message: type) -> str:
    def one(name: str) -> str:
        unit = UNITS.get(name.rpartition("_")[2], "") if "_" in name else ""
        return f"{name} {kind_of(message, name)}" + (f" [{unit}]" if unit else "")

    return ", ".join(map(one, field_names(message)))


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

    listing = make(Study.open(study, grid))
    chosen = listing.chosen(names) if names else listing
    told = Answer(chosen.form, lambda: chosen.values, told=lambda how: shown(chosen, how, whole=bool(names)))
    answer(told, style, tables)
