"""Automatic exposure of the colour camera that the person detector looks through."""

from __future__ import annotations

from dataclasses import dataclass

from scaloft_fi.stack.messages import Exposure, Metering


@dataclass(frozen=True)
class ExposureConfig:
    """Settings of the exposure loop.

    Attributes:
        gain: share of the metered error corrected per tick.
        limit_ev: the loop stays within +- this [EV].
        gain_from_ev: above this the sensor gain doubles with every EV.
    """

    gain: float
    limit_ev: float
    gain_from_ev: float


class ExposureControl:
    """An integrating loop on the light meter's error."""

    def __init__(self, config: ExposureConfig) -> None:
        self.config = config
        self._ev = 0.0

    def meter(self, metering: Metering | None) -> Exposure:
        """The order to the camera; without a message of the light meter the order stays."""
        config = self.config
        if metering is not None:
            self._ev = min(config.limit_ev, max(-config.limit_ev, self._ev + config.gain * metering.error_ev))
        return Exposure(self._ev, 2.0 ** max(0.0, self._ev - config.gain_from_ev), 0.0)
