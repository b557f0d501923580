"""What a sensor is: how it is declared, what it measures from, what it does at a tick.

A sensor of another author's package is one class and one declaration, in a module that the package's entry point in the
group `scaloft_fi.plugins` names:

    class RangeFinder:
        def __init__(self, config: RangeConfig, flight: FlightSetting) -> None: ...
        def measure(self, moment: Moment) -> Range | None: ...

    SENSORS.declare("range", SensorKind(RangeFinder, Range, read=RangeConfig.read, latency_s=0.05))

A study whose `sensors.yaml` has an entry `range` flies with it, and its stack reads `frames["range"]`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from scaloft_fi.document import Item
from scaloft_fi.registry import Registry
from scaloft_fi.sim.contact import Contact
from scaloft_fi.sim.raster import Scene, View
from scaloft_fi.stack.messages import Exposure, Stamps
from scaloft_fi.streams import Array


@dataclass(frozen=True, eq=False)
class FlightSetting:
    """What stays the same in a flight.

    Attributes:
        settings: of every sensor of the study, by the sensor's name.
        scene: the triangles of the world.
        labels: names of the bodies that a person detector finds, and the class labels of their boxes.
        light: visible light, 0..1.
        stream: names the noise of the flight: its situation's key and its seed.  A sensor draws from
            `streams.Table(width, *stream, "name of the sensor")`.
    """

    settings: Mapping[str, Any]
    scene: Scene
    labels: Mapping[str, str]
    light: float
    stream: tuple[str, int]


class Moment(NamedTuple):
    """What a sensor may measure from at a tick.

    Attributes:
        tick: number of the tick.
        now_s: its time [s].
        state: (13,) true state of the vehicle, laid out as `sim.vehicle` says.
        thrusts: (4,) thrust of each rotor [N].
        view: what the depth camera looks at.
        contacts: what was touched since the last tick.
        exposure: the order in force for the colour camera.
        stamps: what the sensors' clocks read now.
    """

    tick: int
    now_s: float
    state: Array
    thrusts: Array
    view: View
    contacts: tuple[Contact, ...]
    exposure: Exposure
    stamps: Stamps


class Sensor(Protocol):
    """One sensor of one flight."""

    def measure(self, moment: Moment) -> Any | None:
        """The message that is sent at this moment, None when none is."""
        ...


@dataclass(frozen=True)
class SensorKind:
    """A declared sensor.

    Attributes:
        make: the sensor of a flight from its settings (None without `read`) and what stays the same in the flight.
        message: type of what it sends.
        read: its settings from its entry in `sensors.yaml`; None for a sensor without settings.
        period_ticks: it measures at every tick whose number is a multiple of this.
        latency_s: from measurement to delivery [s]: a number, or read off its settings.
        required: whether every study has it; otherwise those whose `sensors.yaml` has an entry for it.
    """

    make: Callable[[Any, FlightSetting], Sensor]
    message: type
    read: Callable[[Item], Any] | None = None
    period_ticks: int = 1
    latency_s: float | Callable[[Any], float] = 0.0
    required: bool = False

    def latency_of(self, settings: Any) -> float:
        """From measurement to delivery [s]."""
        return self.latency_s(settings) if callable(self.latency_s) else self.latency_s


SENSORS = Registry[SensorKind]("sensor")
