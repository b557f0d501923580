"""The JSON Schemas of `sim/situations.yaml` and of further grids, `sim/grids/*.yaml`."""

from __future__ import annotations

from typing import Any

from scaloft_fi.sim.grid import MOST_AXES
from scaloft_fi.sim.patch import PARTS
from scaloft_fi.sim.situation import AXIS_ID, MOST_BINS, MOST_CONSTRAINTS, MOST_FREE, MOST_VALUES, Shape
from scaloft_fi.views.documents.build import (
    Schema,
    anything,
    either,
    fixed,
    listed,
    mapping,
    named,
    number,
    text,
    whole,
)
from scaloft_fi.views.documents.declared import Declared
from scaloft_fi.views.documents.sources import source_entries
from scaloft_fi.views.documents.vehicle import sensors, vehicle
from scaloft_fi.views.documents.world import world

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
