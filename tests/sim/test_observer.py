from __future__ import annotations

import math

import pybullet
import pytest

from scaloft_fi.sim.build import build
from scaloft_fi.sim.contact import Contact
from scaloft_fi.sim.observer import Observer
from scaloft_fi.sim.sensors.camera import look
from scaloft_fi.sim.vehicle import spawn
from tests.sim.conftest import state_at

pytestmark = pytest.mark.flight

GROUND = Contact("ground", True)


@pytest.fixture
def watch(client, config, scenario):
    """A vehicle that is put where a test wants it, and its observer."""

    def begin(key="T1O1W0D0H1"):
        flown = scenario(key)
        ids = build(client, flown.world)
        body = spawn(client, config.vehicle, (0, 0, 1.65), 0)
        observer = Observer(client, ids, body, config.vehicle, flown, flown.world.surroundings())

        def at(x, y, z=1.65, velocity=(0, 0, 0), yaw=0.0, roll=0.0):
            attitude = pybullet.getQuaternionFromEuler([roll, 0, yaw])
            pybullet.resetBasePositionAndOrientation(body, (x, y, z), attitude, physicsClientId=client)
            return state_at((x, y, z), attitude, velocity)

        def sample(state, view=None):
            return dict(zip(observer.names, observer.sample(1.0, state, view), strict=True))

        return observer, at, sample, flown

    return begin


def test_a_sample_tells_position_attitude_time_and_clearances_to_the_hull(watch):
    _, at, sample, flown = watch()
    row = sample(at(0.1, 6.0, 1.6, velocity=(0.3, 0.4, 0), yaw=0.5))
    assert (row["x_m"], row["y_m"], row["z_m"], row["elapsed_s"], row["light"]) == (0.1, 6.0, 1.6, 1, 0.9)
    assert row["remaining_s"] == flown.t_max_s - 1
    assert [row[name] for name in ("yaw_rad", "speed_mps", "home_m")] == pytest.approx([0.5, 0.5, math.hypot(0.1, 6)])
    row = sample(at(-0.15, 5 - 0.25 - 0.235 - 0.4))
    assert row["clearance_obstacle_m"] == pytest.approx(0.4, abs=2e-3)
    assert row["clearance_m"] == min(value for name, value in row.items() if name.startswith("clearance_"))
    assert row["clearance_bar_m"] == row["clearance_ground_m"] == 1


def test_a_body_that_is_not_there_is_never_near(watch):
    _, at, sample, _ = watch("T1O0W0D0H0")
    row = sample(at(-0.5, 3.25))
    assert row["clearance_person_m"] == row["clearance_obstacle_m"] == 1
    assert row["person_range_m"] == row["person_sight_m"] == 100


def test_speed_and_contacts_are_those_since_the_last_sample(watch):
    observer, at, sample, _ = watch()
    observer.step(0.1, at(0, 2, velocity=(0, 0.9, 0)), [Contact("wall", False)])
    observer.step(0.2, at(0, 2), [Contact("bar", False)])
    first, second = (sample(at(0, 2, velocity=(0, 0.2, 0))) for _ in range(2))
    assert [first["speed_mps"], second["speed_mps"]] == pytest.approx([0.9, 0.2])
    assert first["clearance_wall_m"] <= -0.001
    assert first["clearance_m"] <= -0.001 < 0 < second["clearance_m"]
    assert (observer.struck, observer.struck_at_s) == ("wall", 0.1)


def test_the_ground_may_be_touched_near_home(watch):
    observer, at, sample, _ = watch()
    sample(at(0.3, 0.2))
    observer.step(0.1, at(0.3, 0.2, 0.3, velocity=(0, 0, -3)), ())
    observer.step(0.2, at(0.3, 0.2, 0.05), [GROUND])
    row = sample(at(0.3, 0.2, 0.05))
    assert (observer.struck, observer.landed, row["landed"], row["clearance_ground_m"]) == ("", True, 1, 1)


@pytest.mark.parametrize(
    ("sink_mps", "roll_deg", "struck"), [(0.5, 0, ""), (0.8, 0, "ground"), (0.5, 15, "ground"), (0.69, 9, "")]
)
def test_away_from_home_only_a_landing_may_touch_the_ground(watch, sink_mps, roll_deg, struck):
    observer, at, sample, _ = watch()
    sample(at(0, 4))
    observer.step(0.1, at(0, 4, 0.2, velocity=(0, 0, -sink_mps), roll=math.radians(roll_deg)), ())
    observer.step(0.2, at(0, 4, 0.06), [GROUND])  # what counts is how it came down
    row = sample(at(0, 4, 0.06))
    assert (observer.struck, observer.landed, row["clearance_m"] > 0) == (struck, not struck, not struck)


def test_standing_on_the_ground_before_take_off_is_no_landing_and_passes_no_waypoint(watch):
    observer, at, sample, _ = watch("T0O0W0D0H0")
    assert sample(at(0, 0, 0.055))["waypoints_left"] == 2
    observer.step(0.1, at(0, 0, 0.055), [GROUND])
    assert not observer.landed


@pytest.mark.parametrize(
    ("key", "place", "range_m", "in_sight"),
    [
        ("T1O0W0D0H1", (-0.5, 5.25), math.hypot(2, 0.2) - 0.25, True),  # to the head, which is round
        ("T1O0W0D0H1", (-3.5, 7.5), 4.96, False),  # round the corner
        ("T1O1W0D0H1", (0.15, 5.6, 0.4), 2.19, False),  # behind the obstacle
        ("T1O1W0D0H1", (-0.9, 5.6, 0.4), 2.13, True),
    ],
)
def test_the_person_is_in_sight_where_a_free_line_exists(watch, key, place, range_m, in_sight):
    _, at, sample, _ = watch(key)
    row = sample(at(*place))
    assert row["person_range_m"] == pytest.approx(range_m, abs=0.02)
    assert row["person_sight_m"] == (row["person_range_m"] if in_sight else 100)


def test_waypoints_are_passed_in_order_home_last(watch):
    _, at, sample, _ = watch("T1O0W0D0H0")
    way = ((0, 0), (-3, 8), (0.4, 7), (-3, 8), (0, 7.2), (0, 1), (0, 0.4))
    assert [sample(at(x, y))["waypoints_left"] for x, y in way] == [4, 4, 3, 2, 1, 1, 0]


def test_the_wall_at_a_waypoint_is_measured_only_near_the_waypoint(watch):
    _, at, sample, flown = watch("T1O0W1D0H0")
    x, y, z = flown.route[0]
    near = sample(at(x, y, z))
    assert near["waypoint_wall_m"] == near["clearance_wall_m"] == pytest.approx(1.5 - x - 0.235, abs=0.1)
    assert sample(at(0, 4))["waypoint_wall_m"] == 100


def test_obstacle_pixels_are_those_of_the_ideal_picture(watch):
    _, at, sample, flown = watch("T0O1W0D0H0")
    toward, away = at(0, 2, yaw=math.pi / 2), at(0, 2, yaw=-math.pi / 2)
    scene, camera = flown.world.scene, flown.sensors.depth.camera
    toward_pixels, away_pixels = (
        sample(state, look(scene, camera, state[:3], state[3:7]))["obstacle_pixels"] for state in (toward, away)
    )
    assert toward_pixels > 25
    assert away_pixels == sample(away)["obstacle_pixels"] == 0
