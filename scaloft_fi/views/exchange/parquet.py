"""All flights of a campaign as Parquet, typed, lists as lists: the rows of `export`, for data frames.

Texts are data here and stand as the store has them; only lone surrogates, which UTF-8 cannot hold, are spelled out.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from scaloft_fi.errors import InputError
from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import export_format

INTEGERS = frozenset({"seed", "carried", "altered"})
LISTS = frozenset({"violated", "held", "revealed_by", "violation_bodies", "triggered", "realised"})
TEXTS = frozenset({"mutant", "situation", "status", "ending", "struck", "digest"})
"""Columns by type; every other one is a number."""


@export_format("parquet", "one row per flight, typed (extra: parquet)", text=False)
def parquet_rows(dossier: Dossier) -> bytes:
    """The file of a campaign."""
    return parquet(dossier.rows, dossier.columns)


def parquet(rows: Sequence[dict[str, Any]], columns: Sequence[str]) -> bytes:
    """A Parquet file with one row a flight.

    Raises:
        InputError: pyarrow is not installed.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise InputError("--format='parquet' needs pyarrow: pip install 'scaloft-fi[parquet]'") from error
    types = {name: pyarrow.int64() for name in INTEGERS} | {name: pyarrow.string() for name in TEXTS}
    types |= {name: pyarrow.list_(pyarrow.string()) for name in LISTS}
    types |= {"violation_times_s": pyarrow.list_(pyarrow.float64())}
    schema = pyarrow.schema([(name, types.get(name, pyarrow.float64())) for name in columns])
    table = pyarrow.Table.from_pylist([{name: _utf8(row[name]) for name in columns} for row in rows], schema=schema)
    file = io.BytesIO()
    pyarrow.parquet.write_table(table, file, compression="zstd")
    return file.getvalue()


def _utf8(value: Any) -> Any:
    if isinstance(value, list):
        return [_utf8(entry) for entry in value]
    return value.encode("utf-8", "backslashreplace").decode() if isinstance(value, str) else value
