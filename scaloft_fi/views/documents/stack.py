"""The JSON Schema of `sim/stack.yaml`: the stack under test, and its settings as the stack declares them."""

from __future__ import annotations

from scaloft_fi.outside.border import BORDERS, PORTS
from scaloft_fi.outside.exchange import BELOW, FRAMES, OutsideConfig, SeamConfig
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.views.documents.build import Schema, choice, either, fixed, mapping, named, text
from scaloft_fi.views.documents.declared import Declared
from scaloft_fi.views.documents.docstrings import attributes_of
from scaloft_fi.views.documents.settings import settings_schema

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
