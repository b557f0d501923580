"""The reference stack with exchangeable stages: what a copy with one defective stage derives from.

`Parts` names the class of each stage that a bug may stand in.  With the classes of the reference stack the copy is the
reference stack, bit for bit; a test flies both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scaloft_fi.stack.declaration import Declaration, Stack, Task, Wire
from scaloft_fi.stack.messages import SensorFrames
from scaloft_fi.stack.reference.companion import Companion, ExposureControl, Stages
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.estimator import Estimator
from scaloft_fi.stack.reference.flight_control import FlightControl, InnerLoop
from scaloft_fi.stack.reference.memory import ObstacleMemory
from scaloft_fi.stack.reference.messages import Route
from scaloft_fi.stack.reference.mission import BatteryMonitor, Mission, SpeedLimitStage
from scaloft_fi.stack.reference.planner import Planner
from scaloft_fi.stack.reference.proximity import ProximityMonitor, Recoil
from scaloft_fi.stack.reference.stack import ReferenceConfig, ReferenceStack


class Receiver:
    """The stage that takes messages off the sensors' links; this one hands them on as they are."""

    def receive(self, frames: SensorFrames) -> SensorFrames:
        """The messages of a tick as the other stages get them; called once a tick."""
        return frames


@dataclass(frozen=True)
class Parts:
    """The classes of the stages.

    Attributes:
        receiver, estimator, memory, proximity, mission, companion: class of each stage.
        compiled: whether the 240 Hz part may run compiled; not where a defect stands in the Python code of that part.
    """

    receiver: type[Receiver] = Receiver
    estimator: type[Estimator] = Estimator
    memory: type[ObstacleMemory] = ObstacleMemory
    proximity: type[ProximityMonitor] = ProximityMonitor
    mission: type[Mission] = Mission
    companion: type[Companion] = Companion
    compiled: bool = True


class StagedStack(ReferenceStack):
    """The reference stack, built from the stages that `parts` names."""

    def __init__(self, task: Task, wire: Wire, parts: Parts) -> None:
        super().__init__(task, wire)
        config: ReferenceConfig = task.settings
        self._receiver = parts.receiver()
        self._estimator = parts.estimator(config.estimator, np.array(task.home), task.yaw_rad)
        self._control = FlightControl(config.control, config.failsafe, self._estimator, task.yaw_rad)
        self._companion = parts.companion(
            config.companion,
            Stages(
                parts.memory(config.memory, task.camera),
                parts.proximity(config.proximity, task.camera),
                SpeedLimitStage(config.speed_limit, task.cruise_mps, task.slow_mps),
                ExposureControl(config.exposure),
                BatteryMonitor(config.battery),
                parts.mission(config.mission, (task.home[0], task.home[1], task.altitude_m)),
                Planner(config.planner),
                Recoil(config.recoil),
            ),
            wire,
            Route(task.route),
            task.yaw_rad,
        )
        self._control.take_off(task.altitude_m)
        self.fast_path = InnerLoop(self._estimator, self._control) if parts.compiled else None  # type: ignore[assignment]
        self._pose = self._estimator.tick(0.0, None)
        self._received: SensorFrames | None = None

    def autopilot(self, now_s: float, frames: SensorFrames) -> None:
        """Receive the messages of the tick; then as the reference stack."""
        self._received = self._receiver.receive(frames)
        super().autopilot(now_s, self._received)

    def companion(self, now_s: float, frames: SensorFrames) -> None:
        """As the reference stack, with the messages that `autopilot` received."""
        super().companion(now_s, self._received or frames)


def declaration(name: str, parts: Parts) -> Declaration:
    """The declaration of a staged stack: that of the reference stack under another name."""

    def make(task: Task, wire: Wire) -> Stack:
        return StagedStack(task, wire, parts)

    return replace(REFERENCE, name=name, make=make)
