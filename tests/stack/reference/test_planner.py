"""The local planner; its compiled parts beside slow ones that say the same; the velocity along a plan."""

import copy
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from options import usually

from scaloft_fi.stack.declaration import TICK_S
from scaloft_fi.stack.reference import planner as compiled
from scaloft_fi.stack.reference.messages import ObstacleMap, SpeedLimit
from scaloft_fi.stack.reference.planner import (
    BIN_DEG,
    COLUMNS,
    PUBLISHED,
    ROWS,
    LocalPlan,
    Planner,
    SpeedLaw,
    dilation_bins,
    shape_velocity,
    stopping_mps,
)
from tests.stack.conftest import pose_at

F = np.float32
NOTHING = np.empty((0, 3))
AHEAD = (5.0, 0.0, 1.5)


@pytest.fixture(scope="session")
def planned(config):
    """The plan of a new planner."""

    def plan(points, goal=AHEAD, inflation=1.0, **pose):
        return Planner(config.planner).plan(told(points, inflation), goal, pose_at(**pose))

    return plan


def told(points, inflation=1.0):
    return ObstacleMap(0.0, np.asarray(points, dtype=float), inflation, np.zeros(3))


def panel(x, left, right):
    """A flat obstacle across the way, `x` ahead, from `right` to `left`."""
    y, z = np.meshgrid(np.arange(right, left + 1e-9, 0.1), np.arange(0.6, 2.4, 0.1))
    return np.column_stack([np.full(y.size, x), y.ravel(), z.ravel()])


def bearing(plan):
    return math.degrees(math.atan2(plan.direction[1], plan.direction[0]))


@given(st.floats(-math.pi, math.pi), st.floats(0.5, 9.0), st.floats(-0.3, 0.3))
def test_free_flight_is_straight_to_the_goal(planned, azimuth, distance, slope):
    way = distance * np.array([math.cos(azimuth), math.sin(azimuth), slope])
    plan = planned(NOTHING, tuple(way + np.array([0.0, 0.0, 1.5])))
    assert plan.distance_m == pytest.approx(np.linalg.norm(way))
    assert plan.direction @ way / plan.distance_m > 1 - 1e-5
    assert np.linalg.norm(plan.direction) == pytest.approx(1.0, abs=1e-5)
    assert not plan.blocked


def test_it_turns_aside_from_a_wall_to_the_side_that_is_open_and_from_a_thin_bar(planned):
    assert 25 < abs(bearing(planned(panel(1.3, 0.5, -0.5)))) < 100
    assert bearing(planned(panel(1.3, 0.2, -1.5))) > 15
    assert bearing(planned(panel(1.3, 1.5, -0.2))) < -15
    bar = np.column_stack([np.full(20, 1.2), np.full(20, 0.02), np.linspace(0.2, 2.6, 20)])
    assert abs(bearing(planned(bar, (4.0, 0.0, 1.5)))) > 15


def test_mirrored_obstacles_give_a_mirrored_way(planned):
    points, mirror = np.vstack([panel(1.4, 0.33, -1.41), panel(2.6, 1.23, 0.51)]), [1, -1, 1]
    plan, mirrored = planned(points, (5.0, 0.13, 1.5)), planned(points * mirror, (5.0, -0.13, 1.5))
    assert mirrored.direction == pytest.approx(plan.direction * mirror, abs=1e-5)


def test_what_is_far_or_behind_the_goal_does_not_matter(planned, config):
    far = planned(panel(8.0 + config.planner.range_m, 0.5, -0.5), (20.0, 0.0, 1.5))
    behind = planned(panel(1.0 + config.planner.beyond_goal_m + 0.01, 2, -2), (1.0, 0.0, 1.5))
    assert [bearing(far), bearing(behind)] == pytest.approx([0.0, 0.0], abs=1e-4)


def test_near_the_goal_it_flies_straight_in_whatever_the_map_says_and_at_the_goal_nowhere(planned):
    plan = planned(panel(0.3, 1, -1), (0.3, 0.1, 1.5))
    assert plan.direction == pytest.approx(np.array([0.3, 0.1, 0.0]) / math.hypot(0.3, 0.1))
    assert plan.expanded == 0
    there = planned(NOTHING, (0.0, 0.0, 1.5))
    assert (there.direction.any(), there.distance_m) == (False, 0.0)


def test_more_inflation_keeps_farther_away_within_the_histograms_width(planned):
    turned = [abs(bearing(planned(panel(0.9, 0.1, -0.1), (5.0, 0.02, 1.5), factor))) for factor in (0.0, 0.5, 1.0, 2.0)]
    assert turned == sorted(set(turned))
    bins = [dilation_bins(9, factor) for factor in (0.0, 0.5, 1.0, 2.0, 100.0, -1.0, math.nan)]
    assert bins == [0, 4, 9, 18, 29, 0, 9]


def test_a_way_towards_something_near_is_called_blocked(planned):
    ring = np.array([[math.cos(t), math.sin(t), 0.0] for t in np.arange(0, 2 * math.pi, 0.05)]) * 0.7
    assert planned(np.vstack([ring + np.array([0.0, 0.0, z]) for z in np.arange(0.3, 2.8, 0.1)])).blocked
    assert not planned(NOTHING).blocked


def test_it_holds_on_to_the_side_it_chose_and_copies_plan_alike(config, planned):
    planner, slightly_right = Planner(config.planner), told(panel(1.3, 0.51, -0.49))
    first = planner.plan(told(panel(1.3, 0.49, -0.51)), AHEAD, pose_at())
    twin = copy.deepcopy(planner)
    second, same = (one.plan(slightly_right, AHEAD, pose_at()) for one in (planner, twin))
    assert bearing(first) == pytest.approx(-bearing(planned(slightly_right.points)), abs=1e-4)
    assert bearing(second) == pytest.approx(bearing(first), abs=1e-4)
    assert np.array_equal(second.direction, same.direction)


def test_the_tree_stops_early_at_a_near_goal(planned, config):
    expanded = [planned(NOTHING, (x, 0.0, 1.5)).expanded for x in (1.4, 50.0)]
    assert expanded == [2, config.planner.expansions]


@pytest.mark.parametrize("x", [math.nan, math.inf])
def test_a_diverged_estimate_gives_no_direction_and_points_that_are_no_numbers_are_ignored(planned, x):
    plan, points = planned(panel(1.3, 1, -1), x=x), panel(1.3, 0.5, -0.6)
    assert not plan.direction.any()
    assert plan.blocked
    odd = np.vstack([points, [[x, 0, 1.5], [1e300, 1, 1]]])
    assert np.array_equal(planned(points).direction, planned(odd).direction)


def clouds(n=80):
    rows = st.lists(st.tuples(*[st.floats(-3, 3, width=32)] * 3), max_size=n)
    return rows.map(lambda points: np.array(points, dtype=np.float32).reshape(-1, 3))


def slow_histogram(points, node, near, far):
    """Distance of the nearest point of each bin, and whether no bin and no membership hangs on the last bit."""
    nearest, clear = np.full((ROWS, COLUMNS), np.inf), True
    for x, y, z in points.astype(float) - node:
        distance = math.sqrt(x * x + y * y + z * z)
        turns = math.degrees(math.atan2(y, x)) / BIN_DEG, math.degrees(math.atan2(z, math.hypot(x, y))) / BIN_DEG
        clear &= all(abs(turn - round(turn)) > 1e-3 for turn in turns)
        clear &= all(abs(distance - limit) > 1e-3 for limit in (near, far))
        if near <= distance < far:
            e, a = min(int(turns[1] + 90 / BIN_DEG), ROWS - 1), int(turns[0] + 180 / BIN_DEG) % COLUMNS
            nearest[e, a] = min(nearest[e, a], distance)
    return nearest.reshape(-1), clear


def fast_histogram(points, node, far):
    nearest = np.empty(ROWS * COLUMNS, np.float32)
    x, y, z = (np.ascontiguousarray(axis) for axis in points.T)
    compiled.histogram(x, y, z, tuple(map(F, node)), F(0.2), F(far), nearest)
    return nearest


@settings(max_examples=usually(25, release=60))
@given(clouds(), st.tuples(*[st.floats(-1, 1, width=32)] * 3), st.floats(0.3, 3.0))
def test_a_bin_holds_its_nearest_point(points, node, far):
    points = points[[slow_histogram(point[None], np.array(node), 0.2, far)[1] for point in points]]
    nearest, (slow, _) = fast_histogram(points, node, far), slow_histogram(points, np.array(node), 0.2, far)
    seen = np.isfinite(slow)
    assert np.array_equal(nearest < 1e8, seen)
    assert np.sqrt(nearest[seen]) == pytest.approx(slow[seen], rel=1e-4)


@settings(max_examples=usually(25, release=60))
@given(clouds(), st.tuples(*[st.floats(-1, 1, width=32)] * 3), st.floats(0.3, 3.0), st.floats(0.5, 9.0, width=32))
def test_a_node_reaches_the_same_points_in_its_slabs_as_in_the_whole_cloud(points, node, far, reach):
    x, y, z, axis, begins = compiled.relative(points.astype(float), np.zeros(3), F(reach))
    assert sorted(zip(x, y, z, strict=True)) == sorted(
        tuple(point) for point in points if np.sum(point * point, dtype=F) < F(reach) * F(reach)
    )
    low, high = compiled.span(begins, F(node[axis]), F(far), F(reach))
    cloud = np.column_stack([x, y, z])
    assert np.array_equal(fast_histogram(cloud, node, far), fast_histogram(cloud[low:high], node, far))


def test_points_at_the_seams_of_the_sphere_have_a_bin():
    points = np.array([[-1, 0, 0], [-1, -0.0, 0], [0, 0, 1], [0, 0, -1], [0, 1, 0]], dtype=np.float32)
    assert 4 <= np.sum(fast_histogram(points, (0, 0, 0), 2.5) < 1e8) <= 5


@given(st.floats(0.2, 2.5))
def test_the_obstacle_cost_falls_from_twice_its_scale_through_it_to_nothing(distance):
    cost = np.empty(2, np.float32)
    compiled.obstacle_costs(np.array([distance**2, 1e9], dtype=np.float32), F(5000), F(1.1), F(0.2), cost)
    q = (1.1 - distance) / 0.2
    assert cost == pytest.approx([5000 * (1 + q / math.sqrt(1 + q * q)), 0.0], abs=0.05)


def slow_dilation(cost, radius):
    out = np.zeros_like(cost)
    for e, a in np.ndindex(*cost.shape):
        for i, j in np.ndindex(2 * radius + 1, 2 * radius + 1):
            if 0 <= e + i - radius < ROWS:
                share = (1 - abs(i - radius) / (radius + 1)) * (1 - abs(j - radius) / (radius + 1))
                out[e, a] = max(out[e, a], cost[e + i - radius, (a + j - radius) % COLUMNS] * share)
    return out


@pytest.mark.parametrize("radius", [0, 1, 5, 9])
def test_the_dilation_is_the_maximum_over_a_pyramid_that_dilutes_no_thin_obstacle(radius):
    rng, out = np.random.default_rng(radius), np.zeros((ROWS, COLUMNS), np.float32)
    cost = (rng.random((ROWS, COLUMNS)) * (rng.random((ROWS, COLUMNS)) < 0.02) * 1e4).astype(np.float32)
    compiled.dilate(cost, radius, 7, 23, out)
    slow = slow_dilation(cost, radius)
    slow[:7] = slow[23:] = 0.0
    assert out == pytest.approx(slow, rel=1e-5)
    assert np.all(out[7:23] >= cost[7:23])


@settings(max_examples=usually(25, release=40))
@given(
    st.tuples(*[st.floats(-5, 5, width=32)] * 3).filter(lambda goal: math.hypot(goal[0], goal[1]) > 0.1),
    st.tuples(*[st.floats(-1, 1, width=32)] * 3),
    st.integers(0, 1000),
)
def test_a_direction_costs_what_the_formula_says(config, goal, previous, seed):
    p, obstacle = config.planner, (np.random.default_rng(seed).random((ROWS, COLUMNS)) * 1e4).astype(np.float32)
    out = np.zeros((ROWS, COLUMNS), np.float32)
    angles = tuple(np.empty(size, np.float32) for size in (COLUMNS, ROWS, COLUMNS, COLUMNS, ROWS, ROWS))
    toward = compiled.aim(tuple(map(F, goal)), *angles)
    compiled.direction_costs(obstacle, toward, angles, tuple(map(F, previous)), compiled.settings(p), 7, 23, out)
    azimuth = math.degrees(math.atan2(goal[1], goal[0]))
    elevation = math.degrees(math.atan2(goal[2], math.hypot(goal[0], goal[1])))
    assert math.remainder(toward[0] - azimuth, 360) == pytest.approx(0.0, abs=1e-3)
    assert toward[1] == pytest.approx(elevation, abs=1e-3)
    assert np.abs(angles[0] - (BIN_DEG * (np.arange(COLUMNS) + 0.5) - 180)).max() <= BIN_DEG / 2 + 1e-3
    assert np.abs(angles[1] - (BIN_DEG * (np.arange(ROWS) + 0.5) - 90)).max() <= BIN_DEG / 2 + 1e-3
    yaw, pitch = angles[0][None, :].astype(float), angles[1][7:23, None].astype(float)
    level, rise = np.cos(np.radians(pitch)), np.sin(np.radians(pitch)) * np.ones_like(yaw)
    u = np.stack([level * np.cos(np.radians(yaw)), level * np.sin(np.radians(yaw)), rise])
    turned = p.yaw_cost * ((yaw - azimuth + 180) % 360 - 180) ** 2 + p.pitch_cost * (pitch - elevation) ** 2
    inertia = p.inertia_cost * (np.linalg.norm(previous) - np.tensordot(previous, u, 1))
    assert out[7:23] == pytest.approx(obstacle[7:23] + turned + inertia, rel=1e-4, abs=1.0)


angles, slopes, distances = st.floats(-math.pi, math.pi), st.floats(-1.2, 1.2), st.floats(0.0, 20.0)


@pytest.fixture(scope="session")
def shaped(config):
    """Velocity and heading along a direction."""

    def shape(azimuth=0.0, slope=0.0, distance=5.0, yaw=0.0, limit=0.5, norm="euclidean", direction=None):
        level = math.cos(slope)
        way = np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(slope)])
        plan = LocalPlan(way if direction is None else direction, distance, blocked=False, expanded=1)
        return shape_velocity(plan, pose_at(yaw=yaw), SpeedLimit(0.0, limit, norm), config.planner)

    return shape


@given(angles, slopes, distances, angles, st.floats(0.01, 2.0))
def test_no_speed_is_above_the_limit_per_axis_that_of_no_axis(shaped, azimuth, slope, distance, yaw, limit):
    assert np.linalg.norm(shaped(azimuth, slope, distance, yaw, limit)[0]) <= limit * (1 + 1e-9)
    assert np.abs(shaped(azimuth, slope, distance, yaw, limit, "per_axis")[0]).max() <= limit * (1 + 1e-9)


@given(angles)
def test_per_axis_a_diagonal_is_faster_than_the_limit(shaped, azimuth):
    speeds = [np.linalg.norm(shaped(azimuth, yaw=azimuth, limit=0.2, norm=norm)[0]) for norm in ("any", "per_axis")]
    assert speeds == pytest.approx([0.2, 0.2 / max(abs(math.cos(azimuth)), abs(math.sin(azimuth)))])


@given(angles, angles, distances)
def test_far_off_the_cameras_axis_it_only_turns(shaped, config, azimuth, yaw, distance):
    off_axis = abs(math.remainder(azimuth - yaw, 2 * math.pi))
    velocity, heading = shaped(azimuth, distance=distance, yaw=yaw)
    if off_axis >= config.planner.stop_off_axis_rad:
        assert not velocity.any()
    elif off_axis <= config.planner.full_off_axis_rad and distance >= config.planner.slow_radius_m:
        assert np.linalg.norm(velocity) == pytest.approx(0.5)
    assert math.remainder(heading - azimuth, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


@given(st.floats(0.2, 0.5), st.floats(0.2, 0.5), st.floats(0.0, 0.999))
def test_the_farther_off_axis_and_the_nearer_to_the_goal_the_slower_but_it_creeps_on(
    shaped, config, one, other, distance
):
    fast, slow = (np.linalg.norm(shaped(off_axis)[0]) for off_axis in (one, other))
    assert (fast - slow) * (one - other) <= 1e-12
    near = max(config.planner.creep_mps, config.planner.slow_gain_per_s * distance)
    assert shaped(distance=distance, limit=5.0)[0][0] == pytest.approx(near)
    assert shaped(distance=distance, limit=0.05)[0][0] == pytest.approx(0.05)


def test_straight_up_it_keeps_its_heading_and_goes_and_without_a_direction_it_stays(shaped):
    velocity, heading = shaped(direction=np.array([0.0, 0.0, 1.0]), yaw=1.0)
    assert (velocity.tolist(), heading) == ([0.0, 0.0, 0.5], 1.0)
    velocity, heading = shaped(direction=np.zeros(3), distance=0.0, yaw=0.3, norm="per_axis")
    assert (velocity.tolist(), heading) == ([0.0, 0.0, 0.0], 0.3)


@pytest.fixture(scope="session")
def numbers(config):
    """The numbers of the published speed law, in the study."""
    return replace(config.navigator, law=PUBLISHED)


class Flying:
    """A vehicle that follows the law's order at once, along x from the origin."""

    def __init__(self, numbers, goal=(20.0, 0.0, 1.5), limit=1.8):
        self.law, self.goal, self.limit = SpeedLaw(numbers), goal, limit
        self.x = self.speed = 0.0

    def tick(self, yaw=0.0, azimuth=0.0, obstacles=NOTHING):
        pose = pose_at(self.x, yaw=yaw)._replace(velocity=np.array([self.speed, 0.0, 0.0]))
        way = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        plan = LocalPlan(way, self.goal[0] - self.x, blocked=False, expanded=1)
        self.law.look(told(obstacles), plan, pose)
        velocity, heading = self.law.order(plan, self.goal, pose, SpeedLimit(0.0, self.limit, "euclidean"))
        self.speed = float(np.linalg.norm(velocity))
        self.x += float(velocity[0]) * TICK_S
        return self.speed, heading


def test_the_speed_follows_its_target_with_the_published_time_constant(numbers):
    flying = Flying(numbers)
    speeds = [flying.tick()[0] for _ in range(40)]
    share = TICK_S / (numbers.follow_s + TICK_S)
    assert speeds == pytest.approx([1.8 * (1 - (1 - share) ** (n + 1)) for n in range(40)])
    assert speeds[17] / 1.8 == pytest.approx(1 - math.exp(-1), abs=0.01)  # after 0.9 s


@given(angles, angles)
def test_the_target_falls_linearly_from_the_axis_to_the_edge_of_the_view(numbers, azimuth, yaw):
    off_axis = abs(math.remainder(azimuth - yaw, 2 * math.pi))
    flying = Flying(numbers)
    speed, heading = flying.tick(yaw, azimuth)
    target = 1.8 * max(0.0, 1 - off_axis / (0.5 * numbers.view_rad))
    assert speed == pytest.approx(target * TICK_S / (numbers.follow_s + TICK_S))
    assert math.remainder(heading - azimuth, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_after_a_turn_the_speed_that_is_left_is_flown_along_the_new_way(numbers):
    flying = Flying(numbers)
    for _ in range(100):
        flying.tick()
    before = flying.speed
    speeds = [flying.tick(azimuth=math.pi / 2)[0] for _ in range(18)]
    assert before > 1.75
    assert speeds[0] > 0.9 * before
    assert speeds[-1] == pytest.approx(before * math.exp(-1), rel=0.03)


def test_near_the_goal_the_distance_is_the_speed_and_the_heading_stays(numbers):
    flying = Flying(numbers, goal=(0.8, 0.0, 1.5))
    told_at = [flying.tick(yaw=0.3 + 0.01 * n) for n in range(400)]
    assert {heading for _, heading in told_at} == {0.3}
    assert all(speed <= 0.8 for speed, _ in told_at)
    assert flying.x == pytest.approx(0.8, abs=0.01)


@given(st.floats(1.0, 4.5), st.floats(0.2, 3.0))
def test_it_stops_before_what_it_saw_on_its_way_and_passes_what_is_beside_it(numbers, ahead, limit):
    stopping = Flying(numbers, limit=limit)
    wall = np.array([[ahead, 0.9 * numbers.side_m, 1.5]])
    for _ in range(600):
        stopping.tick(obstacles=wall)
    assert stopping.x <= ahead - numbers.ahead_m + 1e-9
    passing = Flying(numbers, limit=limit)
    for _ in range(600):
        passing.tick(obstacles=np.array([[ahead, 1.1 * numbers.side_m, 1.5]]))
    assert passing.x > ahead


@given(st.lists(st.floats(0.05, 2.0), min_size=1, max_size=20))
def test_the_speed_limit_acts_at_once(numbers, limits):
    flying = Flying(numbers)
    for flying.limit in [1.8] * 60 + limits:
        assert flying.tick()[0] <= flying.limit * (1 + 1e-9)


def test_the_way_flown_before_the_brakes_act_is_no_room(numbers):
    flying = Flying(numbers)
    for _ in range(100):
        before = flying.tick()[0]
    flying.x = 0.0
    room = 2.0 - numbers.ahead_m - numbers.delay_s * before
    speed, _ = flying.tick(obstacles=np.array([[2.0, 0.0, 1.5]]))
    assert speed == pytest.approx(stopping_mps(room, numbers.accel_mps2, numbers.jerk_mps3))


def test_on_the_way_to_the_next_goal_it_takes_a_heading_again(numbers):
    flying = Flying(numbers, goal=(0.8, 0.0, 1.5))
    assert flying.tick(yaw=0.3)[1] == 0.3
    flying.goal = (5.0, 0.0, 1.5)
    assert flying.tick(yaw=0.3)[1] == 0.0
    flying.goal = (0.8, 0.0, 1.5)
    assert flying.tick(yaw=0.1)[1] == 0.1


def test_after_a_rest_it_starts_from_standing(numbers):
    flying = Flying(numbers)
    for _ in range(60):
        flying.tick()
    flying.law.rest()
    assert flying.tick()[0] < 0.1


@given(st.floats(0.0, 50.0), st.floats(0.1, 10.0), st.floats(0.1, 20.0))
def test_the_stopping_speed_solves_its_equation(room, accel, jerk):
    u = stopping_mps(room, accel, jerk)
    assert u * u + 2 * accel * (u * accel / jerk) == pytest.approx(2 * accel * room, abs=1e-6)
