"""Answers of verbs as typed columns: the types follow from the declared shapes, whatever the values are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import pytest

from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.errors import InputError
from scaloft_fi.marks import Bounds
from scaloft_fi.views.output import Answer, ColumnType, Output
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
    """A door."""

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


FORM = Output.of("doors", "1.0", Mine, rows="doors")
DOORS = (
    Door("north", True, math.inf, None, {"Ada": 2}, (Bolt(1), Bolt(2))),
    Door("south", False, 1.5, Lock(3, ("Ada",), True), {}, ()),
)


@pytest.fixture
def answer() -> Answer:
    mine = Mine(DOORS, Ratio(1, 2), ("Ada",), None)
    return Answer(FORM, lambda: mine, lambda: (Table("Doors", ("name",), (("<north>",),)),))


def test_each_list_of_records_is_a_table_with_typed_columns(answer: Answer) -> None:
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


def test_what_stands_in_no_table_is_the_summary_and_nothing_can_be_changed(answer: Answer) -> None:
    assert dict(answer.summary) == {"shut_part": 1, "shut_whole": 2, "names": ("Ada",), "wind_mps": None}
    with pytest.raises(TypeError):
        answer.summary["shut_part"] = 2  # type: ignore[index]
    with pytest.raises(ValueError, match="read-only"):
        answer["doors"]["open"][0] = False


def test_a_wrong_name_is_a_sentence_with_the_nearest_one(answer: Answer) -> None:
    with pytest.raises(KeyError, match="doors has no table 'door'; did you mean 'doors'"):
        _ = answer["door"]
    with pytest.raises(InputError, match=r"style='cvs' must be one of table, .*; did you mean 'csv'"):
        answer.text("cvs")


def test_it_is_what_the_verb_prints(answer: Answer) -> None:
    first = {"name": "north", "open": True, "width_m": "inf", "lock": None, "passed": {"Ada": 2}}
    assert answer.record()["doors"][0] == first | {"bolts": [{"turns": 1}, {"turns": 2}]}
    assert answer.text("csv") == answer.csv()["doors"]
    assert answer.csv()["summary"] == "what,value\nshut_part,1\nshut_whole,2\nnames,Ada\nwind_mps,\n"
    assert answer.text("markdown").startswith("### Doors")
    assert "&lt;north&gt;" in answer._repr_html_()
    assert repr(answer) == "<doors: doors (2), doors_bolts (2)>"
