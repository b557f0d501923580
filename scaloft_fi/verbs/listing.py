"""A list of what a study has, for the verbs that list: an overview of all entries, or some of them whole."""

from __future__ import annotations

import fnmatch
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar, get_args, get_origin

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
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Format, Table, TableCell, render


@dataclass(frozen=True)
class Entry:
    """An entry of a list.

    Attributes:
        name: its name.
    """

    name: str

    def sheet(self) -> Sequence[tuple[str, str]]:
        """The entry whole, as pairs of a heading and a text; what is empty is left out."""
        raise NotImplementedError


E = TypeVar("E", bound=Entry)


@dataclass(frozen=True)
class Listing(Generic[E]):
    """A list of what a study has.

    Attributes:
        noun: what an entry is, such as "signal".
        title: of the overview.
        overview: column of the overview -> attribute of the entry.
        entries: they.
        form: the form of the list as JSON, whose one key has the entries.
        notes: under the overview.
    """

    noun: str
    title: str
    overview: Mapping[str, str]
    entries: tuple[E, ...]
    form: Output
    notes: tuple[str, ...] = ()

    @property
    def by_name(self) -> dict[str, E]:
        """The entries by name."""
        return {entry.name: entry for entry in self.entries}

    def chosen(self, patterns: Sequence[str]) -> Listing[E]:
        """The entries that have one of these names, or match one of these patterns with `*`, `?` or `[`.

        Raises:
            InputError: a name or pattern fits nothing; the message names the nearest name.
        """
        wanted: set[str] = set()
        for pattern in patterns:
            fits = [pattern] if pattern in self.by_name else fnmatch.filter(self.by_name, pattern)
            if not fits:
                raise InputError(f"no {self.noun} {pattern!r}{did_you_mean(pattern, self.by_name)}")
            wanted.update(fits)
        return replace(self, entries=tuple(entry for entry in self.entries if entry.name in wanted))

    def answer(self, patterns: Sequence[str] = ()) -> Answer:
        """An overview, or the entries that are named, whole.

        Raises:
            InputError: as for `chosen`.
        """
        chosen = self.chosen(patterns) if patterns else self
        return Answer(
            self.form,
            lambda: self.form.answer(chosen.entries),
            told=lambda how: shown(chosen, how, whole=bool(patterns)),
        )


def shown(listing: Listing[Any], how: Format, *, whole: bool) -> str:
    """The list as a text for people that ends in a line break: the overview, or each entry whole."""
    if whole:
        return render([Table(one.name, ("what", ""), _rows(one.sheet())) for one in listing.entries], how)
    rows = tuple(tuple(plain(getattr(one, key)) for key in listing.overview.values()) for one in listing.entries)
    return render((Table(listing.title, tuple(listing.overview), rows, listing.notes),), how)


def plain(value: Any) -> TableCell:
    """A value as the cell of a table.

    >>> plain(("a", "b")), plain(True)
    ('a; b', 'yes')
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "; ".join(map(str, value)) if isinstance(value, tuple) else value


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


@dataclass(frozen=True)
class MessageField:
    """A field.

    Attributes:
        name: its name.
        kind: what it is.
        unit: its unit; empty for none.
    """

    name: str
    kind: str
    unit: str

    def __str__(self) -> str:
        return f"{self.name}: {self.kind}" + (f" [{self.unit}]" if self.unit else "")


def fields_of(seam: Seam) -> tuple[MessageField, ...]:
    """The fields of a seam's message."""
    return tuple(
        MessageField(name, kind_of(seam.message, name), _unit(seam, name)) for name in field_names(seam.message)
    )


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
