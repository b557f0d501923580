"""What users import, and all that a plugin needs: `from scaloft_fi.api import ...`.

A plugin is a module that declares stacks, operators, sensors, export formats and ways to choose situations when it is
imported, named by an entry point of the group `scaloft_fi.plugins`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from scaloft_fi.marks import Bounds, Choices, Count, Examples, NotNegative, Pattern, Positive, Size
from scaloft_fi.mutants.operator import (
    ANYTHING,
    IMAGE,
    NUMBERS,
    STAMP,
    Axis,
    Component,
    Degrees,
    Example,
    Factor,
    Facts,
    Hold,
    Metres,
    Need,
    Number,
    NumericField,
    Period,
    Range,
    Seconds,
    Share,
    Tap,
    TapContext,
    Windows,
    operator,
    the,
)
from scaloft_fi.mutants.sample import on_each, within
from scaloft_fi.sim.log import signal
from scaloft_fi.sim.stacks import declare_claims, declare_stack
from scaloft_fi.stack import messages
from scaloft_fi.stack.declaration import (
    STEP_HZ,
    STEP_S,
    TICK_HZ,
    TICK_S,
    Belief,
    Claim,
    Declaration,
    FastPath,
    Instant,
    Mark,
    PlainStack,
    PlainWire,
    Seam,
    Stack,
    Task,
    Wire,
)
from scaloft_fi.stack.messages import Array, Image, Point, Stamp, Vector
from scaloft_fi.streams import Table

if TYPE_CHECKING:
    from scaloft_fi.campaign.flights.check_stack import StackCheck, check_stack
    from scaloft_fi.campaign.runs.request import Asked, strategy
    from scaloft_fi.mutants.check_operator import OperatorCheck, check_operator, operators_of
    from scaloft_fi.outside.border import BORDERS, Arrival, BorderError, CameraInfo, Land, Topic
    from scaloft_fi.outside.exchange import Command, Processes
    from scaloft_fi.outside.lines import Codec, LinesBorder
    from scaloft_fi.outside.ros2 import LAYOUTS, Ends, Layout, layout_of, sample_in
    from scaloft_fi.sim.happenings import HAPPENINGS, Effect, HappeningKind, Surroundings
    from scaloft_fi.sim.sensors.sensor import SENSORS, FlightSetting, Moment, SensorKind
    from scaloft_fi.sim.world import ROLES, Role
    from scaloft_fi.stack.reference.declaration import REFERENCE
    from scaloft_fi.stack.reference.messages import SpeedLimit
    from scaloft_fi.stack.reference.planner import LocalPlan, Planner
    from scaloft_fi.stack.reference.stack import ReferenceStack
    from scaloft_fi.study import Study
    from scaloft_fi.verbs.export.dossier import Dossier, export_format

LATE = {
    name: f"scaloft_fi.{module}"
    for module, names in {
        "campaign.flights.check_stack": "StackCheck check_stack",
        "campaign.runs.request": "Asked strategy",
        "mutants.check_operator": "OperatorCheck check_operator operators_of",
        "outside.border": "Arrival BORDERS BorderError CameraInfo Land Topic",
        "outside.exchange": "Command Processes",
        "outside.lines": "Codec LinesBorder",
        "outside.ros2": "Ends LAYOUTS Layout layout_of sample_in",
        "sim.happenings": "Effect HAPPENINGS HappeningKind Surroundings",
        "sim.sensors.sensor": "FlightSetting Moment SENSORS SensorKind",
        "sim.world": "ROLES Role",
        "stack.reference.declaration": "REFERENCE",
        "stack.reference.messages": "SpeedLimit",
        "stack.reference.planner": "LocalPlan Planner",
        "stack.reference.stack": "ReferenceStack",
        "study": "Study",
        "verbs.export": "Dossier export_format",
    }.items()
    for name in names.split()
}
"""Where the names are that no flight needs, or that bring the compiler or a table library; imported by whoever asks for
one of them, so that the keys of a plugin's flights leave the rest out."""

# for operators
__all__ = ["ANYTHING", "IMAGE", "NUMBERS", "STAMP", "Axis", "Component", "Degrees", "Example", "Factor", "Facts"]
__all__ += ["Hold", "Metres", "Need", "Number", "NumericField", "OperatorCheck", "Period", "Range", "Seconds"]
__all__ += ["Share", "Tap", "TapContext", "Windows", "check_operator", "on_each", "operator", "operators_of", "the"]
__all__ += ["within"]
# for settings
__all__ += ["Bounds", "Choices", "Count", "Examples", "NotNegative", "Pattern", "Positive", "Size"]
# for stacks
__all__ += ["STEP_HZ", "STEP_S", "TICK_HZ", "TICK_S", "Belief", "Claim", "Declaration", "FastPath", "Instant", "Mark"]
__all__ += ["PlainStack", "PlainWire", "Seam", "SpeedLimit", "Stack", "StackCheck", "Task", "Wire", "check_stack"]
__all__ += ["declare_claims", "declare_stack"]
# for planners in the reference stack
__all__ += ["REFERENCE", "LocalPlan", "Planner", "ReferenceStack"]
# for samples and their noise
__all__ += ["Array", "Image", "Point", "Stamp", "Table", "Vector", "messages"]
# for worlds, sensors and signals
__all__ += ["HAPPENINGS", "ROLES", "SENSORS", "Effect", "FlightSetting", "HappeningKind", "Moment", "Role"]
__all__ += ["SensorKind", "Surroundings", "signal"]
# for stages and simulators outside
__all__ += ["BORDERS", "LAYOUTS", "Arrival", "BorderError", "CameraInfo", "Codec", "Command", "Ends", "Land"]
__all__ += ["Layout", "LinesBorder", "Processes", "Topic", "layout_of", "sample_in"]
# for campaigns and exports
__all__ += ["Asked", "Dossier", "Study", "export_format", "strategy"]


def __getattr__(name: str) -> Any:
    """A name of `LATE`.

    Raises:
        AttributeError: there is none.
    """
    if name not in LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(LATE[name]), name)
