"""Compiled geometry of the ground truth: nearest point of a surface, line of sight, distance to boxes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.stack.kernel import jit

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
Segments = NDArray[np.int16]


@jit
def nearest(vertices: Array, faces: Faces, owner: Segments, body: int, point: Array, foot: Array) -> float:
    """Distance from `point` (3,) to the triangles of `body` [m]; writes the nearest point into `foot` (3,).

    Regions of the triangle after Ericson, Real-Time Collision Detection (2005), section 5.1.5.
    """
    best = np.inf
    for f in range(faces.shape[0]):
        if owner[f] != body:
            continue
        a, b, c = vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]]
        d1, d2, d3, d4, d5, d6 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(3):
            ab, ac = b[k] - a[k], c[k] - a[k]
            d1 += ab * (point[k] - a[k])
            d2 += ac * (point[k] - a[k])
            d3 += ab * (point[k] - b[k])
            d4 += ac * (point[k] - b[k])
            d5 += ab * (point[k] - c[k])
            d6 += ac * (point[k] - c[k])
        va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
        if d1 <= 0.0 and d2 <= 0.0:
            v, w = 0.0, 0.0
        elif d3 >= 0.0 and d4 <= d3:
            v, w = 1.0, 0.0
        elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
            v, w = d1 / (d1 - d3), 0.0
        elif d6 >= 0.0 and d5 <= d6:
            v, w = 0.0, 1.0
        elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
            v, w = 0.0, d2 / (d2 - d6)
        elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
            w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
            v = 1.0 - w
        else:
            v, w = vb / (va + vb + vc), vc / (va + vb + vc)
        square = 0.0
        for k in range(3):
            square += (a[k] + v * (b[k] - a[k]) + w * (c[k] - a[k]) - point[k]) ** 2
        if square < best:
            best = square
            for k in range(3):
                foot[k] = a[k] + v * (b[k] - a[k]) + w * (c[k] - a[k])
    return math.sqrt(best)


@jit
def blocked(vertices: Array, faces: Faces, owner: Segments, spared: int, start: Array, end: Array) -> bool:
    """Whether a triangle of any body except `spared` intersects the line from `start` to `end` (3,) [m, world].

    Intersection after Moeller and Trumbore (1997), both sides.
    """
    dx, dy, dz = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    for f in range(faces.shape[0]):
        if owner[f] == spared:
            continue
        a, b, c = vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
        px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
        volume = ux * px + uy * py + uz * pz
        if volume == 0.0:
            continue
        sx, sy, sz = start[0] - a[0], start[1] - a[1], start[2] - a[2]
        u = (sx * px + sy * py + sz * pz) / volume
        if u < 0.0 or u > 1.0:
            continue
        qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
        v = (dx * qx + dy * qy + dz * qz) / volume
        if v < 0.0 or u + v > 1.0:
            continue
        t = (vx * qx + vy * qy + vz * qz) / volume
        if 0.0 < t < 1.0:
            return True
    return False


@jit
def outside(boxes: Array, x: float, y: float, z: float, distances: Array) -> None:
    """Write the distance from (x, y, z) to each of `boxes` (N, 6) [least x, y, z, then greatest]; 0 inside a box."""
    for i in range(boxes.shape[0]):
        dx = max(boxes[i, 0] - x, 0.0, x - boxes[i, 3])
        dy = max(boxes[i, 1] - y, 0.0, y - boxes[i, 4])
        dz = max(boxes[i, 2] - z, 0.0, z - boxes[i, 5])
        distances[i] = math.sqrt(dx * dx + dy * dy + dz * dz)
