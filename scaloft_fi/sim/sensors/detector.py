"""Person detector on the colour camera, 5 Hz, and its light meter: light, visible pixels and exposure decide.

The colour camera has the view of the depth camera.  A person with n visible pixels is detected with probability
best * light / (light + noise_light * gain) * logistic((n - pixels_half) / pixels_width)
* exp(-0.5 (exposure error / exposure_width)^2), where n excludes the saturated share.  Dust lowers the light of the
person by exp(-haze * range).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from scaloft_fi.marks import Bounds, NotNegative, Positive, Share
from scaloft_fi.sim.mesh import View
from scaloft_fi.sim.sensors.sensor import OWN_LATENCY, SENSORS, FlightSetting, Latency, Moment, SensorKind
from scaloft_fi.stack.messages import Detections, Exposure, Metering, Person
from scaloft_fi.streams import Table

PERIOD_TICKS = 4
"""Ticks from one picture to the next: 5 Hz."""

GHOST = "person"
"""Class label of a false positive."""


@dataclass(frozen=True)
class DetectorConfig:
    """Settings of the person detector.

    Attributes:
        best: probability of detecting a large person in full light.
        noise_light: light at which half of that probability remains, at sensor gain 1.
        pixels_half, pixels_width: visible pixels at which half of it remains, and width of the logistic curve.
        exposure_width_ev: exposure error at which 61 % of it remains [EV].
        bearing_sigma_deg: standard deviation of the bearing [deg].
        range_sigma: standard deviation of the range, as a share of the range.
        score_base, score_slope, score_sigma: score = base + slope * probability + noise, within 0.05..0.999.
        false_positives: probability of a false positive per picture.
        latency_s: from the picture to delivery [s].
    """

    best: Share
    noise_light: NotNegative
    pixels_half: NotNegative
    pixels_width: Positive
    exposure_width_ev: Annotated[float, Bounds(least=1e-3)]
    bearing_sigma_deg: NotNegative
    range_sigma: NotNegative
    score_base: float
    score_slope: float
    score_sigma: NotNegative
    false_positives: Share
    latency_s: Latency

    def probability(self, pixels: float, light: float, gain: float, error_ev: float) -> float:
        """Probability of detecting a person in one picture.

        Args:
            pixels: visible pixels of the person.
            light: visible light, 0..1.
            gain: sensor gain factor.
            error_ev: exposure error [EV].
        """
        if light <= 0.0 or pixels <= 0.0:
            return 0.0
        bright = light / (light + self.noise_light * max(gain, 0.0))
        large = 0.5 * (1.0 + math.tanh(0.5 * (pixels - self.pixels_half) / self.pixels_width))
        return self.best * bright * large * math.exp(-0.5 * (error_ev / self.exposure_width_ev) ** 2)

    def score(self, probability: float, noise: float) -> float:
        """Confidence of a detection, from its probability and a standard normal number."""
        return min(0.999, max(0.05, self.score_base + self.score_slope * probability + self.score_sigma * noise))


class Detector:
    """Detects persons in the picture."""

    def __init__(self, config: DetectorConfig, flight: FlightSetting) -> None:
        stream, names = flight.stream, flight.scene.names
        chance = (*stream, "detector chance")
        self._config, self._bearing_sigma_rad = config, math.radians(config.bearing_sigma_deg)
        self._metering = flight.settings["metering"]
        self._camera = flight.settings["depth"].camera
        self._rays = self._camera.rays
        self._bodies = [
            (names.index(name), label, Table(3, *stream, "detector", name), Table(1, *chance, name, uniform=True))
            for name, label in flight.labels.items()
        ]
        self._ghosts = Table(4, *stream, "detector ghosts", uniform=True)

    def measure(self, moment: Moment) -> Detections | None:
        """The detections in the picture of this tick; None without any."""
        around, picture = moment.around, moment.tick // PERIOD_TICKS
        stamp_s = moment.stamps.person_s
        return self.find(picture, moment.view, moment.exposure, stamp_s, around.light, around.haze_per_m)

    def find(
        self, picture: int, view: View, exposure: Exposure, stamp_s: float, light: float, haze_per_m: float = 0.0
    ) -> Detections | None:
        """The detections in picture number `picture`, in light (0..1) and dust [1/m]; None without any."""
        config = self._config
        error_ev = self._metering.error_ev(light, exposure)
        persons = []
        for number, label, noise, chance in self._bodies:
            shown = np.flatnonzero(view.segments == number)
            if not len(shown):
                continue
            pixels = len(shown) * (1.0 - min(1.0, max(0.0, exposure.saturated)))
            rows, columns = np.divmod(shown, view.segments.shape[1])
            left = self._rays[rows, columns, 1]
            range_m = float(np.mean(view.depth[rows, columns] * np.sqrt(1.0 + left * left)))
            contrast = math.exp(-haze_per_m * range_m) if haze_per_m else 1.0
            probability = config.probability(pixels, light * contrast, exposure.gain, error_ev)
            if float(chance.row(picture)[0]) >= probability:
                continue
            draw = noise.row(picture)
            score = config.score(probability, float(draw[0]))
            bearing_rad = math.atan(float(np.mean(left))) + self._bearing_sigma_rad * float(draw[1])
            range_m = max(0.1, range_m * (1.0 + config.range_sigma * float(draw[2])))
            persons.append(Person(label, score, bearing_rad, range_m))
        chance_of_ghost, where, far, sure = self._ghosts.row(picture)
        if chance_of_ghost < config.false_positives:
            bearing_rad = (0.5 - float(where)) * self._camera.fov_rad
            persons.append(Person(GHOST, 0.5 + 0.4 * float(sure), bearing_rad, 1.0 + 5.0 * float(far)))
        return Detections(stamp_s, tuple(persons)) if persons else None


SENSORS.declare("detector", SensorKind(Detector, Detections, DetectorConfig, PERIOD_TICKS, OWN_LATENCY, required=True))


LIMIT_EV = 16.0
"""End of the meter's scale."""


@dataclass(frozen=True)
class MeteringConfig:
    """Settings of the light meter.

    Attributes:
        mid: brightness of a correctly exposed picture, 0..1.
        sigma_ev: standard deviation of a reading [EV].
    """

    mid: Annotated[float, Bounds(least=1e-6, most=1.0)]
    sigma_ev: NotNegative

    def error_ev(self, light: float, exposure: Exposure) -> float:
        """Exposure error of the picture [EV], + when too dark."""
        if light <= 0.0 or not math.isfinite(exposure.ev):
            return LIMIT_EV
        return min(LIMIT_EV, max(-LIMIT_EV, math.log2(self.mid / light) - exposure.ev))


class LightMeter:
    """Measures the exposure error."""

    def __init__(self, config: MeteringConfig, flight: FlightSetting) -> None:
        self._config = config
        self._noise = Table(1, *flight.stream, "metering")

    def measure(self, moment: Moment) -> Metering:
        """The reading at the current exposure."""
        noise_ev = self._config.sigma_ev * float(self._noise.row(moment.tick)[0])
        return Metering(moment.now_s, self._config.error_ev(moment.around.light, moment.exposure) + noise_ev)


SENSORS.declare("metering", SensorKind(LightMeter, Metering, MeteringConfig, required=True))
