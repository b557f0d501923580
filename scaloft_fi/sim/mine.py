"""The mine as meshes: a footprint extruded between rough walls, or a user's mesh."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError
from scaloft_fi.marks import Bounds, Either, Examples, MoreThanZero, NotNegative, Share, Size
from scaloft_fi.model import value_of
from scaloft_fi.sim import mesh as meshes
from scaloft_fi.sim.mesh import FARTHEST_M, Array, Faces, Flaw, Mesh, MeshLimits, join, section
from scaloft_fi.streams import generator

SLAB_M = 0.5
"""Floor and ceiling extend beyond the footprint by this [m]."""

MOST_CORNERS = 500
"""Most corners of a footprint with its pillars; each side is compared with each other side."""

Corner = tuple[float, float]
Ring = tuple[Corner, ...]
Metres = Annotated[float, Bounds(least=-FARTHEST_M, most=FARTHEST_M)]


class WallPoint(NamedTuple):
    """A point on the wall.  place: (2,) [m, world]; inward: (2,) unit normal into the open space."""

    place: Corner
    inward: Corner

    @property
    def bearing_rad(self) -> float:
        """Direction along the wall, which is on the right, from x [rad, world].

        >>> WallPoint((1.5, 3.5), (-1.0, 0.0)).bearing_rad == math.pi / 2
        True
        """
        return math.atan2(-self.inward[0], self.inward[1])


@dataclass(frozen=True, eq=False)
class Mine:
    """The rock.

    Attributes:
        wall: walls and ceiling; the faces are wound inwards.
        ground: the floor.
        ground_is_slab: whether the floor may become a solid slab in the physics.
        wall_reflectivity, ground_reflectivity: reflected share of infrared light, 0..1.
        footprint: rings (outer first, then pillars) of an extruded mine [m, world]; empty for a mesh.
        height_m: height of the ceiling of an extruded mine [m].

    Every value of every axis is checked in the same mine with nearly the same waypoints, so what it holds is kept.
    """

    wall: Mesh
    ground: Mesh
    ground_is_slab: bool
    wall_reflectivity: float
    ground_reflectivity: float
    footprint: tuple[Ring, ...]
    height_m: float
    _held: dict[tuple[float, ...], bool] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def extents(self) -> Array:
        """(2, 3) lowest and highest corner of the box around walls and floor [m, world]."""
        corners = np.concatenate([self.wall.triangles.reshape(-1, 3), self.ground.triangles.reshape(-1, 3)])
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    @property
    def extents_text(self) -> str:
        """As in: x -4 to 8, y -2 to 6, z 0 to 4."""
        low, high = ([float(f"{value:.3g}") for value in corner] for corner in self.extents)
        return ", ".join(f"{axis} {least:g} to {most:g}" for axis, least, most in zip("xyz", low, high, strict=True))

    def size_text(self, factor: float = 1.0) -> str:
        """Its extents times `factor`, as in: 12 x 8 x 4 m."""
        edges = (self.extents[1] - self.extents[0]) * factor
        return " x ".join(f"{float(f'{edge:.3g}'):g}" for edge in edges) + " m"

    def holds(self, point: Sequence[float]) -> bool:
        """Whether `point` (3,) [m, world] is in the open space of the mine."""
        x, y, z = place = tuple(map(float, point))
        if place not in self._held and self.footprint:
            self._held[place] = 0.0 < z < self.height_m and inside(section(self.wall.triangles, z), x, y)
        elif place not in self._held:
            self._held[place] = join([self.wall, self.ground]).encloses(place)
        return self._held[place]

    def is_between(self, start: Corner, end: Corner, z_m: float) -> bool:
        """Whether a wall crosses the straight line from `start` to `end` [m, world] at height `z_m`."""
        return any(_cross(start, end, *side) for side in section(self.wall.triangles, z_m))

    def wall_towards(self, point: Sequence[float], direction: Corner) -> WallPoint | None:
        """The nearest point to `point` (3,) [m, world] on the wall segment in a horizontal direction.

        The wall of an extruded mine is its footprint without roughness; the wall of a mesh is its section at the height
        of the point.  None where no wall lies in that direction.
        """
        x, y, z = point
        rings = [side for ring in self.footprint for side in zip(ring, ring[1:] + ring[:1], strict=True)]
        sides = rings or list(section(self.wall.triangles, z))
        hits = [(reach, side) for side in sides if (reach := _reach((x, y), direction, *side)) is not None]
        if not hits:
            return None
        (x0, y0), (x1, y1) = min(hits)[1]
        length = math.hypot(x1 - x0, y1 - y0)
        along_x, along_y = (x1 - x0) / length, (y1 - y0) / length
        along_m = (x - x0) * along_x + (y - y0) * along_y
        foot = (x0 + along_m * along_x, y0 + along_m * along_y)
        side = 1.0 if (x - foot[0]) * -along_y + (y - foot[1]) * along_x >= 0.0 else -1.0
        return WallPoint(foot, (-along_y * side, along_x * side))

    def floor_m(self, x: float, y: float) -> float:
        """Height of the floor at (x, y) [m, world]; NaN where there is no floor."""
        heights = meshes.heights_at(self.ground.triangles, x, y)
        return float(heights.max()) if len(heights) else math.nan

    def bare(self, point: Sequence[float]) -> str:
        """What a mesh lacks above or below `point` (3,) [m, world], as a sentence; "" where it lacks nothing."""
        heights = np.concatenate([meshes.heights_at(part.triangles, *point[:2]) for part in (self.wall, self.ground)])
        lacks = ["roof"] * (not (heights > point[2]).any()) + ["floor"] * (not (heights < point[2]).any())
        return f"no face of the mesh is a {' or a '.join(lacks)} of it, so it is open there: close it" if lacks else ""


Corners = Annotated[tuple[tuple[Metres, Metres], ...], Size(most=MOST_CORNERS)]
_SHAPE = "a list of at least 3 corners [x, y] that enclose an area"


@dataclass(frozen=True)
class _Rock:
    """What every mine has.

    Attributes:
        wall_reflectivity: share of infrared light that the walls reflect.
        ground_reflectivity: share of infrared light that the floor reflects.
    """

    wall_reflectivity: Share
    ground_reflectivity: Share


@dataclass(frozen=True)
class GroundPlan(_Rock):
    """A mine from a ground plan: rough walls, a flat floor at z = 0 and a flat ceiling.

    Attributes:
        footprint: corners [x, y] of an outline that does not cross itself [m, world].
        height_m: height of the ceiling [m].
        cell_m: grid size of the rough walls [m].
        roughness_m: greatest displacement of a grid point, at most half of cell_m [m].
        pillars: outlines of pillars [m, world].
    """

    footprint: Annotated[Corners, Examples(((-1.5, -2.0), (1.5, -2.0), (1.5, 9.5), (-1.5, 9.5)))]
    height_m: Annotated[float, Bounds(above=0.0, most=FARTHEST_M), Examples(2.7)]
    cell_m: Annotated[float, Bounds(least=0.1), Examples(0.9)]
    roughness_m: Annotated[NotNegative, Examples(0.06)]
    pillars: Annotated[tuple[Corners, ...], Size(most=MOST_CORNERS)] = ()

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse outlines that enclose nothing or cross themselves, and walls of too many triangles."""
        outer, pillars = item.need("footprint"), item.get("pillars")
        outlines = [outer, *(pillars.items() if pillars else ())]
        for ring, entry in zip((self.footprint, *self.pillars), outlines, strict=True):
            yield from _misshapen(ring, entry)
        if (corners := sum(map(len, (self.footprint, *self.pillars)))) > MOST_CORNERS:
            allowed = f"must have at most {MOST_CORNERS} corners, pillars included"
            yield InputError(f"{outer.place}: footprint {allowed}, it has {corners:,}; a mesh may have more")
        if self.roughness_m > 0.5 * self.cell_m:
            yield item.need("roughness_m").error(f">= 0 and <= {0.5 * self.cell_m:g}")
        counts = (sum(_counts(ring, self.cell_m)) for ring in (self.footprint, *self.pillars))
        triangles = 2 * _rows(self.height_m, self.cell_m) * sum(counts)
        if triangles > MeshLimits.triangles:
            most = f"{MeshLimits.triangles:,} triangles, not {triangles:,}"
            yield item.need("cell_m").error(f"so coarse that the walls have at most {most}")

    def mine(self, item: Item) -> Mine:
        """The rock between the walls."""
        # counter-clockwise, but pillars clockwise: the open space is to the left
        turned = ((ring, -1.0 if place else 1.0) for place, ring in enumerate((self.footprint, *self.pillars)))
        rings = tuple(ring if _area(ring) * sign > 0 else ring[::-1] for ring, sign in turned)
        walls = [_wall(ring, i, self.height_m, self.cell_m, self.roughness_m) for i, ring in enumerate(rings)]
        low, high = np.min(self.footprint, axis=0) - SLAB_M, np.max(self.footprint, axis=0) + SLAB_M
        ceiling, ground = _plate(low, high, self.height_m, upward=False), _plate(low, high, 0.0, upward=True)
        reflectivity = self.wall_reflectivity, self.ground_reflectivity
        return Mine(join([*walls, ceiling]), ground, True, *reflectivity, rings, self.height_m)


@dataclass(frozen=True)
class MeshMine(_Rock):
    """A mine from a mesh file, whose walls, roof and floor together enclose the open space.

    Attributes:
        mesh: path of the file, beside this one: .obj, .stl, .ply, .glb, .gltf, .dae or .off.
        scale_m: metres per unit of the file; left out: what the file says (DAE, glTF), else 1 [m].
        up: axis of the file that is up; left out: what the file says (DAE, glTF), else z.
        shift_m: moves the mesh, in world axes, so that the floor is at z = 0 where the mission begins [m].
        decimate_to: triangles to which a larger mesh, such as a scan, is reduced; left out: it stays as it is.
        ground: objects of the file that form the floor; left out: the level faces with no face below.
        mesh_limits: limits of the file.
    """

    mesh: Annotated[str, Examples("my_mine.obj")]
    scale_m: Annotated[MoreThanZero | None, Examples(0.01)] = None
    up: Literal["y", "z"] | None = None
    shift_m: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.0)
    decimate_to: Annotated[int | None, Bounds(least=100, most=1_000_000), Examples(50_000)] = None
    ground: tuple[str, ...] = ()
    mesh_limits: MeshLimits = field(default_factory=MeshLimits)

    def surface(self, item: Item) -> tuple[Path, meshes.MeshFile]:
        """The file, and what it has.

        Raises:
            InputError: the mesh is unreadable.
        """
        path, place, limits = item.path.parent / self.mesh, item.need("mesh").place, self.mesh_limits
        if self.decimate_to is not None:
            limits = replace(limits, triangles=max(limits.triangles, meshes.MOST_DECIMATED))
        file = meshes.read_mesh(path, place, *self.reading(path), limits)
        if self.decimate_to is not None:
            file = meshes.decimated(file, self.decimate_to, item.need("decimate_to").place)
        if any(self.shift_m):
            file = file._replace(mesh=file.mesh.moved(self.shift_m))
        return path, file

    def reading(self, path: Path) -> tuple[float, str]:
        """Metres per unit of the file, and its axis that is up."""
        said = meshes.stated(path)
        return self.scale_m or said.unit_m or 1.0, self.up or said.up or "z"

    def mine(self, item: Item) -> Mine:
        """The rock of the mesh.

        Raises:
            InputError: the mesh is unreadable, or has no floor.
        """
        _, file = self.surface(item)
        place = (item.get("ground") or item.need("mesh")).place
        wall, ground = meshes.split_floor(file.mesh, file.names, list(self.ground), place)
        for part, what in ((wall, "walls"), (ground, "floor")):
            faces, corners = len(part.faces), len(part.vertices)
            if faces > meshes.MOST_FACES_OF_ONE or corners > meshes.MOST_CORNERS:
                most = f"{meshes.MOST_FACES_OF_ONE:,} and {meshes.MOST_CORNERS:,} of one surface"
                sentence = f"the {what} of the mesh have {faces:,} triangles and {corners:,} vertices"
                remedy = "`decimate_to: 100000` beside `mesh` makes fewer"
                raise InputError(f"{item.need('mesh').place}: {sentence}, PyBullet takes at most {most}; {remedy}")
        return Mine(wall, ground, False, self.wall_reflectivity, self.ground_reflectivity, (), math.nan)


Rock = Annotated[GroundPlan | MeshMine, Either()]
"""The `mine` of a world."""


def read_mine(item: Item) -> Mine:
    """Read the `mine` of a world: an extruded footprint or a mesh.

    Raises:
        InputError: a value is not allowed, a key is unknown, a mesh is unreadable.
    """
    rock: GroundPlan | MeshMine = value_of(Rock, item)
    return rock.mine(item)


def flaws_of(item: Item, points: Sequence[Sequence[float]] = ()) -> tuple[Flaw, ...]:
    """The flaws of the mesh that the `mine` of a world names; none of an extruded mine.

    Args:
        item: the `mine`.
        points: (P, 3) places that must be in open space [m, world].

    Raises:
        InputError: the mesh cannot be read.
    """
    rock: GroundPlan | MeshMine = value_of(Rock, item)
    if isinstance(rock, GroundPlan):
        return ()
    path, file = rock.surface(item)
    return tuple(meshes.surface_flaws(file.mesh.triangles, file.lines, path, file.word, points))


UNITS_M = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "feet": 0.3048, "metres": 1.0}
FLOOR_M = 0.1
"""The floor at the start of the mission is at height 0, but for this [m]."""


def reading_for(item: Item, points: Sequence[Sequence[float]]) -> str:
    """The keys of a mesh with which all points are in its open space, as a remedy; or "".

    Args:
        item: the `mine`.
        points: (P, 3) places [m, world], the first one above a floor at height 0.

    Raises:
        InputError: the mesh cannot be read.
    """
    rock: GroundPlan | MeshMine = value_of(Rock, item)
    if isinstance(rock, GroundPlan):
        return ""
    path, file = rock.surface(item)
    scale_m, up = rock.reading(path)
    others = [(unit_m, axis) for axis in (up, "yz".replace(up, "")) for unit_m in (scale_m, *UNITS_M.values())]
    foot, beneath = ((*points[0][:2], z_m) for z_m in (FLOOR_M, -FLOOR_M))
    for unit_m, axis in sorted(dict.fromkeys(others), key=lambda one: (one[0] != scale_m) + (one[1] != up)):
        places = (np.array([beneath, foot, *points]) - rock.shift_m) * (scale_m / unit_m)
        if axis != up:
            places = meshes.turn_up(places) if up == "y" else meshes.turn_back(places)
        below, *above = (file.mesh.encloses(place + rock.shift_m) for place in places)
        if all(above) and not below:
            keys = [f"`scale_m: {unit_m:g}`"] * (unit_m != scale_m) + [f"`up: {axis}`"] * (axis != up)
            return f"{', '.join(keys)} beside `mesh` puts every waypoint into its open space" if keys else ""
    return ""


def _misshapen(points: Ring, item: Item) -> Iterator[InputError]:
    """An error for an outline that encloses nothing, names a corner twice, or crosses itself."""
    if len(points) < 3 or abs(_area(points)) < 1e-6:
        yield InputError(f"{item.place}: {item.name} must be {_SHAPE}")
    elif len(set(points)) < len(points):
        yield InputError(f"{item.place}: {item.name} must not name a corner twice")
    else:
        sides = list(zip(points, points[1:] + points[:1], strict=True))
        if any(_cross(*first, *second) for first, second in combinations(sides, 2)):
            yield InputError(f"{item.place}: {item.name} must not cross itself")


def _cross(a: Corner, b: Corner, c: Corner, d: Corner) -> bool:
    """Whether the segments a-b and c-d cross, each strictly between its ends."""
    return _area((a, b, c)) * _area((a, b, d)) < 0 and _area((c, d, a)) * _area((c, d, b)) < 0


def _reach(origin: Corner, direction: Corner, a: Corner, b: Corner) -> float | None:
    """Length of a ray up to the segment a-b, in units of `direction`; None where the ray misses the segment."""
    dx, dy = direction
    sx, sy = b[0] - a[0], b[1] - a[1]
    across = dx * sy - dy * sx
    if across == 0.0:
        return None
    wx, wy = a[0] - origin[0], a[1] - origin[1]
    reach, share = (wx * sy - wy * sx) / across, (wx * dy - wy * dx) / across
    return reach if reach > 0.0 and 0.0 <= share <= 1.0 else None


def _area(ring: Ring) -> float:
    return 0.5 * sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(ring, ring[1:] + ring[:1], strict=True))


def inside(outline: Iterable[tuple[Corner, Corner]], x: float, y: float) -> bool:
    """Whether (x, y) is inside closed outlines: the parity of their segments in direction +x decides."""
    crossings = sum(
        (y0 > y) != (y1 > y) and x < x0 + (y - y0) * (x1 - x0) / (y1 - y0) for (x0, y0), (x1, y1) in outline
    )
    return crossings % 2 == 1


def _plate(low: Array, high: Array, z_m: float, *, upward: bool) -> Mesh:
    corners = np.array([[low[0], low[1], z_m], [high[0], low[1], z_m], [high[0], high[1], z_m], [low[0], high[1], z_m]])
    faces: Faces = np.array([[0, 1, 2], [0, 2, 3]], np.int64)
    return Mesh(corners, faces if upward else faces[:, ::-1])


def _wall(ring: Ring, number: int, height_m: float, cell_m: float, roughness_m: float) -> Mesh:
    """The wall along a ring as a strip of triangles; its grid points are displaced by up to `roughness_m`."""
    columns: list[tuple[float, float, float, float]] = []
    sides = zip(ring[-1:] + ring[:-1], ring, ring[1:] + ring[:1], _counts(ring, cell_m), strict=True)
    for before, (x0, y0), (x1, y1), count in sides:
        inward = _inward((x0, y0), (x1, y1))
        for k in range(count):
            nx, ny = inward if k else _bisector(_inward(before, (x0, y0)), inward)
            columns.append((x0 + (x1 - x0) * k / count, y0 + (y1 - y0) * k / count, nx, ny))
    rows = _rows(height_m, cell_m)
    push = generator("mine", number).uniform(-roughness_m, roughness_m, (len(columns), rows + 1))
    grid = np.array(columns)
    vertices = np.empty((len(columns), rows + 1, 3))
    vertices[:, :, :2] = grid[:, None, :2] + push[:, :, None] * grid[:, None, 2:]
    vertices[:, :, 2] = height_m * np.arange(rows + 1) / rows
    faces = []
    for i in range(len(columns)):
        right = (i + 1) % len(columns)
        for j in range(rows):
            a, b = i * (rows + 1) + j, right * (rows + 1) + j
            faces += [(a, b + 1, b), (a, a + 1, b + 1)]
    return Mesh(vertices.reshape(-1, 3), np.array(faces, np.int64))


def _counts(ring: Ring, cell_m: float) -> list[int]:
    """Number of grid cells along each side of a ring."""
    sides = zip(ring, ring[1:] + ring[:1], strict=True)
    return [max(1, round(math.hypot(x1 - x0, y1 - y0) / cell_m)) for (x0, y0), (x1, y1) in sides]


def _rows(height_m: float, cell_m: float) -> int:
    """Number of grid cells from floor to ceiling."""
    return max(1, round(height_m / cell_m))


def _inward(p: Corner, q: Corner) -> Corner:
    """Unit normal on the left side of p -> q."""
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = math.hypot(dx, dy)
    return -dy / length, dx / length


def _bisector(a: Corner, b: Corner) -> Corner:
    """Displacement of a corner when both its walls move inwards by 1 m."""
    scale = 1.0 + a[0] * b[0] + a[1] * b[1]
    return ((a[0] + b[0]) / scale, (a[1] + b[1]) / scale) if scale > 0.2 else b
