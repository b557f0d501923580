"""Flat tables as columns whose types follow from the declared shapes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scaloft_fi.views.columns import Columns, ColumnType
from scaloft_fi.views.outputs.csv_tables import cell
from scaloft_fi.views.outputs.flat import Field, Flat
from scaloft_fi.views.outputs.shape import Shape, inner

_TYPES = {"integer": ColumnType.WHOLE, "number": ColumnType.NUMBER, "boolean": ColumnType.TRUTH}


def columns_of(name: str, flat: Flat) -> Columns:
    """The columns of a table."""
    types = {column: type_of(field) for column, field in flat.columns.items()}
    rows = [
        {column: _value(kind, value) for (column, kind), value in zip(types.items(), row, strict=True)}
        for row in flat.rows
    ]
    return Columns(f"{name}: {flat.about}", types, rows)


def summary_of(flat: Flat) -> dict[str, Any]:
    """The single values of a summary by name, each list as a tuple."""
    (row,) = flat.rows
    return {
        name: tuple(value) if isinstance(value, list) else value for name, value in zip(flat.columns, row, strict=True)
    }


def type_of(field: Field) -> ColumnType:
    """The type of a column; whole numbers and truth values of which one may be missing are numbers (true is 1)."""
    shape = inner(field.shape)
    if "items" in shape:
        return ColumnType.NUMBERS if _bare(inner(shape["items"])) in _TYPES else ColumnType.TEXTS
    kind = _TYPES.get(_bare(shape), ColumnType.TEXT)
    return ColumnType.NUMBER if field.lacking and kind is not ColumnType.TEXT else kind


def _bare(shape: Shape) -> str:
    """The type of JSON values; a number that may be the text `inf` is a number."""
    named: str | Sequence[str] = shape.get("type", "")
    return named if isinstance(named, str) else named[0]


def _value(kind: ColumnType, value: Any) -> Any:
    if kind in (ColumnType.TEXTS, ColumnType.NUMBERS):
        return [float(one) if kind is ColumnType.NUMBERS else str(cell(one)) for one in value or ()]
    if kind is ColumnType.TEXT:
        return "" if value is None else str(cell(value))
    return float(value) if kind is ColumnType.NUMBER and value is not None else value
