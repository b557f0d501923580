"""Reads a mesh from a Wavefront OBJ file, within limits that the study can raise."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.document import FILE_BYTES, MIB, Item, UnreadableError, read_text
from scaloft_fi.errors import InputError, shown
from scaloft_fi.sim.mesh import Mesh

FARTHEST_M = 1e5
"""Greatest coordinate of anything in a world [m]; the stack's map and the physics server lose precision beyond."""

_LINE = re.compile(r"^[^\S\n]*([vfog])(?![^\s#])([^\n]*)", re.MULTILINE)
"""A line that counts; texture coordinates, normals, materials and comments do not."""


@dataclass(frozen=True)
class MeshLimits:
    """Limits of a mesh.

    Attributes:
        size_bytes: largest file [bytes].
        triangles: most triangles, after polygons became fans of triangles.
        corners: most corners of one polygon.
    """

    size_bytes: int = 32 * MIB
    triangles: int = 200_000
    corners: int = 1_000

    @classmethod
    def read(cls, item: Item | None) -> MeshLimits:
        """Read the `mesh_limits` of a mine; what is left out keeps its default.

        Raises:
            InputError: a limit is not allowed, or a key is unknown.
        """
        if item is None:
            return cls()
        highest = {"size_bytes": FILE_BYTES, "triangles": 10_000_000, "corners": 1_000_000}
        given = {name: entry.whole(least=1, most=most) for name, most in highest.items() if (entry := item.get(name))}
        item.close()
        return cls(**given)


def read_obj(path: Path, place: str, scale: float, limits: MeshLimits | None = None) -> tuple[Mesh, tuple[str, ...]]:
    """Read the faces of a Wavefront OBJ file; polygons become fans of triangles.

    Args:
        path: the file.
        place: `file:line` of the key that names the file, for error messages.
        scale: metres per unit of the file.
        limits: limits of the mesh; None = the defaults.

    Returns:
        The mesh, and for each face the name of its object or group ("" before the first name).

    Raises:
        InputError: the file cannot be read, is not a mesh, or exceeds a limit.
    """
    limits = limits or MeshLimits()
    try:
        text = read_text(path, limits.size_bytes).replace("\r\n", "\n").replace("\r", "\n")
    except UnreadableError as error:
        hint = f"; {_raised('size_bytes')}" if "larger" in error.reason else ""
        raise InputError(f"{place}: mesh={shown(str(path))} cannot be read: {error.reason}{hint}") from error
    vertices: list[tuple[float, ...]] = []
    faces: list[tuple[int, int, int]] = []
    names: list[str] = []
    name = ""
    for line in _LINE.finditer(text):
        # One word more than is allowed shows that there are too many; the rest of a long line is not split.
        word, rest = line[1], line[2].split("#", 1)[0].split(None, max(3, limits.corners))
        try:
            if word == "v":
                x, y, z = (float(value) * scale for value in rest[:3])
                if not all(abs(value) <= FARTHEST_M for value in (x, y, z)):
                    raise ValueError
                vertices.append((x, y, z))
            elif word == "f":
                if len(rest) > limits.corners:
                    raise _exceeded(path, text, line, f"a face must have at most {limits.corners:,} corners", "corners")
                corners = [_corner(value, len(vertices)) for value in rest]
                fan = [(corners[0], b, c) for b, c in pairwise(corners[1:])]
                if not fan:
                    raise ValueError
                faces += fan
                names += [name] * len(fan)
            else:
                name = " ".join(rest)
        except (ValueError, IndexError):
            allowed = f"a vertex `v x y z` within {FARTHEST_M:,.0f} m, or a face of known vertices"
            raise InputError(f"{path}:{_number(text, line)}: {shown(line[0].strip())} must be {allowed}") from None
        if len(faces) > limits.triangles or len(vertices) > 3 * limits.triangles:
            most = f"the mesh must have at most {limits.triangles:,} triangles, and three vertices for each"
            raise _exceeded(path, text, line, most, "triangles")
    if not faces:
        raise InputError(f"{place}: mesh={shown(str(path))} must have faces (lines `f ...`)")
    return Mesh(np.array(vertices), np.array(faces, np.int64)), tuple(names)


def lines_of_faces(path: Path, limits: MeshLimits) -> NDArray[np.int64]:
    """(F,) the line of each triangle of a file that `read_obj` can read."""
    text = read_text(path, limits.size_bytes).replace("\r\n", "\n").replace("\r", "\n")
    lines: list[int] = []
    number, counted = 1, 0
    for line in _LINE.finditer(text):
        number, counted = number + text.count("\n", counted, line.start(1)), line.start(1)
        if line[1] == "f":
            lines += [number] * (len(line[2].split("#", 1)[0].split()) - 2)
    return np.array(lines, np.int64)


def _corner(text: str, count: int) -> int:
    """Index of the vertex at a corner of a face: OBJ counts from 1, or from the end with negative numbers."""
    index = int(text.split("/", 1)[0])
    place = index - 1 if index > 0 else count + index
    if index == 0 or not 0 <= place < count:
        raise IndexError
    return place


def _number(text: str, line: re.Match[str]) -> int:
    return text.count("\n", 0, line.start(1)) + 1


def _exceeded(path: Path, text: str, line: re.Match[str], most: str, limit: str) -> InputError:
    return InputError(f"{path}:{_number(text, line)}: {most}; {_raised(limit)}")


def _raised(limit: str) -> str:
    return f"`mesh_limits: {{{limit}: ...}}` beside `mesh` allows more"
