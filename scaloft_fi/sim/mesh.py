"""Triangle meshes: the shapes of the world, their OBJ files, what is wrong with a surface, what a camera renders."""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.document import FILE_BYTES, MIB, UnreadableError, is_file, opened, read_apart, read_text
from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.marks import Bounds
from scaloft_fi.registry import in_one_line
from scaloft_fi.stack.messages import DepthCamera

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

    def turned(self, yaw_rad: float) -> Mesh:
        """The mesh, turned about z by `yaw_rad`, counter-clockwise from above."""
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        return Mesh(self.vertices @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]), self.faces)

    def part(self, keep: NDArray[np.bool_]) -> Mesh:
        """The faces in `keep` (F,) and their vertices."""
        used, faces = np.unique(self.faces[keep], return_inverse=True)
        return Mesh(self.vertices[used], faces.reshape(-1, 3).astype(np.int64))


def join(meshes: Sequence[Mesh]) -> Mesh:
    """Join meshes into one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


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
            near = did_you_mean(name, set(names) - {""})
            raise InputError(f"{place}: ground={name!r} is no object of the mesh{near}")
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
            sentence = "level faces of the mesh overlap too often; name the floor's objects under `ground`"
            raise InputError(f"{place}: {sentence}")
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
    return float(2.0 * _half_angles(triangles, point).sum() / (4.0 * math.pi))


def _half_angles(triangles: Array, point: Sequence[float]) -> Array:
    """(F,) half of the solid angle of each triangle seen from `point` [sr]."""
    a, b, c = (triangles[:, i] - np.asarray(point, np.float64) for i in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    numerator = np.einsum("ij,ij->i", a, np.cross(b, c))
    denominator = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return np.asarray(np.arctan2(numerator, denominator))


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


def hull(points: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """The convex hull of points in the plane, counter-clockwise (Andrew's monotone chain).

    >>> hull([(0, 0), (2, 0), (1, 1), (2, 2), (0, 2), (1, 0)])
    ((0, 0), (2, 0), (2, 2), (0, 2))
    """
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return tuple(ordered)

    def half(along: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for point in along:
            while len(chain) > 1 and turn(chain[-2], chain[-1], point) <= 0:
                chain.pop()
            chain.append(point)
        return chain

    def turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    return tuple(half(ordered)[:-1] + half(ordered[::-1])[:-1])


Segments = NDArray[np.int16]


@dataclass(frozen=True)
class Camera:
    """A pinhole camera that looks along body x.

    Attributes:
        width, height: size of the picture [pixels].
        fov_rad: horizontal angle of view [rad].
        ahead_m: distance of the camera from the vehicle's centre along body x [m].
    """

    width: int
    height: int
    fov_rad: float
    ahead_m: float

    @property
    def pitch(self) -> float:
        """Distance of neighbouring pixels at depth 1 m [m]."""
        return 2.0 * math.tan(0.5 * self.fov_rad) / self.width

    @property
    def rays(self) -> Array:
        """(H, W, 3) point of each pixel's ray at depth 1 m, (1, left, up) [m, body axes at the camera]."""
        return DepthCamera.pinhole(self.width, self.height, self.fov_rad, self.ahead_m).rays


@dataclass(frozen=True, eq=False)
class Scene:
    """All triangles of a world.

    Attributes:
        vertices: (V, 3) [m, world].
        faces: (F, 3) indices of vertices.
        owner: (F,) index of the body of each face.
        names: names of the bodies.
        reflectivity: (B,) reflectivity of the bodies, 0..1.
    """

    vertices: Array
    faces: Faces
    owner: Segments
    names: tuple[str, ...]
    reflectivity: Array


@dataclass(frozen=True, eq=False)
class View:
    """A rendered picture without sensor errors.

    Attributes:
        depth: (H, W) depth along the optical axis [m]; inf where no triangle is.
        segments: (H, W) index of the body in the names of the scene; -1 where no triangle is.
    """

    depth: Array
    segments: Segments


COST = "each 100,000 triangles add about 1 s to a flight and 60 MiB to every process that flies"
"""Measured with a torus of 10,000 and of 150,000 triangles, three flights of half a minute each."""
MANY_TRIANGLES = 100_000
MOST_CORNERS, MOST_FACES_OF_ONE = 131_072, 174_762
"""Most vertices and triangles of one surface in PyBullet (`B3_MAX_NUM_VERTICES`, `B3_MAX_NUM_INDICES`)."""
MOST_DECIMATED = 2_000_000
"""Most triangles of a file that is decimated."""
FARTHEST_M = 1e5
"""Greatest coordinate of anything in a world [m]; the stack's map and the physics server lose precision beyond."""


class MeshFile(NamedTuple):
    """A mesh file.

    Attributes:
        mesh: the mesh.
        names: for each face the name of its object or group, "" before the first.
        lines: for each face its line in an OBJ file, its number in any other.
        word: which of both: `line` or `face`.
    """

    mesh: Mesh
    names: tuple[str, ...]
    lines: Faces
    word: str = "line"


class Stated(NamedTuple):
    """What a mesh file says of itself.

    Attributes:
        up: the axis that is up, `y` or `z`; None where it does not say.
        unit_m: metres per unit; None where it does not say [m].
    """

    up: str | None = None
    unit_m: float | None = None


_HEAD = 1 << 16
_UNIT, _UP_AXIS = re.compile(r"<unit\b[^>]*\bmeter\s*=\s*[\"']([^\"']*)"), re.compile(r"<up_axis>\s*([YZ])_UP")


def stated(path: Path) -> Stated:
    """What a file says of its unit and of the axis that is up: glTF (2.0, section 3.4) and DAE (COLLADA 1.4.1) do."""
    if path.suffix.lower() in (".glb", ".gltf"):
        return Stated("y", 1.0)
    if path.suffix.lower() != ".dae" or not is_file(path):
        return Stated()
    with opened(path) as file:
        head = file.read(_HEAD).decode("latin-1")
    axis, unit = _UP_AXIS.search(head), _UNIT.search(head)
    with suppress(ValueError):
        unit_m = float(unit[1]) if unit else 1.0
        if 0.0 < unit_m < math.inf:
            return Stated(axis[1].lower() if axis else "y", unit_m)
    return Stated(axis[1].lower() if axis else "y")


def turn_up(points: Array) -> Array:
    """Points (..., 3) of a file whose y is up, turned so that z is."""
    return np.asarray(points @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]))


def turn_back(points: Array) -> Array:
    """Points (..., 3) turned so that y is up: undoes `turn_up`."""
    return np.asarray(points @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]))


BY_LIBRARY = (".stl", ".ply", ".glb", ".gltf", ".dae", ".off")
"""The endings of the files that `trimesh` reads; any other file is read as OBJ."""


_CONTINUED = r"\\[^\S\n]*\n"
_LINE = re.compile(
    rf"^[^\S\n]*([vfog])(?![^\s#])((?:(?<=[vf])(?:[^#\n]*{_CONTINUED})*)?[^\n]*)",
    re.MULTILINE,
)
"""A line that counts; texture coordinates, normals, materials and comments do not.  A backslash at the end of a line
of a vertex or a face joins the next line to it, but not one in a comment, which may be a path of Windows."""


@dataclass(frozen=True)
class MeshLimits:
    """Limits of a mesh file, which you may raise; time and memory of a flight grow with the triangles.

    Attributes:
        size_bytes: largest file [bytes].
        triangles: most triangles, after polygons became fans of triangles.
        corners: most corners of one polygon.
    """

    size_bytes: Annotated[int, Bounds(least=1, most=FILE_BYTES)] = 32 * MIB
    triangles: Annotated[int, Bounds(least=1, most=10_000_000)] = 200_000
    corners: Annotated[int, Bounds(least=1, most=1_000_000)] = 1_000


def read_mesh(path: Path, place: str, scale: float, up: str, limits: MeshLimits) -> MeshFile:
    """Read a mesh file: OBJ here, those of `BY_LIBRARY` by `trimesh`; with y up it is turned so that z is.

    Args:
        path: the file.
        place: `file:line` of the key that names the file, for error messages.
        scale: metres per unit of the file.
        up: `y` or `z`, the axis of the file that is up.
        limits: limits of the mesh.

    Raises:
        InputError: the file cannot be read, is not a mesh, or exceeds a limit.
    """
    read = _read_by_library if path.suffix.lower() in BY_LIBRARY else read_obj
    file = read(path, place, scale, limits)
    return file if up != "y" else file._replace(mesh=Mesh(turn_up(file.mesh.vertices), file.mesh.faces))


def _exceeded(place: str, reason: str, limit: str) -> InputError:
    fewer = f"; {COST}, and `decimate_to: 50000` beside `mesh` makes fewer" if limit == "triangles" else ""
    return InputError(f"{place}: {reason}; `mesh_limits: {{{limit}: ...}}` beside `mesh` allows more{fewer}")


def decimated(file: MeshFile, most: int, place: str) -> MeshFile:
    """A mesh of about `most` triangles, by quadric error metrics (Garland and Heckbert 1997).

    Names and lines are those of the nearest faces before.  Pairs of faces that fold onto each other go, so what is
    closed stays closed.

    Raises:
        InputError: the library is not installed.
    """
    from scipy.spatial import KDTree

    if find_spec("fast_simplification") is None:
        raise InputError(f"{place}: decimate_to={most} needs pip install fast-simplification")
    if len(file.mesh.faces) <= most:
        return file
    whole = import_module("trimesh").Trimesh(file.mesh.vertices, file.mesh.faces)
    fewer = whole.simplify_quadric_decimation(face_count=most)
    mesh = Mesh(np.asarray(fewer.vertices, np.float64), np.array(fewer.faces, np.int64))
    which = np.unique(np.sort(mesh.faces, axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    a, b, c = mesh.faces.T
    sides = np.sign((b - a) * (c - b) * (a - c))  # how a face is wound, by its indices
    mesh = Mesh(mesh.vertices, mesh.faces[sides * np.bincount(which, weights=sides)[which] > 0])
    near = KDTree(file.mesh.triangles.mean(axis=1)).query(mesh.triangles.mean(axis=1))[1]
    return MeshFile(mesh, tuple(file.names[number] for number in near), file.lines[near], file.word)


def _text(path: Path, place: str, limits: MeshLimits) -> str:
    """The text of a mesh file, if it is not too large; programs write a mark of the encoding, or names in Latin-1."""
    try:
        return read_text(path, limits.size_bytes, other="latin-1").removeprefix("\ufeff")
    except UnreadableError as error:
        sentence = f"mesh={shown(str(path))} cannot be read: {error.reason}"
        if "larger" in error.reason:
            raise _exceeded(place, sentence, "size_bytes") from error
        raise InputError(f"{place}: {sentence}") from error


def _read_by_library(path: Path, place: str, scale: float, limits: MeshLimits) -> MeshFile:
    _text(path, place, limits)
    pieces = read_apart(path, lambda: _pieces(path, place))
    if not pieces:
        raise InputError(f"{place}: mesh={shown(str(path))} must have faces")
    corners = np.concatenate([vertices[faces].reshape(-1, 3) for vertices, faces, _ in pieces]) * scale
    vertices, faces = np.unique(corners, axis=0, return_inverse=True)  # many formats write each corner for each face
    whole = Mesh(vertices, faces.reshape(-1, 3).astype(np.int64))
    if len(whole.faces) > limits.triangles:
        raise _exceeded(place, f"the mesh must have at most {limits.triangles:,} triangles", "triangles")
    if not (np.abs(whole.vertices) <= FARTHEST_M).all():
        raise InputError(f"{place}: mesh={shown(str(path))} must have its vertices within {FARTHEST_M:,.0f} m")
    names = [name for _, faces, name in pieces for _ in faces]
    return MeshFile(whole, tuple(names), np.arange(1, len(whole.faces) + 1), "face")


def _pieces(path: Path, place: str) -> list[tuple[Array, Faces, str]]:
    """Vertices, faces and name of each object that `trimesh` reads."""
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # it logs each texture that is not there
    try:
        pieces = import_module("trimesh").load_scene(path, process=False).dump()
    except MemoryError:
        raise
    except Exception as error:
        needs = "pip install pycollada: " if path.suffix.lower() == ".dae" and find_spec("collada") is None else ""
        told = f"{needs}{in_one_line(error)}"
        raise InputError(f"{place}: mesh={shown(str(path))} cannot be read: {told}") from error
    return [
        (np.asarray(one.vertices, np.float64), np.array(one.faces, np.int64), str(one.metadata.get("name", "")))
        for one in pieces
        if len(getattr(one, "faces", ()))
    ]


def read_obj(path: Path, place: str, scale: float, limits: MeshLimits | None = None) -> MeshFile:
    """Read the faces of a Wavefront OBJ file; polygons become fans of triangles.

    Args:
        path: the file.
        place: `file:line` of the key that names the file, for error messages.
        scale: metres per unit of the file.
        limits: limits of the mesh; None = the defaults.

    Raises:
        InputError: the file cannot be read, is not a mesh, or exceeds a limit.
    """
    limits = limits or MeshLimits()
    text = _text(path, place, limits).replace("\r\n", "\n").replace("\r", "\n")
    vertices: list[tuple[float, ...]] = []
    faces: list[tuple[int, int, int]] = []
    names: list[str] = []
    lines: list[int] = []
    name, number, counted = "", 1, 0
    for line in _LINE.finditer(text):
        number, counted = number + text.count("\n", counted, line.start(1)), line.start(1)
        # One word more than is allowed shows that there are too many; the rest of a long line is not split.
        whole = re.sub(_CONTINUED, " ", line[2]) if "\n" in line[2] else line[2]
        word, rest = line[1], whole.split("#", 1)[0].split(None, max(3, limits.corners))
        try:
            if word == "v":
                x, y, z = (float(value) * scale for value in rest[:3])
                if not all(abs(value) <= FARTHEST_M for value in (x, y, z)):
                    raise ValueError
                vertices.append((x, y, z))
            elif word == "f":
                if len(rest) > limits.corners:
                    most = f"a face must have at most {limits.corners:,} corners"
                    raise _exceeded(f"{path}:{number}", most, "corners")
                corners = [_corner(value, len(vertices)) for value in rest]
                fan = [(corners[0], b, c) for b, c in pairwise(corners[1:])]
                if not fan:
                    raise ValueError
                faces += fan
                names += [name] * len(fan)
                lines += [number] * len(fan)
            else:
                name = " ".join(rest)
        except (ValueError, IndexError):
            allowed = f"a vertex `v x y z` within {FARTHEST_M:,.0f} m, or a face of known vertices"
            raise InputError(f"{path}:{number}: {shown(line[0].strip())} must be {allowed}") from None
        if len(faces) > limits.triangles or len(vertices) > 3 * limits.triangles:
            most = f"the mesh must have at most {limits.triangles:,} triangles, and three vertices for each"
            raise _exceeded(f"{path}:{number}", most, "triangles")
    if not faces:
        read = (
            ""
            if path.suffix.lower() == ".obj"
            else f"; it is read as OBJ, as it does not end in {', '.join(BY_LIBRARY)}"
        )
        raise InputError(f"{place}: mesh={shown(str(path))} must have faces (lines `f ...`){read}")
    return MeshFile(Mesh(np.array(vertices), np.array(faces, np.int64)), tuple(names), np.array(lines, np.int64))


def _corner(text: str, count: int) -> int:
    """Index of the vertex at a corner of a face: OBJ counts from 1, or from the end with negative numbers."""
    index = int(text.split("/", 1)[0])
    place = index - 1 if index > 0 else count + index
    if index == 0 or not 0 <= place < count:
        raise IndexError
    return place


WELD_DIGITS = 6
"""Vertices that agree in this many decimal places [m] are one: many programs write each corner once for each face."""
LEAST_AREA_M2 = 1e-10
MOST_PIECES = 200
"""Closed surfaces that are compared with the outer one."""
MOST_FACES = 64
"""Faces of such a surface that are looked at, spread over it."""
MOST_BEYOND = 0.25
"""Share of its area that may lie beyond the outer one."""
_TURN = "turn them around, as `recalculate normals` of a 3D program does"


@dataclass(frozen=True)
class Flaw:
    """A flaw of a mesh.

    Attributes:
        place: `file:line` of the first face that has it.
        at: centre of that face (x, y, z) [m, world].
        sentence: what is wrong.
        remedy: what to do about it.
        grave: whether open space cannot be told from rock with it; otherwise it may be harmless.
    """

    place: str
    at: tuple[float, float, float]
    sentence: str
    remedy: str
    grave: bool

    def __str__(self) -> str:
        where = ", ".join(f"{value:.3g}" for value in self.at)
        return f"{self.place}: {self.sentence}, near ({where}) m; {self.remedy}"


def surface_flaws(
    triangles: Array, lines: Faces, path: Path, word: str = "line", points: Sequence[Sequence[float]] = ()
) -> Iterator[Flaw]:
    """The flaws of a surface.

    Args:
        triangles: (F, 3, 3) corners [m].
        lines: (F,) line of each triangle in the file.
        path: the file.
        word: what `lines` count: `line` or `face`.
        points: (P, 3) places that must be in open space [m, world].
    """

    def flaw(face: int, sentence: str, remedy: str, *, grave: bool) -> Flaw:
        place = f"{path}:{lines[face]}" if word == "line" else f"{path}: face {lines[face]}"
        x, y, z = map(float, triangles[face].mean(axis=0))
        if word != "line":
            sentence = sentence.replace("the face at this line", "this face").replace("at this line", "here")
        return Flaw(place, (x, y, z), sentence, remedy, grave)

    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    empty = 0.5 * np.linalg.norm(sides, axis=1) <= LEAST_AREA_M2
    if empty.any():
        remedy = "remove them, or merge the vertices that stand at one place"
        yield flaw(int(empty.argmax()), f"{_faces(empty)} without area, the first at this line", remedy, grave=False)
    triangles, lines = triangles[~empty], lines[~empty]
    if not len(triangles):
        return
    again, turned = _twice(triangles)
    if again.any():
        two_sided = ", turned around: an export of two-sided faces" if turned else ""
        sentence = f"{_faces(again)} there twice{two_sided}, the first again at this line"
        yield flaw(int(again.argmax()), sentence, "remove the second one of each", grave=True)
        triangles, lines = triangles[~again], lines[~again]
    surface = _Surface.of(triangles)
    if surface.one_sided.any():
        sentence, remedy = "the surface of this face has one side only", "separate the faces that cross there"
        yield flaw(int(surface.one_sided.argmax()), sentence, remedy, grave=True)
    if surface.turned.any():
        first = int(surface.turned.argmax())
        sentence = f"{_faces(surface.turned)} wound the other way than their neighbours, the first at this line"
        beside = f"beside {'the face at line' if word == 'line' else word} {lines[surface.upright_neighbour(first)]}"
        yield flaw(first, f"{sentence}, {beside}", _TURN, grave=True)
    for own in _swollen(triangles, surface):
        sentence = f"this closed surface of {int(own.sum())} faces lies within another and is wound like it"
        yield flaw(int(own.argmax()), f"{sentence}, so the space in it counts as open", _TURN, grave=True)
    hull_of = next((own for point in points for own in _hull_around(triangles, surface, point)), None)
    if hull_of is not None:
        sentence = f"this closed surface of {int(hull_of.sum())} faces lies around the mine and is wound against it"
        sentence = f"{sentence}, as the outside of a block of rock is, so the space in the mine counts as outside"
        yield flaw(int(hull_of.argmax()), sentence, "delete these faces: only the inside is flown", grave=True)
    crowded = surface.open_edges[surface.edge_uses > 1]
    if len(crowded):
        joins = f"3 or more faces meet at an edge of {len(np.unique(crowded[:, 0]))} faces, the first at this line"
        remedy = "remove the faces inside: a surface has two at each edge"
        yield flaw(int(crowded[0, 0]), f"{joins}, so no side is the open space there", remedy, grave=False)
    single = surface.open_edges[surface.edge_uses == 1]
    if len(single):
        face, corner = single[0]
        ends = ([f"{number:.3g}" for number in triangles[face, place]] for place in (corner, (corner + 1) % 3))
        edge = " to ".join(f"({', '.join(end)})" for end in ends)
        sentence = f"the surface has holes: {len(single)} edges have no second face, the first is {edge}"
        remedy = "close it, and merge the vertices that stand at one place"
        yield flaw(face, f"{sentence} of the face at this line", remedy, grave=False)


def _twice(triangles: Array) -> tuple[NDArray[np.bool_], bool]:
    """(F,) which faces have the corners of an earlier one, and whether each of them is wound the other way."""
    corners = np.unique(np.round(triangles.reshape(-1, 3), WELD_DIGITS), axis=0, return_inverse=True)[1].reshape(-1, 3)
    _, first, which = np.unique(np.sort(corners, axis=1), axis=0, return_index=True, return_inverse=True)
    earlier = first[which.reshape(-1)]
    again = earlier != np.arange(len(corners))
    signs = [np.linalg.det(np.eye(3)[np.argsort(own[again], axis=1)]) for own in (corners, corners[earlier])]
    return again, bool((signs[0] * signs[1] < 0.0).all())


def _hull_around(triangles: Array, surface: _Surface, point: Sequence[float]) -> Iterator[NDArray[np.bool_]]:
    """The closed surface around a point that another one, around it too, undoes; the one that reaches farther."""
    angles = _half_angles(triangles, point)
    by_piece = np.bincount(surface.piece, weights=angles, minlength=surface.pieces) / (2.0 * math.pi)
    around = np.flatnonzero(np.abs(by_piece) > 0.5)
    if abs(by_piece[around].sum()) < 0.5 and len(around) > 1:
        reach = [float(np.ptp(triangles[surface.piece == piece].reshape(-1, 3), axis=0).max()) for piece in around]
        yield surface.piece == around[int(np.argmax(reach))]


def _swollen(triangles: Array, surface: _Surface) -> Iterator[NDArray[np.bool_]]:
    """Closed surfaces, such as pillars, within another one and wound like it: the space within them counts as open."""
    upright = np.where(surface.turned[:, None, None], triangles[:, ::-1], triangles)
    volumes = np.einsum("ij,ij->i", upright[:, 0], np.cross(upright[:, 1], upright[:, 2])) / 6.0
    by_piece = np.bincount(surface.piece, weights=volumes, minlength=surface.pieces)
    shell = int(np.abs(by_piece).argmax())
    alike = by_piece * by_piece[shell] > 0.0
    alike[[shell, *surface.piece[surface.open_edges[:, 0]]]] = False
    for piece in np.flatnonzero(alike)[:MOST_PIECES]:
        own = surface.piece == piece
        if _lies_within(upright[own], upright[surface.piece == shell]):
            yield own


def _lies_within(piece: Array, shell: Array) -> bool:
    """Whether a surface lies within a shell but for faces on the shell or a little beyond: a pillar on the floor.

    A room that is joined to another one by letting the two overlap lies beyond it with most of its surface.
    """
    looked_at = piece[:: -(-len(piece) // MOST_FACES)]
    depths = np.abs([winding(shell, face.mean(axis=0)) for face in looked_at])
    areas = np.linalg.norm(np.cross(looked_at[:, 1] - looked_at[:, 0], looked_at[:, 2] - looked_at[:, 0]), axis=1)
    return bool(depths.max() > 0.75 and areas[depths < 0.25].sum() <= MOST_BEYOND * areas.sum())


@dataclass(frozen=True)
class _Surface:
    """How the faces of a surface hang together.

    Attributes:
        piece: (F,) number of the piece of each face; faces that share an edge with one other are of one piece.
        pieces: number of pieces.
        turned: (F,) whether the face is wound the other way than most of its piece.
        one_sided: (F,) whether the piece of the face has one side only.
        open_edges: (E, 2) face, and place of the first corner of the edge, of edges with an odd number of faces.
        edge_uses: (E,) how many faces each of these edges has: 1, 3, 5, ...
        pairs: (P, 2) faces that share an edge with each other alone.
    """

    piece: Faces
    pieces: int
    turned: NDArray[np.bool_]
    one_sided: NDArray[np.bool_]
    open_edges: Faces
    edge_uses: Faces
    pairs: Faces

    @classmethod
    def of(cls, triangles: Array) -> _Surface:
        """The surface of (F, 3, 3) triangles."""
        from scipy.sparse import coo_array, csgraph

        count = len(triangles)
        corners = np.unique(np.round(triangles.reshape(-1, 3), WELD_DIGITS), axis=0, return_inverse=True)[1]
        faces = corners.reshape(-1, 3).astype(np.int64)
        starts, ends = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
        low, high = np.minimum(starts, ends), np.maximum(starts, ends)
        _, edge, uses = np.unique(low * (corners.max() + 1) + high, return_inverse=True, return_counts=True)
        edge = edge.reshape(-1)
        order = np.argsort(edge, kind="stable")
        twice = order[uses[edge[order]] == 2].reshape(-1, 2)
        pairs = twice // 3
        alike = starts[twice[:, 0]] != starts[twice[:, 1]]  # the neighbour runs along the edge the other way
        one, other = pairs[:, 0], pairs[:, 1]
        # each face stands twice, as it is and turned around: what hangs together with a face as it is has its winding
        rows = np.concatenate([one, one + count])
        columns = np.concatenate([np.where(alike, other, other + count), np.where(alike, other + count, other)])
        graph: Any = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(2 * count, 2 * count))
        label = csgraph.connected_components(graph, directed=False)[1]
        as_is, around = label[:count], label[count:]
        piece = np.unique(np.minimum(as_is, around), return_inverse=True)[1].reshape(-1)
        pieces = int(piece.max()) + 1
        side = as_is > around
        most = np.bincount(piece, weights=np.where(side, 1.0, -1.0), minlength=pieces) > 0.0
        odd = np.flatnonzero(uses[edge] % 2 == 1)
        turned, open_edges = (side != most[piece]) & (as_is != around), np.stack([odd // 3, odd % 3], axis=1)
        return cls(piece, pieces, turned, as_is == around, open_edges, uses[edge][odd], pairs)

    def upright_neighbour(self, face: int) -> int:
        """A face that is not turned beside a turned one, or the nearest such face of the piece in the file."""
        near = self.pairs[(self.pairs == face).any(axis=1)].ravel()
        upright = near[~self.turned[near]]
        if not len(upright):
            upright = np.flatnonzero(~self.turned & (self.piece == self.piece[face]))
        return int(upright[np.abs(upright - face).argmin()])


def _faces(which: NDArray[np.bool_]) -> str:
    count = int(which.sum())
    return f"{count} of {len(which)} faces {'is' if count == 1 else 'are'}"
