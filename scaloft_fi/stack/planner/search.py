"""The compiled planner: polar histogram, obstacle dilation, costs of directions, look-ahead tree.

Everything is relative to the vehicle and in single precision: 6 deg bins need no more, and it doubles the width of the
vector units.  Grids are (elevation, azimuth): row e covers [-90 + 6 e, -84 + 6 e) deg, column a [-180 + 6 a, -174 + 6 a).
"""

from __future__ import annotations

import math

import numpy as np

from scaloft_fi.stack.kernel import jit

BIN_DEG = 6.0
ROWS, COLUMNS = 30, 60
MAX_DILATION = 29  # a wider window would wrap onto itself

_F = np.float32
_FAR = np.float32(1.0e9)
_DEG = np.float32(180.0 / math.pi)
# odd minimax polynomial of atan on [0, 1] (error below 2e-6 rad), Abramowitz and Stegun 4.4.49 in form
_A1, _A3, _A5, _A7, _A9, _A11 = (
    _F(0.99997726), _F(-0.33262347), _F(0.19354346), _F(-0.11643287), _F(0.05265332), _F(-0.01172120),
)  # fmt: skip


@jit
def _atan2_deg(y, x):  # type: ignore[no-untyped-def]
    """atan2 [deg] without branches, so that a loop over it is vectorised; 0 for the origin."""
    u, v = abs(x), abs(y)
    high = max(max(u, v), _F(1e-30))
    t = min(u, v) / high
    s = t * t
    angle = t * (_A1 + s * (_A3 + s * (_A5 + s * (_A7 + s * (_A9 + s * _A11))))) * _DEG
    angle = _F(90.0) - angle if v > u else angle
    angle = _F(180.0) - angle if x < _F(0.0) else angle
    return -angle if y < _F(0.0) else angle


@jit
def _locate(x, y, z, node, bins, square):  # type: ignore[no-untyped-def]
    """Bin (row * COLUMNS + column) and squared distance [m2] of each point, seen from `node`."""
    nx, ny, nz = node
    for i in range(len(x)):
        dx, dy, dz = x[i] - nx, y[i] - ny, z[i] - nz
        flat = dx * dx + dy * dy
        azimuth = (_atan2_deg(dy, dx) + _F(180.0)) * _F(1.0 / BIN_DEG)
        elevation = (_atan2_deg(dz, math.sqrt(flat)) + _F(90.0)) * _F(1.0 / BIN_DEG)
        a, e = np.int32(azimuth), np.int32(elevation)
        a = a - np.int32(COLUMNS) if a >= np.int32(COLUMNS) else a  # +180 deg is -180 deg
        e = np.int32(ROWS - 1) if e >= np.int32(ROWS) else e
        bins[i] = e * np.int32(COLUMNS) + a
        square[i] = flat + dz * dz


@jit
def histogram(x, y, z, node, near, far, nearest):  # type: ignore[no-untyped-def]
    """Fill `nearest` (ROWS * COLUMNS,) with the squared distance of the nearest point in each bin [m2], or a huge one."""
    bins = np.empty(len(x), np.int32)
    square = np.empty(len(x), np.float32)
    _locate(x, y, z, node, bins, square)
    nearest[:] = _FAR
    low, high = near * near, far * far
    for i in range(len(x)):
        s = square[i]
        if s >= low and s < high and s < nearest[bins[i]]:
            nearest[bins[i]] = s


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

    out[e, a] = max over |i|, |j| <= radius of cost[e + i, a + j] * k(i) * k(j), k(i) = 1 - |i| / (radius + 1): the kernel
    of PX4-Avoidance, with the maximum in place of the sum, which dilutes thin obstacles.  Azimuth wraps, elevation
    ends at the poles.  Products of non-negative numbers commute with the maximum: two passes give the whole window.
    """
    wide = np.empty(COLUMNS + 2 * radius, np.float32)
    column = np.empty(COLUMNS, np.float32)
    for e in range(first, last):
        column[:] = cost[e]
        for i in range(1, radius + 1):
            weight = _F(1.0) - _F(i) / _F(radius + 1)
            if e + i < ROWS:
                _raise(column, cost[e + i], weight)
            if e - i >= 0:
                _raise(column, cost[e - i], weight)
        wide[radius : radius + COLUMNS] = column
        wide[:radius] = column[COLUMNS - radius :]
        wide[radius + COLUMNS :] = column[:radius]
        row = out[e]
        row[:] = column
        for i in range(1, radius + 1):
            weight = _F(1.0) - _F(i) / _F(radius + 1)
            _raise(row, wide[radius - i : radius - i + COLUMNS], weight)
            _raise(row, wide[radius + i : radius + i + COLUMNS], weight)


@jit
def _raise(out, source, weight):  # type: ignore[no-untyped-def]
    """Raise `out` to `source` * `weight` where that is more."""
    for k in range(COLUMNS):
        value = source[k] * weight
        out[k] = value if value > out[k] else out[k]


@jit
def _turned(a, b):  # type: ignore[no-untyped-def]
    """Difference of two azimuths [deg], in -180..180."""
    d = a - b
    if d > _F(180.0):
        return d - _F(360.0)
    return d + _F(360.0) if d < _F(-180.0) else d


@jit
def _direction_costs(obstacle, goal, inertia, speed, p, first, last, azimuths, elevations, out):  # type: ignore[no-untyped-def]
    """Fill rows first..last-1 of `out` with the cost of flying along each bin; see `direction_costs` in the tests.

    The bins that hold the goal's azimuth and elevation stand for exactly these, so that free flight is straight.
    """
    to_azimuth = _atan2_deg(goal[1], goal[0])
    to_elevation = _atan2_deg(goal[2], math.sqrt(goal[0] * goal[0] + goal[1] * goal[1]))
    for a in range(COLUMNS):
        azimuths[a] = _F((a + 0.5) * BIN_DEG - 180.0)
    for e in range(ROWS):
        elevations[e] = _F((e + 0.5) * BIN_DEG - 90.0)
    a0 = min(max(int((to_azimuth + _F(180.0)) / _F(BIN_DEG)), 0), COLUMNS - 1)
    e0 = min(max(int((to_elevation + _F(90.0)) / _F(BIN_DEG)), 0), ROWS - 1)
    azimuths[a0], elevations[e0] = to_azimuth, to_elevation
    across = np.empty(COLUMNS, np.float32)
    along = np.empty(COLUMNS, np.float32)
    for a in range(COLUMNS):
        turn = _turned(azimuths[a], to_azimuth)
        across[a] = p.yaw_cost * turn * turn
        along[a] = math.cos(azimuths[a] / _DEG) * inertia[0] + math.sin(azimuths[a] / _DEG) * inertia[1]
    for e in range(first, last):
        pitch = elevations[e] - to_elevation
        level, rise = math.cos(elevations[e] / _DEG), math.sin(elevations[e] / _DEG) * inertia[2]
        base = _F(p.pitch_cost * pitch * pitch + p.inertia_cost * (speed - rise))
        slope = _F(p.inertia_cost * level)
        source, row = obstacle[e], out[e]
        for a in range(COLUMNS):
            row[a] = source[a] + across[a] + base - slope * along[a]


@jit
def _best(costs, first, last, least):  # type: ignore[no-untyped-def]
    """(row, column) of the least cost; `least` (ROWS,) keeps each row's least and is -1 where it must be renewed."""
    row, best = first, np.float32(np.inf)
    for e in range(first, last):
        if least[e] < 0.0:
            value = costs[e, 0]
            for a in range(1, COLUMNS):
                value = min(value, costs[e, a])
            least[e] = value
        if least[e] < best:
            row, best = e, least[e]
    for a in range(COLUMNS):
        if costs[row, a] == best:
            return row, a
    return row, 0


@jit
def search(points, origin, target, previous, radius, p):  # type: ignore[no-untyped-def]
    """First direction of the cheapest way to `target`: ((3,) unit vector, its dilated obstacle cost, nodes expanded).

    points (N, 3), origin (3,), target (3,) [m, world]; previous (3,) velocity [m/s]; radius of the dilation [bins];
    p: PlannerConfig.  Expands the node of least cost so far plus heuristic; the way is the one to the goal, or else to
    the deepest open node, the cheapest of them.
    """
    n = 0
    x, y, z = np.empty(len(points), np.float32), np.empty(len(points), np.float32), np.empty(len(points), np.float32)
    for i in range(len(points)):
        dx, dy, dz = points[i, 0] - origin[0], points[i, 1] - origin[1], points[i, 2] - origin[2]
        if dx * dx + dy * dy + dz * dz < 100.0:
            x[n], y[n], z[n] = dx, dy, dz
            n += 1
    x, y, z = x[:n], y[:n], z[:n]
    first = int(math.ceil((90.0 - p.elevation_limit_deg) / BIN_DEG - 0.5))
    last = ROWS - first
    nearest = np.empty(ROWS * COLUMNS, np.float32)
    cost = np.empty((ROWS, COLUMNS), np.float32)
    obstacle = np.zeros((ROWS, COLUMNS), np.float32)
    total = np.empty((ROWS, COLUMNS), np.float32)
    azimuths, elevations = np.empty(COLUMNS, np.float32), np.empty(ROWS, np.float32)
    least = np.empty(ROWS, np.float32)

    most = 1 + p.expansions * p.children
    place = np.zeros((most, 3), np.float32)
    heading = np.zeros((most, 3), np.float32)  # unit vector along which a node was reached
    start = np.zeros((most, 3), np.float32)  # the way's first direction
    start_cost = np.zeros(most, np.float32)
    spent = np.zeros(most, np.float32)
    left = np.zeros(most, np.float32)  # to the goal [m]
    depth = np.zeros(most, np.int32)
    is_open = np.ones(most, np.bool_)
    goal = np.empty(3, np.float32)
    for k in range(3):
        goal[k] = target[k] - origin[k]
    left[0] = math.sqrt(goal[0] * goal[0] + goal[1] * goal[1] + goal[2] * goal[2])
    pace = math.sqrt(previous[0] * previous[0] + previous[1] * previous[1] + previous[2] * previous[2])
    nodes, expanded, chosen = 1, 0, -1
    while expanded < p.expansions:
        node, value = -1, np.float32(np.inf)
        for i in range(nodes):
            f = spent[i] + _F(p.heuristic_cost) * left[i]
            if is_open[i] and f < value:
                node, value = i, f
        if node < 0:
            break
        if node > 0 and left[node] <= p.straight_in_m:
            chosen = node
            break
        is_open[node] = False
        expanded += 1
        here = (place[node, 0], place[node, 1], place[node, 2])
        far = min(p.range_m, left[node] + p.beyond_goal_m)
        histogram(x, y, z, here, _F(p.near_m), _F(far), nearest)
        obstacle_costs(
            nearest, _F(p.obstacle_cost * p.obstacle_weight), _F(p.obstacle_m), _F(p.obstacle_width_m), cost.reshape(-1)
        )
        dilate(cost, radius, first, last, obstacle)
        ahead = (goal[0] - here[0], goal[1] - here[1], goal[2] - here[2])
        if node == 0:
            inertia = (_F(previous[0]), _F(previous[1]), _F(previous[2]))
        else:
            inertia = (_F(heading[node, 0] * pace), _F(heading[node, 1] * pace), _F(heading[node, 2] * pace))
        _direction_costs(obstacle, ahead, inertia, _F(pace), p, first, last, azimuths, elevations, total)
        least[:] = -1.0
        born = 0
        step = min(_F(p.node_m), left[node])
        while born < p.children:
            e, a = _best(total, first, last, least)
            price = total[e, a]
            if not price < np.inf:
                break
            total[e, a], least[e] = np.inf, -1.0
            azimuth, elevation = azimuths[a] / _DEG, elevations[e] / _DEG
            level = math.cos(elevation)
            ux, uy, uz = level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)
            cx, cy, cz = here[0] + step * ux, here[1] + step * uy, here[2] + step * uz
            clear = True
            for i in range(nodes):
                qx, qy, qz = place[i, 0] - cx, place[i, 1] - cy, place[i, 2] - cz
                if qx * qx + qy * qy + qz * qz < p.separation_m * p.separation_m:
                    clear = False
                    break
            if not clear:
                continue
            c = nodes
            place[c, 0], place[c, 1], place[c, 2] = cx, cy, cz
            heading[c, 0], heading[c, 1], heading[c, 2] = ux, uy, uz
            if node == 0:
                start[c], start_cost[c] = heading[c], obstacle[e, a]
            else:
                start[c], start_cost[c] = start[node], start_cost[node]
            spent[c] = spent[node] + price
            depth[c] = depth[node] + 1
            gx, gy, gz = goal[0] - cx, goal[1] - cy, goal[2] - cz
            left[c] = math.sqrt(gx * gx + gy * gy + gz * gz)
            nodes += 1
            born += 1
    if chosen < 0:
        value = np.float32(np.inf)
        chosen = 0
        for i in range(1, nodes):
            f = spent[i] + _F(p.heuristic_cost) * left[i]
            if is_open[i] and (depth[i] > depth[chosen] or (depth[i] == depth[chosen] and f < value)):
                chosen, value = i, f
    return start[chosen].astype(np.float64), float(start_cost[chosen]), expanded
