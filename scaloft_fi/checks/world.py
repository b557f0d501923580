"""World, vehicle and sensors of a study, piece by piece."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from scaloft_fi.checks.finding import Findings, Severity, finding_of
from scaloft_fi.document import Item, load
from scaloft_fi.sim.happenings import check_happenings, read_happening
from scaloft_fi.sim.mesh import flaws_of
from scaloft_fi.sim.mine import Mine, read_mine
from scaloft_fi.sim.sensors import read_sensors
from scaloft_fi.sim.vehicle import read_vehicle
from scaloft_fi.sim.world import World, assembled, misplaced, read_body, read_light, read_mission, read_waypoint

MOST_TIMES, LEAST_WAY_M = 10.0, 10.0
"""A mesh more than this many times as large, in every direction, as the way is long, or as this [m], is told of."""


def check_world(path: Path, findings: Findings) -> World | None:
    """Read a world; None where it cannot be read.

    Args:
        path: `sim/world.yaml`.
        findings: takes the findings.
    """
    mine: Mine | None = None
    with findings.collecting():
        pieces = load(path).mapping()
        if "mine" in pieces:
            with findings.collecting():
                check_mesh(pieces["mine"], findings)
                mine = read_mine(load(path).need("mine"))
        findings.each(lambda one: read_body(*one), _entries(pieces, "bodies"))
        waypoints = list(_entries(pieces, "waypoints"))
        findings.each(lambda one: read_waypoint(one[1], 0.0), waypoints)
        if "mission" in pieces:
            with findings.collecting():
                read_mission(pieces["mission"], [name for name, _ in waypoints])
        if "light" in pieces:
            with findings.collecting():
                read_light(pieces["light"])
        findings.each(lambda one: read_happening(*one), _entries(pieces, "happenings"))
        document = load(path)
        world, happenings = assembled(document, mine)
        if findings.all_of(misplaced(world, document)):
            check_size(world, document, findings)
            check_happenings(world, happenings)
            return world
    return None


def _entries(pieces: dict[str, Item], name: str) -> Iterable[tuple[str, Any]]:
    """The entries of a mapping of the world; none where there is no such mapping, which the whole world is told of."""
    value = pieces[name].value if name in pieces else None
    return value.items() if isinstance(value, dict) else ()


def check_mesh(mine: Item, findings: Findings) -> None:
    """The flaws of the mesh of a mine; the flaws that may be harmless are notes.

    Raises:
        InputError: the mesh cannot be read.
    """
    for flaw in flaws_of(mine):
        findings.add(finding_of(str(flaw), Severity.ERROR if flaw.grave else Severity.NOTE))


def check_size(world: World, item: Item, findings: Findings) -> None:
    """A note for a mesh so large beside the route that it may be in another unit."""
    mesh = item.need("mine").get("mesh")
    if mesh is None:
        return
    low, high = world.mine.extents
    places = [place[:2] for place in world.waypoints.values()]
    way_m = max(math.dist(one, other) for one in places for other in places)
    if min(high - low) > MOST_TIMES * max(way_m, LEAST_WAY_M):
        mine = world.mine.extents_text
        findings.note(
            mesh.place,
            f"the mine reaches from {mine} m, and no two waypoints are more than {way_m:.3g} m apart",
            "`scale_m` is metres per unit of the file, such as 0.001 for millimetres",
        )


def check_vehicle(folder: Path, findings: Findings) -> None:
    """Vehicle and sensors, each on its own."""
    with findings.collecting():
        read_vehicle(load(folder / "vehicle.yaml"))
    with findings.collecting():
        read_sensors(load(folder / "sensors.yaml"))
