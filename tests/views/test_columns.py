"""Columns as data frames take them; pandas and polars are no dependencies, so their tests say when they are missing."""

from __future__ import annotations

import io
import math
from typing import Any

import numpy as np
import pytest

from scaloft_fi.verbs.export.dossier import parquet
from scaloft_fi.verbs.export.rows import column_type
from scaloft_fi.views.output import Columns, ColumnType

TYPES = {
    "mutant": ColumnType.TEXT,
    "seed": ColumnType.WHOLE,
    "rho_SR1": ColumnType.NUMBER,
    "violated": ColumnType.TEXTS,
    "violation_times_s": ColumnType.NUMBERS,
    "counted": ColumnType.TRUTH,
}
ROWS: list[dict[str, Any]] = [
    {
        "mutant": "<b>\ud800",
        "seed": 2,
        "rho_SR1": None,
        "violated": ["SR1"],
        "violation_times_s": [1.5],
        "counted": True,
    },
    {"mutant": "", "seed": 0, "rho_SR1": -0.5, "violated": [], "violation_times_s": [], "counted": False},
]


@pytest.fixture
def columns() -> Columns:
    return Columns("Flights", TYPES, ROWS)


def test_each_column_is_an_array_of_its_type_that_cannot_be_written(columns: Columns) -> None:
    arrays = {name: values for name, values in columns.items() if not isinstance(values, list)}
    assert {name: values.dtype.kind for name, values in arrays.items()} == {
        "mutant": "O",
        "seed": "i",
        "rho_SR1": "f",
        "counted": "b",
    }
    assert (columns["violated"], columns["violation_times_s"]) == ([["SR1"], []], [[1.5], []])
    assert columns.rows == 2
    assert math.isnan(columns["rho_SR1"][0])
    for values in arrays.values():
        with pytest.raises(ValueError, match="read-only"):
            values[0] = values[1]
    assert columns["seed"][columns["mutant"] == ""].tolist() == [0]


def test_without_rows_the_columns_keep_their_types() -> None:
    empty = Columns("Flights", TYPES, [])
    assert empty.rows == 0
    full = Columns("Flights", TYPES, ROWS)
    kinds = [[getattr(values, "dtype", list) for values in columns.values()] for columns in (empty, full)]
    assert kinds[0] == kinds[1]


def test_a_column_that_is_not_there_names_the_nearest(columns: Columns) -> None:
    with pytest.raises(KeyError, match="no column 'mutants'; did you mean 'mutant'"):
        columns["mutants"]


def test_pandas_takes_the_columns_as_they_are(columns: Columns) -> None:
    pandas = pytest.importorskip("pandas", reason="pandas is not installed (statsmodels brings it)")
    frame = pandas.DataFrame(columns)
    assert list(frame.columns) == list(TYPES)
    assert frame["seed"].dtype == np.int64
    assert frame["rho_SR1"].dtype == np.float64
    assert frame["violated"].tolist() == [["SR1"], []]
    assert frame["mutant"].tolist() == ["<b>\\ud800", ""]
    assert frame[frame.seed > 0].counted.tolist() == [True]


def test_polars_takes_the_columns_as_they_are(columns: Columns) -> None:
    polars = pytest.importorskip("polars", reason="polars is not installed (180 MB): pip install polars")
    frame = polars.DataFrame(columns)
    assert frame.columns == list(TYPES)
    assert frame.schema["seed"] == polars.Int64
    assert frame.schema["mutant"] == polars.String
    assert frame.schema["violated"] == polars.List(polars.String)
    assert "SR1" in str(frame)  # a frame of Python's objects cannot be printed
    assert frame["rho_SR1"].is_nan().to_list() == [True, False]
    assert frame.filter(polars.col("seed") > 0)["counted"].to_list() == [True]
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    exact = polars.DataFrame(columns.arrow())
    assert exact.schema["violated"] == polars.List(polars.String)
    assert exact["rho_SR1"].to_list() == [None, -0.5]


def test_arrow_has_the_exact_types_and_nulls(columns: Columns) -> None:
    pyarrow = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    table = pyarrow.RecordBatchReader.from_stream(columns).read_all()  # by the PyCapsule protocol
    assert [str(one.type) for one in table.schema] == [
        "string",
        "int64",
        "double",
        "list<item: string>",
        "list<item: double>",
        "bool",
    ]
    assert table["rho_SR1"].to_pylist() == [None, -0.5]
    assert Columns("Flights", TYPES, []).arrow().schema == table.schema


def test_arrow_data_is_that_of_the_parquet_export() -> None:
    reading = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    names = [name for name in TYPES if name != "counted"]
    columns = Columns("Flights", {name: column_type(name) for name in names}, ROWS)
    assert reading.read_table(io.BytesIO(parquet(ROWS, names))).equals(columns.arrow())


def test_without_pyarrow_arrow_data_is_refused_in_a_sentence(columns: Columns, monkeypatch: pytest.MonkeyPatch) -> None:
    from scaloft_fi.errors import InputError

    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(InputError, match=r"needs pyarrow: pip install 'scaloft-fi\[parquet\]'"):
        columns.arrow()


def test_a_notebook_shows_the_first_rows_and_runs_no_text_of_a_study(columns: Columns) -> None:
    page = columns._repr_html_()
    assert "&lt;b&gt;\\ud800" in page
    assert "<b>" not in page
    many = Columns("Seeds", {"seed": ColumnType.WHOLE}, [{"seed": seed} for seed in range(25)])
    assert many._repr_html_().count("<tr>") == 11
    assert "... 15 more rows" in many._repr_html_()
    assert "... 15 more rows" in str(many)
    assert repr(many) == "<Seeds: 25 rows of seed>"
