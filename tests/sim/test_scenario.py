from __future__ import annotations

import math
from itertools import pairwise

from scaloft_fi.sim.load import load

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
