"""Free axes: numbers around the situations of a grid, left out of keys where they are benign."""

from __future__ import annotations

from pathlib import Path

import pytest
from finding import SMALL, small_study

from scaloft_fi.campaign.runs.request import choose_situations
from scaloft_fi.errors import InputError
from scaloft_fi.sim.grids import load_grid
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def searched():
    return Study.open(ROOT, "search")


def test_a_free_axis_at_its_benign_value_is_left_out_and_changes_nothing(searched):
    own = Study.open(ROOT)
    for situation in own.grid.situations:
        same = searched.grid.situation(situation.key)
        assert same == situation
        assert searched.changes(same) == own.changes(situation)
    assert searched.grid.at({"T": 0, "O": 0, "W": 0, "D": 0, "H": 1}, {"Cs": 0.5}).key == "T0O0W0D0H1"


BELT = """
  Be:
    title: belt conveyor of height
    category: environment, static obstacle
    set: bodies.belt.size_m.2
    from: 0.4
    to: 1.2
    unit: m
    distribution: uniform
    benign: 0.9
    also: {bodies.belt.present: true}
adds:
  world:
    bodies:
      belt:
        role: structure
        shape: box
        size_m: [0.7, 5.0, 0.9]
        position: [0.15, 4.0]
        reflectivity: 0.3
        present: false
        optional: true
"""


def test_an_optional_body_has_a_signal_only_where_it_stands(tmp_path):
    own = small_study(tmp_path)
    (tmp_path / "sim" / "grids" / "belt.yaml").write_text(SMALL + BELT, encoding="utf-8")
    searched = Study.open(tmp_path, "belt")
    without, with_ = (searched.grid.situation(key) for key in ("T0D0H0", "T0D0H0Be=0.8"))
    assert "belt" not in searched.scenario(without).world.surfaces
    assert searched.scenario(with_).world.surfaces[-1] == "belt"
    assert searched.signals == own.signals
    assert "clearance_belt_m" in searched.grid.passing_signals


def test_another_number_stands_at_the_end_of_the_key_and_is_flown(searched):
    situation = searched.grid.situation("T1O1W0D2H1Cs=0.87Vy=2")
    assert Situation.parse(situation.key) == situation
    assert situation.point.key == "T1O1W0D2H1"
    scenario = searched.scenario(situation)
    assert scenario.world.mission.cruise_mps == 0.87
    assert [happening.name for happening in scenario.world.happenings] == ["lamp", "draught"]
    assert searched.grid.titles(situation)[-2:] == ("cruise speed 0.87 m/s", "wind along the corridor 2 m/s")
    assert searched.space.words_of(situation.key) == searched.grid.titles(situation)
    assert searched.space.point[situation.key] == searched.space.point["T1O1W0D2H1"]


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("T0O1W0D0H0Vy=2Cs=0.8", "must be written 'T0O1W0D0H0Cs=0.8Vy=2'"),
        ("T0O0W0D0H0Ox=1", r"search.yaml:\d+: Ox=1 goes only with O=\[1\]"),
        ("T0O0W0D0H0Cs=0.5", "must be written 'T0O0W0D0H0'"),
        ("T0O0W0D0H0Cs=0.2", r"search.yaml:\d+: Cs=0.2 must be 0.3 to 1.2"),
        ("T0O0W0D0H0Zs=0.2", "there is no free axis 'Zs'; did you mean"),
    ],
)
def test_a_number_that_the_grid_does_not_have_is_refused_with_what_it_must_be(searched, key, message):
    with pytest.raises(InputError, match=message):
        searched.grid.situation(key)
    assert key not in searched.space.point or "must be written" in message


AXIS = """
  Xs:
    title: cruise speed
    category: speed
    set: mission.cruise_mps
    from: 0.4
    to: 1.2
    unit: m/s
    distribution: uniform
    benign: 0.5
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "benign: 0.5",
            "benign: 0.6",
            r"grids/one.yaml:\d+: benign=0.6 must be 0.5, what the study has at .*world.yaml",
        ),
        ("mission.cruise_mps", "mission.cruise", r"one.yaml:\d+: no path 'world.mission.cruise' in the study"),
        ("  Xs:", "  T:", "free axis 'T' must have a name of its own"),
        ("to: 1.2", "to: 0.4", "to=0.4 must be > 0.4, which is 'from'"),
        ("set: mission.cruise_mps", "set: stack.goal_m", "belongs to the stack under test"),
        ("benign: 0.5", "benign: 0.5\n    only_with: {Q: 1}", "only_with names the unknown axis 'Q'"),
        ("benign: 0.5", "benign: 0.5\n    only_with: {T: 7}", r"must be values of axis 'T', 0 to 1"),
        ("benign: 0.5", "benign: 0.5\n    bins: 3", "unknown key 'bins'"),
        ("benign: 0.5", "benign: 0.5\n    also: {light: [1]}", r"light=\[...\] must be a single value"),
        ("benign: 0.5", "benign: 0.5\n    also: {light: 0.1}", "Xs and D1 both set world.light; name under only_with"),
    ],
)
def test_a_free_axis_that_cannot_be_is_refused_with_its_place(study, old, new, message):
    own = (study / "situations.yaml").read_text().split("aliases:")[0].replace("name: paper", "")
    (study / "grids" / "one.yaml").write_text(own + "free:" + AXIS.replace(old, new, 1))
    with pytest.raises(InputError, match=message):
        load_grid(study, "one")


@pytest.mark.parametrize("how", ["random:40", "sobol:40", "draws:40"])
def test_a_choice_draws_numbers_of_free_axes_and_leaves_most_of_them_benign(searched, how):
    drawn = choose_situations(how, searched.grid.situations, (0,), 0, searched.space).situations
    assert all(searched.grid.situation(situation.key) == situation for situation in drawn)
    off = sum(len(situation.numbers) for situation in drawn) / len(drawn)
    assert 2 < off < len(searched.grid.free) / 2
    assert drawn == choose_situations(how, searched.grid.situations, (0,), 0, searched.space).situations


def test_of_scenarios_with_drawn_numbers_only_the_last_ones_are_kept(searched, monkeypatch):
    monkeypatch.setattr("scaloft_fi.sim.load.MOST_DRAWN", 2)
    first, *others = (searched.grid.situation(f"T0O0W0D0H0Cs={cruise}") for cruise in (0.6, 0.7, 0.8, 0.9))
    kept = searched.scenario(first)
    assert searched.scenario(first) is kept
    for other in others:
        searched.scenario(other)
    assert searched.scenario(first) is not kept
    point = searched.grid.situation("T0O0W0D0H0")
    assert searched.scenario(point) is searched.scenario(point)
