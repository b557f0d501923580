"""The local planner of the 3DVFH* kind (PX4-Avoidance local_planner): histogram, costs, look-ahead tree, velocity.

Two laws make a velocity of the plan: one turns before it moves, the other is the published one.

Positions are relative to the vehicle and in single precision, which suffices for bins of 6 deg and doubles the width
of the vector units.  Grids are (elevation, azimuth): row e covers -90 + 6 e to -84 + 6 e deg, column a -180 + 6 a to
-174 + 6 a.

It deviates from its model in four ways: obstacles are dilated by the maximum instead of a sum, because a sum dilutes
thin bars; a bin holds its nearest point instead of the mean; the costs are tuned for a tunnel; a bin that holds the
goal stands for the goal's exact bearing.  Like its model it knows no hard safety margin.
"""

from __future__ import annotations

import math
from collections import namedtuple
from dataclasses import astuple, dataclass, fields
from typing import Annotated, Any, NamedTuple

import numpy as np

from scaloft_fi.marks import Bounds, Choices, Count, NotNegative, Positive
from scaloft_fi.stack.declaration import TICK_S
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import Array, Point
from scaloft_fi.stack.reference.messages import ObstacleMap, PoseEstimate, SpeedLimit


@dataclass(frozen=True)
class PlannerConfig:
    """Settings of the local planner, with the values that a vehicle of 0.5 m needs in a tunnel 3 m wide.

    Attributes:
        obstacle_cost: scale of the obstacle term (PX4-Avoidance distance cost: 5000).
        obstacle_weight: gain of the dilated obstacle term against the other costs.
        obstacle_m: distance at which the obstacle term is half its maximum [m] (PX4-Avoidance obstacle_cost_param).
        obstacle_width_m: over which distance the term falls off [m].
        dilation_bins: radius of the obstacle dilation [bins of 6 deg] at inflation 1.
        yaw_cost: per squared degree off the goal's azimuth (PX4-Avoidance: 3).
        pitch_cost: per squared degree off the goal's elevation (PX4-Avoidance: 25).
        inertia_cost: of turning by a right angle from the direction flown before (PX4-Avoidance velocity cost: 6000
            per m/s, 4000 here, at the cruise speed of 0.5 m/s).
        elevation_limit_deg: steepest direction that is considered [deg].
        range_m: points farther than this from a tree node are ignored: their cost is below 1 % of the maximum [m].
        near_m: points nearer than this to a tree node are ignored [m] (PX4-Avoidance min_sensor_range).
        node_m: length of a tree edge [m].
        expansions: tree nodes that are expanded at most.
        children: directions followed from a node at most.
        separation_m: tree nodes are at least this far apart [m] (PX4-Avoidance: 0.2).
        heuristic_cost: per metre to the goal.
        beyond_goal_m: points farther away than the goal plus this are ignored [m].
        straight_in_m: inside this distance of the goal the vehicle flies straight to it [m].
        full_off_axis_rad: up to this angle off the camera's axis the vehicle flies at full speed [rad].
        stop_off_axis_rad: from this angle on the vehicle only turns [rad].
        slow_radius_m: inside this distance of the goal the vehicle slows down [m] (PX4-Avoidance: 1 m).
        slow_gain_per_s: speed inside `slow_radius_m`, per metre to the goal [1/s].
        creep_mps: least speed inside `slow_radius_m`, unless the speed limit is lower [m/s].
    """

    obstacle_cost: NotNegative
    obstacle_weight: NotNegative
    obstacle_m: Positive
    obstacle_width_m: Positive
    dilation_bins: Annotated[int, Bounds(least=0, most=1_000)]
    yaw_cost: NotNegative
    pitch_cost: NotNegative
    inertia_cost: NotNegative
    elevation_limit_deg: Annotated[float, Bounds(least=0.0, most=90.0)]
    range_m: NotNegative
    near_m: NotNegative
    node_m: Annotated[float, Bounds(least=0.01)]
    expansions: Count
    children: Count
    separation_m: NotNegative
    heuristic_cost: NotNegative
    beyond_goal_m: NotNegative
    straight_in_m: NotNegative
    full_off_axis_rad: NotNegative
    stop_off_axis_rad: NotNegative
    slow_radius_m: NotNegative
    slow_gain_per_s: NotNegative
    creep_mps: NotNegative


# the same fields as compiled code takes them
Settings: Any = namedtuple("Settings", [field.name for field in fields(PlannerConfig)])  # type: ignore[misc]


def settings(config: PlannerConfig) -> Any:
    """`config` for compiled code."""
    return Settings(*astuple(config))


BIN_DEG = 6.0
ROWS, COLUMNS = 30, 60
MAX_DILATION = 29  # a wider window would wrap onto itself
SLABS = 64  # the points are sorted into slabs once, so that a node asks only those that it reaches

_F = np.float32
_FAR = np.float32(1.0e9)
_INFINITE = np.float32(np.inf)
_DEG = np.float32(180.0 / math.pi)
# odd minimax polynomial of atan on [0, 1], off by at most 2e-6 rad
_A1, _A3, _A5, _A7, _A9, _A11 = (
    _F(0.99997726), _F(-0.33262347), _F(0.19354346), _F(-0.11643287), _F(0.05265332), _F(-0.01172120),
)  # fmt: skip

_AZIMUTHS = ((np.arange(COLUMNS) + 0.5) * BIN_DEG - 180.0).astype(np.float32)
_ELEVATIONS = ((np.arange(ROWS) + 0.5) * BIN_DEG - 90.0).astype(np.float32)
_COSINES, _SINES = np.cos(np.radians(_AZIMUTHS)), np.sin(np.radians(_AZIMUTHS))
_LEVELS, _RISES = np.cos(np.radians(_ELEVATIONS)), np.sin(np.radians(_ELEVATIONS))


@jit
def _atan2_deg(y, x):  # type: ignore[no-untyped-def]
    """atan2 [deg] without branches, so that a loop over it is vectorised; 0 for the origin; off by at most 1e-4."""
    u, v = abs(x), abs(y)
    high = max(max(u, v), _F(1e-30))
    t = min(u, v) / high
    s = t * t
    angle = t * (_A1 + s * (_A3 + s * (_A5 + s * (_A7 + s * (_A9 + s * _A11))))) * _DEG
    angle = _F(90.0) - angle if v > u else angle
    angle = _F(180.0) - angle if x < _F(0.0) else angle
    return -angle if y < _F(0.0) else angle


@jit
def slab(along, reach):  # type: ignore[no-untyped-def]
    """Number of the slab that holds the coordinate `along`, of SLABS equal ones from -reach to reach."""
    number = np.int32((along + reach) * (_F(SLABS) / (_F(2.0) * reach)))
    return min(max(number, np.int32(0)), np.int32(SLABS - 1))


@jit
def relative(points, origin, reach):  # type: ignore[no-untyped-def]
    """The points (N, 3) within `reach` of `origin`, relative to it, in slabs across the axis x or y of most of them.

    Returns x, y, z (M,), the number of the axis, and where each slab begins (SLABS + 1,).
    """
    size = len(points)
    x, y, z, numbers = np.empty(size, _F), np.empty(size, _F), np.empty(size, _F), np.empty(size, np.int32)
    wide = 0
    for i in range(size):
        x[i], y[i], z[i] = _F(points[i, 0] - origin[0]), _F(points[i, 1] - origin[1]), _F(points[i, 2] - origin[2])
        wide += abs(y[i]) > abs(x[i])
    axis = 1 if 2 * wide > size else 0
    along = y if axis == 1 else x
    for i in range(size):  # a loop without branches, which is vectorised
        within = x[i] * x[i] + y[i] * y[i] + z[i] * z[i] < reach * reach
        numbers[i] = slab(along[i], reach) if within else np.int32(SLABS)
    begins = np.zeros(SLABS + 2, np.int64)
    for i in range(size):
        begins[numbers[i] + 1] += 1
    for k in range(SLABS + 1):
        begins[k + 1] += begins[k]
    place, cloud = begins.copy(), np.empty((3, size), _F)
    for i in range(size):
        n = place[numbers[i]]
        cloud[0, n], cloud[1, n], cloud[2, n] = x[i], y[i], z[i]
        place[numbers[i]] = n + 1
    kept = begins[SLABS]
    return cloud[0][:kept], cloud[1][:kept], cloud[2][:kept], axis, begins[: SLABS + 1]


@jit
def span(begins, along, far, reach):  # type: ignore[no-untyped-def]
    """First point and end of the slabs that hold every point within `far` of the coordinate `along`."""
    far += _F(0.01) + _F(1e-6) * reach  # against rounding
    return begins[slab(along - far, reach)], begins[slab(along + far, reach) + 1]


@jit
def histogram(x, y, z, node, near, far, nearest):  # type: ignore[no-untyped-def]
    """Fill `nearest` (ROWS * COLUMNS,) with the squared distance of the nearest point of each bin [m2], or a huge one.

    Of the points x, y, z (N,) those count that are `near` to `far` away from `node`.
    """
    nx, ny, nz = node
    low, high = near * near, far * far
    bins, square = np.empty(len(x), np.int32), np.empty(len(x), np.float32)
    for i in range(len(x)):  # a loop without branches, which is vectorised
        dx, dy, dz = x[i] - nx, y[i] - ny, z[i] - nz
        flat = dx * dx + dy * dy
        azimuth = (_atan2_deg(dy, dx) + _F(180.0)) * _F(1.0 / BIN_DEG)
        elevation = (_atan2_deg(dz, math.sqrt(flat)) + _F(90.0)) * _F(1.0 / BIN_DEG)
        a, e = np.int32(azimuth), np.int32(elevation)
        a = a - np.int32(COLUMNS) if a >= np.int32(COLUMNS) else a  # +180 deg is -180 deg
        e = np.int32(ROWS - 1) if e >= np.int32(ROWS) else e
        s = flat + dz * dz
        bins[i] = e * np.int32(COLUMNS) + a
        square[i] = s if (s >= low) & (s < high) else _FAR
    nearest[:] = _FAR
    for i in range(len(x)):  # without a branch, too: processors would predict it wrong too often
        nearest[bins[i]] = min(nearest[bins[i]], square[i])


@jit
def obstacle_costs(nearest, scale, half, width, cost):  # type: ignore[no-untyped-def]
    """Fill `cost` with scale * (1 + q / sqrt(1 + q^2)), q = (half - distance) / width; about 0 for an empty bin."""
    for i in range(len(cost)):
        q = (half - math.sqrt(nearest[i])) / width
        value = scale * (_F(1.0) + q / math.sqrt(_F(1.0) + q * q))
        cost[i] = value if nearest[i] < _FAR else _F(0.0)


@jit
def dilate(cost, radius, first, last, out):  # type: ignore[no-untyped-def]
    """Fill rows first..last-1 of `out` with the max-dilation of `cost` (both (ROWS, COLUMNS)) by a pyramid.

    out[e, a] = max over |i|, |j| <= radius of cost[e + i, a + j] * k(i) * k(j), k(i) = 1 - |i| / (radius + 1): the
    kernel of PX4-Avoidance, with the maximum in place of the sum, which dilutes thin obstacles.  Azimuth wraps,
    elevation ends at the poles.  Non-negative factors commute with the maximum: two passes give the whole window.
    """
    wide = np.empty(COLUMNS + 2 * radius, np.float32)
    # two rows in turn: to keep or replace a number in place is a masked store, which is slow on some processors
    row, other = np.empty(COLUMNS, np.float32), np.empty(COLUMNS, np.float32)
    for e in range(first, last):
        row[:] = cost[e]
        for i in range(1, radius + 1):
            weight = _F(1.0) - _F(i) / _F(radius + 1)
            # beyond a pole the pole's own row comes again, with a smaller weight than before: no effect
            above, below = cost[min(e + i, ROWS - 1)], cost[max(e - i, 0)]
            for a in range(COLUMNS):
                other[a] = max(row[a], max(above[a], below[a]) * weight)
            row, other = other, row
        wide[radius : radius + COLUMNS] = row
        wide[:radius] = row[COLUMNS - radius :]
        wide[radius + COLUMNS :] = row[:radius]
        for i in range(1, radius + 1):
            weight = _F(1.0) - _F(i) / _F(radius + 1)
            left, right = wide[radius - i :], wide[radius + i :]
            for a in range(COLUMNS):
                other[a] = max(row[a], max(left[a], right[a]) * weight)
            row, other = other, row
        out[e] = row


@jit
def aim(goal, azimuths, elevations, cosines, sines, levels, rises):  # type: ignore[no-untyped-def]
    """Azimuth and elevation of `goal` [deg] and its bins; fills the angle that each column and row stands for.

    The bins that hold the goal's azimuth and elevation stand for exactly these, so that free flight is straight.
    """
    azimuth = _atan2_deg(goal[1], goal[0])
    elevation = _atan2_deg(goal[2], math.sqrt(goal[0] * goal[0] + goal[1] * goal[1]))
    azimuths[:], elevations[:] = _AZIMUTHS, _ELEVATIONS
    cosines[:], sines[:], levels[:], rises[:] = _COSINES, _SINES, _LEVELS, _RISES
    a = min(max(int((azimuth + _F(180.0)) / _F(BIN_DEG)), 0), COLUMNS - 1)
    e = min(max(int((elevation + _F(90.0)) / _F(BIN_DEG)), 0), ROWS - 1)
    azimuths[a], elevations[e] = azimuth, elevation
    cosines[a], sines[a] = math.cos(azimuth / _DEG), math.sin(azimuth / _DEG)
    levels[e], rises[e] = math.cos(elevation / _DEG), math.sin(elevation / _DEG)
    return azimuth, elevation


@jit
def direction_costs(  # type: ignore[no-untyped-def]
    obstacle, toward, angles, previous, p, first, last, out
):
    """Fill rows first..last-1 of `out` with the cost of flying along each bin.

    obstacle + yaw_cost * turn^2 + pitch_cost * pitch^2 + inertia_cost * (|previous| - u . previous), turn and pitch in
    deg off `toward` (azimuth, elevation), u the bin's unit vector, `previous` the direction flown before.
    """
    azimuths, elevations, cosines, sines, levels, rises = angles
    across, along = np.empty(COLUMNS, np.float32), np.empty(COLUMNS, np.float32)
    for a in range(COLUMNS):
        turn = abs(azimuths[a] - toward[0])
        turn = min(turn, _F(360.0) - turn)
        across[a] = _F(p.yaw_cost) * turn * turn
        along[a] = cosines[a] * previous[0] + sines[a] * previous[1]
    size = math.sqrt(previous[0] * previous[0] + previous[1] * previous[1] + previous[2] * previous[2])
    for e in range(first, last):
        pitch = elevations[e] - toward[1]
        base = _F(p.pitch_cost) * pitch * pitch + _F(p.inertia_cost) * (size - rises[e] * previous[2])
        slope = _F(p.inertia_cost) * levels[e]
        source, row = obstacle[e], out[e]
        for a in range(COLUMNS):
            row[a] = source[a] + across[a] + base - slope * along[a]


@jit
def _exclude(costs, angles, first, last, way, step, apart):  # type: ignore[no-untyped-def]
    """Make infinite the cost of each bin whose end point, `step` [m] along it, is nearer than `apart` to `way`."""
    x, y, z = way
    square = x * x + y * y + z * z
    _azimuths, _elevations, cosines, sines, levels, rises = angles
    least = (square + step * step - apart * apart) / (_F(2.0) * step)
    along = np.empty(COLUMNS, np.float32)
    for a in range(COLUMNS):
        along[a] = cosines[a] * x + sines[a] * y
    for e in range(first, last):
        level, rest = levels[e], least - rises[e] * z
        row = costs[e]
        for a in range(COLUMNS):
            row[a] += _INFINITE if level * along[a] > rest else _F(0.0)


@jit
def _best(costs, first, last):  # type: ignore[no-untyped-def]
    """(row, column) of the least cost; the lowest column, then row, of equals."""
    lanes, other = np.full(COLUMNS, _INFINITE, np.float32), np.empty(COLUMNS, np.float32)
    for e in range(first, last):
        row = costs[e]
        for a in range(COLUMNS):
            other[a] = row[a] if row[a] < lanes[a] else lanes[a]
        lanes, other = other, lanes
    column = 0
    for a in range(1, COLUMNS):
        if lanes[a] < lanes[column]:
            column = a
    for e in range(first, last):
        if costs[e, column] == lanes[column]:
            return e, column
    return first, column


@jit
def _grow(tree, node, here, goal, obstacle, total, angles, first, last, p):  # type: ignore[no-untyped-def]
    """Add up to p.children children to `node`, along the cheapest directions that lead to new places."""
    _azimuths, _elevations, cosines, sines, levels, rises = angles
    place, heading, start, spent, left, depth, is_open, count = tree
    nodes = count[0]
    step = min(_F(p.node_m), left[node])
    apart = _F(p.separation_m)
    for i in range(nodes):
        way = (place[i, 0] - here[0], place[i, 1] - here[1], place[i, 2] - here[2])
        if way[0] * way[0] + way[1] * way[1] + way[2] * way[2] < (step + apart) * (step + apart):
            _exclude(total, angles, first, last, way, step, apart)
    for _ in range(p.children):
        e, a = _best(total, first, last)
        price = total[e, a]
        if not price < _INFINITE:
            break
        u = (levels[e] * cosines[a], levels[e] * sines[a], rises[e])
        way = (step * u[0], step * u[1], step * u[2])
        off = (goal[0] - here[0] - way[0], goal[1] - here[1] - way[1], goal[2] - here[2] - way[2])
        for k in range(3):
            place[nodes, k] = here[k] + way[k]
            heading[nodes, k] = u[k]
            start[nodes, k] = start[node, k] if node else u[k]
        start[nodes, 3] = start[node, 3] if node else obstacle[e, a]
        spent[nodes] = spent[node] + price
        depth[nodes] = depth[node] + 1
        left[nodes] = math.sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2])
        is_open[nodes] = True
        nodes += 1
        _exclude(total, angles, first, last, way, step, apart)
        total[e, a] = _INFINITE
    count[0] = nodes


@jit
def search(points, origin, target, previous, radius, p):  # type: ignore[no-untyped-def]
    """First direction of the cheapest way to `target`: ((3,) unit vector, its dilated obstacle cost, nodes expanded).

    points (N, 3), origin (3,), target (3,) [m, world]; previous (3,) direction flown before, or zero; radius of the
    dilation [bins]; p: the planner's settings.  Expands the node of least cost so far plus heuristic; the way is the
    one that comes near the goal first, or else the one to the deepest open node, the cheapest of them.
    """
    first = math.ceil((90.0 - p.elevation_limit_deg) / BIN_DEG - 0.5)
    last = ROWS - first
    nearest = np.empty(ROWS * COLUMNS, np.float32)
    cost = np.empty((ROWS, COLUMNS), np.float32)
    flat = cost.reshape(-1)
    obstacle, total = np.empty((ROWS, COLUMNS), np.float32), np.empty((ROWS, COLUMNS), np.float32)
    columns, rows = np.empty((3, COLUMNS), np.float32), np.empty((3, ROWS), np.float32)
    angles = (columns[0], rows[0], columns[1], columns[2], rows[1], rows[2])

    most = 1 + p.expansions * p.children
    place = np.zeros((most, 3), np.float32)
    heading = np.zeros((most, 3), np.float32)  # direction along which a node was reached
    start = np.zeros((most, 4), np.float32)  # the first direction of the way there, and its obstacle cost
    spent = np.zeros(most, np.float32)
    left = np.zeros(most, np.float32)  # distance to the goal [m]
    depth = np.zeros(most, np.int32)
    is_open = np.ones(most, np.bool_)
    count = np.ones(1, np.int64)
    tree = (place, heading, start, spent, left, depth, is_open, count)
    goal = (_F(target[0] - origin[0]), _F(target[1] - origin[1]), _F(target[2] - origin[2]))
    left[0] = math.sqrt(goal[0] * goal[0] + goal[1] * goal[1] + goal[2] * goal[2])
    for k in range(3):
        heading[0, k] = previous[k]
    reach = _F(min(p.expansions * p.node_m, left[0]) + p.range_m)
    x, y, z, axis, begins = relative(points, origin, reach)
    expanded, chosen = 0, 0
    while expanded < p.expansions:
        node, value = -1, _INFINITE
        for i in range(count[0]):
            f = spent[i] + _F(p.heuristic_cost) * left[i]
            if is_open[i] and f < value:
                node, value = i, f
        if node < 0:
            break
        if left[node] <= p.straight_in_m:
            chosen = node
            break
        is_open[node] = False
        expanded += 1
        here = (place[node, 0], place[node, 1], place[node, 2])
        far = min(_F(p.range_m), left[node] + _F(p.beyond_goal_m))
        low, high = span(begins, here[1] if axis == 1 else here[0], far, reach)
        histogram(x[low:high], y[low:high], z[low:high], here, _F(p.near_m), far, nearest)
        obstacle_costs(nearest, _F(p.obstacle_cost * p.obstacle_weight), _F(p.obstacle_m), _F(p.obstacle_width_m), flat)
        dilate(cost, radius, first, last, obstacle)
        toward = aim((goal[0] - here[0], goal[1] - here[1], goal[2] - here[2]), *angles)
        before = (heading[node, 0], heading[node, 1], heading[node, 2])
        direction_costs(obstacle, toward, angles, before, p, first, last, total)
        _grow(tree, node, here, goal, obstacle, total, angles, first, last, p)
    if chosen == 0:
        value = _INFINITE
        for i in range(1, count[0]):
            f = spent[i] + _F(p.heuristic_cost) * left[i]
            if is_open[i] and (depth[i] > depth[chosen] or (depth[i] == depth[chosen] and f < value)):
                chosen, value = i, f
    return start[chosen, :3].astype(np.float64), float(start[chosen, 3]), expanded


_STEEP = 0.2  # a direction with less than this share in the plane has no bearing


def permitted_mps(direction: Array, limit: SpeedLimit) -> float:
    """Greatest speed along the unit vector `direction` (3,) within `limit` [m/s]."""
    if limit.norm == "per_axis":
        return limit.limit_mps / float(np.max(np.abs(direction)))
    return limit.limit_mps


def shape_velocity(
    plan: LocalPlan, pose: PoseEstimate, limit: SpeedLimit, config: PlannerConfig
) -> tuple[Array, float]:
    """Velocity (3,) [m/s, world] and heading to take [rad, world] to follow `plan`.

    The speed falls to zero with the angle between the plan's bearing and the camera's axis, and near the goal.  The
    heading is the plan's bearing: flight control limits how fast the vehicle turns.
    """
    x, y, z = plan.direction.tolist()
    flat, length = math.hypot(x, y), math.sqrt(x * x + y * y + z * z)
    if not length > 0.0:
        return np.zeros(3), pose.yaw_rad
    share, heading = 1.0, pose.yaw_rad
    if flat > _STEEP * length:
        heading = math.atan2(y, x)
        off_axis = abs(math.remainder(heading - pose.yaw_rad, 2.0 * math.pi))
        fade = config.stop_off_axis_rad - config.full_off_axis_rad
        share = min(max((config.stop_off_axis_rad - off_axis) / fade, 0.0), 1.0)
    speed = permitted_mps(plan.direction, limit)
    if plan.distance_m < config.slow_radius_m:
        speed = min(speed, max(config.creep_mps, config.slow_gain_per_s * plan.distance_m))
    return plan.direction * (share * speed), heading


TURNING, PUBLISHED = "turning", "published"
"""How a plan is flown: `shape_velocity`, which turns before it moves, or the published speed law of `SpeedLaw`."""


@dataclass(frozen=True)
class NavigatorConfig:
    """How a plan is flown; the numbers are those of the published speed law.

    Attributes:
        law: turning, or published.
        follow_s: with this time constant the speed follows its target [s].
        goal_m: inside this distance of the goal the target is the distance per second, and the heading stays [m].
        view_rad: width of the view; the target falls linearly from its axis to 0 at its edge [rad].
        accel_mps2: greatest deceleration [m/s2].
        jerk_mps3: how fast it grows [m/s3].
        delay_s: from a range until the vehicle brakes; the way flown meanwhile is not room [s].
        reach_m: how far the way is known to be free where nothing is seen on it [m].
        side_m: half width of the way that has to be free [m].
        ahead_m: from the vehicle's centre to its side, which the way ends before an obstacle [m].
    """

    law: Annotated[str, Choices((TURNING, PUBLISHED))]
    follow_s: Positive
    goal_m: NotNegative
    view_rad: Positive
    accel_mps2: Positive
    jerk_mps3: Positive
    delay_s: NotNegative
    reach_m: NotNegative
    side_m: NotNegative
    ahead_m: NotNegative


class SpeedLaw:
    """The published speed law of the local planner's model, which has a memory: the speed follows its target late.

    Source: PX4-Avoidance c386852c, `WaypointGenerator::adaptSpeed`, `scaleToFOV`, `LocalPlanner::getAvoidanceOutput`.
    As there, the speed that is left over after a turn is flown along the new way.  It deviates in two ways: the speed
    limit acts at once, as the velocity limit of the paper's autopilot does; and the speed from which the vehicle can
    stop, which its model takes from the range of the sensor, is taken from what was seen on the way.
    """

    def __init__(self, config: NavigatorConfig) -> None:
        self.config = config
        self._speed = 0.0
        self._heading_at_goal: float | None = None
        self._room_m = config.reach_m

    def look(self, obstacles: ObstacleMap, plan: LocalPlan, pose: PoseEstimate) -> None:
        """Measure the free way along a new plan on the map that it was made of."""
        config = self.config
        offsets = obstacles.points - pose.position
        along = offsets @ plan.direction
        beside = np.einsum("ij,ij->i", offsets, offsets) - along * along
        ahead = along[(along > 0.0) & (beside < config.side_m * config.side_m)]
        nearest = float(ahead.min()) - config.ahead_m if len(ahead) else math.inf
        self._room_m = max(0.0, min(config.reach_m, nearest))

    def rest(self) -> None:
        """Forget the speed: the vehicle holds its position or retreats."""
        self._speed, self._heading_at_goal = 0.0, None

    def order(self, plan: LocalPlan, goal: Point, pose: PoseEstimate, limit: SpeedLimit) -> tuple[Array, float]:
        """Velocity (3,) [m/s, world] and heading to take [rad, world] at a tick; `goal` (3,) is the waypoint [m]."""
        config, direction = self.config, plan.direction
        offset = np.asarray(goal, np.float64) - pose.position
        distance_m = math.sqrt(float(offset @ offset))
        if distance_m < config.goal_m:
            direction = offset / distance_m if distance_m > 0.0 else np.zeros(3)
            if self._heading_at_goal is None:
                self._heading_at_goal = pose.yaw_rad
            heading, target = self._heading_at_goal, distance_m
        else:
            self._heading_at_goal = None
            heading = math.atan2(direction[1], direction[0])
            off_axis = abs(math.remainder(heading - pose.yaw_rad, 2.0 * math.pi))
            target = limit.limit_mps * max(0.0, 1.0 - 2.0 * off_axis / config.view_rad)
        share = TICK_S / (config.follow_s + TICK_S)
        self._speed = min(share * target + (1.0 - share) * self._speed, distance_m)
        if not float(direction @ direction) > 0.0:
            return np.zeros(3), heading
        room_m = self._room_m - config.delay_s * max(0.0, float(pose.velocity @ direction))
        most = stopping_mps(max(0.0, room_m), config.accel_mps2, config.jerk_mps3)
        self._speed = min(self._speed, most, permitted_mps(direction, limit))
        return direction * self._speed, heading


def stopping_mps(room_m: float, accel_mps2: float, jerk_mps3: float) -> float:
    """Greatest speed from which a vehicle stops within `room_m` [m/s]: u^2 + 2 a (u a/j) - 2 a room = 0.

    >>> round(stopping_mps(2.0, 3.0, 4.0), 3), stopping_mps(0.0, 3.0, 4.0)
    (1.881, 0.0)
    """
    ramp = accel_mps2 * accel_mps2 / jerk_mps3
    return math.sqrt(ramp * ramp + 2.0 * accel_mps2 * room_m) - ramp


class LocalPlan(NamedTuple):
    """The direction to fly.

    direction: (3,) unit vector [world], zero at the goal itself; distance_m: to the goal [m];
    blocked: the way starts towards an obstacle nearer than the planner's half-cost distance; expanded: tree nodes.
    """

    direction: Array
    distance_m: float
    blocked: bool
    expanded: int


class Planner:
    """Plans a direction.  It remembers its last direction, because the cost of a turn is measured from there."""

    def __init__(self, config: PlannerConfig) -> None:
        self.config = config
        self._settings = settings(config)
        self._previous = np.zeros(3)

    def plan(self, obstacles: ObstacleMap, target: Point, pose: PoseEstimate) -> LocalPlan:
        """Plan from `pose` to `target` [m, world] past `obstacles`."""
        c = self.config
        goal = np.array(target, dtype=np.float64)
        offset = goal - pose.position
        distance = math.sqrt(float(offset @ offset))
        if not math.isfinite(distance):
            return LocalPlan(np.zeros(3), distance, blocked=True, expanded=0)
        if distance <= c.straight_in_m:
            direction = offset / distance if distance > 0.0 else np.zeros(3)
            return LocalPlan(direction, distance, blocked=False, expanded=0)
        radius = dilation_bins(c.dilation_bins, obstacles.inflation)
        points = np.ascontiguousarray(obstacles.points)
        direction, cost, expanded = search(points, pose.position, goal, self._previous, radius, self._settings)
        self._previous = direction
        return LocalPlan(direction, distance, cost >= c.obstacle_cost * c.obstacle_weight, expanded)


def dilation_bins(bins: int, inflation: float) -> int:
    """Radius of the dilation [bins] at `inflation`, at most what the histogram's width allows."""
    return int(min(max(round(bins * inflation), 0), MAX_DILATION)) if math.isfinite(inflation) else bins
