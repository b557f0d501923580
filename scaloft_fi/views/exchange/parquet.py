"""All flights of a campaign as Parquet, typed, lists as lists: the rows of `export`, for data frames.

Texts are data here and stand as the store has them; only lone surrogates, which UTF-8 cannot hold, are spelled out.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING

from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import export_format
from scaloft_fi.views.flights.export import FlightRow, flight_columns

if TYPE_CHECKING:
    import pyarrow


@export_format("parquet", "one row per flight, typed (extra: parquet)", text=False)
def parquet_rows(dossier: Dossier) -> bytes:
    """The file of a campaign."""
    return parquet(dossier.rows, dossier.columns)


def parquet(rows: Sequence[FlightRow], columns: Sequence[str]) -> bytes:
    """A Parquet file with one row a flight.

    Raises:
        InputError: pyarrow is not installed.
    """
    return parquet_file(flight_columns(rows, columns).arrow())


def parquet_file(table: pyarrow.Table) -> bytes:
    """A Parquet file with the columns of a table."""
    import pyarrow.parquet

    file = io.BytesIO()
    pyarrow.parquet.write_table(table, file, compression="zstd")
    return file.getvalue()
