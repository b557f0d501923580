"""All sensors of one flight: each measures at its period and delivers after its latency."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, make_dataclass
from functools import lru_cache
from typing import Annotated, Any

from scaloft_fi.document import Item
from scaloft_fi.marks import About, Called
from scaloft_fi.model import NO_NAMES, Names, read, summary_of
from scaloft_fi.sim.contact import Contact
from scaloft_fi.sim.happenings import Surroundings
from scaloft_fi.sim.mesh import View
from scaloft_fi.sim.sensors import body  # noqa: F401 - they declare their sensors
from scaloft_fi.sim.sensors.body import BatteryConfig, ImuConfig, ImuSensor, PositioningConfig
from scaloft_fi.sim.sensors.camera import DepthConfig, DetectorConfig, MeteringConfig, look
from scaloft_fi.sim.sensors.sensor import SENSORS, FlightSetting, Moment, Sensor, SensorKind
from scaloft_fi.stack.declaration import TICK_HZ, TICK_S
from scaloft_fi.stack.messages import Entry, Exposure, Imu, SensorFrames, Stamps
from scaloft_fi.streams import Array


@dataclass(frozen=True, eq=False)
class SensorsConfig:
    """The settings in `sensors.yaml`.

    Attributes:
        imu: settings of the inertial sensor, which measures at every physics step and is not in the registry.
        by_name: settings of the declared sensors of the study; None for a sensor without settings.
        depth, positioning, metering, detector, battery: settings of those that every study has.
    """

    imu: ImuConfig
    by_name: Mapping[str, Any]

    depth = Entry[DepthConfig]("depth")
    positioning = Entry[PositioningConfig]("positioning")
    metering = Entry[MeteringConfig]("metering")
    detector = Entry[DetectorConfig]("detector")
    battery = Entry[BatteryConfig]("battery")

    def __getitem__(self, sensor: str) -> Any:
        return self.by_name[sensor]


@dataclass(frozen=True)
class NoSettings:
    """A sensor without settings."""


def sensors_model(names: Names = NO_NAMES) -> type:
    """The model of `sensors.yaml`: the inertial sensor, and an entry for each declared sensor that has settings."""
    return _sensors_model(tuple((name, SENSORS[name]) for name in names.get("sensors", SENSORS)))


@lru_cache(maxsize=16)
def _sensors_model(kinds: tuple[tuple[str, SensorKind], ...]) -> type:
    fields: list[Any] = [("imu", Annotated[ImuConfig, About(f"{summary_of(ImuConfig)} 240 Hz.")])]
    for number, (name, kind) in enumerate(kinds):
        if kind.settings is None and kind.required:
            continue
        settings: Any = kind.settings or NoSettings
        marks = Called(name), About(f"{summary_of(settings)} {TICK_HZ / kind.period_ticks:g} Hz.")
        entry: Any = Annotated[(settings if kind.required else settings | None, *marks)]
        fields.append((f"sensor_{number}", entry, *([] if kind.required else [field(default=None)])))
    about = "The sensors: the stack gets data of the simulator only through them."
    return make_dataclass("Sensors", fields, frozen=True, kw_only=True, namespace={"__doc__": about})


def read_sensors(item: Item) -> SensorsConfig:
    """Read the sensors.

    Raises:
        InputError: a value is not allowed, or a sensor or key is unknown.
    """
    model: Any = read(sensors_model(), item)
    by_name: dict[str, Any] = {}
    for number, (name, kind) in enumerate(SENSORS.items()):
        settings = getattr(model, f"sensor_{number}", None)
        if settings is not None or kind.required:
            by_name[name] = None if isinstance(settings, NoSettings) else settings
    return SensorsConfig(model.imu, by_name)


def pipe(latency_s: float) -> deque[Any]:
    """A delay line, appended to at every tick: a message leaves it at the first tick at least `latency_s` after."""
    return deque([None] * math.ceil(latency_s / TICK_S - 1e-9))


class Sensors:
    """The sensors of one flight.

    Args:
        config: settings of the sensors.
        around: the surroundings of the flight.
        labels: class label of each body that the person detector finds, by the body's name.
        situation: key of the situation.
        seed: seed of the flight; situation and seed name the noise.

    Attributes:
        inertial: the inertial sensor.
        view: the view of the depth camera at the last tick.
    """

    def __init__(
        self, config: SensorsConfig, around: Surroundings, labels: Mapping[str, str], situation: str, seed: int
    ) -> None:
        setting = FlightSetting(config.by_name, around.scene, labels, (situation, seed))
        self.view: View | None = None
        self.inertial = ImuSensor(config.imu, situation, seed)
        self._around, self._camera = around, config.depth.camera
        self._contacts: list[Contact] = []
        self._fitted: list[tuple[str, Sensor, int, deque[Any]]] = []
        for name, settings in config.by_name.items():
            kind = SENSORS[name]
            late = pipe(kind.latency_of(settings))
            self._fitted.append((name, kind.make(settings, setting), kind.period_ticks, late))

    def imu(self, step: int, state: Array) -> Imu:
        """The inertial sample of physics step `step` (240 Hz)."""
        return self.inertial.measure(step, state)

    def feel(self, contacts: Iterable[Contact]) -> None:
        """Add the contacts of one physics step."""
        self._contacts.extend(contacts)

    def frames(
        self, tick: int, state: Array, thrusts: Array, exposure: Exposure, stamps: Stamps | None = None
    ) -> SensorFrames:
        """Measure at tick `tick` (20 Hz), and return the messages that arrive at this tick.

        Args:
            tick: number of the tick.
            state: (13,) true state of the vehicle.
            thrusts: (4,) thrust of each rotor [N].
            exposure: current exposure of the colour camera.
            stamps: current readings of the sensors' clocks; None = the true time.
        """
        now_s = tick * TICK_S
        self.view = look(self._around.scene, self._camera, state[:3], state[3:7])
        stamps = stamps or Stamps(now_s, now_s, now_s)
        moment = Moment(tick, now_s, state, thrusts, self.view, tuple(self._contacts), exposure, stamps, self._around)
        self._contacts.clear()
        arrived = {}
        for name, sensor, period_ticks, late in self._fitted:
            late.append(None if tick % period_ticks else sensor.measure(moment))
            arrived[name] = late.popleft()
        return SensorFrames(arrived)
