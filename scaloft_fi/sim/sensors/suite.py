"""All sensors of one flight: they measure when they are due and deliver when their latency is over."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Generic, TypeVar

from scaloft_fi.document import Item
from scaloft_fi.sim.contact import Contact
from scaloft_fi.sim.raster import Scene, View, look
from scaloft_fi.sim.sensors import battery, detector
from scaloft_fi.sim.sensors.bumper import BumperSensor
from scaloft_fi.sim.sensors.camera import DepthConfig, DepthSensor
from scaloft_fi.sim.sensors.imu import ImuConfig, ImuSensor
from scaloft_fi.sim.sensors.metering import LightMeter, MeteringConfig
from scaloft_fi.sim.sensors.positioning import Positioning, PositioningConfig
from scaloft_fi.stack.messages import DepthFrame, Detections, Exposure, Fix, Imu, SensorFrames, Stamps
from scaloft_fi.stack.rates import TICK_S
from scaloft_fi.streams import Array

M = TypeVar("M")


@dataclass(frozen=True)
class SensorsConfig:
    """What `sensors.yaml` says."""

    imu: ImuConfig
    positioning: PositioningConfig
    depth: DepthConfig
    metering: MeteringConfig
    detector: detector.DetectorConfig
    battery: battery.BatteryConfig


def read_sensors(item: Item) -> SensorsConfig:
    """Read the sensors.

    Raises:
        InputError: a value is not allowed, or a key unknown.
    """
    config = SensorsConfig(
        imu=ImuConfig.read(item.need("imu")),
        positioning=PositioningConfig.read(item.need("positioning")),
        depth=DepthConfig.read(item.need("depth")),
        metering=MeteringConfig.read(item.need("metering")),
        detector=detector.DetectorConfig.read(item.need("detector")),
        battery=battery.BatteryConfig.read(item.need("battery")),
    )
    item.close()
    return config


class Pipe(Generic[M]):
    """Messages on their way: each arrives at the first tick that is `latency_s` after it was sent."""

    def __init__(self, latency_s: float) -> None:
        self._delay = math.ceil(latency_s / TICK_S - 1e-9)
        self._messages: deque[tuple[int, M]] = deque()

    def send(self, tick: int, message: M) -> None:
        """Put a message in at `tick`."""
        self._messages.append((tick + self._delay, message))

    def arrive(self, tick: int) -> M | None:
        """The message due at `tick`, None when none is."""
        if self._messages and self._messages[0][0] <= tick:
            return self._messages.popleft()[1]
        return None


class Sensors:
    """The sensors of one flight.

    Args:
        config: what they are.
        scene: what the cameras see.
        persons: names of the persons in the scene.
        light: visible light, 0..1.
        situation: key of the situation, and
        seed: number of the flight; both name the noise.

    Attributes:
        inertial: the inertial sensor.
        view: the camera's last picture, drawn at the last tick.
    """

    def __init__(
        self, config: SensorsConfig, scene: Scene, persons: Iterable[str], light: float, situation: str, seed: int
    ) -> None:
        stream = (situation, seed)
        self.view: View | None = None
        self._scene = scene
        self._camera = config.depth.camera
        self.inertial = ImuSensor(config.imu, *stream)
        self._positioning = Positioning(config.positioning, *stream)
        self._depth = DepthSensor(config.depth, scene.reflectivity, light, *stream)
        self._meter = LightMeter(config.metering, light, *stream)
        numbers = {scene.names.index(name): name for name in persons}
        self._detector = detector.Detector(config.detector, config.metering, self._camera, numbers, light, *stream)
        self._battery = battery.BatteryGauge(config.battery)
        self._bumper = BumperSensor()
        self._fixes: Pipe[Fix] = Pipe(config.positioning.latency_s)
        self._frames: Pipe[DepthFrame] = Pipe(config.depth.latency_s)
        self._detections: Pipe[Detections | None] = Pipe(config.detector.latency_s)

    def imu(self, step: int, state: Array) -> Imu:
        """The inertial sample of physics step `step` (240 Hz)."""
        return self.inertial.measure(step, state)

    def feel(self, contacts: Iterable[Contact]) -> None:
        """Let the bumper feel the touches of one physics step."""
        self._bumper.feel(contacts)

    def frames(
        self, tick: int, state: Array, thrusts: Array, exposure: Exposure, stamps: Stamps | None = None
    ) -> SensorFrames:
        """What arrives at tick `tick` (20 Hz); what is measured now is on its way.

        Args:
            tick: number of the tick.
            state: (13,) true state of the vehicle.
            thrusts: (4,) thrust of each rotor [N].
            exposure: order in force for the colour camera.
            stamps: what the sensors' clocks read now; the true time when not given.
        """
        now_s = tick * TICK_S
        stamps = stamps or Stamps(now_s, now_s, now_s)
        self.view = look(self._scene, self._camera, state[:3], state[3:7])
        self._fixes.send(tick, self._positioning.measure(tick, state, stamps.fix_s))
        self._frames.send(tick, self._depth.measure(tick, self.view, stamps.depth_s))
        if tick % detector.PERIOD_TICKS == 0:
            picture = tick // detector.PERIOD_TICKS
            self._detections.send(tick, self._detector.measure(picture, self.view, exposure, stamps.person_s))
        voltage_v = self._battery.drain(thrusts, TICK_S)
        return SensorFrames(
            fix=self._fixes.arrive(tick),
            depth=self._frames.arrive(tick),
            detections=self._detections.arrive(tick),
            metering=self._meter.measure(tick, exposure, now_s),
            battery=self._battery.measure(voltage_v, now_s) if tick % battery.PERIOD_TICKS == 0 else None,
            bumper=self._bumper.measure(now_s),
        )
