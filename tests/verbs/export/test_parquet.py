from __future__ import annotations

import io

import pyarrow.parquet
from builders import GRID, KINDS, ROSTER, campaigns
from hypothesis import given

from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.export.dossier import parquet
from scaloft_fi.verbs.export.rows import columns, export_rows


@given(campaigns())
def test_a_data_frame_gets_back_every_row_of_the_export(outcomes: list[Outcome]) -> None:
    names = list(KINDS)
    rows = export_rows(outcomes, ROSTER, GRID, names)
    table = pyarrow.parquet.read_table(io.BytesIO(parquet(rows, columns(rows, names))))
    assert table.column_names == columns(rows, names)
    assert table.to_pylist() == rows


def test_a_list_stays_a_list_and_a_seed_a_whole_number() -> None:
    schema = pyarrow.parquet.read_table(io.BytesIO(parquet([], columns([], list(KINDS))))).schema
    assert str(schema.field("violated").type) == "list<element: string>"
    assert str(schema.field("seed").type) == "int64"
    assert str(schema.field("rho_SR1").type) == "double"
