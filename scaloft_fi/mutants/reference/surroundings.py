"""Operators on the pose estimate, the obstacle map, the collision flag and what raises that flag."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, Literal

import numpy as np

from scaloft_fi.mutants.operator import (
    TOLERANCE_S,
    Degrees,
    Facts,
    Hold,
    Metres,
    Period,
    Samples,
    Seconds,
    Share,
    Tap,
    TapContext,
    on,
)
from scaloft_fi.mutants.sample import Remembering, at_each, on_each
from scaloft_fi.stack.messages import Array, Bumper
from scaloft_fi.stack.reference.messages import Clearing, CollisionFlag, ObstacleMap, PoseEstimate, Proximity

on_pose = partial(on, PoseEstimate)
on_obstacles = partial(on, ObstacleMap)
on_clearing = partial(on, Clearing)
on_flag = partial(on, CollisionFlag)


def _pose(x: float, y: float, yaw_rad: float = 0.0) -> PoseEstimate:
    attitude = np.array([0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)])
    return PoseEstimate(0.0, np.array([x, y, 1.65]), np.zeros(3), yaw_rad, attitude)


def turned(attitude: Array, angle_rad: float) -> Array:
    """`attitude` (4,) quaternion x, y, z, w, turned about the world's z axis by `angle_rad` [rad]."""
    s, c = math.sin(angle_rad / 2), math.cos(angle_rad / 2)
    x, y, z, w = attitude
    return np.array([c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z])


@on_pose(
    "hold_component",
    {"component": "yaw"},
    (_pose(0.0, 0.0, 1.5), None, _pose(0.0, 1.0, 0.5)),
    (_pose(0.0, 0.0, 1.5), None, _pose(0.0, 1.0, 1.5)),
)
def hold_component(_context: TapContext, *, component: Literal["x", "y", "z", "yaw"]) -> Tap:
    """Keep one component of the position [m, world], or the heading, at its first value: one measurement is not fused.

    A held heading turns the attitude too, so that all consumers receive the same heading.
    """

    def step(own: Any, _t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        if component == "yaw":
            own.held = sample.yaw_rad if own.held is None else own.held
            return sample._replace(yaw_rad=own.held, attitude=turned(sample.attitude, own.held - sample.yaw_rad))
        axis = "xyz".index(component)
        own.held = float(sample.position[axis]) if own.held is None else own.held
        position = sample.position.copy()
        position[axis] = own.held
        return sample._replace(position=position)

    return Remembering(step, held=None)


@on_pose(
    "reset_origin",
    {"at_s": 0.05},
    (_pose(1.0, 2.0), _pose(1.0, 3.0), _pose(1.0, 4.0)),
    (_pose(1.0, 2.0), _pose(0.0, 0.0), _pose(0.0, 1.0)),
)
def reset_origin(_context: TapContext, *, at_s: Seconds = 20.0) -> Tap:
    """From `at_s` [s] on, count x and y from where the vehicle was then.

    An estimator that restarts in flight; height is kept.
    """

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        if sample is None or t_s < at_s - TOLERANCE_S:
            return sample
        if own.origin is None:
            own.origin = sample.position * np.array([1.0, 1.0, 0.0])
        return sample._replace(position=sample.position - own.origin)

    return Remembering(step, origin=None)


_HERE = np.array([0.0, 0.0, 1.5])


def _map(*points: tuple[float, float, float]) -> ObstacleMap:
    return ObstacleMap(0.0, np.array(points, dtype=float).reshape(-1, 3), 1.0, _HERE)


def _clearing(*forget: int) -> Clearing:
    return Clearing(0.0, np.array(forget, dtype=np.int64), np.array([3, 5, 8], dtype=np.int64))


@on_obstacles("empty_map", {}, (_map((1.0, 0.0, 1.5)), None), (_map(), None))
def empty_map(_context: TapContext) -> Tap:
    """Send the planner a map without obstacles: the map's topic is not connected."""
    return on_each(lambda sent: sent._replace(points=sent.points[:0].copy()))


@on_obstacles(
    "lose_points", {"share": 0.25}, (_map((0.0, 1.0, 1.5), (1.0, 0.0, 1.5)), None), (_map((1.0, 0.0, 1.5)), None)
)
def lose_points(context: TapContext, *, share: Share) -> Tap:
    """Lose the points in a sector of `share` (0..1) of all directions from the vehicle: a tile that is not loaded.

    The sector's middle is the direction of the first leg, along the wall on the leg's right where there is one.
    """
    half_rad, centre_rad = math.pi * share, context.facts.bearing_rad

    def partial(sent: ObstacleMap) -> ObstacleMap:
        away = sent.points - sent.origin
        off_rad = np.arctan2(away[:, 1], away[:, 0]) - centre_rad
        off_rad = np.abs((off_rad + math.pi) % (2 * math.pi) - math.pi)
        return sent._replace(points=sent.points[off_rad > half_rad])

    return on_each(partial)


def _free_cells(occupied: Array, origin: Array, cell_m: float, radius_m: float) -> Array:
    """Centres (N, 3) [m, world] of the cells around `origin` without one of `occupied` (M, 3) in them."""
    reach = math.ceil(radius_m / cell_m)
    steps = np.arange(-reach, reach + 1)
    grid = np.stack(np.meshgrid(steps, steps, [-1, 0, 1], indexing="ij"), axis=-1)
    here = np.floor(origin / cell_m).astype(int)
    free = np.hypot(grid[..., 0], grid[..., 1]) * cell_m <= radius_m
    taken = np.floor(occupied / cell_m).astype(int) - here + (reach, reach, 1)
    within = ((taken >= 0) & (taken < free.shape)).all(axis=1)
    free[tuple(taken[within].T)] = False
    centres: Array = (grid[free] + here + 0.5) * cell_m
    return centres


def _swaps_free_and_occupied(before: Samples, after: Samples) -> bool:
    wall, inverted = before[0].points, after[0].points
    gaps_m = np.linalg.norm(inverted[:, None, :] - wall[None, :, :], axis=2).min(axis=1)
    return after[1] is None and len(inverted) > 0 and bool(np.all(gaps_m > 0.1))


@on_obstacles(
    "invert_map",
    {},
    (_map((0.375, 0.075, 1.575), (0.375, 0.225, 1.575)), None),
    _swaps_free_and_occupied,
    facts=Facts(settings={"memory": {"voxel_m": 0.15}}),
)
def invert_map(context: TapContext, *, radius_m: Metres = 1.5) -> Tap:
    """Send the planner the free cells around the vehicle in place of the occupied ones: inverted polarity.

    Cells have the memory's edge; those within `radius_m` [m] count, with one layer above and one below the vehicle.
    """
    cell_m = context.facts.settings["memory"]["voxel_m"]
    return on_each(lambda sent: sent._replace(points=_free_cells(sent.points, sent.origin, cell_m, radius_m)))


@on_obstacles("shift_map", {"distance_m": 0.5}, (_map((1.0, 2.0, 1.5)), None), (_map((1.5, 2.0, 1.5)), None))
def shift_map(_context: TapContext, *, distance_m: Metres, bearing_deg: Degrees = 0.0) -> Tap:
    """Shift the map against the world by `distance_m` [m] towards `bearing_deg` [deg from x, world].

    A wrong frame offset.
    """
    angle_rad = math.radians(bearing_deg)
    offset = distance_m * np.array([math.cos(angle_rad), math.sin(angle_rad), 0.0])
    return on_each(lambda sent: sent._replace(points=sent.points + offset))


@on_obstacles("rotate_map", {"angle_deg": 90.0}, (_map((1.0, 2.0, 1.5)), None), (_map((-2.0, 1.0, 1.5)), None))
def rotate_map(_context: TapContext, *, angle_deg: Degrees) -> Tap:
    """Rotate the map about the world's origin by `angle_deg` [deg, left positive].

    A wrong heading at the start of the map.
    """
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return on_each(lambda sent: sent._replace(points=sent.points @ turn))


@on_clearing("never_clear", {}, (_clearing(3, 5), None), (_clearing(), None))
def never_clear(_context: TapContext) -> Tap:
    """Forget no cell: neither age nor seeing through a cell removes an obstacle."""
    return on_each(lambda clearing: clearing._replace(forget=clearing.forget[:0].copy()))


@on_clearing(
    "clear_all",
    {"period_s": 0.1},
    (_clearing(3), _clearing(), _clearing(5)),
    (_clearing(3), _clearing(), _clearing(3, 5, 8)),
)
def clear_all(context: TapContext, *, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Forget all occupied cells at once, each `period_s` [s]: the map server restarts."""
    windows = context.windows(period_s, phase_s, period_s)
    return at_each(windows, lambda clearing: clearing._replace(forget=clearing.occupied.copy()))


_FLAG = CollisionFlag(0.0, 0.2)
_SECTORS = Proximity(
    0.0, np.array([1.0, 0.2, 0.3, 2.0]), np.full(4, True), np.array([0.6, 0.2, -0.2, -0.6]), 0.4, touched=False
)


@on(
    Bumper,
    "gear_as_hull",
    {},
    (Bumper(0.0, hull=False, gear=True), Bumper(0.05, hull=False, gear=False), None),
    (Bumper(0.0, hull=True, gear=True), Bumper(0.05, hull=False, gear=False), None),
)
def gear_as_hull(_context: TapContext) -> Tap:
    """Report contact of the landing gear as contact of the hull: one switch for both (seen in the published log)."""
    return on_each(lambda bumper: bumper._replace(hull=bumper.hull or bumper.gear))


@on(
    Proximity,
    "watch",
    {"share": 0.5},
    (_SECTORS, None),
    (_SECTORS._replace(watched=np.array([True, True, False, False])), None),
)
def watch(_context: TapContext, *, share: Share) -> Tap:
    """Watch only the first `share` (0..1) of the sectors, from the left: one of several sensors is not read."""

    def partly(proximity: Proximity) -> Proximity:
        kept = np.arange(len(proximity.watched)) < round(share * len(proximity.watched))
        return proximity._replace(watched=proximity.watched & kept)

    return on_each(partly)


@on_flag("invert_flag", {}, (None, _FLAG), (CollisionFlag(0.0, 0.0), None))
def invert_flag(_context: TapContext, *, bearing_deg: Degrees = 0.0) -> Tap:
    """Raise the flag at `bearing_deg` [deg, left positive] while it is not raised, and hide it while it is.

    Wrong polarity.
    """
    bearing_rad = math.radians(bearing_deg)
    return lambda t_s, sample: CollisionFlag(t_s, bearing_rad) if sample is None else None


@on_flag(
    "false_flag",
    {"hold_s": 0.05, "period_s": 0.1, "bearing_deg": 180.0},
    (None, None, None, _FLAG),
    (None, None, CollisionFlag(0.1, math.pi), _FLAG),
)
def false_flag(
    context: TapContext,
    *,
    hold_s: Hold = 0.5,
    period_s: Period = 20.0,
    phase_s: Seconds = 0.0,
    bearing_deg: Degrees = 0.0,
) -> Tap:
    """Raise the flag at `bearing_deg` [deg, left positive] without cause for `hold_s` [s] each `period_s` [s].

    Dust, an electrical glitch.  A flag that is raised with cause passes as it is.
    """
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))
    bearing_rad = math.radians(bearing_deg)

    def tap(t_s: float, sample: Any | None) -> Any | None:
        return CollisionFlag(t_s, bearing_rad) if sample is None and windows.open(t_s) else sample

    return tap
