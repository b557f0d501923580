"""Renderer of the depth camera: a compiled z-buffer with the same result per pixel as ray casting.

The ray of pixel (row j, column i) passes through the pixel's centre.  In body axes at the camera (x along the optical
axis, y left, z up) its point at depth 1 m is (1, (W/2 - i - 0.5) pitch, (H/2 - j - 0.5) pitch) with
pitch = 2 tan(fov/2) / W.  Depth is measured along the optical axis, not along the ray.

The signs of a triangle's three edge planes decide whether a ray hits it (homogeneous rasterisation after Olano and
Greer, 1997), so no triangle needs clipping; both sides of a triangle are visible.  The inverse of depth is linear over
the picture, so the z-buffer keeps the inverse.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.sim.optics import Array, Camera, Faces, Scene, Segments, View
from scaloft_fi.stack.kernel import jit

__all__ = ["Camera", "Scene", "View", "draw", "look", "pixels_of"]

NOTHING = -1
NEAR_M = 0.01


def look(scene: Scene, camera: Camera, position: Array, attitude: Array) -> View:
    """Render the picture from the vehicle's pose.

    Args:
        scene: the triangles of the world.
        camera: the camera.
        position: (3,) vehicle centre [m, world].
        attitude: (4,) quaternion x, y, z, w, body to world.
    """
    depth = np.empty((camera.height, camera.width))
    segments = np.empty((camera.height, camera.width), np.int16)
    draw(scene.vertices, scene.faces, scene.owner, position, attitude, camera.ahead_m, camera.pitch, depth, segments)
    return View(depth, segments)


@jit
def draw(
    vertices: Array,
    faces: Faces,
    owner: Segments,
    position: Array,
    attitude: Array,
    ahead_m: float,
    pitch: float,
    depth: Array,
    segments: Segments,
) -> None:
    """Draw all triangles into `depth` (H, W) [m] and `segments` (H, W); see `look`."""
    height, width = depth.shape
    x, y, z, w = attitude[0], attitude[1], attitude[2], attitude[3]
    r00, r01, r02 = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)
    r10, r11, r12 = 2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)
    r20, r21, r22 = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)
    ox, oy, oz = position[0] + ahead_m * r00, position[1] + ahead_m * r10, position[2] + ahead_m * r20
    # Camera coordinates in pixels: (forward, column, row), so that pixel (j, i) is the ray (1, i, j).
    centre_i, centre_j, scale = 0.5 * width - 0.5, 0.5 * height - 0.5, 1.0 / pitch
    seen = np.empty((vertices.shape[0], 3))
    for v in range(vertices.shape[0]):
        dx, dy, dz = vertices[v, 0] - ox, vertices[v, 1] - oy, vertices[v, 2] - oz
        forward = r00 * dx + r10 * dy + r20 * dz
        left = r01 * dx + r11 * dy + r21 * dz
        up = r02 * dx + r12 * dy + r22 * dz
        seen[v, 0] = forward
        seen[v, 1] = centre_i * forward - left * scale
        seen[v, 2] = centre_j * forward - up * scale
    for j in range(height):
        for i in range(width):
            depth[j, i] = 0.0
            segments[j, i] = NOTHING
    corner = np.empty((3, 3))
    for f in range(faces.shape[0]):
        ahead = 0
        for k in range(3):
            v = faces[f, k]
            corner[k, 0], corner[k, 1], corner[k, 2] = seen[v, 0], seen[v, 1], seen[v, 2]
            if corner[k, 0] > NEAR_M:
                ahead += 1
        if ahead == 0:
            continue
        low_i, high_i, low_j, high_j = np.inf, -np.inf, np.inf, -np.inf
        for k in range(3):
            af, ai, aj = corner[k, 0], corner[k, 1], corner[k, 2]
            n = (k + 1) % 3
            bf, bi, bj = corner[n, 0], corner[n, 1], corner[n, 2]
            if af > NEAR_M:
                low_i, high_i = min(low_i, ai / af), max(high_i, ai / af)
                low_j, high_j = min(low_j, aj / af), max(high_j, aj / af)
            if (af > NEAR_M) != (bf > NEAR_M):
                t = (NEAR_M - af) / (bf - af)
                ci, cj = (ai + t * (bi - ai)) / NEAR_M, (aj + t * (bj - aj)) / NEAR_M
                low_i, high_i = min(low_i, ci), max(high_i, ci)
                low_j, high_j = min(low_j, cj), max(high_j, cj)
        if high_i < 0.0 or low_i > width - 1.0 or high_j < 0.0 or low_j > height - 1.0:
            continue
        first_j, last_j = math.ceil(max(low_j - 1e-6, 0.0)), math.floor(min(high_j + 1e-6, height - 1.0))
        first_i, last_i = math.ceil(max(low_i - 1e-6, 0.0)), math.floor(min(high_i + 1e-6, width - 1.0))
        if first_j > last_j or first_i > last_i:
            continue
        # Edge planes n_k = p_(k+1) x p_(k+2); volume = p_0 . n_0.
        a0 = corner[1, 1] * corner[2, 2] - corner[1, 2] * corner[2, 1]
        b0 = corner[1, 2] * corner[2, 0] - corner[1, 0] * corner[2, 2]
        c0 = corner[1, 0] * corner[2, 1] - corner[1, 1] * corner[2, 0]
        a1 = corner[2, 1] * corner[0, 2] - corner[2, 2] * corner[0, 1]
        b1 = corner[2, 2] * corner[0, 0] - corner[2, 0] * corner[0, 2]
        c1 = corner[2, 0] * corner[0, 1] - corner[2, 1] * corner[0, 0]
        a2 = corner[0, 1] * corner[1, 2] - corner[0, 2] * corner[1, 1]
        b2 = corner[0, 2] * corner[1, 0] - corner[0, 0] * corner[1, 2]
        c2 = corner[0, 0] * corner[1, 1] - corner[0, 1] * corner[1, 0]
        volume = corner[0, 0] * a0 + corner[0, 1] * b0 + corner[0, 2] * c0
        if volume == 0.0:
            continue
        g = 1.0 / volume
        a0, b0, c0, a1, b1, c1, a2, b2, c2 = a0 * g, b0 * g, c0 * g, a1 * g, b1 * g, c1 * g, a2 * g, b2 * g, c2 * g
        step = b0 + b1 + b2
        body = owner[f]
        t0, t1, t2 = -1.0 / b0, -1.0 / b1, -1.0 / b2
        for j in range(first_j, last_j + 1):
            # The range of columns in which no edge function is negative.
            e0, e1, e2 = a0 + c0 * j, a1 + c1 * j, a2 + c2 * j
            low, high = float(first_i), float(last_i)
            for e, b, t in ((e0, b0, t0), (e1, b1, t1), (e2, b2, t2)):
                if b > 0.0:
                    low = max(low, e * t - 1e-9)
                elif b < 0.0:
                    high = min(high, e * t + 1e-9)
                elif e < 0.0:
                    high = -1.0
            if low > high:
                continue
            base = e0 + e1 + e2
            start, end = math.ceil(low), math.floor(high) + 1
            line, bodies = depth[j, start:end], segments[j, start:end]
            for i in range(len(line)):
                inverse = base + step * (start + i)
                nearer = inverse > line[i]
                line[i] = inverse if nearer else line[i]
                bodies[i] = body if nearer else bodies[i]
    for j in range(height):
        for i in range(width):
            depth[j, i] = 1.0 / depth[j, i] if depth[j, i] > 0.0 else np.inf


@jit
def pixels_of(segments: Segments, depth: Array, wanted: NDArray[np.bool_], range_m: float) -> int:
    """Count the pixels that show a wanted body within range.

    Args:
        segments: (H, W) index of the visible body; -1 for none.
        depth: (H, W) [m].
        wanted: (B,) whether each body counts.
        range_m: greatest depth that counts [m].
    """
    count = 0
    for j in range(segments.shape[0]):
        for i in range(segments.shape[1]):
            body = segments[j, i]
            if body >= 0 and wanted[body] and depth[j, i] <= range_m:
                count += 1
    return count
