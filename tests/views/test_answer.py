"""Answers of verbs as typed columns: the types follow from the declared shapes, whatever the values are."""

from __future__ import annotations

import math
from typing import Any

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.verbs.margin import magnitude
from scaloft_fi.views.output import (
    Answer,
    ColumnType,
    Output,
    by_name,
    count,
    flag,
    listing,
    number,
    optional,
    ratio,
    record,
    text,
    texts,
)
from scaloft_fi.views.table import Table

FORM = Output(
    "doors",
    "1.0",
    "the doors of a mine",
    {
        "doors": listing(
            "every door",
            record(
                "a door",
                {
                    "name": text("its name"),
                    "open": flag("whether it is open"),
                    "width_m": magnitude("its width"),
                    "lock": optional(
                        record(
                            "its lock",
                            {"keys": count("how many"), "by": texts("who has one"), "barred": flag("whether")},
                        )
                    ),
                    "passed": by_name("by miner", count("how often")),
                    "bolts": listing("its bolts", record("a bolt", {"turns": count("how many")})),
                },
            ),
        ),
        "shut": ratio("doors that are shut"),
        "names": texts("of the miners"),
        "wind_mps": optional(number("wind", "m/s")),
    },
    rows="doors",
)
DOORS: list[dict[str, Any]] = [
    {
        "name": "north",
        "open": True,
        "width_m": "inf",
        "lock": None,
        "passed": {"Ada": 2},
        "bolts": [{"turns": 1}, {"turns": 2}],
    },
    {
        "name": "south",
        "open": False,
        "width_m": 1.5,
        "lock": {"keys": 3, "by": ["Ada"], "barred": True},
        "passed": {},
        "bolts": [],
    },
]


@pytest.fixture
def answer() -> Answer:
    values = {"doors": DOORS, "shut": {"part": 1, "whole": 2}, "names": ["Ada"], "wind_mps": None}
    return Answer(FORM, lambda: values, lambda: (Table("Doors", ("name",), (("<north>",),)),))


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
    assert answer.record()["doors"] == DOORS
    assert answer.text("csv") == answer.csv()["doors"]
    assert answer.csv()["summary"] == "what,value\nshut_part,1\nshut_whole,2\nnames,Ada\nwind_mps,\n"
    assert answer.text("markdown").startswith("### Doors")
    assert "&lt;north&gt;" in answer._repr_html_()
    assert repr(answer) == "<doors: doors (2), doors_bolts (2)>"
