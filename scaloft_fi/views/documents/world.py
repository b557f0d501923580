"""The JSON Schema of `sim/world.yaml`: mine, bodies, waypoints, mission, happenings."""

from __future__ import annotations

from typing import Any

from scaloft_fi.document import FILE_BYTES
from scaloft_fi.sim.mesh import FARTHEST_M, MeshLimits
from scaloft_fi.sim.mine import MOST_CORNERS
from scaloft_fi.sim.world import LEAST_M, MOST_BODIES, MOST_WAYPOINTS
from scaloft_fi.views.documents.build import (
    Schema,
    choice,
    either,
    fixed,
    flag,
    listed,
    mapping,
    named,
    number,
    numbers,
    text,
    whole,
)
from scaloft_fi.views.documents.declared import Declared
from scaloft_fi.views.documents.docstrings import summary_of
from scaloft_fi.views.documents.probe import probed

CAPSULE_HEIGHT = "height, at least twice the radius"
IDENTIFIER = r"(?!(?:wall|ground)$)[^\W\d]\w*"
HAPPENINGS = {
    "body": "name of a present body of this file",
    "path": "places [x, y] that the body goes to, straight, in order [m, world]",
    "speed_mps": "its speed [m/s]",
    "light": "the visible light becomes this, 0 (dark) to 1",
    "velocity_mps": "velocity of the air x, y, z [m/s, world]",
    "haze_per_m": "extinction of light; 5 % of the contrast is left after 3 / haze_per_m [1/m]",
    "rate_mps": "every fix is off by this rate x, y, z times the time since the start [m/s, world]",
}
"""What the keys of the package's happenings are."""


def world(declared: Declared) -> Schema:
    """`sim/world.yaml`."""
    return mapping(
        "The mine, its bodies, the mission and what happens during a flight.  World axes: x east, y north, z up.",
        {
            "mine": _mine(),
            "bodies": named(
                "the bodies by name; each has a clearance in the log",
                _body(declared),
                pattern=IDENTIFIER,
                most=MOST_BODIES,
            ),
            "waypoints": named(
                "the places of the mission by name; without z at the mission's altitude",
                _place("x, y, or x, y, z, in the open space [m, world]"),
                most=MOST_WAYPOINTS,
            ),
            "mission": _mission(),
            "light": number("brightness of visible light: 0 dark, 1 full", "", 0.9, 0.003, least=0, most=1),
        },
        {
            "signals": listed(
                "optional signals that every flight records; `scaloft-fi signals` lists them",
                choice("an optional signal", {name: one.meaning for name, one in declared.signals.items()}),
            ),
            "happenings": named("what happens during a flight, by name", _happening(declared)),
        },
    )


def _place(about: str) -> Schema:
    return {
        "type": "array",
        "description": about,
        "items": {"type": "number"},
        "minItems": 2,
        "maxItems": 3,
        "examples": [[0.0, 7.0], [0.0, 7.0, 1.4]],
    }


def _mine() -> Schema:
    reflectivity = {
        "wall_reflectivity": number("share of infrared light that the walls reflect", "", 0.5, least=0, most=1),
        "ground_reflectivity": number("share of infrared light that the floor reflects", "", 0.5, least=0, most=1),
    }
    ring = listed(
        "corners [x, y] of an outline that does not cross itself [m, world]",
        _corner(),
        least=3,
        most=MOST_CORNERS,
        examples=([[-1.5, -2.0], [1.5, -2.0], [1.5, 9.5], [-1.5, 9.5]],),
    )
    extruded = mapping(
        "A mine from a ground plan: rough walls, a flat floor at z = 0 and a flat ceiling.",
        {
            "footprint": ring,
            "height_m": number("height of the ceiling", "m", 2.7, above=0, most=FARTHEST_M),
            "cell_m": number("grid size of the rough walls", "m", 0.9, least=0.1),
            "roughness_m": number("greatest displacement of a grid point, at most half of cell_m", "m", 0.06, least=0),
            **reflectivity,
        },
        {"pillars": listed("outlines of pillars", ring, most=MOST_CORNERS)},
    )
    limits = MeshLimits()
    mesh = mapping(
        "A mine from an OBJ file, whose walls, roof and floor together enclose the open space.",
        {"mesh": text("path of the file, beside this one", "my_mine.obj"), **reflectivity},
        {
            "scale_m": number("metres per unit of the file", "m", 0.01, above=0, default=1),
            "ground": listed(
                "objects of the file that form the floor; left out: the level faces with no face below",
                text("name of an object", "floor"),
            ),
            "mesh_limits": mapping(
                "Limits of the file, which you may raise; time and memory of a flight grow with the triangles.",
                {},
                {
                    "size_bytes": whole("largest file [bytes]", least=1, most=FILE_BYTES, default=limits.size_bytes),
                    "triangles": whole("most triangles", least=1, most=10_000_000, default=limits.triangles),
                    "corners": whole("most corners of one face", least=1, most=1_000_000, default=limits.corners),
                },
            ),
        },
    )
    return either("The rock: a ground plan, or a mesh of your own.", extruded, mesh)


def _corner() -> Schema:
    return numbers("a corner x, y", 2, "m, world", least=-FARTHEST_M, most=FARTHEST_M)


def _body(declared: Declared) -> Schema:
    roles = {name: role.meaning for name, role in declared.roles.items()}
    position = {**_place("x, y of its foot, and the height of the foot where it stands on something [m, world]")}
    position["items"] = {"type": "number", "minimum": -FARTHEST_M, "maximum": FARTHEST_M}
    common = {
        "role": choice("how detector, observer and map treat it", roles),
        "position": position,
        "reflectivity": number(
            "share of infrared light that it reflects; dark bodies vanish in the dark", "", 0.3, least=0, most=1
        ),
        "present": flag("whether it is there; an axis may set this"),
    }
    optional = {"optional": flag("whether flights without it have no signal of it", default=False)}
    size = listed(
        "edges x, y, z of the box [m]",
        {"type": "number", "minimum": LEAST_M, "maximum": FARTHEST_M},
        least=3,
        most=3,
        examples=([0.5, 0.5, 1.8],),
    )
    radius = number("radius", "m", 0.25, least=LEAST_M, most=FARTHEST_M)

    def turned(shape: str, about: str, height: Schema) -> Schema:
        keys = {"shape": fixed(shape, about), "radius_m": radius, "height_m": height}
        return mapping(f"A {shape}.", {**keys, **common}, optional)

    return either(
        "A body in the mine.",
        mapping("A box.", {"shape": fixed("box", "a box about the vertical"), "size_m": size, **common}, optional),
        turned("cylinder", "an upright cylinder", number("height", "m", 2.7, least=LEAST_M, most=2 * FARTHEST_M)),
        turned("capsule", "an upright cylinder with round ends", number(CAPSULE_HEIGHT, "m", 1.7, most=2 * FARTHEST_M)),
    )


def _mission() -> Schema:
    nominal = mapping(
        "Speeds of the nominal flight, from which the time limit follows.",
        {
            "climb_mps": number("speed of climb at the start", "m/s", 0.7, above=0),
            "sink_mps": number("speed of descent at the end", "m/s", 0.5, above=0),
            "turn_degps": number("rate of a turn on the spot", "deg/s", 45.0, above=0),
            "dwell_s": number("pause after take-off", "s", 0.5, least=0),
        },
    )
    return mapping(
        "What the drone has to fly.",
        {
            "home": numbers("where it takes off, x, y; the floor there is at z = 0", 2, "m, world", (0.0, 0.0)),
            "yaw_deg": number("heading at the start, from x, left positive", "deg", 0.0),
            "route": listed(
                "names of waypoints in order; it lands at the last one",
                text("a waypoint, or home", "home"),
                least=1,
                most=MOST_WAYPOINTS,
                examples=(["corner", "home"],),
            ),
            "altitude_m": number("altitude of flight, where a waypoint has none of its own", "m", 1.65, above=0),
            "cruise_mps": number("cruise speed", "m/s", 0.5, above=0),
            "slow_mps": number("speed after the first detection of a person", "m/s", 0.2, above=0),
            "nominal": nominal,
        },
    )


def _happening(declared: Declared) -> Schema:
    near = {
        "near": numbers("the vehicle comes near this place x, y", 2, "m, world", (0.0, 3.5)),
        "within_m": number("level distance from the place", "m", 0.7, above=0),
    }
    at_s = number("earliest time from the start of the flight", "s", 20.0, least=0)
    start = either(
        "When it starts; left out: at take-off.",
        mapping("At a time.", {"at_s": at_s}),
        mapping("Where the vehicle comes near a place.", near, {"at_s": at_s}),
    )
    kinds = []
    for name, kind in declared.happenings.items():
        effect = getattr(kind.read, "__self__", None)
        about = summary_of(effect) if isinstance(effect, type) else f"a happening of kind {name}"
        own = probed(kind.read, about, HAPPENINGS, closed=True)
        kinds.append(_of_kind(name, own, start))
    return either("What changes around the vehicle; an axis may set `active`.", *kinds)


def _of_kind(name: str, own: Schema, start: Schema) -> Schema:
    keys: dict[str, Any] = {
        "kind": fixed(name, own["description"]),
        "active": flag("whether it happens"),
        **own.get("properties", {}),
    }
    optional = {
        "start": start,
        "lasts_s": number("how long it lasts; left out: to the end of the flight", "s", 5.0, above=0),
    }
    return {
        **mapping(own["description"], keys, optional),
        "required": ["kind", "active", *own.get("required", ())],
        "additionalProperties": own.get("additionalProperties", True),
    }
