"""The documents of the `sim` folder, sources of their numbers, values by path; scenarios; claims of stacks."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from refused import refusal
from tiny_stack import SOUND

from scaloft_fi import document
from scaloft_fi.errors import InputError
from scaloft_fi.sim.grid import load_grid
from scaloft_fi.sim.load import KINDS, load
from scaloft_fi.sim.situation import added, leaves, patched, qualified
from scaloft_fi.sim.stacks import CLAIMS, claims_of, declare_claims
from scaloft_fi.sources import closure
from scaloft_fi.stack.declaration import Claim
from scaloft_fi.stack.reference.declaration import CLAIMS as OURS
from scaloft_fi.study import Study
from tests.sim.conftest import SIM


def test_every_number_has_a_source_and_every_source_covers_a_value(config):
    assert [path for path in config.numbers if config.source_of(path) is None] == []
    assert all(source.text for source in config.sources.values())
    assert [path for path in config.sources if not any(f"{n}.".startswith(f"{path}.") for n in config.numbers)] == []


def test_the_longest_path_decides_on_the_source_and_assumptions_are_the_numbers_that_are_ours(config):
    paths = ("world.bodies.bar.radius_m", "world.bodies.person.position.0", "vehicle.mass_kg")
    assert [config.source_of(path).kind for path in paths] == ["assumption", "published", "datasheet"]
    assert config.source_of("nowhere.at.all") is None
    assert config.assumptions["sensors.depth.active"] == 32
    assert "vehicle.mass_kg" not in config.assumptions
    assert {config.source_of(path).kind for path in config.numbers} <= set(KINDS)


@pytest.mark.parametrize(
    ("path", "value", "read"),
    [
        ("sensors.depth.latency_s", 0.13, lambda c: c.sensors.depth.latency_s),
        ("world.bodies.bar.position.0", -2.1, lambda c: float(c.world.bodies["bar"].mesh.vertices[:, 0].mean())),
        ("vehicle.mass_kg", 1.7, lambda c: c.vehicle.mass_kg),
        ("stack.planner.range_m", 3.0, lambda c: c.stack.parameters["planner"]["range_m"]),
        ("situations.axes.D.values.1.set.light", 0.01, lambda c: c.scenario(c.grid.situation("2")).world.light),
        ("world.mission.cruise_mps", 0.6, lambda c: c.scenario(c.grid.situation("2")).world.mission.cruise_mps),
    ],
)
def test_single_values_can_be_overridden(study, path, value, read):
    assert read(load(study, {path: value})) == pytest.approx(value)


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        ("sensors.depth.latncy_s", 0.1, "no path 'sensors.depth.latncy_s' in the study; did you mean 'sensors.depth"),
        ("sensor.depth.latency_s", 0.1, "did you mean 'sensors.depth.latency_s'"),
        ("sensors.depth.latency_s", -0.1, "latency_s=-0.1 must be >= 0"),
    ],
)
def test_an_override_that_cannot_be_is_refused(study, path, value, sentence):
    assert sentence in refusal(load, study, {path: value})


def test_a_study_need_not_name_the_sources_of_its_numbers(study):
    (study / "sources.yaml").unlink()
    assert load(study).sources == {}


def test_of_scenarios_with_drawn_numbers_only_the_last_ones_are_kept(monkeypatch):
    monkeypatch.setattr("scaloft_fi.sim.load.MOST_DRAWN", 2)
    config = load(SIM, grid=load_grid(SIM, "search"))
    first, *others, point = (
        config.grid.situation(f"T0O0W0D0H0{number}") for number in ("Cs=0.6", "Cs=0.7", "Cs=0.8", "Cs=0.9", "")
    )
    kept = config.scenario(first)
    assert config.scenario(first) is kept
    for other in others:
        config.scenario(other)
    assert config.scenario(first) is not kept
    assert config.scenario(point) is config.scenario(point)


@pytest.fixture
def item(tmp_path):
    """The item of a text, in a file of that name."""

    def make(text, name="changes"):
        (tmp_path / f"{name}.yaml").write_text(text)
        return document.load(tmp_path / f"{name}.yaml")

    return make


WORLD = "a: {b: 1, c.d: 2}\nlist:\n  - 3\n  - {e: 4}\n"


@pytest.mark.parametrize(
    ("path", "found"),
    [
        ("a.b", {"a": {"b": 9, "c.d": 2}, "list": [3, {"e": 4}]}),
        ("a.c.d", {"a": {"b": 1, "c.d": 9}, "list": [3, {"e": 4}]}),
        ("list.0", {"a": {"b": 1, "c.d": 2}, "list": [9, {"e": 4}]}),
        ("list.1.e", {"a": {"b": 1, "c.d": 2}, "list": [3, {"e": 9}]}),
        ("a", {"a": 9, "list": [3, {"e": 4}]}),
    ],
)
def test_one_value_is_replaced_with_its_own_place_and_the_rest_kept(item, path, found):
    world, other, value = item(WORLD, "world"), item("mass_kg: 1.5", "vehicle"), item("\n\n9\n")
    before = world.plain()
    changed = patched({"world": world, "vehicle": other}, {f"world.{path}": value})
    assert changed["world"].plain() == found
    assert changed["vehicle"] is other
    assert world.plain() == before
    assert [leaf.place for _, leaf in leaves(changed["world"]) if leaf.value == 9] == [value.place]


@pytest.mark.parametrize(
    "path", ["world.a.x", "world.x", "world.list.2", "world.list.one", "world.a.b.c", "wrld.a.b", "world"]
)
def test_an_unknown_path_is_refused_with_the_nearest(item, path):
    with pytest.raises(InputError, match=rf"changes.yaml:3: no path '{path}' in the study"):
        patched({"world": item(WORLD, "world")}, {path: item("\n\n9\n")})


def test_leaves_are_all_scalars_by_path(item):
    found = {path: leaf.value for path, leaf in leaves(item(WORLD))}
    assert found == {"a.b": 1, "a.c.d": 2, "list.0": 3, "list.1.e": 4}


@pytest.mark.parametrize(
    ("path", "whole"),
    [("light", "world.light"), ("mission.cruise_mps", "world.mission.cruise_mps"), ("world.light", "world.light")]
    + [(path, path) for path in ("vehicle.mass_kg", "sensors.depth.max_m")],
)
def test_a_path_without_a_document_is_the_worlds(item, path, whole):
    assert qualified(path, item("1")) == whole


def test_new_entries_join_the_old_ones_and_keep_their_own_place(item):
    world = item("light: 0.9\nbodies:\n  bar: {present: true}\n", "world")
    more = item("world:\n  bodies:\n    belt: {present: false}\n  signals: [charge]\n", "wide")
    joined = added({"world": world}, more)["world"]
    bodies = {"bar": {"present": True}, "belt": {"present": False}}
    assert joined.plain() == {"light": 0.9, "bodies": bodies, "signals": ["charge"]}
    places = [entry.place.rpartition("/")[2] for entry in joined.need("bodies").mapping().values()]
    assert places == ["world.yaml:3", "wide.yaml:3"]
    assert world.plain() == {"light": 0.9, "bodies": {"bar": {"present": True}}}


BEND = math.degrees(math.atan2(3, 1))
ENDS_S = 1.65 / 0.7 + 0.5 + 1.65 / 0.5
"""Climb, pause, landing."""


def test_the_nominal_time_is_climb_turns_legs_and_landing_and_the_time_limit_follows(config, scenario):
    straight = ENDS_S + (90 + 180) / 45 + 14 / 0.5
    corner = ENDS_S + (90 + BEND + 180 + BEND) / 45 + 2 * (7 + math.hypot(3, 1)) / 0.5
    beside_a_person = straight + 14 / 0.2 - 14 / 0.5
    for key, nominal_s in (("T0O0W0D0H0", straight), ("T1O0W0D0H0", corner), ("T0O0W0D0H1", beside_a_person)):
        assert math.isclose(scenario(key).nominal_s, nominal_s)
        assert math.isclose(scenario(key).t_max_s, 20 + 1.5 * nominal_s)


def test_a_person_comes_into_view_while_the_drone_turns_into_the_corridor(scenario):
    turn_begins = 1.65 / 0.7 + 0.5
    assert turn_begins < scenario("T0O0W0D0H1").sighting_s <= turn_begins + 90 / 45
    assert scenario("T0O0W0D0H0").sighting_s is None


def test_a_person_that_stands_behind_rock_is_sighted_later_or_never(edited):
    config = load(edited("world.yaml", "position: [-0.5, 3.25]", "position: [-4.5, 8.0]"))
    assert config.scenario(config.grid.situation("T1O0W0D0H1")).sighting_s > 15
    assert config.scenario(config.grid.situation("T0O0W0D0H1")).sighting_s is None


def test_home_is_on_the_floor_the_start_half_a_hull_above_and_the_nominal_flight_without_jumps(scenario):
    it = scenario("T0O0W0D0H0")
    assert (it.home, it.start, it.route) == ((0, 0, 0), (0, 0, 0.055), ((0, 7, 1.65), (0, 0, 1.65)))
    for key in ("T0O0W0D0H0", "T1O1W1D1H1"):
        legs = list(scenario(key)._legs(0.5))
        assert all(before.end == after.start for before, after in pairwise(legs))
        assert legs[-1].end[:3] == (0, 0, 0)


def test_a_mission_may_fly_waypoints_at_their_own_altitudes_and_land_elsewhere(edited):
    edited("world.yaml", "corner: [0.0, 7.0]", "corner: [0.0, 7.0, 1.0]")
    config = load(edited("world.yaml", "route: [corner, home]", "route: [corner, end]"))
    it = config.scenario(config.grid.situation("T0O0W0D0H0"))
    assert it.route == ((0.0, 7.0, 1.0), (-3.0, 8.0, 1.65))
    legs_m = math.hypot(7, 0.65) + math.hypot(3, 1, 0.65)
    assert math.isclose(it.nominal_s, ENDS_S + (90 + BEND) / 45 + legs_m / 0.5)


STUDY = Study.open()


@pytest.fixture(autouse=True)
def no_claims_are_left():
    yield
    CLAIMS._entries.pop("hop", None)


def clock(**about):
    return Claim("clock", "s", 0.1, lambda _now: 0.0, **about)


def test_a_stack_declares_its_claims_once_and_may_have_none():
    assert claims_of(STUDY.stack, STUDY.signals) == OURS
    assert claims_of(SOUND, []) == ()
    one = clock(about=("elapsed_s",), seam="level")
    declare_claims("hop", one)
    assert claims_of(SOUND, ["elapsed_s"]) == (one,)
    with pytest.raises(ValueError, match="claims of the stack 'hop' is declared twice"):
        declare_claims("hop")


@pytest.mark.parametrize(
    ("claim", "message"),
    [
        (clock(seam="lvel"), "seam 'lvel' does not exist; did you mean 'level'?"),
        (clock(about=("elapsed",)), "signal 'elapsed' does not exist; did you mean"),
    ],
)
def test_a_claim_about_what_does_not_exist_is_refused(claim, message):
    declare_claims("hop", claim)
    assert f"stack 'hop': claim 'clock': {message}" in refusal(claims_of, SOUND, ["elapsed_s", "x_m"])


def test_no_flight_depends_on_a_claim():
    assert not [name for name in closure(STUDY.flying_modules) if "claim" in name]


def test_the_stack_is_a_name_and_plain_parameters_and_an_unknown_setting_is_named(config, edited):
    assert config.stack.name == "reference"
    assert "name" not in config.stack.parameters
    assert isinstance(config.stack.parameters["control"]["rotors"], list)
    choice = load(edited("stack.yaml", "goal_radius_m:", "gaol_radius_m:")).stack
    sentence = r"stack.yaml:\d+: unknown key 'gaol_radius_m' in mission; did you mean 'goal_radius_m'"
    with pytest.raises(InputError, match=sentence):
        choice.settings(choice.declaration)
