"""What is wrong with the surface of a mesh: faces turned around, holes, faces without area, each with its line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.document import Item
from scaloft_fi.sim.mesh import Array, Faces, winding
from scaloft_fi.sim.obj import MeshLimits, lines_of_faces, read_obj

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
        sentence: what is wrong.
        remedy: what to do about it.
        grave: whether open space cannot be told from rock with it; otherwise it may be harmless.
    """

    place: str
    sentence: str
    remedy: str
    grave: bool

    def __str__(self) -> str:
        return f"{self.place}: {self.sentence}; {self.remedy}"


def flaws_of(mine: Item) -> tuple[Flaw, ...]:
    """The flaws of the mesh that the `mine` of a world names; none of an extruded mine.

    Raises:
        InputError: the mesh cannot be read.
    """
    mesh_item, scale_item = mine.get("mesh"), mine.get("scale_m")
    if mesh_item is None:
        return ()
    path, limits = mine.path.parent / mesh_item.text(), MeshLimits.read(mine.get("mesh_limits"))
    mesh, _ = read_obj(path, mesh_item.place, scale_item.number(above=0.0) if scale_item else 1.0, limits)
    return tuple(surface_flaws(mesh.triangles, lines_of_faces(path, limits), path))


def surface_flaws(triangles: Array, lines: Faces, path: Path) -> Iterator[Flaw]:
    """The flaws of a surface.

    Args:
        triangles: (F, 3, 3) corners [m].
        lines: (F,) line of each triangle in the file.
        path: the file.
    """
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    empty = 0.5 * np.linalg.norm(sides, axis=1) <= LEAST_AREA_M2
    if empty.any():
        yield Flaw(
            f"{path}:{lines[empty][0]}",
            f"{_faces(empty)} without area, the first at this line",
            "remove them, or merge the vertices that stand at one place",
            grave=False,
        )
    triangles, lines = triangles[~empty], lines[~empty]
    if len(triangles):
        yield from _closed_flaws(triangles, lines, path)


def _closed_flaws(triangles: Array, lines: Faces, path: Path) -> Iterator[Flaw]:
    surface = _Surface.of(triangles)
    if surface.one_sided.any():
        where = f"{path}:{lines[surface.one_sided][0]}"
        yield Flaw(
            where, "the surface of this face has one side only", "separate the faces that cross there", grave=True
        )
    if surface.turned.any():
        first = int(np.flatnonzero(surface.turned)[0])
        beside = surface.upright_neighbour(first)
        sentence = (
            f"{_faces(surface.turned)} wound the other way than their neighbours, the first at this line, beside the"
            f" face at line {lines[beside]}"
        )
        yield Flaw(f"{path}:{lines[first]}", sentence, _TURN, grave=True)
    yield from _swollen(triangles, lines, path, surface)
    if len(surface.open_edges):
        face, corner = surface.open_edges[0]
        start, end = triangles[face, corner], triangles[face, (corner + 1) % 3]
        sentence = (
            f"the surface has holes: {len(surface.open_edges)} edges have no second face, the first is"
            f" {_point(start)} to {_point(end)} of the face at this line"
        )
        yield Flaw(
            f"{path}:{lines[face]}", sentence, "close it, and merge the vertices that stand at one place", grave=False
        )


def _swollen(triangles: Array, lines: Faces, path: Path, surface: _Surface) -> Iterator[Flaw]:
    """Closed surfaces, such as pillars, within another one and wound like it: the space within them counts as open."""
    upright = np.where(surface.turned[:, None, None], triangles[:, ::-1], triangles)
    volumes = np.einsum("ij,ij->i", upright[:, 0], np.cross(upright[:, 1], upright[:, 2])) / 6.0
    by_piece = np.bincount(surface.piece, weights=volumes, minlength=surface.pieces)
    shell = int(np.abs(by_piece).argmax())
    alike = by_piece * by_piece[shell] > 0.0
    alike[[shell, *surface.open_pieces]] = False
    for piece in np.flatnonzero(alike)[:MOST_PIECES]:
        own = surface.piece == piece
        if _lies_within(upright[own], upright[surface.piece == shell]):
            sentence = f"this closed surface of {int(own.sum())} faces lies within another and is wound like it"
            yield Flaw(f"{path}:{lines[own][0]}", f"{sentence}, so the space in it counts as open", _TURN, grave=True)


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
        pairs: (P, 2) faces that share an edge with each other alone.
    """

    piece: Faces
    pieces: int
    turned: NDArray[np.bool_]
    one_sided: NDArray[np.bool_]
    open_edges: Faces
    pairs: Faces

    @classmethod
    def of(cls, triangles: Array) -> _Surface:
        """The surface of (F, 3, 3) triangles."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

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
        rows, columns = (
            np.concatenate([one, one + count]),
            np.concatenate([np.where(alike, other, other + count), np.where(alike, other + count, other)]),
        )
        graph: Any = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(2 * count, 2 * count))
        label = connected_components(graph, directed=False)[1]
        as_is, around = label[:count], label[count:]
        piece = np.unique(np.minimum(as_is, around), return_inverse=True)[1].reshape(-1)
        pieces = int(piece.max()) + 1
        side = as_is > around
        most = np.bincount(piece, weights=np.where(side, 1.0, -1.0), minlength=pieces) > 0.0
        odd = np.flatnonzero(uses[edge] % 2 == 1)
        return cls(
            piece=piece,
            pieces=pieces,
            turned=(side != most[piece]) & (as_is != around),
            one_sided=as_is == around,
            open_edges=np.stack([odd // 3, odd % 3], axis=1),
            pairs=pairs,
        )

    @property
    def open_pieces(self) -> frozenset[int]:
        """The pieces with an open edge."""
        return frozenset(self.piece[self.open_edges[:, 0]].tolist())

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


def _point(place: Array) -> str:
    return "(" + ", ".join(f"{number:.3g}" for number in place) + ")"
