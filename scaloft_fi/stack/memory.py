"""Obstacle memory: which cells of space were seen occupied, also where the camera does not look now.

Like the local planner of PX4-Avoidance it keeps points outside the field of view up to a maximum age and trusts the
newest frame inside it: a pixel that sees farther than a cell, or that sees nothing, clears that cell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.stack.camera import DepthCamera
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import Array, Clearing, DepthFrame, ObstacleMap, PoseEstimate

Cells = NDArray[np.int64]

_HALF, _BITS = 1 << 20, 21  # a cell is three signed 21-bit indices in one integer
_REACH_M = 1.0e5  # coordinates beyond this are those of a diverged estimate [m]
_MIX = np.uint64(0x9E3779B97F4A7C15)  # Fibonacci hashing


@dataclass(frozen=True)
class MemoryConfig:
    """Settings of the obstacle memory.

    Attributes:
        voxel_m: edge of a cell [m].
        max_age_s: how long a cell outside the view is believed [s] (PX4-Avoidance max_point_age_s).
        min_range_m: depths below are not used [m].
        max_range_m: depths beyond are not used [m].
        min_pixels: pixels of one frame that must fall into a cell to mark it.
        clear_margin_m: how much farther than a cell's centre a pixel must see to clear it [m].
        local_radius_m: the map holds the cells within this distance of the vehicle [m].
    """

    voxel_m: float = 0.15
    max_age_s: float = 20.0
    min_range_m: float = 0.3
    max_range_m: float = 5.0
    min_pixels: int = 2
    clear_margin_m: float = 0.15
    local_radius_m: float = 6.0


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
        self._fresh: Cells = np.empty(0, np.int64)  # what the last frame marked

    def __len__(self) -> int:
        return len(self._cells)

    def observe(self, frame: DepthFrame, pose: PoseEstimate) -> Clearing:
        """What would be forgotten after `frame`, seen from `pose`: cells it sees through, and cells too old.

        Keeps the cells that the frame marks until `update`; a cell that the frame marks is not forgotten.
        """
        c, camera = self.config, self.camera
        self._fresh, forget = _observe(
            frame.depth, camera.ahead_m, camera.column, camera.row, pose.position, pose.attitude,
            c.voxel_m, (c.min_range_m, c.max_range_m), c.min_pixels, c.clear_margin_m,
            self._cells, self._seen_s, frame.stamp_s - c.max_age_s,
        )  # fmt: skip
        self._frame_s = frame.stamp_s
        return Clearing(frame.stamp_s, forget, self._cells)

    def update(self, delivered: Clearing | None) -> None:
        """Forget the cells that were `delivered` (None: forget nothing), then insert what the last frame marked."""
        forget = delivered.forget if delivered is not None else _NOTHING
        self._cells, self._seen_s = _update(self._cells, self._seen_s, forget, self._fresh, self._frame_s)
        self._fresh = _NOTHING

    def map(self, pose: PoseEstimate) -> ObstacleMap:
        """The occupied cells' centres around `pose`, stamped with the newest frame's stamp."""
        points = _centres(self._cells, pose.position, self.config.voxel_m, self.config.local_radius_m)
        return ObstacleMap(self._frame_s, points, 1.0, pose.position)


def cells_at(points: Array, voxel_m: float) -> Cells:
    """Cells of the grid that hold `points` (N, 3) [m, world]."""
    i = np.floor(np.asarray(points) / voxel_m).astype(np.int64) + _HALF
    cells: Cells = (i[:, 0] << 2 * _BITS) | (i[:, 1] << _BITS) | i[:, 2]
    return cells


_NOTHING: Cells = np.empty(0, np.int64)


@jit
def _start(cell, mask):  # type: ignore[no-untyped-def]
    """Where the search for `cell` starts in a table of mask + 1 slots."""
    mixed = (np.uint64(cell) ^ (np.uint64(cell) >> np.uint64(23))) * _MIX
    return np.int64(mixed >> np.uint64(44)) & mask


@jit
def _places(cells, among):  # type: ignore[no-untyped-def]
    """The place in `among` of each of `cells`, or -1."""
    mask = 64
    while mask < 4 * len(among):
        mask *= 2
    mask -= 1
    slots = np.full(mask + 1, -1, np.int32)
    for i in range(len(among)):
        s = _start(among[i], mask)
        while slots[s] >= 0:
            s = (s + 1) & mask
        slots[s] = i
    out = np.full(len(cells), -1, np.int64)
    for i in range(len(cells)):
        s = _start(cells[i], mask)
        while slots[s] >= 0:
            if among[slots[s]] == cells[i]:
                out[i] = slots[s]
                break
            s = (s + 1) & mask
    return out


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
            i = np.int64(math.floor(px * scale)) + _HALF
            j = np.int64(math.floor(py * scale)) + _HALF
            h = np.int64(math.floor(pz * scale)) + _HALF
            cells[k] = ((i << 2 * _BITS) | (j << _BITS) | h) if used else -1


@jit
def _marked(hit, min_pixels):  # type: ignore[no-untyped-def]
    """The distinct cells of `hit` that hold at least `min_pixels`, in order of appearance."""
    mask = 64
    while mask <= len(hit):
        mask *= 2
    mask -= 1
    slots = np.full(mask + 1, np.int32(-1), np.int32)
    cells = np.empty(len(hit), np.int64)
    count = np.zeros(len(hit), np.int32)
    n, before, place = 0, np.int64(-1), 0
    for cell in hit:
        if cell < 0:
            continue
        if cell != before:  # neighbours in a row mostly share a cell
            before = cell
            s = _start(cell, mask)
            while slots[s] >= 0 and cells[slots[s]] != cell:
                s = (s + 1) & mask
            if slots[s] < 0:
                slots[s] = n
                cells[n] = cell
                n += 1
            place = slots[s]
        count[place] += 1
    kept = 0
    for i in range(n):
        if count[i] >= min_pixels:
            cells[kept] = cells[i]
            kept += 1
    return cells[:kept]


@jit
def _observe(  # type: ignore[no-untyped-def]
    depth,
    ahead_m,
    column,
    row,
    position,
    attitude,
    voxel_m,
    ranges,
    min_pixels,
    margin_m,
    cells,
    seen_s,
    oldest_s,
):
    """(cells the frame marks, cells to forget); see ObstacleMemory.observe."""
    turn = _rotation(attitude)
    a, b, c = turn
    eye = (position[0] + ahead_m * a[0], position[1] + ahead_m * b[0], position[2] + ahead_m * c[0])
    hit = np.empty(depth.size, np.int64)
    _pixel_cells(depth, column, row, eye, turn, voxel_m, ranges[0], ranges[1], hit)
    fresh = _marked(hit, min_pixels)
    marked = _places(cells, fresh)
    forget = np.empty(len(cells), np.int64)
    n = 0
    low = (1 << _BITS) - 1
    for i in range(len(cells)):
        if marked[i] >= 0:
            continue
        cell = cells[i]
        gone = seen_s[i] < oldest_s
        x = ((cell >> 2 * _BITS) - _HALF + 0.5) * voxel_m - eye[0]
        y = (((cell >> _BITS) & low) - _HALF + 0.5) * voxel_m - eye[1]
        z = ((cell & low) - _HALF + 0.5) * voxel_m - eye[2]
        ahead = x * a[0] + y * b[0] + z * c[0]
        if ahead > ranges[0] and ahead < ranges[1]:
            k = ((x * a[1] + y * b[1] + z * c[1]) / ahead - column[0]) / column[1] + 0.5
            r = ((x * a[2] + y * b[2] + z * c[2]) / ahead - row[0]) / row[1] + 0.5
            if k >= 0.0 and k < depth.shape[1] and r >= 0.0 and r < depth.shape[0]:
                d = depth[int(r), int(k)]
                gone = gone or d > ahead + margin_m or not d > 0.0
        if gone:
            forget[n] = cell
            n += 1
    return fresh, forget[:n]


@jit
def _dropped(cells, forget):  # type: ignore[no-untyped-def]
    """Which of `cells` are in `forget`; quick where these come in the same order."""
    out = np.zeros(len(cells), np.bool_)
    n = 0
    for i in range(len(cells)):
        if n < len(forget) and cells[i] == forget[n]:
            out[i] = True
            n += 1
    if n < len(forget):
        places = _places(cells, forget)
        for i in range(len(cells)):
            out[i] = places[i] >= 0
    return out


@jit
def _update(cells, seen_s, forget, fresh, stamp_s):  # type: ignore[no-untyped-def]
    """(cells, when each was last seen) after forgetting `forget` and marking `fresh`."""
    dropped = _dropped(cells, forget)
    marked = _places(cells, fresh)
    known = np.zeros(len(fresh), np.bool_)
    out = np.empty(len(cells) + len(fresh), np.int64)
    when = np.empty(len(out), np.float64)
    n = 0
    for i in range(len(cells)):
        if dropped[i]:
            continue
        out[n], when[n] = cells[i], seen_s[i]
        if marked[i] >= 0:
            known[marked[i]] = True
            when[n] = stamp_s
        n += 1
    for j in range(len(fresh)):
        if not known[j]:
            out[n], when[n] = fresh[j], stamp_s
            n += 1
    return out[:n], when[:n]


@jit
def _centres(cells, position, voxel_m, radius_m):  # type: ignore[no-untyped-def]
    """Centres (N, 3) [m, world] of the cells within `radius_m` of `position`."""
    low = (1 << _BITS) - 1
    out = np.empty((len(cells), 3))
    n = 0
    for cell in cells:
        x = ((cell >> 2 * _BITS) - _HALF + 0.5) * voxel_m
        y = (((cell >> _BITS) & low) - _HALF + 0.5) * voxel_m
        z = ((cell & low) - _HALF + 0.5) * voxel_m
        dx, dy, dz = x - position[0], y - position[1], z - position[2]
        if dx * dx + dy * dy + dz * dz < radius_m * radius_m:
            out[n, 0], out[n, 1], out[n, 2] = x, y, z
            n += 1
    return out[:n]
