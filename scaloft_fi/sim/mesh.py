"""Triangle meshes: the shapes of the world, and the questions about them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.errors import InputError, did_you_mean

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
ROUND_SIDES = 16
COLUMNS = 128
"""Most upright columns along each horizontal axis in which faces are compared with each other."""
PAIRS_AT_ONCE, MOST_PAIRS = 100_000, 200_000_000
"""Pairs of faces that are compared at once, and altogether: bounds of memory and time."""
EDGE_M = 1e-6
"""A face this much lower than another lies beneath it, and a face reaches this much beyond its edges [m]."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles.  vertices: (V, 3) [m]; faces: (F, 3) indices of vertices."""

    vertices: Array
    faces: Faces

    @property
    def triangles(self) -> Array:
        """(F, 3, 3) corners of each triangle [m]."""
        return self.vertices[self.faces]

    def encloses(self, point: Sequence[float]) -> bool:
        """Whether `point` (3,) [m] is inside the closed surface."""
        if not self.faces.size or (point < self.vertices.min(0)).any() or (point > self.vertices.max(0)).any():
            return False
        return abs(winding(self.triangles, point)) > 0.5

    def moved(self, offset: Sequence[float]) -> Mesh:
        """The mesh, translated by `offset` (3,) [m]."""
        return Mesh(self.vertices + np.asarray(offset, np.float64), self.faces)

    def part(self, keep: NDArray[np.bool_]) -> Mesh:
        """The faces in `keep` (F,) and their vertices."""
        used, faces = np.unique(self.faces[keep], return_inverse=True)
        return Mesh(self.vertices[used], faces.reshape(-1, 3).astype(np.int64))


def join(meshes: Sequence[Mesh]) -> Mesh:
    """Join meshes into one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]),
    )


def box(size: Sequence[float]) -> Mesh:
    """Box of `size` (x, y, z) [m] about the origin."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * np.asarray(size)
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return Mesh(corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int64))


def lathe(profile: Sequence[tuple[float, float]], sides: int = ROUND_SIDES) -> Mesh:
    """Body of revolution about z; `profile` has (radius, z) [m] from bottom to top, a radius of 0 makes a point."""
    angles = 2.0 * math.pi * np.arange(sides) / sides
    rings: list[range] = []
    vertices: list[tuple[float, float, float]] = []
    for radius, z in profile:
        first = len(vertices)
        turns = angles if radius > 0 else angles[:1]
        vertices += [(radius * math.cos(a), radius * math.sin(a), z) for a in turns]
        rings.append(range(first, len(vertices)))
    faces: list[tuple[int, int, int]] = []
    for below, above in pairwise(rings):
        for i in range(sides):
            a, b = below[i % len(below)], below[(i + 1) % len(below)]
            c, d = above[(i + 1) % len(above)], above[i % len(above)]
            faces += [(a, b, c)] * (a != b) + [(a, c, d)] * (c != d)
    return Mesh(np.array(vertices), np.array(faces, np.int64))


@lru_cache(maxsize=256)
def cylinder(radius_m: float, height_m: float) -> Mesh:
    """Upright cylinder about the origin."""
    half = 0.5 * height_m
    return lathe(((0.0, -half), (radius_m, -half), (radius_m, half), (0.0, half)))


@lru_cache(maxsize=256)
def capsule(radius_m: float, height_m: float) -> Mesh:
    """Upright capsule about the origin; `height_m` includes the caps."""
    waist = max(0.5 * height_m - radius_m, 0.0)
    cap = [(radius_m * math.sin(a), radius_m * math.cos(a)) for a in (0.0, math.pi / 6, math.pi / 3, math.pi / 2)]
    bottom = [(r, -waist - z) for r, z in cap]
    top = [(r, waist + z) for r, z in reversed(cap)]
    return lathe(bottom + (top if waist > 0 else top[1:]))


def split_floor(mesh: Mesh, names: Sequence[str], floor: Sequence[str], place: str) -> tuple[Mesh, Mesh]:
    """Split a mine into (rock, floor).

    The floor consists of the faces of the objects or groups named in `floor`.  Without names it consists of the faces
    that are no steeper than 45 degrees and have no other face of the mesh beneath them.

    Raises:
        InputError: no face belongs to a name in `floor`, or the mesh has only floor or no floor.
    """
    for name in floor:
        if name not in names:
            raise InputError(
                f"{place}: ground={name!r} is no object of the mesh{did_you_mean(name, set(names) - {''})}"
            )
    is_floor = np.array([name in floor for name in names]) if floor else _lowest(mesh.triangles, place)
    if is_floor.all() or not is_floor.any():
        raise InputError(f"{place}: mesh must have a floor and walls; name the floor's objects under `ground`")
    return mesh.part(~is_floor), mesh.part(is_floor)


def _lowest(triangles: Array, place: str) -> NDArray[np.bool_]:
    """(F,) whether each face is no steeper than 45 degrees and has no other face beneath its centre."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = np.cross(b - a, c - a)
    flat = np.abs(normal[:, 2]) >= math.sqrt(0.5) * np.linalg.norm(normal, axis=1)
    flat &= np.abs(normal[:, 2]) > 0
    is_lowest = np.zeros(len(triangles), np.bool_)
    centres, pairs = triangles.mean(axis=1), 0
    for column, near in _columns(triangles, centres, np.flatnonzero(flat)):
        pairs += len(column) * len(near)
        if pairs > MOST_PAIRS:
            raise InputError(
                f"{place}: level faces of the mesh overlap too often; name the floor's objects under `ground`"
            )
        step = 1 + PAIRS_AT_ONCE // len(near)
        for some in (column[k : k + step] for k in range(0, len(column), step)):
            x, y, z = (centres[some, axis, None] for axis in range(3))
            heights, hit = _crossings(triangles[near], x, y)
            is_lowest[some] = ~(hit & (heights < z - EDGE_M)).any(axis=1)
    return is_lowest


def _columns(triangles: Array, centres: Array, wanted: Faces) -> Iterator[tuple[Faces, Faces]]:
    """Split the world into upright columns: the `wanted` faces with their centre there, and all faces that reach there.

    Without columns, the time to compare all faces with each other grows with the square of their number.
    """
    low, high = triangles.min(axis=1)[:, :2] - EDGE_M, triangles.max(axis=1)[:, :2] + EDGE_M
    origin, count = low.min(axis=0), min(COLUMNS, 1 + math.isqrt(len(triangles) // 16))
    size_m = (high.max(axis=0) - origin) / count
    places = (((xy - origin) / size_m).astype(np.int64).clip(0, count - 1) for xy in (low, high, centres[:, :2]))
    first, last, own = places
    for j in np.unique(own[wanted, 1]):
        in_row = np.flatnonzero((first[:, 1] <= j) & (last[:, 1] >= j))
        own_row = wanted[own[wanted, 1] == j]
        for i in np.unique(own[own_row, 0]):
            yield own_row[own[own_row, 0] == i], in_row[(first[in_row, 0] <= i) & (last[in_row, 0] >= i)]


def heights_at(triangles: Array, x: float, y: float) -> Array:
    """(N,) heights at which the vertical line through (x, y) intersects the triangles [m]."""
    heights, hit = _crossings(triangles, np.array([[x]]), np.array([[y]]))
    return np.asarray(heights[hit])


def _crossings(triangles: Array, x: Array, y: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Heights (P, F) at which the upright lines through x, y (P, 1) meet the triangles' planes; whether inside them."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        u = ((x - a[:, 0]) * (c[:, 1] - a[:, 1]) - (y - a[:, 1]) * (c[:, 0] - a[:, 0])) / area
        v = ((b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])) / area
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (area != 0)
        return a[:, 2] + u * (b[:, 2] - a[:, 2]) + v * (c[:, 2] - a[:, 2]), hit


def winding(triangles: Array, point: Sequence[float]) -> float:
    """Winding number of the surface about `point`: near 0 outside, near +-1 inside, even if the surface has small gaps.

    Solid angle of each triangle after Van Oosterom and Strackee (1983).
    """
    a, b, c = (triangles[:, i] - np.asarray(point, np.float64) for i in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    numerator = np.einsum("ij,ij->i", a, np.cross(b, c))
    denominator = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(2.0 * np.arctan2(numerator, denominator).sum() / (4.0 * math.pi))


def section(triangles: Array, z_m: float) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Segments (x, y) [m] in which the horizontal plane at height `z_m` intersects the triangles."""
    is_below = triangles[:, :, 2] < z_m
    crossed = is_below.any(axis=1) & ~is_below.all(axis=1)
    low, is_below = triangles[crossed], is_below[crossed]
    high = np.roll(low, -1, axis=1)
    is_cut = is_below != np.roll(is_below, -1, axis=1)  # two edges of each crossed triangle
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (z_m - low[..., 2]) / (high[..., 2] - low[..., 2])
        places = low[..., :2] + share[..., None] * (high[..., :2] - low[..., :2])
    ends = places[is_cut].reshape(-1, 2, 2).tolist()
    return [((x0, y0), (x1, y1)) for (x0, y0), (x1, y1) in ends]
