"""Happenings: what they change, in whole flights too, and moving bodies as camera, observer and server see them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pybullet
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from options import usually
from tiny_stack import SOUND

from scaloft_fi.document import load
from scaloft_fi.errors import DeclaredError, InputError
from scaloft_fi.sim.build import build, physics_server, place
from scaloft_fi.sim.contact import Clearances, Feeler
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.happenings import HAPPENINGS, Effect, HappeningKind, Start, Walk
from scaloft_fi.sim.load import load as load_sim
from scaloft_fi.sim.observer import Observer
from scaloft_fi.sim.vehicle import spawn
from scaloft_fi.sim.world import read_world
from scaloft_fi.stack.declaration import STEP_S, TICK_S, PlainWire
from tests.sim.conftest import SIM, state_at
from tests.sim.sensors.test_camera import UPRIGHT


def with_happenings(*happenings, present=()):
    """The text of the reference world with these happenings, one line of YAML each, and bodies that are present."""
    text = (SIM / "world.yaml").read_text()
    for body in present:
        head, tail = text.split(f"\n  {body}:", 1)
        text = f"{head}\n  {body}:{tail.replace('present: false', 'present: true', 1)}"
    lines = "".join(f"\n  h{number}: {{active: true, {line}}}" for number, line in enumerate(happenings))
    return f"{text}\nhappenings:{lines or ' {}'}\n"


@pytest.fixture
def world(tmp_path):
    """The reference world with these happenings."""

    def make(*happenings, present=()):
        (tmp_path / "world.yaml").write_text(with_happenings(*happenings, present=present))
        return read_world(load(tmp_path / "world.yaml"))

    return make


def at(around, now_s, x_m=0.0, y_m=0.0):
    around.update(now_s, x_m, y_m)
    return dict(zip(around.names, around.row(), strict=True))


def test_in_a_world_without_happenings_nothing_changes_and_nothing_is_recorded(world):
    plain = world()
    around = plain.surroundings()
    assert at(around, 10.0) == {}
    assert around.scene is plain.scene
    assert (around.light, around.haze_per_m, around.top_body_mps, around.top_wind_mps) == (0.9, 0.0, 0.0, 0.0)
    assert not np.any([around.wind_mps, around.drift_m])


def test_a_happening_that_is_not_active_is_read_and_left_out(edited):
    folder = edited(
        "world.yaml", "\nbodies:", "\nhappenings: {dark: {kind: light, active: false, light: 0.1}}\nbodies:"
    )
    assert read_world(load(folder / "world.yaml")).happenings == ()


@pytest.mark.parametrize(
    ("start", "moments", "lights"),
    [
        ("{at_s: 5}, lasts_s: 2", ((0, 0), (4.95, 0), (5, 0), (7, 0), (7.05, 0)), [0.9, 0.9, 0.1, 0.1, 0.9]),
        (
            "{near: [0, 5], within_m: 1}, lasts_s: 1",  # where the vehicle first comes near, and only once
            ((0, 0), (1, 3.9), (2, 4.1), (2.9, 6.5), (3.1, 5), (9, 5)),
            [0.9, 0.9, 0.1, 0.1, 0.9, 0.9],
        ),
    ],
)
def test_light_changes_while_the_happening_lasts(world, start, moments, lights):
    around, seen = world(f"kind: light, light: 0.1, start: {start}").surroundings(), []
    for now_s, y_m in moments:
        around.update(now_s, 0.0, y_m)
        seen.append(around.light)
    assert seen == lights


def test_a_start_needs_its_time_and_its_place():
    both = Start(at_s=5.0, near=(0.0, 0.0), within_m=1.0)
    assert [both.has_come(*when) for when in ((4.9, 0, 0), (5.0, 2, 0), (5.0, 0.5, 0.5))] == [False, False, True]


def test_winds_dust_and_drifts_add_up_and_are_recorded(world):
    around = world(
        "kind: wind, velocity_mps: [1, 0, 0]",
        "kind: wind, velocity_mps: [0, 2, 0], start: {at_s: 1}",
        "kind: dust, haze_per_m: 0.2",
        "kind: dust, haze_per_m: 0.3, start: {at_s: 1}, lasts_s: 1",
        "kind: drift, rate_mps: [0.01, 0, -0.02], start: {at_s: 2}",
    ).surroundings()
    assert around.top_wind_mps == 3.0
    at(around, 1.0)
    assert (around.wind_mps.tolist(), around.haze_per_m) == ([1.0, 2.0, 0.0], 0.5)
    row = at(around, 12.0)
    assert around.drift_m.tolist() == pytest.approx([0.1, 0.0, -0.2])
    names = [*(f"wind_{k}_mps" for k in "xyz"), "haze_per_m", *(f"drift_{k}_m" for k in "xyz")]
    assert row == pytest.approx(dict(zip(names, (1.0, 2.0, 0.0, 0.2, 0.1, 0.0, -0.2), strict=True)))


def test_a_walking_person_moves_alone_in_the_scene_and_stays_at_the_end(world):
    walk = "kind: walk, body: person, path: [[-0.5, 4.25], [0.5, 4.25]], speed_mps: 0.5"
    still, walked = world(present=["person"]), world(walk, present=["person"])
    flight = walked.surroundings()
    seen = [at(flight, now_s) for now_s in (1.0, 3.0, 60.0)]
    assert [row["person_x_m"] for row in seen] == pytest.approx([-0.5, 0.0, 0.5])
    assert [row["person_y_m"] for row in seen] == pytest.approx([3.75, 4.25, 4.25])
    scene = flight.scene
    person = np.unique(scene.faces[scene.owner == scene.names.index("person")])
    moved = scene.vertices - still.scene.vertices
    assert np.allclose(moved[person], (1.0, 1.0, 0.0))
    assert not np.delete(moved, person, axis=0).any()
    assert np.array_equal(walked.scene.vertices, still.scene.vertices)  # another flight begins anew


def test_a_body_that_appears_is_out_of_reach_before(world):
    around = world("kind: appear, body: obstacle, start: {at_s: 3}", present=["obstacle"]).surroundings()
    obstacle = around.scene.faces[around.scene.owner == around.scene.names.index("obstacle")]
    around.update(2.95, 0.0, 0.0)
    assert around.scene.vertices[obstacle][..., 2].max() < -900
    around.update(3.0, 0.0, 0.0)
    assert around.scene.vertices[obstacle][..., 2].min() >= 0.0


points = st.tuples(st.floats(-3, 3), st.floats(-3, 3))


@given(st.lists(points, min_size=1, max_size=5), st.floats(0.1, 3.0), st.floats(0.0, 20.0), st.floats(0.0, 1.0))
def test_a_walk_is_never_faster_than_its_speed(path, speed_mps, t_s, later_s):
    walk = Walk("person", tuple(path), speed_mps)
    before, after = walk.shift((0.0, 0.0), t_s), walk.shift((0.0, 0.0), t_s + later_s)
    assert math.dist(before, after) <= speed_mps * later_s + 1e-9


def test_two_happenings_that_move_one_body_are_refused(world):
    walk = "kind: walk, body: person, path: [[-0.5, 4.0]], speed_mps: 1"
    with pytest.raises(InputError, match=r"world.yaml:\d+: body 'person' is moved by happening 'h0' already"):
        world(walk, "kind: appear, body: person", present=["person"])


def test_a_happening_after_the_time_limit_is_refused_when_its_situation_is_built(study):
    (study / "world.yaml").write_text(with_happenings("kind: light, light: 0.1, start: {at_s: 140}"))
    config = load_sim(study)
    assert config.scenario(config.grid.situation("T0O0W0D0H1")).t_max_s > 140  # slow beside a person
    with pytest.raises(InputError, match=r"at_s=140 must be before the time limit of situation T0O0W0D0H0, 80.2 s"):
        config.scenario(config.grid.situation("T0O0W0D0H0"))


def test_a_kind_of_another_author_is_one_declaration(world, monkeypatch):
    class Rain(Effect):
        def apply(self, around, since_s):
            around.haze_per_m += 0.1
            around.note(rain_per_m=0.1)

    monkeypatch.setitem(HAPPENINGS._entries, "rain", HappeningKind(Rain, signals=("rain_per_m",)))
    around = world("kind: rain").surroundings()
    assert at(around, 0.0) == {"rain_per_m": 0.1}
    assert around.haze_per_m == 0.1


@pytest.mark.parametrize("attribute", ["light", "haze_per_m"])
def test_a_happening_that_gives_no_finite_number_is_named(world, monkeypatch, attribute):
    class Broken(Effect):
        def apply(self, around, since_s):
            setattr(around, attribute, math.nan)

    monkeypatch.setitem(HAPPENINGS._entries, "broken", HappeningKind(Broken))
    around = world("kind: broken").surroundings()
    with pytest.raises(DeclaredError, match=r"happening '.*' at 0\.500 s makes light, haze, wind, drift or a ") as told:
        around.update(0.5, 0.0, 0.0)
    assert told.value.declared_in == __name__


@pytest.fixture
def flown(study):
    """Hover at home beside a person in a world with one happening."""

    def in_world(happening):
        (study / "stack.yaml").write_text("name: hop\nmass_kg: 1.5\n")
        (study / "world.yaml").write_text(with_happenings(happening, present=["person"]))
        config = load_sim(study)
        return fly(config, config.grid.situation("T0O0W0D0H1"), 0, PlainWire(), SOUND)

    return in_world


@pytest.mark.flight
@pytest.mark.parametrize("start_s", [0.5, 0.51, 0.52, 0.53, 0.54])
@pytest.mark.parametrize("speed_mps", [1.3, 2.9, 9.5])
def test_a_body_that_walks_into_the_drone_strikes_at_the_step_in_which_it_arrives(flown, speed_mps, start_s):
    log = flown(f"kind: walk, body: person, path: [[0.0, 0.0]], speed_mps: {speed_mps}, start: {{at_s: {start_s}}}")
    assert log.struck == "person"
    share = speed_mps * (log.struck_at_s - start_s) / math.hypot(0.5, 3.25)
    i = log.at(log.struck_at_s)
    person = {"x_m": -0.5 * (1 - share), "y_m": 3.25 * (1 - share)}
    gaps = (abs(at_m - log.signals[axis][i]) - 0.235 for axis, at_m in person.items())
    overlap_m = 0.25 - math.hypot(*(max(0.0, gap) for gap in gaps))
    assert -0.02 < overlap_m < 3 * speed_mps * STEP_S + 0.005


@pytest.mark.flight
def test_the_free_room_of_a_tick_is_smaller_by_what_a_body_can_walk_in_it(flown, monkeypatch):
    rooms, look = [], Feeler.look
    monkeypatch.setattr(Feeler, "look", lambda feeler, truth, m: rooms.append(m) or look(feeler, truth, m))
    walk = "kind: walk, body: person, path: [[0.0, 0.0]], start: {at_s: 20}"  # after the landing
    slow, fast = flown(f"{walk}, speed_mps: 1"), flown(f"{walk}, speed_mps: 9")
    assert slow.digest == fast.digest
    first, second = np.split(np.array(rooms), 2)
    assert first - second == pytest.approx(np.full(len(first), 8 * TICK_S))


@pytest.mark.flight
def test_wind_pushes_the_drone_and_stands_in_the_log_where_a_happening_is_marked_when_it_begins(flown):
    calm = flown("kind: light, light: 0.5, start: {at_s: 1.0}")
    windy = flown("kind: wind, velocity_mps: [0.6, 0, 0]")
    assert windy.signals["x_m"][-1] > calm.signals["x_m"][-1] + 0.1
    assert set(windy.signals["wind_x_mps"].tolist()) == {0.6}
    assert "wind_x_mps" not in calm.signals
    assert [(event.t_s, event.text) for event in calm.events if event.kind == "happening"] == [(1.0, "h0 begins")]


WALK = "kind: walk, body: person, path: [[-0.5, 6.0], [0.9, 6.0], [0.9, 1.0]], speed_mps: 1.0"
times_s = st.floats(0.0, 12.0)


@pytest.fixture(scope="module")
def walking(tmp_path_factory):
    """The scenario in which a person walks; a function, because Hypothesis prints arguments."""
    path = tmp_path_factory.mktemp("walk") / "world.yaml"
    path.write_text(with_happenings(WALK, present=["person"]))
    plain = load_sim(SIM)
    scenario = replace(plain.scenario(plain.grid.situation("T0O0W0D0H1")), world=read_world(load(path)))
    return lambda: scenario


@pytest.fixture(scope="module")
def server(walking):
    with physics_server() as client:
        ids = build(client, walking().world)
        body = spawn(client, walking().vehicle, (0.0, 4.0, 1.65), 0.0)
        yield lambda: (client, ids, body, walking().vehicle)


@pytest.mark.flight
@settings(max_examples=usually(25, release=60))
@given(times_s, st.floats(-1.0, 1.0), st.floats(0.5, 6.5), st.floats(0.4, 2.2))
def test_the_oracles_clearance_is_the_servers_wherever_the_person_walks(server, walking, now_s, x, y, z):
    client, ids, body, vehicle = server()
    around = walking().world.surroundings()
    asked = Clearances(client, ids, body, vehicle, walking().world)
    for t_s in (now_s, now_s + 0.05):
        around.update(t_s, x, y)
        place(client, ids, around.shifts)
        pybullet.resetBasePositionAndOrientation(body, (x, y, z), UPRIGHT, physicsClientId=client)
        asked.look((x, y, z, *UPRIGHT), around.shifts)
        points = pybullet.getClosestPoints(body, ids.by_name["person"], 1.0, physicsClientId=client)
        clearance_m = min((point[8] for point in points), default=1.0)
        assert asked.measure("person") == clearance_m
        assert clearance_m <= 0.0 or clearance_m == 1.0 or asked.gaps_m["person"] <= clearance_m + 2e-3
        if 0.0 < clearance_m < 1.0:
            assert clearance_m == pytest.approx(_to_capsule_m(around, vehicle.hull_m, (x, y, z)), abs=0.02)


def _to_capsule_m(around, hull_m, centre):
    """Distance from an upright hull to the person, a vertical segment with a radius of 0.25 m, in plain geometry."""
    person = np.array([-0.5, 3.25]) + around.shifts["person"][:2]
    level = np.maximum(0.0, np.abs(np.array(centre[:2]) - person) - np.array(hull_m[:2]) / 2)
    above = max(0.0, centre[2] - hull_m[2] / 2 - 1.45, 0.25 - centre[2] - hull_m[2] / 2)
    return math.hypot(*level, above) - 0.25


@pytest.fixture
def observed(server, walking):
    """What an observer sees at a time from a place near home."""
    client, ids, body, vehicle = server()
    around = walking().world.surroundings()
    observer = Observer(client, ids, body, vehicle, walking(), around)

    def sample(now_s):
        around.update(now_s, 0.0, 2.0)
        place(client, ids, around.shifts)
        return dict(zip(observer.names, observer.sample(now_s, state_at((0.0, 2.0, 0.85)), None), strict=True))

    return sample


@pytest.mark.flight
def test_the_observer_ranges_and_sights_the_person_where_it_is(observed):
    for now_s, place_m in ((0.0, (-0.5, 3.25)), (2.75, (-0.5, 6.0)), (9.15, (0.9, 1.0))):
        row = observed(now_s)
        assert (row["person_x_m"], row["person_y_m"]) == pytest.approx(place_m, abs=0.02)
        assert row["person_range_m"] == pytest.approx(math.dist(place_m, (0.0, 2.0)) - 0.25, abs=0.03)
        assert row["person_sight_m"] == row["person_range_m"]


@pytest.mark.flight
def test_the_line_of_sight_is_tried_to_where_the_person_is(observed, monkeypatch):
    tried = []
    monkeypatch.setattr("scaloft_fi.sim.observer.blocked", lambda *lines: tried.append(lines[-1][:2].copy()) or True)
    observed(2.75)
    assert len(tried) == 4
    assert all(math.dist(point, (-0.5, 6.0)) < 0.26 for point in tried)


def test_the_nominal_flight_sights_a_person_where_it_has_walked_to(walking, scenario):
    walk = walking().world.happenings[0]
    # round the corner before the drone has taken off
    away = replace(walk, effect=replace(walk.effect, places=((-0.5, 8.2), (-5.0, 8.6)), speed_mps=10.0))
    assert scenario("T0O0W0D0H1").sighting_s is not None
    assert replace(walking(), world=replace(walking().world, happenings=(away,))).sighting_s is None
