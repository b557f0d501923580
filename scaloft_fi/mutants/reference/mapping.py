"""Operators on the obstacle map (message `ObstacleMap`) and on the cells that it forgets (message `Clearing`)."""

from __future__ import annotations

import math

import numpy as np

from scaloft_fi.mutants.operator import (
    Degrees,
    Example,
    Facts,
    Metres,
    Period,
    Samples,
    Seconds,
    Share,
    Tap,
    TapContext,
    operator,
    the,
)
from scaloft_fi.mutants.sample import AtEach, on_each
from scaloft_fi.stack.messages import Array
from scaloft_fi.stack.reference.messages import Clearing, ObstacleMap

_HERE = np.array([0.0, 0.0, 1.5])


def _map(*points: tuple[float, float, float]) -> ObstacleMap:
    return ObstacleMap(0.0, np.array(points, dtype=float).reshape(-1, 3), 1.0, _HERE)


def _clearing(*forget: int) -> Clearing:
    return Clearing(0.0, np.array(forget, dtype=np.int64), np.array([3, 5, 8], dtype=np.int64))


@operator(
    "empty_map", need=the(ObstacleMap), example=Example(ObstacleMap, {}, (_map((1.0, 0.0, 1.5)), None), (_map(), None))
)
def empty_map(_context: TapContext) -> Tap:
    """Send the planner a map without obstacles: the map's topic is not connected."""
    return on_each(lambda sent: sent._replace(points=sent.points[:0].copy()))


@operator(
    "lose_points",
    need=the(ObstacleMap),
    example=Example(
        ObstacleMap, {"share": 0.25}, (_map((0.0, 1.0, 1.5), (1.0, 0.0, 1.5)), None), (_map((1.0, 0.0, 1.5)), None)
    ),
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


@operator(
    "invert_map",
    need=the(ObstacleMap),
    example=Example(
        ObstacleMap,
        {},
        (_map((0.375, 0.075, 1.575), (0.375, 0.225, 1.575)), None),
        _swaps_free_and_occupied,
        Facts(settings={"memory": {"voxel_m": 0.15}}),
    ),
)
def invert_map(context: TapContext, *, radius_m: Metres = 1.5) -> Tap:
    """Send the planner the free cells around the vehicle in place of the occupied ones: inverted polarity.

    Cells have the memory's edge; those within `radius_m` [m] count, with one layer above and one below the vehicle.
    """
    cell_m = context.facts.settings["memory"]["voxel_m"]
    return on_each(lambda sent: sent._replace(points=_free_cells(sent.points, sent.origin, cell_m, radius_m)))


@operator(
    "shift_map",
    need=the(ObstacleMap),
    example=Example(ObstacleMap, {"distance_m": 0.5}, (_map((1.0, 2.0, 1.5)), None), (_map((1.5, 2.0, 1.5)), None)),
)
def shift_map(_context: TapContext, *, distance_m: Metres, bearing_deg: Degrees = 0.0) -> Tap:
    """Shift the map against the world by `distance_m` [m] towards `bearing_deg` [deg from x, world].

    A wrong frame offset.
    """
    angle_rad = math.radians(bearing_deg)
    offset = distance_m * np.array([math.cos(angle_rad), math.sin(angle_rad), 0.0])
    return on_each(lambda sent: sent._replace(points=sent.points + offset))


@operator(
    "rotate_map",
    need=the(ObstacleMap),
    example=Example(ObstacleMap, {"angle_deg": 90.0}, (_map((1.0, 2.0, 1.5)), None), (_map((-2.0, 1.0, 1.5)), None)),
)
def rotate_map(_context: TapContext, *, angle_deg: Degrees) -> Tap:
    """Rotate the map about the world's origin by `angle_deg` [deg, left positive].

    A wrong heading at the start of the map.
    """
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return on_each(lambda sent: sent._replace(points=sent.points @ turn))


@operator(
    "never_clear", need=the(Clearing), example=Example(Clearing, {}, (_clearing(3, 5), None), (_clearing(), None))
)
def never_clear(_context: TapContext) -> Tap:
    """Forget no cell: neither age nor seeing through a cell removes an obstacle."""
    return on_each(lambda clearing: clearing._replace(forget=clearing.forget[:0].copy()))


@operator(
    "clear_all",
    need=the(Clearing),
    example=Example(
        Clearing,
        {"period_s": 0.1},
        (_clearing(3), _clearing(), _clearing(5)),
        (_clearing(3), _clearing(), _clearing(3, 5, 8)),
    ),
)
def clear_all(context: TapContext, *, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
    """Forget all occupied cells at once, each `period_s` [s]: the map server restarts."""
    windows = context.windows(period_s, phase_s, period_s)
    return AtEach(windows, lambda clearing: clearing._replace(forget=clearing.occupied.copy()))
