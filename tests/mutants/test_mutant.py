"""Ids and JSON."""

from __future__ import annotations

import json
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.name import Name, parse, split_magnitude
from scaloft_fi.mutants.mutant import PLACEBO, Mutant

GUIDEWORDS = st.sampled_from(["NO", "MORE", "ASWELLAS", "UNINTENDED"])
PARAMETERS = st.sampled_from(["human", "velcmd", "speedlimit"])
MAGNITUDES = st.one_of(
    st.just(""),
    st.sampled_from(["y", "yaw", "infs", "100%", "2EV", "0.05radps", "5frames", "180deg", "1.5x", "0.8"]),
    st.builds(
        lambda n, unit: f"{n:g}{unit}", st.floats(1e-4, 1e4), st.sampled_from(["s", "ms", "x", "%", "m", "mps2"])
    ),
)
PHASES = st.floats(0.0, 1000.0).map(lambda s: float(f"{s:.4f}")).filter(lambda s: float(f"{s:g}") == s)
EVENTS = st.sampled_from(["sight", "waypoint", "mode", "s", "e5s", "flag_2"])
VALUES = st.one_of(st.booleans(), st.floats(allow_nan=False), st.sampled_from(["y", "per_axis"]))


@given(
    st.one_of(
        st.builds(Name, GUIDEWORDS, PARAMETERS, MAGNITUDES, PHASES),
        st.builds(Name, GUIDEWORDS, PARAMETERS, MAGNITUDES, event=EVENTS),
    )
)
def test_an_id_reads_back_as_it_was_written(name: Name) -> None:
    assert parse(str(name)) == name
    assert str(parse(str(name))) == str(name)
    assert "/" not in str(name)


@given(st.floats(1e-4, 1e4), st.sampled_from(["s", "ms", "x", "%", "m", "EV", "radps", "Hz", ""]))
def test_a_magnitude_splits_into_number_and_unit(number: float, unit: str) -> None:
    rung, found = split_magnitude(f"{number:g}{unit}")
    assert (f"{rung:g}", found) == (f"{number:g}", unit)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "human",
        "LATE",
        "late-human",
        "LATE-human@",
        "LATE-human#5",
        "LATE-human#",
        "LATE-human#Sight",
        "LATE-human#sight#5s",
        "LATE-human#5s#sight",
        "LATE-human@3s#",
        "LATE-human@3s/4",
        "LATE_human",
        "LATE-human@3s#-5s",
        "LATE-human@3 s",
    ],
)
def test_a_malformed_id_is_refused_with_the_form(text: str) -> None:
    with pytest.raises(InputError, match=r"must be of the form GUIDEWORD-parameter\[@magnitude\]\[#phase\]"):
        parse(text)


@given(st.dictionaries(st.sampled_from(["share", "delay_s", "field"]), VALUES))
def test_a_mutant_survives_json_and_pickling(arguments: dict[str, float | str | bool]) -> None:
    mutant = Mutant("NO-human@25%", "NO", "human", "25%", 5.0, "person", "drop", arguments)
    assert Mutant.from_json(json.loads(json.dumps(mutant.to_json()))) == mutant
    assert pickle.loads(pickle.dumps(mutant)) == mutant
    assert hash(mutant) == hash(pickle.loads(pickle.dumps(mutant)))


def test_the_event_of_a_mutant_survives_json_and_a_mutant_without_one_has_no_such_key() -> None:
    mutant = Mutant("NO-human@3s#sight", "NO", "human", "3s", 0.0, "person", "outage", {"burst_s": 3.0}, "sight")
    assert Mutant.from_json(json.loads(json.dumps(mutant.to_json()))) == mutant
    assert str(mutant.name) == mutant.id
    assert "event" not in PLACEBO.to_json()


def test_a_key_too_many_or_too_few_is_named() -> None:
    with pytest.raises(InputError, match="key 'colour' is unknown"):
        Mutant.from_json(PLACEBO.to_json() | {"colour": 1})
    with pytest.raises(InputError, match="key 'seam' is missing"):
        Mutant.from_json({k: v for k, v in PLACEBO.to_json().items() if k != "seam"})
