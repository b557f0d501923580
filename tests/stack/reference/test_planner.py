import copy
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.stack.reference.messages import ObstacleMap
from scaloft_fi.stack.reference.planner import Planner, dilation_bins

NOTHING = np.empty((0, 3))


@pytest.fixture
def planner(planner_config):
    return Planner(planner_config)


def told(points, inflation=1.0):
    return ObstacleMap(0.0, np.asarray(points, dtype=float), inflation, np.zeros(3))


def panel(x, left, right, low=0.6, high=2.4, pitch=0.1):
    """A flat obstacle across the way, `x` ahead, from `right` to `left`."""
    y, z = np.meshgrid(np.arange(right, left + 1e-9, pitch), np.arange(low, high, pitch))
    return np.column_stack([np.full(y.size, x), y.ravel(), z.ravel()])


def bearing(plan):
    return math.degrees(math.atan2(plan.direction[1], plan.direction[0]))


@settings(deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(0.5, 9.0), st.floats(-0.3, 0.3))
def test_free_flight_is_straight_to_the_goal(planner_config, pose_at, azimuth, distance, slope):
    goal = distance * np.array([math.cos(azimuth), math.sin(azimuth), slope]) + [0.0, 0.0, 1.5]
    plan = Planner(planner_config).plan(told(NOTHING), tuple(goal), pose_at())
    way = goal - [0.0, 0.0, 1.5]
    assert plan.distance_m == pytest.approx(np.linalg.norm(way))
    assert plan.direction @ way / plan.distance_m > 1 - 1e-5
    assert np.linalg.norm(plan.direction) == pytest.approx(1.0, abs=1e-5)
    assert not plan.blocked


def test_a_wall_ahead_turns_the_vehicle_aside(planner, pose_at):
    plan = planner.plan(told(panel(1.3, 0.5, -0.5)), (5.0, 0.0, 1.5), pose_at())
    assert 25 < abs(bearing(plan)) < 100
    assert abs(plan.direction[2]) < 0.3


def test_it_turns_to_the_side_that_is_open(planner_config, pose_at):
    left = Planner(planner_config).plan(told(panel(1.3, 0.2, -1.5)), (5.0, 0.0, 1.5), pose_at())
    right = Planner(planner_config).plan(told(panel(1.3, 1.5, -0.2)), (5.0, 0.0, 1.5), pose_at())
    assert bearing(left) > 15
    assert bearing(right) < -15


def test_mirrored_obstacles_give_a_mirrored_way(planner_config, pose_at):
    points = np.vstack([panel(1.4, 0.33, -1.41), panel(2.6, 1.23, 0.51)])
    goal = (5.0, 0.13, 1.5)
    plan = Planner(planner_config).plan(told(points), goal, pose_at())
    mirrored = Planner(planner_config).plan(told(points * [1, -1, 1]), (5.0, -0.13, 1.5), pose_at())
    assert mirrored.direction == pytest.approx(plan.direction * [1, -1, 1], abs=1e-5)


def test_a_far_obstacle_does_not_matter_yet(planner, planner_config, pose_at):
    plan = planner.plan(told(panel(8.0 + planner_config.range_m, 0.5, -0.5)), (20.0, 0.0, 1.5), pose_at())
    assert bearing(plan) == pytest.approx(0.0, abs=1e-4)


def test_what_is_behind_the_goal_does_not_matter(planner, planner_config, pose_at):
    plan = planner.plan(told(panel(1.0 + planner_config.beyond_goal_m + 0.01, 2, -2)), (1.0, 0.0, 1.5), pose_at())
    assert bearing(plan) == pytest.approx(0.0, abs=1e-4)


def test_near_the_goal_it_flies_straight_in_whatever_the_map_says(planner, pose_at):
    plan = planner.plan(told(panel(0.3, 1, -1)), (0.3, 0.1, 1.5), pose_at())
    assert plan.direction == pytest.approx(np.array([0.3, 0.1, 0.0]) / math.hypot(0.3, 0.1))
    assert plan.expanded == 0


def test_at_the_goal_there_is_nowhere_to_go(planner, pose_at):
    plan = planner.plan(told(NOTHING), (0.0, 0.0, 1.5), pose_at())
    assert not plan.direction.any()
    assert plan.distance_m == 0.0


def test_more_inflation_keeps_farther_away(planner_config, pose_at):
    def turned(inflation):
        points = panel(0.9, 0.1, -0.1)
        return abs(bearing(Planner(planner_config).plan(told(points, inflation), (5.0, 0.02, 1.5), pose_at())))

    assert turned(0.0) < turned(0.5) < turned(1.0) < turned(2.0)


def test_inflation_scales_the_dilation_within_the_histograms_width():
    assert [dilation_bins(9, factor) for factor in (0.0, 0.5, 1.0, 2.0, 100.0, -1.0)] == [0, 4, 9, 18, 29, 0]
    assert dilation_bins(9, math.nan) == 9


def test_a_thin_bar_on_the_way_is_dodged(planner, pose_at):
    bar = np.column_stack([np.full(20, 1.2), np.full(20, 0.02), np.linspace(0.2, 2.6, 20)])
    assert abs(bearing(planner.plan(told(bar), (4.0, 0.0, 1.5), pose_at()))) > 15


def test_a_way_towards_something_near_is_called_blocked(planner, pose_at):
    ring = np.array([[math.cos(t), math.sin(t), 0.0] for t in np.arange(0, 2 * math.pi, 0.05)]) * 0.7
    walls = np.vstack([ring + np.array([0.0, 0.0, z]) for z in np.arange(0.3, 2.8, 0.1)])
    assert planner.plan(told(walls), (5.0, 0.0, 1.5), pose_at()).blocked
    assert not planner.plan(told(NOTHING), (5.0, 0.0, 1.5), pose_at()).blocked


def test_it_holds_on_to_the_side_it_chose(planner, planner_config, pose_at):
    slightly_left, slightly_right = panel(1.3, 0.49, -0.51), panel(1.3, 0.51, -0.49)
    first = planner.plan(told(slightly_left), (5.0, 0.0, 1.5), pose_at())
    second = planner.plan(told(slightly_right), (5.0, 0.0, 1.5), pose_at())
    fresh = Planner(planner_config).plan(told(slightly_right), (5.0, 0.0, 1.5), pose_at())
    assert bearing(first) == pytest.approx(-bearing(fresh), abs=1e-4)
    assert bearing(second) == pytest.approx(bearing(first), abs=1e-4)


def test_the_tree_stops_early_at_a_near_goal(planner, planner_config, pose_at):
    assert planner.plan(told(NOTHING), (1.4, 0.0, 1.5), pose_at()).expanded == 2
    assert planner.plan(told(NOTHING), (50.0, 0.0, 1.5), pose_at()).expanded == planner_config.expansions


@pytest.mark.parametrize("x", [math.nan, math.inf])
def test_a_diverged_estimate_gives_no_direction(planner, pose_at, x):
    plan = planner.plan(told(panel(1.3, 1, -1)), (5.0, 0.0, 1.5), pose_at(x=x))
    assert not plan.direction.any()
    assert plan.blocked


def test_points_that_are_no_numbers_are_ignored(planner_config, pose_at):
    points = panel(1.3, 0.5, -0.6)
    odd = np.vstack([points, [[math.nan, 0, 1.5], [math.inf, 0, 0], [1e300, 1, 1]]])
    a, b = (Planner(planner_config).plan(told(p), (5.0, 0.0, 1.5), pose_at()) for p in (points, odd))
    assert np.array_equal(a.direction, b.direction)


def test_copies_plan_alike(planner, pose_at):
    planner.plan(told(panel(1.3, 0.5, -0.6)), (5.0, 0.0, 1.5), pose_at())
    twin = copy.deepcopy(planner)
    for goal in ((5.0, 0.0, 1.5), (-2.0, 3.0, 1.5)):
        a, b = (p.plan(told(panel(1.2, 0.6, -0.5)), goal, pose_at()) for p in (planner, twin))
        assert np.array_equal(a.direction, b.direction)
