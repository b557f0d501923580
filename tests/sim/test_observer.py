from __future__ import annotations

import math

import numpy as np
import pytest

from scaloft_fi.sim.build import build
from scaloft_fi.sim.contact import Contact
from scaloft_fi.sim.observer import Observer
from scaloft_fi.sim.sensors.camera import look
from scaloft_fi.sim.vehicle import STATE_SIZE, spawn

pytestmark = pytest.mark.flight

GROUND = Contact("ground", True)


@pytest.fixture
def watch(client, config):
    """A vehicle that is put where a test wants it, and its observer."""
    import pybullet

    def begin(key="T1O1W0D0H1"):
        scenario = config.scenario(config.grid.situation(key))
        ids = build(client, scenario.world)
        body = spawn(client, config.vehicle, (0, 0, 1.65), 0)
        observer = Observer(client, ids, body, config.vehicle, scenario, scenario.world.surroundings())

        def at(x, y, z=1.65, velocity=(0, 0, 0), yaw=0.0, roll=0.0):
            state = np.zeros(STATE_SIZE)
            state[:3], state[7:10] = (x, y, z), velocity
            state[3:7] = pybullet.getQuaternionFromEuler([roll, 0, yaw])
            pybullet.resetBasePositionAndOrientation(body, state[:3], state[3:7], physicsClientId=client)
            return state

        def sample(state, view=None):
            return dict(zip(observer.names, observer.sample(1.0, state, view), strict=True))

        return observer, at, sample, scenario

    return begin


def test_a_sample_tells_position_attitude_and_time(watch):
    _, at, sample, scenario = watch()
    row = sample(at(0.1, 6.0, 1.6, velocity=(0.3, 0.4, 0), yaw=0.5))
    assert (row["x_m"], row["y_m"], row["z_m"]) == (0.1, 6.0, 1.6)
    assert row["yaw_rad"] == pytest.approx(0.5)
    assert row["speed_mps"] == pytest.approx(0.5)
    assert row["elapsed_s"] == 1
    assert row["remaining_s"] == scenario.t_max_s - 1
    assert row["light"] == 0.9
    assert row["home_m"] == pytest.approx(math.hypot(0.1, 6))


def test_clearances_are_to_the_hull_and_the_least_counts(watch):
    _, at, sample, _ = watch()
    row = sample(at(-0.15, 5 - 0.25 - 0.235 - 0.4))
    assert row["clearance_obstacle_m"] == pytest.approx(0.4, abs=2e-3)
    assert row["clearance_m"] == min(value for name, value in row.items() if name.startswith("clearance_"))
    assert row["clearance_bar_m"] == 1
    assert row["clearance_ground_m"] == 1


def test_a_body_that_is_not_there_is_never_near(watch):
    _, at, sample, _ = watch("T1O0W0D0H0")
    row = sample(at(-0.5, 3.25))
    assert row["clearance_person_m"] == row["clearance_obstacle_m"] == 1
    assert row["person_range_m"] == row["person_sight_m"] == 100


def test_the_speed_is_the_greatest_since_the_last_sample(watch):
    observer, at, sample, _ = watch()
    observer.step(0.1, at(0, 2, velocity=(0, 0.9, 0)), ())
    assert sample(at(0, 2, velocity=(0, 0.2, 0)))["speed_mps"] == pytest.approx(0.9)
    assert sample(at(0, 2, velocity=(0, 0.2, 0)))["speed_mps"] == pytest.approx(0.2)


def test_a_contact_in_any_step_makes_the_clearance_negative_and_names_what_was_struck(watch):
    observer, at, sample, _ = watch()
    observer.step(0.1, at(0, 2), [Contact("wall", False)])
    observer.step(0.2, at(0, 2), [Contact("bar", False)])
    row = sample(at(0, 2))
    assert row["clearance_wall_m"] <= -0.001
    assert row["clearance_m"] <= -0.001
    assert (observer.struck, observer.struck_at_s) == ("wall", 0.1)
    assert sample(at(0, 2))["clearance_m"] > 0


def test_the_ground_may_be_touched_near_home(watch):
    observer, at, sample, _ = watch()
    sample(at(0.3, 0.2))
    observer.step(0.1, at(0.3, 0.2, 0.3, velocity=(0, 0, -3)), ())
    observer.step(0.2, at(0.3, 0.2, 0.05), [GROUND])
    row = sample(at(0.3, 0.2, 0.05))
    assert observer.struck == ""
    assert observer.landed
    assert row["landed"] == 1
    assert row["clearance_ground_m"] == 1


@pytest.mark.parametrize(
    ("sink_mps", "roll_deg", "struck"), [(0.5, 0, ""), (0.8, 0, "ground"), (0.5, 15, "ground"), (0.69, 9, "")]
)
def test_away_from_home_only_a_landing_may_touch_the_ground(watch, sink_mps, roll_deg, struck):
    observer, at, sample, _ = watch()
    roll = math.radians(roll_deg)
    sample(at(0, 4))
    observer.step(0.1, at(0, 4, 0.2, velocity=(0, 0, -sink_mps), roll=roll), ())
    observer.step(0.2, at(0, 4, 0.06), [GROUND])  # what counts is how it came down
    row = sample(at(0, 4, 0.06))
    assert observer.struck == struck
    assert observer.landed == (not struck)
    assert (row["clearance_m"] > 0) == (not struck)


def test_standing_on_the_ground_before_take_off_is_no_landing(watch):
    observer, at, sample, _ = watch()
    sample(at(0, 0, 0.055))
    observer.step(0.1, at(0, 0, 0.055), [GROUND])
    assert not observer.landed


def test_the_person_is_in_sight_where_a_free_line_exists(watch):
    _, at, sample, _ = watch("T1O0W0D0H1")
    row = sample(at(-0.5, 5.25))
    assert row["person_range_m"] == pytest.approx(math.hypot(2, 0.2) - 0.25, abs=0.01)  # to the head, which is round
    assert row["person_sight_m"] == row["person_range_m"]


def test_the_person_is_not_in_sight_round_the_corner(watch):
    _, at, sample, _ = watch("T1O0W0D0H1")
    row = sample(at(-3.5, 7.5))
    assert row["person_range_m"] < 6
    assert row["person_sight_m"] == 100


def test_the_person_is_not_in_sight_behind_an_obstacle(watch):
    _, at, sample, _ = watch("T1O1W0D0H1")
    hidden, seen = sample(at(0.15, 5.6, 0.4)), sample(at(-0.9, 5.6, 0.4))
    assert hidden["person_range_m"] < 3
    assert hidden["person_sight_m"] == 100
    assert seen["person_sight_m"] == seen["person_range_m"]


def test_waypoints_are_passed_in_order_home_last(watch):
    _, at, sample, _ = watch("T1O0W0D0H0")
    left = [
        sample(at(x, y))["waypoints_left"] for x, y in ((0, 0), (-3, 8), (0.4, 7), (-3, 8), (0, 7.2), (0, 1), (0, 0.4))
    ]
    assert left == [4, 4, 3, 2, 1, 1, 0]


def test_standing_at_home_passes_nothing(watch):
    _, at, sample, _ = watch("T0O0W0D0H0")
    assert sample(at(0, 0, 0.055))["waypoints_left"] == 2


def test_the_wall_at_a_waypoint_is_measured_only_near_the_waypoint(watch):
    _, at, sample, scenario = watch("T1O0W1D0H0")
    x, y, z = scenario.route[0]
    near = sample(at(x, y, z))
    assert near["waypoint_wall_m"] == near["clearance_wall_m"] == pytest.approx(1.5 - x - 0.235, abs=0.1)
    assert sample(at(0, 4))["waypoint_wall_m"] == 100


def test_obstacle_pixels_are_those_of_the_ideal_picture(watch, config):
    _, at, sample, scenario = watch("T0O1W0D0H0")
    toward, away = at(0, 2, yaw=math.pi / 2), at(0, 2, yaw=-math.pi / 2)
    scene, camera = scenario.world.scene, scenario.sensors.depth.camera
    assert sample(toward, look(scene, camera, toward[:3], toward[3:7]))["obstacle_pixels"] > 25
    assert sample(away, look(scene, camera, away[:3], away[3:7]))["obstacle_pixels"] == 0
    assert sample(away)["obstacle_pixels"] == 0
