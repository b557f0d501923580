"""Depth camera, 20 Hz: limited range, noise, and no depth where too little light returns.

A pixel has a depth with probability best / (1 + exp(-(snr - snr_half) / snr_width)).  Its signal is the visible texture
of the scene plus the infrared pattern of the camera:
snr = passive * light * min(1, passive_range / z) + active * reflectivity / z^2.
In dust the first term falls with exp(-haze z), the second, which goes there and back, with exp(-2 haze z).  In the dark
only the second term remains, so dark or distant surfaces vanish first.

Noise is hashed from (key, frame, pixel) by SplitMix64: one 64-bit word decides whether the pixel has a depth; the four
16-bit parts of another word sum to a nearly normal number (Irwin-Hall, standard deviation 1, at most 3.47).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.document import Item
from scaloft_fi.sim.optics import Camera, View
from scaloft_fi.sim.sensors.sensor import LONGEST_S, SENSORS, FlightSetting, Moment, SensorKind
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import DepthFrame
from scaloft_fi.streams import Array, key_words

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
MIX_2 = np.uint64(0x94D049BB133111EB)
LOW_16 = np.uint64(0xFFFF)
ONE, TWO, S11, S16, S27, S30, S31, S32, S48 = (np.uint64(n) for n in (1, 2, 11, 16, 27, 30, 31, 32, 48))
UNIT_53 = 2.0**-53
IRWIN_HALL_MEAN = 2.0 * 65535.0
IRWIN_HALL_SIGMA = math.sqrt(4.0 * (65536.0**2 - 1.0) / 12.0)
MOST_PIXELS = 1_024
"""Most pixels of the picture along each edge."""
CERTAIN = 20.0
"""Beyond this number of widths the logistic curve counts as 0 or 1."""
CLEAR = 5.0
"""Beyond this number of widths the curve is within 0.01 of 0 or 1, so most pixels need no evaluation of it."""


@dataclass(frozen=True)
class DepthConfig:
    """Settings of the depth camera.

    Attributes:
        camera: geometry of the camera.
        min_m, max_m: a surface nearer or farther than these gives no depth [m].
        sigma_per_m: standard deviation of depth z is `sigma_per_m` z^2 [1/m].
        best: probability of a depth at full signal.
        snr_half, snr_width: signal at which half of that probability remains, and width of the logistic curve.
        passive, passive_range_m: signal of visible texture in full light, and the range up to which it is constant [m].
        active: signal of the infrared pattern on a white surface at 1 m.
        latency_s: from measurement to delivery [s].
    """

    camera: Camera
    min_m: float
    max_m: float
    sigma_per_m: float
    best: float
    snr_half: float
    snr_width: float
    passive: float
    passive_range_m: float
    active: float
    latency_s: float

    @classmethod
    def read(cls, item: Item) -> DepthConfig:
        """Read the `depth` of `sensors.yaml`."""
        min_m = item.need("min_m").number(least=0.0)
        config = cls(
            camera=Camera(
                width=item.need("width").whole(least=2, most=MOST_PIXELS),
                height=item.need("height").whole(least=2, most=MOST_PIXELS),
                fov_rad=math.radians(item.need("fov_deg").number(least=1.0, most=150.0)),
                ahead_m=item.need("ahead_m").number(),
            ),
            min_m=min_m,
            max_m=item.need("max_m").number(above=min_m),
            sigma_per_m=item.need("sigma_per_m").number(least=0.0),
            best=item.need("best").number(least=0.0, most=1.0),
            snr_half=item.need("snr_half").number(),
            snr_width=item.need("snr_width").number(least=1e-6),
            passive=item.need("passive").number(least=0.0),
            passive_range_m=item.need("passive_range_m").number(least=1e-3),
            active=item.need("active").number(least=0.0),
            latency_s=item.need("latency_s").number(least=0.0, most=LONGEST_S),
        )
        item.close()
        return config

    def numbers(self) -> Array:
        """Argument of `sense`, (9,)."""
        return np.array(
            [
                self.min_m,
                self.max_m,
                self.sigma_per_m,
                self.best,
                self.snr_half,
                self.snr_width,
                self.passive,
                self.passive_range_m,
                self.active,
            ]
        )


class DepthSensor:
    """Converts the rendered view into a depth frame."""

    def __init__(self, config: DepthConfig, flight: FlightSetting) -> None:
        self._numbers = config.numbers()
        self._reflectivity = flight.scene.reflectivity
        self._key = np.uint64(key_words(*flight.stream, "depth")[0])

    def measure(self, moment: Moment) -> DepthFrame:
        """The frame of this tick."""
        around = moment.around
        return self.frame(moment.tick, moment.view, moment.stamps.depth_s, around.light, around.haze_per_m)

    def frame(self, tick: int, view: View, stamp_s: float, light: float, haze_per_m: float = 0.0) -> DepthFrame:
        """The frame of tick `tick`, in visible light `light` (0..1) and dust of this extinction [1/m]."""
        depth, frame = np.empty_like(view.depth), np.uint64(tick)
        sense(view.depth, view.segments, self._reflectivity, light, haze_per_m, self._numbers, self._key, frame, depth)
        return DepthFrame(stamp_s, depth)


@jit
def word(key: np.uint64, counter: np.uint64) -> np.uint64:
    """64 random bits of a counter: SplitMix64 (Steele, Lea, Flood 2014)."""
    x = key + counter * GOLDEN
    x = (x ^ (x >> S30)) * MIX_1
    x = (x ^ (x >> S27)) * MIX_2
    return x ^ (x >> S31)


@jit
def sense(
    depth: Array,
    segments: NDArray[np.int16],
    reflectivity: Array,
    light: float,
    haze_per_m: float,
    numbers: Array,
    key: np.uint64,
    frame: np.uint64,
    out: Array,
) -> None:
    """Write the measured depth into `out` (H, W) [m], 0 where a pixel has no depth.

    Args:
        depth: (H, W) true depth [m].
        segments: (H, W) index of the visible body; -1 for none.
        reflectivity: (B,) reflectivity of the bodies.
        light: visible light, 0..1.
        haze_per_m: extinction of light by dust [1/m].
        numbers: (9,) from `DepthConfig.numbers`.
        key: key of the noise.
        frame: number of the frame.
        out: (H, W) receives the result.
    """
    min_m, max_m, sigma_per_m, best, half, width = (
        numbers[0],
        numbers[1],
        numbers[2],
        numbers[3],
        numbers[4],
        numbers[5],
    )
    passive, passive_range_m, active = numbers[6] * light, numbers[7], numbers[8]
    height, columns = depth.shape
    counter = frame * np.uint64(2 * height * columns)
    least_m = 0.5 * min_m
    uniform, value, x = np.empty(columns), np.empty(columns), np.empty(columns)
    is_open, seen = np.empty(columns, np.bool_), np.ones(columns)
    for j in range(height):
        line, row, bodies = depth[j], out[j], segments[j]
        for i in range(columns):
            x[i] = reflectivity[bodies[i]]
        if haze_per_m > 0.0:
            for i in range(columns):
                seen[i] = math.exp(-haze_per_m * line[i])
        # The next two loops have no branches and no lookups, so that they are vectorised.
        for i in range(columns):
            pixel = counter + TWO * np.uint64(j * columns + i)
            uniform[i] = (word(key, pixel) >> S11) * UNIT_53
            bits = word(key, pixel + ONE)
            total = (bits & LOW_16) + ((bits >> S16) & LOW_16) + ((bits >> S32) & LOW_16) + (bits >> S48)
            z = line[i]
            noisy = z + sigma_per_m * z * z * (np.float64(total) - IRWIN_HALL_MEAN) / IRWIN_HALL_SIGMA
            value[i] = noisy if noisy > least_m else least_m
        for i in range(columns):
            z = line[i]
            fall = passive_range_m / z
            fall = 1.0 if fall > 1.0 else fall
            signal = passive * fall * seen[i] + active * x[i] / (z * z) * (seen[i] * seen[i])
            x[i] = (signal - half) / width
            within = (z >= min_m) & (z <= max_m) & (x[i] >= -CERTAIN)
            returns = (x[i] > CLEAR) & (uniform[i] < 0.99 * best)
            fails = (x[i] < -CLEAR) & (uniform[i] > 0.01 * best)
            row[i] = value[i] if within & returns else 0.0
            is_open[i] = within & (not (returns | fails))
        for i in range(columns):
            if is_open[i]:
                chance = best if x[i] > CERTAIN else best / (1.0 + math.exp(-x[i]))
                row[i] = 0.0 if uniform[i] >= chance else value[i]


SENSORS.declare(
    "depth",
    SensorKind(
        DepthSensor,
        DepthFrame,
        read=DepthConfig.read,
        latency_s=lambda config: config.latency_s,
        required=True,
    ),
)
