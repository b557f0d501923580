"""What a verb answers: its tables as columns, its text, its JSON; verbs print it, scripts read it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.views.columns import Columns
from scaloft_fi.views.outputs.csv_tables import csv_tables
from scaloft_fi.views.outputs.flat import SUMMARY, flat_tables
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.typed import columns_of, summary_of
from scaloft_fi.views.tables.html import html
from scaloft_fi.views.tables.table import Format, Table, render


class Answer(Mapping[str, Columns]):
    """What a verb answers: a mapping with columns for each table that the verb writes with `--tables`, by its name.

    It is a picture of the moment at which it was asked for, and nothing changes it.

    Args:
        form: the form of its JSON.
        values: makes the plain JSON values of the form.
        tables: makes the tables for people.
        told: makes the text for people, where it is not that of the tables.
        rows: name of the table that `csv` prints; by default the one of the form.
        warnings: what a reader must know beside it, in sentences.

    Attributes:
        warnings: what a reader must know beside it, in sentences; often nothing.
    """

    warnings: tuple[str, ...]

    def __init__(
        self,
        form: Output,
        values: Callable[[], Mapping[str, Any]],
        tables: Callable[[], Sequence[Table]] = tuple,
        *,
        told: Callable[[Format], str] | None = None,
        rows: str = "",
        warnings: Sequence[str] = (),
    ) -> None:
        self._form, self._make, self._tables, self.warnings = form, values, tables, tuple(warnings)
        self._rows = rows or form.rows
        self._told = told or (lambda how: render(tables(), how))

    @cached_property
    def summary(self) -> Mapping[str, Any]:
        """What stands in no table: single values by name, a list as a tuple; None where there is no value."""
        return MappingProxyType(summary_of(self._flat[SUMMARY])) if SUMMARY in self._flat else MappingProxyType({})

    def record(self) -> dict[str, Any]:
        """The whole as plain JSON values: what the verb prints with `--format json`."""
        return self._form.record(self._values)

    def text(self, style: str = "table") -> str:
        """What the verb prints.

        Args:
            style: `table`, `markdown`, `latex`, `json`, or `csv` for the one table that the verb prints.

        Raises:
            InputError: there is no such style.
        """
        if style not in list(Format):
            raise InputError(f"style={style!r} must be one of {', '.join(Format)}{did_you_mean(style, list(Format))}")
        how = Format(style)
        if how is Format.JSON:
            return self._form.json(self._values)
        return self.csv()[self._rows] if how is Format.CSV else self._told(how)

    def csv(self) -> dict[str, str]:
        """The text of a CSV file for each table by its name: what the verb writes with `--tables`."""
        return csv_tables(self._form, self._values)

    @cached_property
    def _values(self) -> Mapping[str, Any]:
        return self._make()

    @cached_property
    def _flat(self) -> Mapping[str, Any]:
        return flat_tables(self._form, self._values)

    @cached_property
    def _columns(self) -> Mapping[str, Columns]:
        return {name: columns_of(name, flat) for name, flat in self._flat.items() if name != SUMMARY}

    def __getitem__(self, name: str) -> Columns:
        if name not in self._columns:
            raise KeyError(f"{self._form.verb} has no table {name!r}{did_you_mean(str(name), self._columns)}")
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        rows = ", ".join(f"{name} ({columns.rows})" for name, columns in self.items())
        return f"<{self._form.verb}: {rows or ', '.join(self.summary)}>"

    def _repr_html_(self) -> str:
        return html(self._tables())
