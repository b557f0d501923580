"""A table as typed columns, for data frames: what `pandas.DataFrame(...)` and `polars.DataFrame(...)` take as it is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from enum import StrEnum
from typing import TYPE_CHECKING, Any, NoReturn

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.views.tables.html import html
from scaloft_fi.views.tables.table import Format, Table, TableCell, render

if TYPE_CHECKING:
    from numpy.typing import NDArray

SHOWN, ACROSS = 10, 8
"""Rows and, in a text, columns that are shown."""


class ColumnType(StrEnum):
    """The type of a column."""

    WHOLE = "int64"
    """Whole numbers; there is always a value."""
    NUMBER = "float64"
    """Numbers; NaN where there is no value."""
    TRUTH = "bool"
    """True or false."""
    TEXT = "text"
    """Texts (an array of objects); "" where there is nothing to say."""
    TEXTS = "texts"
    """Lists of texts."""
    NUMBERS = "numbers"
    """Lists of numbers."""
    WHOLES = "wholes"
    """Lists of whole numbers."""


class Columns(dict[str, Any]):
    """Columns of equal length by name: an array (rows,) each, or a list of lists.

    It is a dict, because pandas makes a data frame of no other mapping.  The arrays cannot be written, since data
    frames may share their memory.  A text column is an array of `str`.  A column of lists is a list, because polars
    cannot read arrays of lists; its type there follows from the values, so that of empty lists is `List(Null)`, and
    `arrow` has the exact types.

    Args:
        title: what the rows are, for a reader.
        types: type of each column, in their order.
        rows: the rows; None where a number has no value.

    Attributes:
        title: what the rows are.
        types: type of each column.
        rows: number of rows.
    """

    title: str
    types: dict[str, ColumnType]
    rows: int

    def __init__(self, title: str, types: Mapping[str, ColumnType], rows: Iterable[Mapping[str, Any]]) -> None:
        listed = list(rows)
        super().__init__({name: _column(kind, [row[name] for row in listed]) for name, kind in types.items()})
        self.title, self.types, self.rows = title, dict(types), len(listed)

    def __missing__(self, name: object) -> NoReturn:
        raise KeyError(f"no column {name!r}{did_you_mean(str(name), self)}")

    def arrow(self) -> Any:
        """The same as a `pyarrow.Table`, where numbers without a value are null.

        Raises:
            InputError: pyarrow is not installed.
        """
        pyarrow = needed_pyarrow()
        types = {
            ColumnType.WHOLE: pyarrow.int64(),
            ColumnType.NUMBER: pyarrow.float64(),
            ColumnType.TRUTH: pyarrow.bool_(),
            ColumnType.TEXT: pyarrow.string(),
            ColumnType.TEXTS: pyarrow.list_(pyarrow.string()),
            ColumnType.NUMBERS: pyarrow.list_(pyarrow.float64()),
            ColumnType.WHOLES: pyarrow.list_(pyarrow.int64()),
        }
        columns = [pyarrow.array(self[name], types[kind], from_pandas=True) for name, kind in self.types.items()]
        return pyarrow.Table.from_arrays(columns, names=list(self.types))

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The Arrow PyCapsule protocol, which `pandas.DataFrame.from_arrow` reads.

        Raises:
            InputError: pyarrow is not installed.
        """
        return self.arrow().__arrow_c_stream__(requested_schema)

    def _table(self, rows: int, columns: int | None = None) -> Table:
        """The first `rows` rows and `columns` columns (None: all) as a table of texts."""
        names = list(self)[:columns]
        shown = min(rows, self.rows)
        cells = tuple(tuple(_cell(self[name][row]) for name in names) for row in range(shown))
        more = {"rows": self.rows - shown, "columns": len(self) - len(names)}
        note = " and ".join(f"{count} more {what}" for what, count in more.items() if count)
        return Table(self.title, tuple(names), cells, (f"... {note}",) if note else ())

    def __str__(self) -> str:
        return render((self._table(SHOWN, ACROSS),), Format.TABLE)

    def __repr__(self) -> str:
        return f"<{self.title}: {self.rows} rows of {', '.join(self)}>"

    def _repr_html_(self) -> str:
        return html((self._table(SHOWN),))


def needed_pyarrow() -> Any:
    """The module pyarrow.

    Raises:
        InputError: it is not installed.
    """
    try:
        import pyarrow
    except ImportError as error:
        raise InputError("Arrow data needs pyarrow: pip install 'scaloft-fi[parquet]'") from error
    return pyarrow


def _column(kind: ColumnType, values: Sequence[Any]) -> NDArray[Any] | list[Any]:
    import numpy as np

    if kind in (ColumnType.TEXTS, ColumnType.NUMBERS, ColumnType.WHOLES):
        return list(map(_utf8, values))
    array: NDArray[Any]
    if kind is ColumnType.WHOLE:
        array = np.array(values, dtype=np.int64)
    elif kind is ColumnType.TRUTH:
        array = np.array(values, dtype=np.bool_)
    elif kind is ColumnType.NUMBER:
        array = np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    else:
        array = np.array([_utf8(value) for value in values], dtype=object)
    array.setflags(write=False)
    return array


def _utf8(value: Any) -> Any:
    """A text or a list of texts in which lone surrogates, which UTF-8 cannot hold, are spelled out."""
    if isinstance(value, list):
        return [_utf8(entry) for entry in value]
    return value.encode("utf-8", "backslashreplace").decode() if isinstance(value, str) else value


def _cell(value: Any) -> TableCell:
    if isinstance(value, list):
        return ", ".join(map(str, value))
    if isinstance(value, str):
        return value
    if value.dtype == bool:
        return "yes" if value else "no"
    return "" if value != value else f"{value:g}"  # NaN is the one number that differs from itself
