"""Obstacle memory: a sparse grid of the cells of space that were seen occupied, also outside the present field of view.

A cell is the index triple of a cube of edge `voxel_m`, aligned with the world's origin, packed into one integer.

Like the local planner of PX4-Avoidance it keeps points outside the field of view up to a maximum age and trusts the
newest frame inside it: a pixel that sees farther than a cell, or that sees nothing, clears that cell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.marks import Bounds, Count, NotNegative
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import Array, DepthCamera, DepthFrame
from scaloft_fi.stack.reference.messages import Clearing, ObstacleMap, PoseEstimate

Cells = NDArray[np.int64]

_HALF, _BITS = 1 << 20, 21  # a cell is three signed 21-bit indices in one integer
_REACH_M = 1.0e5  # greater coordinates belong to a diverged estimate [m]
_MIX = np.uint64(0x9E3779B97F4A7C15)  # Fibonacci hashing


def cells_at(points: Array, voxel_m: float) -> Cells:
    """Cells of the grid that hold `points` (N, 3) [m, world]."""
    i = np.floor(np.asarray(points) / voxel_m).astype(np.int64) + _HALF
    cells: Cells = (i[:, 0] << 2 * _BITS) | (i[:, 1] << _BITS) | i[:, 2]
    return cells


@jit
def _centre(cell, voxel_m):  # type: ignore[no-untyped-def]
    """Centre of `cell`: x, y, z [m]."""
    low = (1 << _BITS) - 1
    # Vector units before AVX-512 turn integers into floating point numbers only from 32 bits.
    i, j, k = np.int32(cell >> 2 * _BITS), np.int32((cell >> _BITS) & low), np.int32(cell & low)
    return (i - _HALF + 0.5) * voxel_m, (j - _HALF + 0.5) * voxel_m, (k - _HALF + 0.5) * voxel_m


@jit
def _start(cell, mask):  # type: ignore[no-untyped-def]
    """Where the search for `cell` starts in a table of mask + 1 slots."""
    mixed = (np.uint64(cell) ^ (np.uint64(cell) >> np.uint64(23))) * _MIX
    return np.int64(mixed >> np.uint64(44)) & mask


@jit
def _table(cells):  # type: ignore[no-untyped-def]
    """Hash table of the places of `cells`, -1 in empty slots, with few collisions."""
    size = 64
    while size < 4 * len(cells):
        size *= 2
    slots = np.full(size, -1, np.int32)
    for i in range(len(cells)):
        s = _start(cells[i], size - 1)
        while slots[s] >= 0:
            s = (s + 1) & (size - 1)
        slots[s] = i
    return slots


@jit
def _rotation(q):  # type: ignore[no-untyped-def]
    """Rotation matrix, body to world, of the quaternion x, y, z, w."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )


@jit
def _pixel_cells(depth, column, row, eye, turn, voxel_m, near_m, far_m, out):  # type: ignore[no-untyped-def]
    """The cell each pixel falls into, -1 where the pixel is not used."""
    scale = 1.0 / voxel_m
    a, b, c = turn
    height, width = depth.shape
    flat = depth.reshape(-1)
    for r in range(height):
        z = row[0] + r * row[1]
        base = r * width
        line, cells = flat[base : base + width], out[base : base + width]
        ax, bx, cx = a[0] + a[2] * z, b[0] + b[2] * z, c[0] + c[2] * z
        for k in range(width):
            d = line[k]
            y = column[0] + k * column[1]
            px = eye[0] + d * (ax + a[1] * y)
            py = eye[1] + d * (bx + b[1] * y)
            pz = eye[2] + d * (cx + c[1] * y)
            used = (d >= near_m) & (d <= far_m) & (abs(px) < _REACH_M) & (abs(py) < _REACH_M) & (abs(pz) < _REACH_M)
            # by way of 32 bits, as in `_centre`
            i = np.int64(np.int32(np.floor(px * scale))) + _HALF
            j = np.int64(np.int32(np.floor(py * scale))) + _HALF
            h = np.int64(np.int32(np.floor(pz * scale))) + _HALF
            cells[k] = ((i << 2 * _BITS) | (j << _BITS) | h) if used else -1


@jit
def _marked(hit, min_pixels):  # type: ignore[no-untyped-def]
    """The distinct cells of `hit` that hold at least `min_pixels`, in the order in which they reach it."""
    mask = 64
    while mask <= len(hit):  # most pixels share their cells
        mask *= 2
    mask -= 1
    keys, count = np.full(mask + 1, -1, np.int64), np.zeros(mask + 1, np.int32)
    cells = np.empty(len(hit) + 1, np.int64)
    n = 0
    for cell in hit:
        if cell < 0:
            continue
        s = _start(cell, mask)
        while (keys[s] != cell) & (keys[s] >= 0):  # one branch, mostly not taken
            s = (s + 1) & mask
        keys[s] = cell
        count[s] += 1
        cells[n] = cell
        n += count[s] == min_pixels
    return cells[:n]


@jit
def _near_view(cells, eye, turn, column, row, shape, ranges, voxel_m):  # type: ignore[no-untyped-def]
    """Places in `cells` of the cells that may be partly in view (a loop without branches, which is vectorised)."""
    a, b, c = turn
    left, right = column[0] - 0.5 * column[1], column[0] + (shape[1] - 0.5) * column[1]
    top, bottom = row[0] - 0.5 * row[1], row[0] + (shape[0] - 0.5) * row[1]
    low_y, high_y, low_z, high_z = min(left, right), max(left, right), min(top, bottom), max(top, bottom)
    near, far = ranges[0] - voxel_m, ranges[1] + voxel_m
    steepest = max(max(abs(low_y), abs(high_y)), max(abs(low_z), abs(high_z)))
    pad = 0.87 * voxel_m * math.sqrt(1.0 + steepest * steepest)  # half a cell's diagonal, against a slope
    seen = np.empty(len(cells), np.bool_)
    for i in range(len(cells)):
        x, y, z = _centre(cells[i], voxel_m)
        x, y, z = x - eye[0], y - eye[1], z - eye[2]
        ahead = x * a[0] + y * b[0] + z * c[0]
        side = x * a[1] + y * b[1] + z * c[1]
        up = x * a[2] + y * b[2] + z * c[2]
        seen[i] = (
            (ahead > near) & (ahead < far)
            & (side > low_y * ahead - pad) & (side < high_y * ahead + pad)
            & (up > low_z * ahead - pad) & (up < high_z * ahead + pad)
        )  # fmt: skip
    out = np.empty(len(cells), np.int32)
    n = 0
    for i in range(len(cells)):
        out[n] = i
        n += seen[i]
    return out[:n]


@jit
def _projected(cells, eye, turn, column, row, shape, ranges, voxel_m):  # type: ignore[no-untyped-def]
    """For each of `cells` the pixel that shows its centre, or -1, and the centre's depth [m] (vectorised as above)."""
    a, b, c = turn
    pixels, depths = np.empty(len(cells), np.int64), np.empty(len(cells))
    height, width = shape
    for i in range(len(cells)):
        x, y, z = _centre(cells[i], voxel_m)
        x, y, z = x - eye[0], y - eye[1], z - eye[2]
        ahead = x * a[0] + y * b[0] + z * c[0]
        k = ((x * a[1] + y * b[1] + z * c[1]) / ahead - column[0]) / column[1] + 0.5
        r = ((x * a[2] + y * b[2] + z * c[2]) / ahead - row[0]) / row[1] + 0.5
        shown = (
            (ahead > ranges[0]) & (ahead < ranges[1]) & (k >= 0.0) & (k < width) & (r >= 0.0) & (r < height)
        )  # fmt: skip
        pixels[i] = np.int64(r) * width + np.int64(k) if shown else -1
        depths[i] = ahead
    return pixels, depths


@jit
def observe(  # type: ignore[no-untyped-def]
    depth, ahead_m, column, row, position, attitude, voxel_m, ranges, min_pixels, margin_m, cells, seen_s, oldest_s
):
    """(cells the frame marks, their places in `cells` or -1, cells to forget); see ObstacleMemory.observe."""
    turn = _rotation(attitude)
    a, b, c = turn
    eye = (position[0] + ahead_m * a[0], position[1] + ahead_m * b[0], position[2] + ahead_m * c[0])
    height, width = depth.shape
    hit = np.empty(depth.size, np.int64)
    _pixel_cells(depth, column, row, eye, turn, voxel_m, ranges[0], ranges[1], hit)
    fresh = _marked(hit, min_pixels)
    slots = _table(fresh)
    mask = len(slots) - 1
    places = np.full(len(fresh), -1, np.int64)
    gone = seen_s < oldest_s
    near = _near_view(cells, eye, turn, column, row, (height, width), ranges, voxel_m)
    pixels, ahead = _projected(cells[near], eye, turn, column, row, (height, width), ranges, voxel_m)
    seen = depth.reshape(-1)
    for k in range(len(near)):
        i = near[k]
        cell = cells[i]
        s = _start(cell, mask)
        while slots[s] >= 0 and fresh[slots[s]] != cell:
            s = (s + 1) & mask
        if slots[s] >= 0:
            places[slots[s]], gone[i] = i, False
        elif pixels[k] >= 0:
            d = seen[pixels[k]]
            gone[i] |= d > ahead[k] + margin_m or not d > 0.0
    forget = np.empty(len(cells), np.int64)
    n = 0
    for i in range(len(cells)):
        forget[n] = cells[i]
        n += gone[i]
    return fresh, places, forget[:n]


@jit
def _dropped(cells, forget):  # type: ignore[no-untyped-def]
    """Which of `cells` are in `forget`; fast when both have the same order."""
    out = np.zeros(len(cells), np.bool_)
    n = 0
    for i in range(len(cells)):
        if n < len(forget) and cells[i] == forget[n]:
            out[i] = True
            n += 1
    if n < len(forget):
        slots = _table(forget)
        mask = len(slots) - 1
        for i in range(len(cells)):
            s = _start(cells[i], mask)
            while slots[s] >= 0 and forget[slots[s]] != cells[i]:
                s = (s + 1) & mask
            out[i] = slots[s] >= 0
    return out


@jit
def update(cells, seen_s, forget, fresh, places, stamp_s):  # type: ignore[no-untyped-def]
    """(cells, when each was last seen) after forgetting `forget` and marking `fresh`, which are at `places` or new."""
    dropped = _dropped(cells, forget)
    out = np.empty(len(cells) + len(fresh), np.int64)
    when, moved = np.empty(len(out), np.float64), np.empty(len(cells), np.int64)
    n = 0
    for i in range(len(cells)):
        out[n], when[n], moved[i] = cells[i], seen_s[i], n
        n += not dropped[i]
    for j in range(len(fresh)):
        i = places[j]
        if i >= 0 and not dropped[i]:
            when[moved[i]] = stamp_s
        else:
            out[n], when[n] = fresh[j], stamp_s
            n += 1
    return out[:n], when[:n]


@jit
def centres(cells, position, voxel_m, radius_m):  # type: ignore[no-untyped-def]
    """Centres (N, 3) [m, world] of the cells within `radius_m` of `position`."""
    size = len(cells)
    x, y, z, near = np.empty(size), np.empty(size), np.empty(size), np.empty(size, np.bool_)
    for i in range(size):  # a loop without branches, which is vectorised
        x[i], y[i], z[i] = _centre(cells[i], voxel_m)
        dx, dy, dz = x[i] - position[0], y[i] - position[1], z[i] - position[2]
        near[i] = dx * dx + dy * dy + dz * dz < radius_m * radius_m
    out = np.empty((size, 3))
    n = 0
    for i in range(size):
        out[n, 0], out[n, 1], out[n, 2] = x[i], y[i], z[i]
        n += near[i]
    return out[:n]


_NOTHING: Cells = np.empty(0, np.int64)


@dataclass(frozen=True)
class MemoryConfig:
    """Settings of the obstacle memory.

    Attributes:
        voxel_m: edge of a cell [m].
        max_age_s: how long a cell outside the view is kept [s] (PX4-Avoidance max_point_age_s).
        min_range_m: smaller depths are not used [m].
        max_range_m: greater depths are not used [m].
        min_pixels: pixels of one frame that must fall into a cell to mark it.
        clear_margin_m: how much farther than a cell's centre a pixel must see to clear it [m].
        local_radius_m: the map holds the cells within this distance of the vehicle [m].
    """

    voxel_m: Annotated[float, Bounds(least=0.01, most=100.0)]
    max_age_s: NotNegative
    min_range_m: NotNegative
    max_range_m: NotNegative
    min_pixels: Count
    clear_margin_m: NotNegative
    local_radius_m: NotNegative


class ObstacleMemory:
    """Sparse set of occupied cells, in the order in which they were first seen.

    Cells are indices of an unbounded grid of edge `voxel_m` aligned with the world's origin; see `cells_at`.
    """

    def __init__(self, config: MemoryConfig, camera: DepthCamera) -> None:
        self.config = config
        self.camera = camera
        self._cells: Cells = np.empty(0, np.int64)
        self._seen_s: Array = np.empty(0)
        self._frame_s = -math.inf
        self._fresh: Cells = np.empty(0, np.int64)  # cells that the newest frame marks
        self._places: Cells = np.empty(0, np.int64)  # their places in _cells, or -1

    def __len__(self) -> int:
        return len(self._cells)

    def observe(self, frame: DepthFrame, pose: PoseEstimate) -> Clearing:
        """The cells to forget after `frame`, taken from `pose`: cells that it sees through, and cells that are too old.

        Keeps the cells that the frame marks until `update`; none of them is forgotten.
        """
        c, camera = self.config, self.camera
        self._fresh, self._places, forget = observe(
            np.ascontiguousarray(frame.depth), camera.ahead_m, camera.column, camera.row, pose.position, pose.attitude,
            c.voxel_m, (c.min_range_m, c.max_range_m), c.min_pixels, c.clear_margin_m,
            self._cells, self._seen_s, frame.stamp_s - c.max_age_s,
        )  # fmt: skip
        self._frame_s = frame.stamp_s
        return Clearing(frame.stamp_s, forget, self._cells)

    def update(self, delivered: Clearing | None) -> None:
        """Forget the cells that were `delivered` (None: no cell), then insert the cells that the last frame marked."""
        forget = np.ascontiguousarray(delivered.forget) if delivered is not None else _NOTHING
        self._cells, self._seen_s = update(self._cells, self._seen_s, forget, self._fresh, self._places, self._frame_s)
        self._fresh = self._places = _NOTHING

    def map(self, pose: PoseEstimate) -> ObstacleMap:
        """The occupied cells' centres around `pose`, stamped with the newest frame's stamp."""
        points = centres(self._cells, pose.position, self.config.voxel_m, self.config.local_radius_m)
        return ObstacleMap(self._frame_s, points, 1.0, pose.position)
