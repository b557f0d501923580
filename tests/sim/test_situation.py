from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.errors import InputError
from scaloft_fi.judge.stl import Formula
from scaloft_fi.sim.load import load
from scaloft_fi.sim.log import signal_names
from scaloft_fi.sim.situation import Situation, number_text
from scaloft_fi.stack.reference.messages import BELIEFS


def test_a_key_is_made_of_axes_and_values():
    situation = Situation.of({"T": 1, "Li": 12})
    assert situation.key == str(situation) == "T1Li12"
    assert situation["Li"] == 12


def test_the_benign_predicate_denies_all_others(config):
    axis = config.grid.axes[0]
    assert axis.predicate(1) == "eventually(x_m < -1)"
    assert axis.predicate(0) == "(not (eventually(x_m < -1)))"


def test_every_predicate_is_a_formula_over_the_log(config):
    names = signal_names(config.world.surfaces, BELIEFS)
    for axis in config.grid.axes:
        for value in axis.values:
            assert set(Formula.parse(axis.predicate(value.id), names).names) <= set(names)


BAD = [
    ("    category: mine structure\n", "", "lacks the key 'category'"),
    ("- {id: 0, title: straight}", "- {id: 1, title: straight}", "id=1 must be 0: ids count from 0"),
    (
        "realised: eventually(x_m < -1)\n",
        "\n",
        "value T1 lacks the key 'realised': a formula over signals that says when",
    ),
    ("- {id: 0, title: straight}", "- {id: 0, title: straight, realised: light > 0}", "value T0 must not have the key"),
    (
        "- {id: 0, title: straight}",
        "- {id: 0, titel: straight}",
        "unknown key 'titel' in values[0]; did you mean 'title'?",
    ),
    ("bodies.obstacle.present: true", "bodies.obstacel.present: true", "did you mean 'world.bodies.obstacle.present'"),
    ("set: {light: 0.003}", "set: {light: -0.003}", "light=-0.003 must be >= 0"),
    ("set: {light: 0.003}", "set: {lihgt: 0.003}", "no path 'world.lihgt' in the study; did you mean 'world.light'"),
    ("[0.865, 7.0]", "[1.865, 7.0]", "corner=[1.865, 7.0] must be in the open space"),
    ("[corner, end, corner, home]", "[corner, and, corner, home]", "no waypoint 'and'; did you mean 'end'"),
    ("T0O0W0D1H0", "T0O0W0D7H0", "alias '2': no situation 'T0O0W0D7H0'"),
    ("  T:\n", "  turn:\n", "name 'turn' must be a capital letter"),
    ("axes:\n", "axis:\n", "unknown key 'axis' in situations.yaml; did you mean 'axes'?"),
    ("axes:\n", "speed: 3\naxes:\n", "unknown key 'speed'"),
]


@pytest.mark.parametrize(("old", "new", "sentence"), BAD)
def test_situations_that_cannot_be_are_refused_with_their_line(edited, old, new, sentence):
    study = edited("situations.yaml", old, new)
    with pytest.raises(InputError) as error:
        load(study)
    assert sentence in str(error.value)
    assert "situations.yaml:" in str(error.value)
    assert "\n" not in str(error.value)


@given(
    st.dictionaries(st.from_regex(r"[A-Z][a-z]{0,3}", fullmatch=True), st.integers(0, 99), min_size=1, max_size=5),
    st.lists(st.floats(-1e12, 1e12).map(lambda number: float(number_text(number))), min_size=5, max_size=5),
    st.integers(0, 31),
)
def test_a_key_with_drawn_numbers_names_its_situation(levels, numbers, some):
    drawn = {axis: numbers[place] for place, axis in enumerate(levels) if some >> place & 1}
    situation = Situation.of(levels, drawn)
    assert Situation.parse(situation.key) == situation
    assert dict(situation.numbers) == drawn
    assert situation.point == Situation.of(levels)
    assert re.fullmatch(r"[A-Za-z0-9.=-]+", situation.key)  # plain in shells, globs, file names, CSV and web addresses


NO_KEYS = ["", "t0", "T", "T0=", "T0=x", "T0=1e", "T0T1", "T0 ", "T0=1+2", "T0=--1", "T0=1e999", "T\u0663", "T0\n"]


NO_KEYS = ["", "t0", "T", "T0=", "T0=x", "T0=1e", "T0T1", "T0 ", "T0=1+2", "T0=--1", "T\u0663", "T0\n"]


@pytest.mark.parametrize("text", NO_KEYS)
def test_a_text_that_is_no_key_names_no_situation(text):
    assert Situation.parse(text) is None
