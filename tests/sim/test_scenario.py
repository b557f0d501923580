from __future__ import annotations

import math
from itertools import pairwise

import pytest

from scaloft_fi.sim.load import load


def scenario(config, key):
    return config.scenario(config.grid.situation(key))


def test_the_nominal_time_is_climb_turns_legs_and_landing(config):
    straight = 1.65 / 0.7 + 0.5 + 90 / 45 + 7 / 0.5 + 180 / 45 + 7 / 0.5 + 1.65 / 0.5
    assert math.isclose(scenario(config, "T0O0W0D0H0").nominal_s, straight)
    bend = math.degrees(math.atan2(3, 1))
    turning = 1.65 / 0.7 + 0.5 + (90 + bend + 180 + bend) / 45 + 2 * (7 + math.hypot(3, 1)) / 0.5 + 1.65 / 0.5
    assert math.isclose(scenario(config, "T1O0W0D0H0").nominal_s, turning)


def test_with_a_person_the_legs_are_flown_slowly(config):
    difference = scenario(config, "T0O0W0D0H1").nominal_s - scenario(config, "T0O0W0D0H0").nominal_s
    assert math.isclose(difference, 14 / 0.2 - 14 / 0.5)


def test_the_time_limit_follows_from_the_nominal_time(config):
    for situation in config.grid.situations:
        it = config.scenario(situation)
        assert math.isclose(it.t_max_s, 20 + 1.5 * it.nominal_s)


def test_a_person_comes_into_view_while_the_drone_turns_into_the_corridor(config):
    sighting_s = scenario(config, "T0O0W0D0H1").sighting_s
    turn_begins, turn_ends = 1.65 / 0.7 + 0.5, 1.65 / 0.7 + 0.5 + 90 / 45
    assert turn_begins < sighting_s <= turn_ends
    assert scenario(config, "T0O0W0D0H0").sighting_s is None


def test_a_person_that_stands_behind_rock_is_sighted_later_or_never(edited):
    config = load(edited("world.yaml", "position: [-0.5, 3.25]", "position: [-4.5, 8.0]"))
    assert scenario(config, "T1O0W0D0H1").sighting_s > 15
    assert scenario(config, "T0O0W0D0H1").sighting_s is None


def test_home_is_on_the_floor_and_the_start_half_a_hull_above(config):
    it = scenario(config, "T0O0W0D0H0")
    assert it.home == (0, 0, 0)
    assert it.start == (0, 0, 0.055)
    assert it.route == ((0, 7, 1.65), (0, 0, 1.65))


@pytest.mark.parametrize("key", ["T0O0W0D0H0", "T1O1W1D1H1"])
def test_the_nominal_flight_is_without_jumps(config, key):
    legs = list(scenario(config, key)._legs(0.5))
    for before, after in pairwise(legs):
        assert before.end == after.start
    assert legs[-1].end[:3] == (0, 0, 0)


def test_a_mission_may_fly_waypoints_at_their_own_altitudes_and_land_elsewhere(edited):
    edited("world.yaml", "corner: [0.0, 7.0]", "corner: [0.0, 7.0, 1.0]")
    config = load(edited("world.yaml", "route: [corner, home]", "route: [corner, end]"))
    it = scenario(config, "T0O0W0D0H0")
    assert it.route == ((0.0, 7.0, 1.0), (-3.0, 8.0, 1.65))
    bend = math.degrees(math.atan2(3, 1))
    legs_m = math.hypot(7, 0.65) + math.hypot(3, 1, 0.65)
    nominal_s = 1.65 / 0.7 + 0.5 + (90 + bend) / 45 + legs_m / 0.5 + 1.65 / 0.5
    assert math.isclose(it.nominal_s, nominal_s)
