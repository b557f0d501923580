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
        self._places: Cells = np.empty(0, np.int64)  # where these are known already, or -1

    def __len__(self) -> int:
        return len(self._cells)

    def observe(self, frame: DepthFrame, pose: PoseEstimate) -> Clearing:
        """What would be forgotten after `frame`, seen from `pose`: cells it sees through, and cells too old.

        Keeps the cells that the frame marks until `update`; a cell that the frame marks is not forgotten.
        """
        c, camera = self.config, self.camera
        self._fresh, self._places, forget = _observe(
            frame.depth, camera.rays, camera.ahead_m, camera.column, camera.row, pose.position, pose.attitude,
            c.voxel_m, (c.min_range_m, c.max_range_m), c.min_pixels, c.clear_margin_m,
            self._cells, self._seen_s, frame.stamp_s - c.max_age_s,
        )  # fmt: skip
        self._frame_s = frame.stamp_s
        return Clearing(frame.stamp_s, forget, self._cells)

    def update(self, delivered: Clearing | None) -> None:
        """Forget the cells that were `delivered` (None: forget nothing), then insert what the last frame marked."""
        forget = delivered.forget if delivered is not None else _NOTHING
        self._cells, self._seen_s = _update(self._cells, self._seen_s, forget, self._fresh, self._places, self._frame_s)
        self._fresh = self._places = _NOTHING

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
def _slot(cell, mask):  # type: ignore[no-untyped-def]
    """Where the search for `cell` starts in a table of mask + 1 slots."""
    mixed = (np.uint64(cell) ^ (np.uint64(cell) >> np.uint64(23))) * _MIX
    return np.int64(mixed >> np.uint64(44)) & mask


@jit
def _table(cells):  # type: ignore[no-untyped-def]
    """Hash table over `cells`: (slots, with the place in `cells` or -1; mask)."""
    size = 64
    while size < 4 * len(cells):
        size *= 2
    mask = size - 1
    slots = np.full(size, np.int32(-1), np.int32)
    for i in range(len(cells)):
        s = _slot(cells[i], mask)
        while slots[s] >= 0:
            s = (s + 1) & mask
        slots[s] = i
    return slots, mask


@jit
def _find(slots, mask, cells, cell):  # type: ignore[no-untyped-def]
    """Place of `cell` in `cells`, or -1."""
    s = _slot(cell, mask)
    while slots[s] >= 0:
        if cells[slots[s]] == cell:
            return slots[s]
        s = (s + 1) & mask
    return np.int32(-1)


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
def _pixel_cells(depth, rays, eye, turn, voxel_m, near_m, far_m, out):  # type: ignore[no-untyped-def]
    """The cell each pixel falls into, -1 where the pixel is not used."""
    scale = 1.0 / voxel_m
    a, b, c = turn
    n = 0
    for r in range(depth.shape[0]):
        for k in range(depth.shape[1]):
            d = depth[r, k]
            y, z = rays[r, k, 1], rays[r, k, 2]
            px = eye[0] + d * (a[0] + a[1] * y + a[2] * z)
            py = eye[1] + d * (b[0] + b[1] * y + b[2] * z)
            pz = eye[2] + d * (c[0] + c[1] * y + c[2] * z)
            used = (d >= near_m) & (d <= far_m) & (abs(px) < _REACH_M) & (abs(py) < _REACH_M) & (abs(pz) < _REACH_M)
            if used:
                i = np.int64(math.floor(px * scale)) + _HALF
                j = np.int64(math.floor(py * scale)) + _HALF
                h = np.int64(math.floor(pz * scale)) + _HALF
                out[n] = (i << 2 * _BITS) | (j << _BITS) | h
            else:
                out[n] = -1
            n += 1


@jit
def _marked(hit, min_pixels):  # type: ignore[no-untyped-def]
    """The distinct cells of `hit` that hold at least `min_pixels`, in order of appearance."""
    mask = 2
    while mask < 2 * len(hit):
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
            s = _slot(cell, mask)
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
    return cells[:kept].copy()


@jit
def _observe(  # type: ignore[no-untyped-def]
    depth,
    rays,
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
    """(cells the frame marks, their places in `cells` or -1, cells to forget); see ObstacleMemory.observe."""
    turn = _rotation(attitude)
    a, b, c = turn
    eye = (position[0] + ahead_m * a[0], position[1] + ahead_m * b[0], position[2] + ahead_m * c[0])
    hit = np.empty(depth.size, np.int64)
    _pixel_cells(depth, rays, eye, turn, voxel_m, ranges[0], ranges[1], hit)
    fresh = _marked(hit, min_pixels)
    places = np.full(len(fresh), -1, np.int64)
    slots, mask = _table(fresh)
    forget = np.empty(len(cells), np.int64)
    height, width = depth.shape
    n = 0
    low = (1 << _BITS) - 1
    for i in range(len(cells)):
        cell = cells[i]
        gone = seen_s[i] < oldest_s
        x = ((cell >> 2 * _BITS) - _HALF + 0.5) * voxel_m - eye[0]
        y = (((cell >> _BITS) & low) - _HALF + 0.5) * voxel_m - eye[1]
        z = ((cell & low) - _HALF + 0.5) * voxel_m - eye[2]
        ahead = x * a[0] + y * b[0] + z * c[0]
        marked = False
        if ahead > ranges[0] - voxel_m and ahead < ranges[1] + voxel_m:
            k = ((x * a[1] + y * b[1] + z * c[1]) / ahead - column[0]) / column[1] + 0.5
            r = ((x * a[2] + y * b[2] + z * c[2]) / ahead - row[0]) / row[1] + 0.5
            rim = abs(voxel_m / (ahead * column[1]))  # a cell whose centre is out of the view may still be marked
            if k > -rim and k < width + rim and r > -rim and r < height + rim:
                place = _find(slots, mask, fresh, cell)
                marked = place >= 0
                if marked:
                    places[place] = i
                elif k >= 0.0 and k < width and r >= 0.0 and r < height and ahead > ranges[0] and ahead < ranges[1]:
                    d = depth[int(r), int(k)]
                    gone = gone or d > ahead + margin_m or not d > 0.0
        if gone and not marked:
            forget[n] = cell
            n += 1
    return fresh, places, forget[:n].copy()


@jit
def _dropped(cells, forget):  # type: ignore[no-untyped-def]
    """Which of `cells` are in `forget`; quick where that is in the same order."""
    out = np.zeros(len(cells), np.bool_)
    n = 0
    for i in range(len(cells)):
        if n == len(forget):
            return out
        if cells[i] == forget[n]:
            out[i] = True
            n += 1
    if n < len(forget):
        slots, mask = _table(forget)
        for i in range(len(cells)):
            out[i] = _find(slots, mask, forget, cells[i]) >= 0
    return out


@jit
def _update(cells, seen_s, forget, fresh, places, stamp_s):  # type: ignore[no-untyped-def]
    """(cells, when each was last seen) after forgetting `forget` and marking `fresh`, known at `places`."""
    dropped = _dropped(cells, forget)
    out = np.empty(len(cells) + len(fresh), np.int64)
    when = np.empty(len(out), np.float64)
    place = np.empty(len(cells), np.int64)
    n = 0
    for i in range(len(cells)):
        if not dropped[i]:
            out[n], when[n], place[i] = cells[i], seen_s[i], n
            n += 1
    for j in range(len(fresh)):
        i = places[j]
        if i >= 0 and not dropped[i]:
            when[place[i]] = stamp_s
        else:
            out[n], when[n] = fresh[j], stamp_s
            n += 1
    return out[:n].copy(), when[:n].copy()


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
    return out[:n].copy()
