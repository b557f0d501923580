"""Triangle meshes: the shapes of the world, and meshes read from OBJ files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.errors import InputError, did_you_mean

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
ROUND_SIDES = 16


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles.  vertices: (V, 3) [m]; faces: (F, 3) indices of vertices."""

    vertices: Array
    faces: Faces

    @property
    def triangles(self) -> Array:
        """(F, 3, 3) corners of each triangle [m]."""
        return self.vertices[self.faces]

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


def cylinder(radius_m: float, height_m: float) -> Mesh:
    """Upright cylinder about the origin."""
    half = 0.5 * height_m
    return lathe(((0.0, -half), (radius_m, -half), (radius_m, half), (0.0, half)))


def capsule(radius_m: float, height_m: float) -> Mesh:
    """Upright capsule about the origin; `height_m` includes the caps."""
    waist = max(0.5 * height_m - radius_m, 0.0)
    cap = [(radius_m * math.sin(a), radius_m * math.cos(a)) for a in (0.0, math.pi / 6, math.pi / 3, math.pi / 2)]
    bottom = [(r, -waist - z) for r, z in cap]
    top = [(r, waist + z) for r, z in reversed(cap)]
    return lathe(bottom + (top if waist > 0 else top[1:]))


def read_obj(path: Path, place: str, scale: float) -> tuple[Mesh, tuple[str, ...]]:
    """Read the faces of a Wavefront OBJ file; polygons become fans of triangles.

    Args:
        path: the file.
        place: `file:line` of the key that names the file, for error messages.
        scale: metres per unit of the file.

    Returns:
        The mesh, and for each face the name of its object or group ("" before the first name).

    Raises:
        InputError: the file cannot be read or is not a mesh.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise InputError(f"{place}: mesh={str(path)!r} cannot be read: {reason}") from error
    vertices: list[tuple[float, ...]] = []
    faces: list[tuple[int, int, int]] = []
    names: list[str] = []
    name = ""
    for number, line in enumerate(lines, 1):
        word, *rest = line.split("#", 1)[0].split() or [""]
        try:
            if word == "v":
                x, y, z = (float(value) for value in rest[:3])
                if not all(map(math.isfinite, (x, y, z))):
                    raise ValueError
                vertices.append((x, y, z))
            elif word == "f":
                corners = [_corner(value, len(vertices)) for value in rest]
                fan = [(corners[0], b, c) for b, c in pairwise(corners[1:])]
                if not fan:
                    raise ValueError
                faces += fan
                names += [name] * len(fan)
            elif word in ("o", "g"):
                name = " ".join(rest)
        except (ValueError, IndexError):
            raise InputError(
                f"{path}:{number}: {line.strip()!r} must be a vertex `v x y z` or a face of known vertices"
            ) from None
    if not faces:
        raise InputError(f"{place}: mesh={str(path)!r} must have faces (lines `f ...`)")
    return Mesh(np.array(vertices) * scale, np.array(faces, np.int64)), tuple(names)


def _corner(text: str, count: int) -> int:
    """Index of the vertex at a corner of a face: OBJ counts from 1, or from the end with negative numbers."""
    index = int(text.split("/", 1)[0])
    place = index - 1 if index > 0 else count + index
    if index == 0 or not 0 <= place < count:
        raise IndexError
    return place


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
    is_floor = np.array([name in floor for name in names]) if floor else _lowest(mesh.triangles)
    if is_floor.all() or not is_floor.any():
        raise InputError(f"{place}: mesh must have a floor and walls; name the floor's objects under `ground`")
    return mesh.part(~is_floor), mesh.part(is_floor)


def _lowest(triangles: Array) -> NDArray[np.bool_]:
    """(F,) whether each face is no steeper than 45 degrees and has no other face beneath its centre."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = np.cross(b - a, c - a)
    flat = np.abs(normal[:, 2]) >= math.sqrt(0.5) * np.linalg.norm(normal, axis=1)
    flat &= np.abs(normal[:, 2]) > 0
    is_lowest = np.zeros(len(triangles), np.bool_)
    for i in np.flatnonzero(flat):
        centre = triangles[i].mean(axis=0)
        below = heights_at(triangles, centre[0], centre[1])
        is_lowest[i] = not (below < centre[2] - 1e-6).any()
    return is_lowest


def heights_at(triangles: Array, x: float, y: float) -> Array:
    """(N,) heights at which the vertical line through (x, y) intersects the triangles [m]."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        u = ((x - a[:, 0]) * (c[:, 1] - a[:, 1]) - (y - a[:, 1]) * (c[:, 0] - a[:, 0])) / area
        v = ((b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])) / area
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (area != 0)
        return np.asarray((a[:, 2] + u * (b[:, 2] - a[:, 2]) + v * (c[:, 2] - a[:, 2]))[hit])


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
    segments = []
    for triangle in triangles:
        cuts = []
        for p, q in ((0, 1), (1, 2), (2, 0)):
            low, high = triangle[p], triangle[q]
            if (low[2] < z_m) != (high[2] < z_m):
                share = (z_m - low[2]) / (high[2] - low[2])
                x, y = low[:2] + share * (high[:2] - low[:2])
                cuts.append((float(x), float(y)))
        if len(cuts) == 2:
            segments.append((cuts[0], cuts[1]))
    return segments
