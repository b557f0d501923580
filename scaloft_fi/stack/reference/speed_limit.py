"""Slow down for people: the first person seen lowers the speed limit for the rest of the mission."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.stack.messages import Detections, Person
from scaloft_fi.stack.reference.messages import SpeedLimit


@dataclass(frozen=True)
class SpeedLimitConfig:
    """The rule of the published mission script, with the distance of requirement SR2.

    Attributes:
        label: class of box that counts.
        min_score: least confidence that counts.
        max_range_m: farthest person that counts [m].
    """

    label: str
    min_score: float
    max_range_m: float


class SpeedLimitStage:
    """Publishes the limit at the start, and the slow limit with every message that shows a person.

    Attributes:
        cruise_mps: limit without a person [m/s].
        slow_mps: limit from the first person on [m/s].
    """

    def __init__(self, config: SpeedLimitConfig, cruise_mps: float, slow_mps: float) -> None:
        self.config = config
        self.cruise_mps, self.slow_mps = cruise_mps, slow_mps
        self._published = False

    def update(self, now_s: float, detections: Detections | None) -> tuple[SpeedLimit | None, Person | None]:
        """The limit to publish at this tick, and the nearest person that counts; None for each that there is not."""
        person = self._nearest(detections) if detections is not None else None
        if person is not None:
            self._published = True
            return SpeedLimit(now_s, self.slow_mps, "euclidean"), person
        if not self._published:
            self._published = True
            return SpeedLimit(now_s, self.cruise_mps, "euclidean"), None
        return None, None

    def _nearest(self, detections: Detections) -> Person | None:
        config = self.config
        near = [
            p
            for p in detections.persons
            if p.label == config.label and p.score >= config.min_score and p.range_m <= config.max_range_m
        ]
        return min(near, key=lambda p: p.range_m, default=None)
