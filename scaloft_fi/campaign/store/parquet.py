"""Read a file of columns (Parquet) that may come from anywhere: no more than a store may hold, errors as a sentence."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scaloft_fi.campaign.store.cells import CHUNK, TooLargeError, most_flights
from scaloft_fi.errors import InputError

if TYPE_CHECKING:
    import pyarrow

MOST_ROW_BYTES = 131_072
"""Greatest mean size of a row in memory; the trajectory of a flight of 15 minutes has 126,000 bytes."""
TEXT, WHOLE, NUMBER = "string", "int64", "double"
TEXTS, WHOLES, NUMBERS, FLOATS = "list<string>", "list<int64>", "list<double>", "list<float>"
"""Types of columns, as Arrow names them."""
_SHOWN = 200
"""Characters of Arrow's own message that a message shows."""


def read_columns(path: Path, content: bytes, types: Mapping[str, str]) -> pyarrow.Table:
    """Columns of a file.

    Args:
        path: path of the file, for messages.
        content: its bytes.
        types: the type of each column that is needed; others are not read.

    Raises:
        InputError: pyarrow is not installed, or the file is damaged, lacks a column or is too large.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise InputError(f"{path}: reading it needs pyarrow: pip install 'scaloft-fi[parquet]'") from error
    most = most_flights()
    try:
        file = pyarrow.parquet.ParquetFile(pyarrow.BufferReader(content))
        there = {field.name: _named(field.type) for field in file.schema_arrow}
        for name, kind in types.items():
            if there.get(name) != kind:
                raise ValueError(f"column {name!r} must be {kind}, and is {there.get(name, 'missing')}")
        groups = (file.metadata.row_group(number) for number in range(file.metadata.num_row_groups))
        if file.metadata.num_rows > most or sum(group.total_byte_size for group in groups) > most * MOST_ROW_BYTES:
            raise TooLargeError(path.name)
        parts, size = [], 0
        for part in file.iter_batches(CHUNK, columns=list(types)):
            parts.append(part)
            size += part.nbytes
            if size > most * MOST_ROW_BYTES:  # a value that is repeated is larger than its file says
                raise TooLargeError(path.name)
        return pyarrow.Table.from_batches(parts, pyarrow.schema(file.schema_arrow.field(name) for name in types))
    except TooLargeError as error:
        raise InputError(f"{path}: {error}") from error
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        own = ascii(str(error).partition("\n")[0])[1:-1][:_SHOWN]
        raise InputError(f"{path}: the file holds no flights of an archive: {own}") from error


def _named(kind: Any) -> str:
    """The name of a type; a list is named by its members."""
    member = getattr(kind, "value_type", None)
    return str(kind) if member is None else f"list<{member}>"
