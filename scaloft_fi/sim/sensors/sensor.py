"""The interface of a sensor: its declaration, its inputs, its measurement at a tick.

A plugin adds a sensor with one class and one declaration, in a module that its entry point in the group
`scaloft_fi.plugins` names:

    class RangeFinder:
        def __init__(self, config: RangeConfig, flight: FlightSetting) -> None: ...
        def measure(self, moment: Moment) -> Range | None: ...

    SENSORS.declare("range", SensorKind(RangeFinder, Range, RangeConfig, latency_s=0.05))

If `sensors.yaml` of a study has an entry `range`, its flights have the sensor, and the stack reads `frames["range"]`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Annotated, Any, NamedTuple, Protocol

from scaloft_fi.marks import Bounds
from scaloft_fi.registry import Registry
from scaloft_fi.sim.contact import Contact
from scaloft_fi.sim.happenings import Surroundings
from scaloft_fi.sim.mesh import Scene, View
from scaloft_fi.stack.messages import Exposure, Stamps
from scaloft_fi.streams import Array


@dataclass(frozen=True, eq=False)
class FlightSetting:
    """The constants of a flight.

    Attributes:
        settings: settings of every sensor of the study, by the sensor's name.
        scene: the triangles of the world; bodies that can move stand where they are at the present tick.
        labels: class label of each body that the person detector finds, by the body's name.
        stream: name of the flight's noise: key of the situation, and seed.  A sensor draws from
            `streams.Table(width, *stream, "name of the sensor")`.
    """

    settings: Mapping[str, Any]
    scene: Scene
    labels: Mapping[str, str]
    stream: tuple[str, int]


class Moment(NamedTuple):
    """The inputs of a sensor at a tick.

    Attributes:
        tick: number of the tick.
        now_s: time of the tick [s].
        state: (13,) true state of the vehicle in the layout of `sim.vehicle`.
        thrusts: (4,) thrust of each rotor [N].
        view: view of the depth camera.
        contacts: contacts since the last tick.
        exposure: current exposure of the colour camera.
        stamps: current readings of the sensors' clocks.
        around: light, dust, wind and localisation error at this tick.
    """

    tick: int
    now_s: float
    state: Array
    thrusts: Array
    view: View
    contacts: tuple[Contact, ...]
    exposure: Exposure
    stamps: Stamps
    around: Surroundings


class Sensor(Protocol):
    """One sensor of one flight."""

    def measure(self, moment: Moment) -> Any | None:
        """The message that the sensor sends at this tick; None if it sends none."""
        ...


@dataclass(frozen=True)
class SensorKind:
    """A declared sensor.

    Attributes:
        make: makes the sensor of a flight from its settings (None without any) and the constants of the flight.
        message: type of its messages.
        settings: the model of its entry in `sensors.yaml` (`scaloft_fi.model`); None for a sensor without settings.
        period_ticks: the sensor measures at every tick whose number is a multiple of this.
        latency_s: time from measurement to delivery [s]: a number, or a function of the settings.
        required: whether every study must have the sensor; an optional sensor needs an entry in `sensors.yaml`.
    """

    make: Callable[[Any, FlightSetting], Sensor]
    message: type
    settings: type | None = None
    period_ticks: int = 1
    latency_s: float | Callable[[Any], float] = 0.0
    required: bool = False

    def latency_of(self, settings: Any) -> float:
        """Time from measurement to delivery [s]."""
        return self.latency_s(settings) if callable(self.latency_s) else self.latency_s


Latency = Annotated[float, Bounds(least=0.0, most=3_600.0)]
"""From measurement to delivery [s], an hour at most."""
OWN_LATENCY = attrgetter("latency_s")
"""The latency that settings name."""

SENSORS = Registry[SensorKind]("sensor")
