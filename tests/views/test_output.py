"""Answers of verbs: their schemas, typed columns that follow from the records, and frames of pandas and polars.

pandas and polars are no dependencies, so their tests say when they are missing.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from printed import of_form

from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.errors import InputError
from scaloft_fi.marks import Bounds
from scaloft_fi.verbs import VERBS
from scaloft_fi.verbs.export.dossier import column_type, parquet
from scaloft_fi.verbs.schema import ANSWERS, answer_form, answer_texts
from scaloft_fi.views.output import Answer, Columns, ColumnType, Output, Shape, inner
from scaloft_fi.views.table import Table


class Lock(NamedTuple):
    """A lock."""

    keys: int
    by: tuple[str, ...]
    barred: bool


class Bolt(NamedTuple):
    """A bolt."""

    turns: int


class Door(NamedTuple):
    """A door.

    Attributes:
        bolts: its bolts.
    """

    name: str
    open: bool
    width_m: Annotated[float, Bounds(infinite=True)]
    lock: Lock | None
    passed: Mapping[str, int]
    bolts: tuple[Bolt, ...]


@dataclass(frozen=True)
class Mine:
    """The doors of a mine.

    Attributes:
        doors: every door.
        shut: doors that are shut.
        names: of the miners.
        wind_mps: wind [m/s].
    """

    doors: tuple[Door, ...]
    shut: Ratio
    names: tuple[str, ...]
    wind_mps: float | None


FORM = Output("doors", "1.0", Mine, rows="doors")
DOORS = (
    Door("north", True, math.inf, None, {"Ada": 2}, (Bolt(1), Bolt(2))),
    Door("south", False, 1.5, Lock(3, ("Ada",), True), {}, ()),
)


@pytest.fixture
def answer() -> Answer:
    mine = Mine(DOORS, Ratio(1, 2), ("Ada",), None)
    return Answer(FORM, lambda: mine, lambda: (Table("Doors", ("name",), (("<north>",),)),))


def test_each_list_of_records_is_a_table_with_typed_columns(answer: Answer):
    assert list(answer) == ["doors", "doors_bolts"]
    doors = answer["doors"]
    assert {name: kind.value for name, kind in doors.types.items()} == {
        "name": "text",
        "open": "bool",
        "width_m": "float64",
        "lock_keys": "float64",
        "lock_by": "texts",
        "lock_barred": "float64",
        "passed_Ada": "float64",
    }
    assert doors["width_m"].tolist() == [math.inf, 1.5]
    assert math.isnan(doors["lock_keys"][0])
    assert (doors["lock_keys"][1], doors["lock_by"]) == (3.0, [[], ["Ada"]])
    assert str(doors["lock_barred"]) == "[nan  1.]"
    assert answer["doors_bolts"].types == {"of_name": ColumnType.TEXT, "turns": ColumnType.WHOLE}
    assert answer["doors_bolts"]["of_name"].tolist() == ["north", "north"]


def test_what_stands_in_no_table_is_the_summary_and_nothing_can_be_changed(answer: Answer):
    assert dict(answer.summary) == {"shut_part": 1, "shut_whole": 2, "names": ("Ada",), "wind_mps": None}
    with pytest.raises(TypeError):
        answer.summary["shut_part"] = 2  # type: ignore[index]
    with pytest.raises(ValueError, match="read-only"):
        answer["doors"]["open"][0] = False


def test_a_wrong_name_is_a_sentence_with_the_nearest_one(answer: Answer):
    with pytest.raises(KeyError, match="doors has no table 'door'; did you mean 'doors'"):
        _ = answer["door"]
    with pytest.raises(InputError, match=r"style='cvs' must be one of table, .*; did you mean 'csv'"):
        answer.text("cvs")


def test_it_is_what_the_verb_prints(answer: Answer):
    first = {"name": "north", "open": True, "width_m": "inf", "lock": None, "passed": {"Ada": 2}}
    assert answer.record()["doors"][0] == first | {"bolts": [{"turns": 1}, {"turns": 2}]}
    assert answer.text("csv") == answer.csv()["doors"]
    assert answer.csv()["summary"] == "what,value\nshut_part,1\nshut_whole,2\nnames,Ada\nwind_mps,\n"
    assert answer.text("markdown").startswith("### Doors")
    assert "&lt;north&gt;" in answer._repr_html_()
    assert repr(answer) == "<doors: doors (2), doors_bolts (2)>"


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


def test_each_column_is_an_array_of_its_type_that_cannot_be_written(columns: Columns):
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


def test_without_rows_the_columns_keep_their_types():
    empty = Columns("Flights", TYPES, [])
    assert empty.rows == 0
    full = Columns("Flights", TYPES, ROWS)
    kinds = [[getattr(values, "dtype", list) for values in columns.values()] for columns in (empty, full)]
    assert kinds[0] == kinds[1]


def test_a_column_that_is_not_there_names_the_nearest(columns: Columns):
    with pytest.raises(KeyError, match="no column 'mutants'; did you mean 'mutant'"):
        columns["mutants"]


def test_pandas_takes_the_columns_as_they_are(columns: Columns):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed (statsmodels brings it)")
    frame = pandas.DataFrame(columns)
    assert list(frame.columns) == list(TYPES)
    assert frame["seed"].dtype == np.int64
    assert frame["rho_SR1"].dtype == np.float64
    assert frame["violated"].tolist() == [["SR1"], []]
    assert frame["mutant"].tolist() == ["<b>\\ud800", ""]
    assert frame[frame.seed > 0].counted.tolist() == [True]


def test_polars_takes_the_columns_as_they_are(columns: Columns):
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


def test_arrow_has_the_exact_types_and_nulls(columns: Columns):
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


def test_arrow_data_is_that_of_the_parquet_export():
    reading = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    names = [name for name in TYPES if name != "counted"]
    columns = Columns("Flights", {name: column_type(name) for name in names}, ROWS)
    assert reading.read_table(io.BytesIO(parquet(ROWS, names))).equals(columns.arrow())


def test_without_pyarrow_arrow_data_is_refused_in_a_sentence(columns: Columns, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(InputError, match=r"needs pyarrow: pip install 'scaloft-fi\[parquet\]'"):
        columns.arrow()


def test_a_notebook_shows_the_first_rows_and_runs_no_text_of_a_study(columns: Columns):
    page = columns._repr_html_()
    assert "&lt;b&gt;\\ud800" in page
    assert "<b>" not in page
    many = Columns("Seeds", {"seed": ColumnType.WHOLE}, [{"seed": seed} for seed in range(25)])
    assert many._repr_html_().count("<tr>") == 11
    assert "... 15 more rows" in many._repr_html_()
    assert "... 15 more rows" in str(many)
    assert repr(many) == "<Seeds: 25 rows of seed>"


SCORE = Path(__file__).parents[2] / "results" / "published" / "reference" / "score.json"
PUBLISHED = Path(__file__).parents[2] / "docs" / "schemas" / "output"


def test_the_published_schemas_are_those_of_the_code():
    published = {path.name: path.read_text(encoding="utf-8") for path in PUBLISHED.iterdir()}
    assert published == answer_texts(), "run python docs/schemas/write.py"


def test_the_published_score_has_the_form_of_today():
    of_form("score", SCORE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("verb", ANSWERS)
def test_a_schema_is_one_and_every_key_says_what_it_is(verb: str):
    output = answer_form(verb)
    assert verb in VERBS
    assert output.verb == verb
    Draft202012Validator.check_schema(output.schema)
    for name, shape in _shapes(verb, output.schema):
        assert inner(shape).get("description"), name
        if inner(shape).get("type") == "object":
            assert inner(shape)["additionalProperties"] is not True, name


def _shapes(name: str, shape: Shape) -> list[tuple[str, Shape]]:
    """The shapes of a schema by key, those within lists too."""
    bare = inner(shape)
    below = list(bare.get("properties", {}).items())
    found = [(f"{name}.{key}", each) for key, each in below]
    for key, each in below:
        found += _shapes(f"{name}.{key}", each)
    if "properties" in bare.get("items", {}):
        found += _shapes(f"{name}[]", bare["items"])
    return found
