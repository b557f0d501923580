"""The compiled parts beside slow ones that say the same."""

import math

import numpy as np
import pytest
from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.stack.reference import planner
from scaloft_fi.stack.reference.planner import BIN_DEG, COLUMNS, ROWS
from scaloft_fi.stack.reference.planner import settings as compiled

F = np.float32


def clouds(n=80):
    coordinate = st.floats(-3, 3, width=32)
    return st.lists(st.tuples(coordinate, coordinate, coordinate), max_size=n).map(
        lambda rows: np.array(rows, dtype=np.float32).reshape(-1, 3)
    )


def slow_histogram(points, node, near, far):
    nearest = np.full((ROWS, COLUMNS), np.inf)
    for x, y, z in points.astype(float) - node:
        distance = math.sqrt(x * x + y * y + z * z)
        if near <= distance < far:
            a = int((math.degrees(math.atan2(y, x)) + 180) / BIN_DEG) % COLUMNS
            e = min(int((math.degrees(math.atan2(z, math.hypot(x, y))) + 90) / BIN_DEG), ROWS - 1)
            nearest[e, a] = min(nearest[e, a], distance)
    return nearest


def off_edge(points, node, limits):
    """Points whose bin and whose membership do not hang on the last bit."""
    keep = []
    for x, y, z in points.astype(float) - node:
        turns = (math.degrees(math.atan2(y, x)) / BIN_DEG, math.degrees(math.atan2(z, math.hypot(x, y))) / BIN_DEG)
        distance = math.sqrt(x * x + y * y + z * z)
        keep.append(
            all(abs(turn - round(turn)) > 1e-3 for turn in turns)
            and all(abs(distance - limit) > 1e-3 for limit in limits)
        )
    return points[np.array(keep, dtype=bool)] if keep else points


@settings(max_examples=usually(25, release=60), deadline=None)
@given(clouds(), st.tuples(*[st.floats(-1, 1, width=32)] * 3), st.floats(0.3, 3.0))
def test_a_bin_holds_its_nearest_point(points, node, far):
    points = off_edge(points, np.array(node), (0.2, far))
    nearest = np.empty(ROWS * COLUMNS, np.float32)
    x, y, z = (np.ascontiguousarray(axis) for axis in points.T)
    planner.histogram(x, y, z, tuple(map(F, node)), F(0.2), F(far), nearest)
    slow = slow_histogram(points, np.array(node), 0.2, far).reshape(-1)
    assert np.array_equal(nearest < 1e8, np.isfinite(slow))
    seen = np.isfinite(slow)
    assert np.sqrt(nearest[seen]) == pytest.approx(slow[seen], rel=1e-4)


def test_points_at_the_seams_of_the_sphere_have_a_bin():
    points = np.array([[-1, 0, 0], [-1, -0.0, 0], [0, 0, 1], [0, 0, -1], [0, 1, 0]], dtype=np.float32)
    nearest = np.empty(ROWS * COLUMNS, np.float32)
    x, y, z = (np.ascontiguousarray(axis) for axis in points.T)
    planner.histogram(x, y, z, (F(0), F(0), F(0)), F(0.2), F(2.5), nearest)
    assert 4 <= np.sum(nearest < 1e8) <= 5


@given(st.floats(0.2, 2.5))
def test_the_obstacle_cost_falls_from_twice_its_scale_through_it_to_nothing(distance):
    cost = np.empty(2, np.float32)
    planner.obstacle_costs(np.array([distance**2, 1e9], dtype=np.float32), F(5000), F(1.1), F(0.2), cost)
    q = (1.1 - distance) / 0.2
    assert cost[0] == pytest.approx(5000 * (1 + q / math.sqrt(1 + q * q)), abs=0.05)
    assert cost[1] == 0.0


def slow_dilation(cost, radius):
    out = np.zeros_like(cost)
    for e, a in np.ndindex(*cost.shape):
        for i in range(-radius, radius + 1):
            for j in range(-radius, radius + 1):
                if 0 <= e + i < ROWS:
                    share = (1 - abs(i) / (radius + 1)) * (1 - abs(j) / (radius + 1))
                    out[e, a] = max(out[e, a], cost[e + i, (a + j) % COLUMNS] * share)
    return out


@pytest.mark.parametrize("radius", [0, 1, 5, 9])
def test_the_dilation_is_the_maximum_over_a_pyramid(radius):
    rng = np.random.default_rng(radius)
    cost = (rng.random((ROWS, COLUMNS)) * (rng.random((ROWS, COLUMNS)) < 0.02) * 1e4).astype(np.float32)
    out = np.zeros((ROWS, COLUMNS), np.float32)
    planner.dilate(cost, radius, 7, 23, out)
    slow = slow_dilation(cost, radius)
    assert out[7:23] == pytest.approx(slow[7:23], rel=1e-5)
    assert not out[:7].any()
    assert not out[23:].any()


def test_a_thin_obstacle_is_not_diluted():
    cost = np.zeros((ROWS, COLUMNS), np.float32)
    cost[15, 0] = 1000.0
    out = np.zeros((ROWS, COLUMNS), np.float32)
    planner.dilate(cost, 9, 7, 23, out)
    assert out[15, 0] == 1000.0
    assert out[15, 5] == out[15, COLUMNS - 5] == pytest.approx(500.0)
    assert out[15, 10] == 0.0


@settings(max_examples=usually(25, release=40), deadline=None)
@given(
    st.tuples(*[st.floats(-5, 5, width=32)] * 3).filter(lambda goal: math.hypot(goal[0], goal[1]) > 0.1),
    st.tuples(*[st.floats(-1, 1, width=32)] * 3),
    st.integers(0, 1000),
)
def test_a_direction_costs_what_the_formula_says(planner_config, goal, previous, seed):
    obstacle = (np.random.default_rng(seed).random((ROWS, COLUMNS)) * 1e4).astype(np.float32)
    out = np.zeros((ROWS, COLUMNS), np.float32)
    sizes = (COLUMNS, ROWS, COLUMNS, COLUMNS, ROWS, ROWS)
    angles = tuple(np.empty(size, np.float32) for size in sizes)
    toward = planner.aim(tuple(map(F, goal)), *angles)
    planner.direction_costs(obstacle, toward, angles, tuple(map(F, previous)), compiled(planner_config), 7, 23, out)
    azimuth = math.degrees(math.atan2(goal[1], goal[0]))
    elevation = math.degrees(math.atan2(goal[2], math.hypot(goal[0], goal[1])))
    assert math.remainder(toward[0] - azimuth, 360) == pytest.approx(0.0, abs=1e-3)
    assert toward[1] == pytest.approx(elevation, abs=1e-3)
    for e in range(7, 23):
        for a in range(0, COLUMNS, 7):
            yaw, pitch = float(angles[0][a]), float(angles[1][e])
            centre = -180 + BIN_DEG * (a + 0.5), -90 + BIN_DEG * (e + 0.5)
            assert abs(yaw - centre[0]) <= BIN_DEG / 2 + 1e-3
            assert abs(pitch - centre[1]) <= BIN_DEG / 2 + 1e-3
            turn = abs((yaw - azimuth + 180) % 360 - 180)
            u = [
                math.cos(math.radians(pitch)) * math.cos(math.radians(yaw)),
                math.cos(math.radians(pitch)) * math.sin(math.radians(yaw)),
                math.sin(math.radians(pitch)),
            ]
            expected = (
                obstacle[e, a]
                + planner_config.yaw_cost * turn**2
                + planner_config.pitch_cost * (pitch - elevation) ** 2
                + planner_config.inertia_cost * (np.linalg.norm(previous) - np.dot(u, previous))
            )
            assert out[e, a] == pytest.approx(expected, rel=1e-4, abs=1.0)
