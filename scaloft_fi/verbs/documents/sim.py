"""The JSON Schemas of `sim/`: world, vehicle, sensors, stack, situations, sources, and what a command flies."""

from __future__ import annotations

from typing import Any

from scaloft_fi.document import FILE_BYTES, MOST
from scaloft_fi.outside.border import BORDERS, PORTS
from scaloft_fi.outside.command import MOST_LIMIT_S
from scaloft_fi.outside.exchange import BELOW, FRAMES, OutsideConfig, SeamConfig
from scaloft_fi.outside.records.record_map import TIME_UNITS, UNITS, Keep
from scaloft_fi.sim.grid import MOST_AXES
from scaloft_fi.sim.load import DOCUMENTS
from scaloft_fi.sim.mesh import FARTHEST_M, MeshLimits
from scaloft_fi.sim.mine import MOST_CORNERS
from scaloft_fi.sim.patch import PARTS
from scaloft_fi.sim.sensors.body import ImuConfig
from scaloft_fi.sim.situation import AXIS_ID, MOST_BINS, MOST_CONSTRAINTS, MOST_FREE, MOST_VALUES, Shape
from scaloft_fi.sim.vehicle import LARGEST, SMALLEST
from scaloft_fi.sim.world import LEAST_M, MOST_BODIES, MOST_WAYPOINTS
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.verbs.documents.schema import (
    Declared,
    Schema,
    anything,
    attributes_of,
    choice,
    either,
    fixed,
    flag,
    listed,
    mapping,
    named,
    number,
    numbers,
    probed,
    settings_schema,
    summary_of,
    text,
    whole,
)

KINDS = {
    "published": "a paper, its repository, or another publication",
    "datasheet": "maker's data, or the configuration that a device is shipped with",
    "derived": "computed from those",
    "assumption": "chosen for the study; tables of sensitivity vary these",
}


def sources(_: Declared) -> Schema:
    """`sim/sources.yaml`."""
    about = "The source of each number of `sim/` by dotted path, its document first; a path covers all below it."
    return source_entries(about)


def source_entries(about: str) -> Schema:
    """Sources by dotted path."""
    keys = {
        "kind": choice("what kind of source it is", KINDS),
        "source": text("the source, or the reason of an assumption"),
    }
    paths = rf"(?:{'|'.join(DOCUMENTS)})(?:\..+)?"
    return named(about, mapping("The source of the numbers at this path.", keys), pattern=paths)


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


SENSOR_KEYS = {
    "width": "columns of the picture [pixel]",
    "height": "rows of the picture [pixel]",
    "fov_deg": "width of the view [deg]",
    "ahead_m": "how far ahead of the vehicle's centre the camera sits [m]",
    "bearing_sigma_deg": "standard deviation of the bearing [deg]",
    "yaw_sigma_deg": "standard deviation of the heading [deg]",
    "cells": "number of cells in series",
}
"""Keys whose settings have another name or unit in the code."""


def vehicle(_: Declared) -> Schema:
    """`sim/vehicle.yaml`."""
    positive = {"least": SMALLEST, "most": LARGEST}
    spin = {"enum": [1, -1], "description": "1 or -1"}
    return mapping(
        "The vehicle: a rigid hull with four rotors.  Body axes: x forward, y left, z up.",
        {
            "mass_kg": number("mass", "kg", 1.5, **positive),
            "inertia_kgm2": numbers("principal moments of inertia x, y, z", 3, "kg m2, body", **positive),
            "hull_m": numbers(
                "edges x, y, z of the hull, a box about the centre", 3, "m, body", (0.47, 0.47, 0.11), **positive
            ),
            "rotors_m": listed(
                "places x, y of the four rotors [m, body]",
                numbers("place of a rotor", 2, "m, body", least=-LARGEST, most=LARGEST),
                least=4,
                most=4,
            ),
            "spins": listed("direction of each rotor's torque about body z", spin, least=4, most=4),
            "moment_m": number("rotor torque per thrust", "m", 0.06, **positive),
            "max_thrust_n": number("greatest thrust of one rotor; four must lift the mass", "N", 10.35, **positive),
            "spin_up_s": number("time constant of a rising thrust", "s", 0.0125, **positive),
            "spin_down_s": number("time constant of a falling thrust", "s", 0.025, **positive),
            "drag_ns_per_m": number("drag force per speed", "N s/m", 0.2, least=0, most=LARGEST),
        },
    )


def sensors(declared: Declared) -> Schema:
    """`sim/sensors.yaml`."""
    needed = {"imu": _sensor(ImuConfig.read, "The inertial sensor, 240 Hz.")}
    optional: dict[str, Schema] = {}
    for name, kind in declared.sensors.items():
        if kind.read is None and kind.required:
            continue  # it has no settings, so no entry
        about = (
            f"The sensor {name}, {20.0 / kind.period_ticks:g} Hz."
            if kind.read
            else f"The sensor {name}; it has no settings."
        )
        schema = _sensor(kind.read, about) if kind.read else mapping(about, {})
        (needed if kind.required else optional)[name] = schema
    return mapping("The sensors: the stack gets data of the simulator only through them.", needed, optional)


def _sensor(read: object, about: str) -> Schema:
    config = getattr(read, "__self__", None)
    told = {**attributes_of(config), **SENSOR_KEYS} if isinstance(config, type) else SENSOR_KEYS
    more = f"  {summary_of(config)}" if isinstance(config, type) else ""
    assert callable(read)
    return probed(read, about + more, told, closed=True)


OUTSIDE = "outside"


def stack(declared: Declared) -> Schema:
    """`sim/stack.yaml`."""
    forms = [form for name, one in declared.stacks.items() for form in _forms(name, one)]
    return either("The stack under test: its name, and its settings.", *forms)


def _forms(name: str, declared: Declaration) -> list[Schema]:
    if name == OUTSIDE:
        return _outside()
    if declared.settings is None:
        free = mapping(f"The stack {name}.", {"name": fixed(name, "the stack")})
        return [{**free, "additionalProperties": True}]
    return [_of(name, settings_schema(declared.settings(), about=f"The stack {name}."))]


def _of(name: str, settings: Schema) -> Schema:
    about = "the stack; another name means other settings"
    return {
        **settings,
        "properties": {"name": fixed(name, about), **settings["properties"]},
        "required": ["name", *settings["required"]],
    }


def _outside() -> list[Schema]:
    """A form for each part of our drone that may fly below the stages outside."""
    from scaloft_fi.outside.stack import GoalConfig, VelocityConfig

    forms = []
    for below, config in (("flight_control", VelocityConfig), ("planner", GoalConfig)):
        taken = " and ".join(BELOW[below])
        told = attributes_of(OutsideConfig)
        instead = {
            "border": choice(told["border"], tuple(BORDERS)),
            "below": fixed(below, f"{told['below']} Takes {taken} from outside."),
            "seams": named(told["seams"], _seam(below)),
        }
        about = f"Stages in other processes above {below.replace('_', ' ')} of our drone."
        schema = _of(OUTSIDE, settings_schema(config, about=about, instead=instead))
        schema["properties"]["inside"]["description"] = told["inside"]
        forms.append(schema)
    return forms


def _seam(below: str) -> Schema:
    ports = {name: port.meaning for name, port in PORTS.items() if port.outward or name in BELOW[below]}
    told = attributes_of(SeamConfig)
    schema = settings_schema(
        SeamConfig,
        instead={
            "carries": choice(told["carries"], ports),
            "frame": text(told["frame"]) | {"examples": list(FRAMES[1:])},
        },
    )
    schema["properties"]["carries"]["description"] = choice(told["carries"], ports)["description"]
    del schema["properties"]["frame"]["minLength"]
    return schema


NAME = "[A-Za-z0-9_-]{1,100}"
PATH = "path of one value, such as mission.cruise_mps of world.yaml, vehicle.mass_kg, sensors.battery.charge"
CHOOSE = "how a run chooses situations when nobody says it, as for `run --choose`; left out: all"


def situations(_: Declared) -> Schema:
    """`sim/situations.yaml`."""
    name = text("name of this grid, as for --grid; left out: situations", "paper", pattern=NAME)
    return mapping("The axes of the study's own grid of situations.", _needed(), {"name": name, **_optional()})


def grid(declared: Declared) -> Schema:
    """`sim/grids/<name>.yaml`."""
    about = "what only this grid has: new entries of world, vehicle and sensors, as those documents have them"
    more = {
        "adds": mapping(about, {}, _additions(declared)),
        "sources": source_entries("the source of each number of this file by dotted path, as in sim/sources.yaml"),
    }
    return mapping(
        "The axes of a further grid over the same world; `run --grid` flies it.", _needed(), {**_optional(), **more}
    )


def _additions(declared: Declared) -> dict[str, Schema]:
    """New entries of each document; an entry that exists may get new keys."""
    documents = {"world": world(declared), "vehicle": vehicle(declared), "sensors": sensors(declared)}
    return {part: _loosened(documents[part], f"new entries of sim/{part}.yaml") for part in PARTS}


def _loosened(document: Schema, about: str) -> Schema:
    """A mapping of which nothing is needed, and whose entries by name may be parts of entries."""
    keys = {}
    for key, schema in document["properties"].items():
        each = schema.get("additionalProperties") or next(iter(schema.get("patternProperties", {}).values()), None)
        if each:
            part = {"anyOf": [each, {"type": "object", "description": "new keys of an entry that exists"}]}
            schema = {"type": "object", "description": schema["description"], "additionalProperties": part}
        elif schema.get("type") == "object":
            schema = {**schema, "required": []}
        keys[key] = schema
    return {**document, "description": about, "properties": keys, "required": []}


def _needed() -> dict[str, Schema]:
    axis = either("An axis: single values, or a range of one number.", _axis_of_values(), _axis_of_range())
    about = "the axes by name, a capital letter, then small ones, in the order of the keys"
    return {"axes": named(about, axis, pattern=AXIS_ID.pattern, least=1, most=MOST_AXES)}


def _optional() -> dict[str, Schema]:
    exclude = named("values of two or more axes that do not go together, by axis", _value_ids(), least=2)
    constraint = mapping(
        "A combination that the grid leaves out.",
        {"exclude": exclude, "reason": text("why no situation has the combination")},
    )
    about = "numbers around the situations that span no grid; at the benign value left out of keys"
    return {
        "choose": text(CHOOSE, "3-way", "random:20", "sobol:32"),
        "constraints": listed("combinations of values that the grid leaves out", constraint, most=MOST_CONSTRAINTS),
        "free": named(about, _free_axis(), pattern=AXIS_ID.pattern, most=MOST_FREE),
        "aliases": named("other names of situations, by name", text("key of a situation", "T0O0W0D0H1")),
    }


def _common() -> dict[str, Schema]:
    return {
        "title": text("name of the axis in tables", "lighting condition"),
        "category": text("category of the operational design domain", "environment, light level"),
    }


def _axis_of_values() -> Schema:
    sets = {
        "type": "object",
        "description": f"what the value changes: new values by path; {PATH}",
        "additionalProperties": anything("the new value"),
        "propertyNames": {"pattern": "^(?!stack(\\.|$))"},
        "examples": [{"bodies.person.present": True}, {"light": 0.003}],
    }
    title = text("name of the value in tables", "dark")
    realised = text(
        "formula over the flight log: whether a flight met the value; `scaloft-fi signals` lists the signals",
        "eventually(person_sight_m <= 3)",
    )
    value = either(
        "A value of the axis; ids count from 0.",
        mapping(
            "The benign value, met by a flight that meets no other.",
            {"id": fixed(0, "the benign value"), "title": title},
            {"set": sets},
        ),
        mapping(
            "Another value.",
            {
                "id": whole("place in the list; it stands in keys, as in T1", 1, least=1),
                "title": title,
                "realised": realised,
            },
            {"set": sets},
        ),
    )
    return mapping(
        "An axis with single values.",
        {**_common(), "values": listed("the values, the benign one first", value, least=2, most=MOST_VALUES)},
    )


def _axis_of_range() -> Schema:
    bins = whole("number of parts of the same probability, each one value of the grid", 4, least=2, most=MOST_BINS)
    range_ = _distributed("A range of one number.", {**_ends(), "bins": bins}, {})
    realised = text(
        "formula over the flight log, with the word `number` for the number that is flown",
        "eventually(speed_mps >= 0.8 * number)",
    )
    return mapping("An axis that is a range of one number.", {**_common(), "range": range_, "realised": realised})


def _free_axis() -> Schema:
    also = {
        "type": "object",
        "description": "what else a number off the benign value sets, by path",
        "additionalProperties": anything("a single value"),
        "examples": [{"happenings.dust.active": True}],
    }
    only = named("values of other axes without which the number has no effect or cannot be, by axis", _value_ids())
    return _distributed(
        "A number around the situations of the grid.", {**_common(), **_ends()}, {"also": also, "only_with": only}
    )


def _ends() -> dict[str, Schema]:
    return {
        "set": text(f"the number: {PATH}", "mission.cruise_mps"),
        "from": number("lower end, at most four significant digits", "", 0.4),
        "to": number("upper end, at most four significant digits", "", 1.2),
        "unit": text("unit of the number", "m/s"),
        "benign": number("the benign number; of a free axis the one that the documents have", "", 0.5),
    }


def _distributed(about: str, needed: dict[str, Schema], optional: dict[str, Any]) -> Schema:
    more = {
        Shape.UNIFORM: ("every number is as likely", {}),
        Shape.LOG_UNIFORM: ("every ratio is as likely; both ends above 0", {}),
        Shape.NORMAL: (
            "normal, cut off at both ends",
            {
                "mean": number("mean before it is cut off"),
                "sd": number("standard deviation before it is cut off", above=0),
            },
        ),
        Shape.TRIANGULAR: ("triangular", {"mode": number("the likeliest number, between both ends")}),
    }
    forms = [
        mapping(about, {**needed, "distribution": fixed(shape.value, words), **own}, optional)
        for shape, (words, own) in more.items()
    ]
    return either(about, *forms)


def _value_ids() -> Schema:
    one = whole("id of a value", 1)
    return {
        "description": "id of a value, or a list of ids",
        "anyOf": [one, {"type": "array", "items": one, "minItems": 1}],
    }


PLACES = "{situation}, {seed}, {fault}, {record}, {folder}, {study}, {python}"


def flyer(_: Declared) -> Schema:
    """`sim/flyer.yaml`."""
    word = {"type": ["string", "number"]}
    return mapping(
        "A command that flies instead of our simulator.",
        {
            "flyer": fixed("command", "a command flies"),
            "run": listed(
                f"program and arguments; {PLACES} and values of the situation by dotted path stand in braces",
                {**word, "description": "a word of the command"},
                least=1,
                most=MOST,
                examples=(["{python}", "fly.py", "--situation", "{situation}", "--record", "{record}"],),
            ),
            "record": text(
                "name of the file, in a private folder of the flight, that it records to; with * any that fits",
                "flight.csv",
            ),
            "limit_s": number("longest wall time of a flight", "s", 120, above=0, most=MOST_LIMIT_S),
        },
        {
            "env": named(
                "environment variables beside ours; with the same places in braces",
                {**word, "description": "a value"},
                most=MOST,
            ),
            "mission_s": number("time limit of a flight, simulated; left out: that of its situation", "s", above=0),
            "inputs": listed(
                "files of the study, beside sim/, that decide what is flown; a changed one flies again",
                text("path inside the study", "fly.py"),
                most=MOST,
            ),
            "deterministic": flag(
                "whether two flights of the same subject, situation and seed are the same", default=False
            ),
            "seams": named(
                "the seams that the matrix may use, by name; `every` stands for all of the stack",
                _offer(),
                most=MOST,
            ),
            "clock": mapping(
                "The topic on which the simulator tells its time; left out: by the stamps of messages.",
                {"topic": text("name of the topic", "/clock"), "border": _border()},
                {"type": text("type of its messages")},
            ),
        },
    )


def _border() -> Schema:
    return choice("what the topic goes over", tuple(BORDERS))


def _offer() -> Schema:
    message = {
        "message": choice(
            "the port whose message it has; left out: as the stack declares the seam",
            {n: p.meaning for n, p in PORTS.items()},
        )
    }
    relay = mapping(
        "A relay between two topics of the simulator, with the fault in it.",
        {
            "from": text("the topic that it reads", "/cmd_vel"),
            "to": text("another topic, which it writes", "/cmd_vel_faulty"),
            "border": _border(),
        },
        {
            "type": text("type of the messages, as the border names it", "geometry_msgs/msg/Twist"),
            "frame": text("frame id of messages"),
            "qos": named("quality of service, as the border names it", anything("a setting"), most=MOST),
            "fields": named(
                "fields of the border's message by path to those of the sample", text("a field"), most=MOST
            ),
        },
    )
    return either(
        "How the faults of a seam reach the simulator.",
        mapping(
            "The command gets the fault in {fault} and injects it itself.",
            {"parameter": fixed(True, "by {fault}")},
            message,
        ),
        mapping("Our relay alters the messages of a topic.", {"relay": relay}, message),
    )


def record(_: Declared) -> Schema:
    """`sim/record.yaml`."""
    about = "where the signals stand, by name; `scaloft-fi signals` says which follow from others"
    return mapping(
        "Where the signals of the requirements stand in a record of a flight.",
        {"signals": named(about, _signal(), least=0, most=MOST)},
        {
            "time": _time(),
            "start": _moment(
                "When the flight starts: at the first message of at least `least`; left out: the first of x_m."
            ),
            "end": _moment(
                "When the flight ends: at the first message of at least `least`; left out: the last of x_m."
            ),
            "altered": _counted("How many samples a fault has altered up to then."),
            "carried": _counted("How many samples the fault's seam has carried up to then."),
        },
    )


def _where() -> tuple[dict[str, Schema], dict[str, Schema]]:
    """Two ways to say where a value stands: in a table, in messages."""
    column = {"column": text("name of the column", "east")}
    topic = {"topic": text("the topic", "/odom"), "field": text("path of the field", "pose.pose.position.x", "q[0]")}
    return column, topic


def _signal() -> Schema:
    value = {"type": ["number", "boolean"]}
    optional = {
        "unit": choice("conversion to the signal's unit; not beside factor and offset", tuple(UNITS)),
        "factor": number("signal = factor x value + offset", default=1),
        "offset": number("signal = factor x value + offset", default=0),
        "unknown": {
            **value,
            "description": "its value before the first message; left out: it must have one by the start",
        },
        "keep": choice("which value stands for the messages since the last sample", tuple(Keep), default=Keep.LAST),
    }
    forms = [
        mapping(name, needed, optional) for name, needed in zip(("In a table.", "In messages."), _where(), strict=True)
    ]
    constant = mapping("Nowhere: always the same.", {"constant": {**value, "description": "the value"}})
    return either("Where a signal stands.", *forms, constant)


def _time() -> Schema:
    messages = {"received": "the time at which a message was received", "stamp": "the stamp in the message"}
    return either(
        "Which time the values have; left out: at which messages were received.",
        mapping(
            "A column of a table.",
            {"column": text("name of the column", "t_s")},
            {"unit": choice("its unit", tuple(TIME_UNITS), default="s")},
        ),
        mapping("Of the messages.", {"message": choice("which time of a message counts", messages)}),
        mapping("A topic that tells the simulated time.", {"clock": text("the topic", "/clock")}),
    )


def _moment(about: str) -> Schema:
    least = {"least": number("the least value that counts", "", 1)}
    return either(about, *(mapping(about, {**where, **least}) for where in _where()))


def _counted(about: str) -> Schema:
    return either(about, *(mapping(about, where) for where in _where()))
