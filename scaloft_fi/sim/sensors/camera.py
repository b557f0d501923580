"""Depth camera, 20 Hz, with its compiled renderer; person detector, 5 Hz, and light meter on the colour camera.

The ray of pixel (row j, column i) passes through the pixel's centre.  In body axes at the camera (x along the optical
axis, y left, z up) its point at depth 1 m is (1, (W/2 - i - 0.5) pitch, (H/2 - j - 0.5) pitch) with
pitch = 2 tan(fov/2) / W.  Depth is measured along the optical axis, not along the ray.

The signs of a triangle's three edge planes decide whether a ray hits it (homogeneous rasterisation after Olano and
Greer, 1997), so no triangle needs clipping; both sides of a triangle are visible.  The inverse of depth is linear over
the picture, so the z-buffer keeps the inverse.

A pixel has a depth with probability best / (1 + exp(-(snr - snr_half) / snr_width)).  Its signal is the visible texture
of the scene plus the infrared pattern of the camera:
snr = passive * light * min(1, passive_range / z) + active * reflectivity / z^2.
In dust the first term falls with exp(-haze z), the second, which goes there and back, with exp(-2 haze z).  In the dark
only the second term remains, so dark or distant surfaces vanish first.

Noise is hashed from (key, frame, pixel) by SplitMix64: one 64-bit word decides whether the pixel has a depth; the four
16-bit parts of another word sum to a nearly normal number (Irwin-Hall, standard deviation 1, at most 3.47).

The colour camera has the view of the depth camera.  A person with n visible pixels is detected with probability
best * light / (light + noise_light * gain) * logistic((n - pixels_half) / pixels_width)
* exp(-0.5 (exposure error / exposure_width)^2), where n excludes the saturated share.  Dust lowers the light of the
person by exp(-haze * range).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import astuple, dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError
from scaloft_fi.marks import Bounds, NotNegative, Positive, Share
from scaloft_fi.sim.mesh import Array, Camera, Faces, Scene, Segments, View
from scaloft_fi.sim.sensors.sensor import OWN_LATENCY, SENSORS, FlightSetting, Latency, Moment, SensorKind
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import DepthFrame, Detections, Exposure, Metering, Person
from scaloft_fi.streams import Table, key_words

NOTHING = -1
NEAR_M = 0.01


def look(scene: Scene, camera: Camera, position: Array, attitude: Array) -> View:
    """Render the picture from the vehicle's pose.

    Args:
        scene: the triangles of the world.
        camera: the camera.
        position: (3,) vehicle centre [m, world].
        attitude: (4,) quaternion x, y, z, w, body to world.
    """
    depth = np.empty((camera.height, camera.width))
    segments = np.empty((camera.height, camera.width), np.int16)
    draw(scene.vertices, scene.faces, scene.owner, position, attitude, camera.ahead_m, camera.pitch, depth, segments)
    return View(depth, segments)


@jit
def draw(
    vertices: Array, faces: Faces, owner: Segments, position: Array, attitude: Array, ahead_m: float, pitch: float,
    depth: Array, segments: Segments,
) -> None:  # fmt: skip
    """Draw all triangles into `depth` (H, W) [m] and `segments` (H, W); see `look`."""
    height, width = depth.shape
    x, y, z, w = attitude[0], attitude[1], attitude[2], attitude[3]
    r00, r01, r02 = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)
    r10, r11, r12 = 2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)
    r20, r21, r22 = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)
    ox, oy, oz = position[0] + ahead_m * r00, position[1] + ahead_m * r10, position[2] + ahead_m * r20
    # Camera coordinates in pixels: (forward, column, row), so that pixel (j, i) is the ray (1, i, j).
    centre_i, centre_j, scale = 0.5 * width - 0.5, 0.5 * height - 0.5, 1.0 / pitch
    seen = np.empty((vertices.shape[0], 3))
    for v in range(vertices.shape[0]):
        dx, dy, dz = vertices[v, 0] - ox, vertices[v, 1] - oy, vertices[v, 2] - oz
        forward = r00 * dx + r10 * dy + r20 * dz
        left = r01 * dx + r11 * dy + r21 * dz
        up = r02 * dx + r12 * dy + r22 * dz
        seen[v, 0] = forward
        seen[v, 1] = centre_i * forward - left * scale
        seen[v, 2] = centre_j * forward - up * scale
    for j in range(height):
        for i in range(width):
            depth[j, i] = 0.0
            segments[j, i] = NOTHING
    corner = np.empty((3, 3))
    for f in range(faces.shape[0]):
        ahead = 0
        for k in range(3):
            v = faces[f, k]
            corner[k, 0], corner[k, 1], corner[k, 2] = seen[v, 0], seen[v, 1], seen[v, 2]
            if corner[k, 0] > NEAR_M:
                ahead += 1
        if ahead == 0:
            continue
        low_i, high_i, low_j, high_j = np.inf, -np.inf, np.inf, -np.inf
        for k in range(3):
            af, ai, aj = corner[k, 0], corner[k, 1], corner[k, 2]
            n = (k + 1) % 3
            bf, bi, bj = corner[n, 0], corner[n, 1], corner[n, 2]
            if af > NEAR_M:
                low_i, high_i = min(low_i, ai / af), max(high_i, ai / af)
                low_j, high_j = min(low_j, aj / af), max(high_j, aj / af)
            if (af > NEAR_M) != (bf > NEAR_M):
                t = (NEAR_M - af) / (bf - af)
                ci, cj = (ai + t * (bi - ai)) / NEAR_M, (aj + t * (bj - aj)) / NEAR_M
                low_i, high_i = min(low_i, ci), max(high_i, ci)
                low_j, high_j = min(low_j, cj), max(high_j, cj)
        if high_i < 0.0 or low_i > width - 1.0 or high_j < 0.0 or low_j > height - 1.0:
            continue
        first_j, last_j = math.ceil(max(low_j - 1e-6, 0.0)), math.floor(min(high_j + 1e-6, height - 1.0))
        first_i, last_i = math.ceil(max(low_i - 1e-6, 0.0)), math.floor(min(high_i + 1e-6, width - 1.0))
        if first_j > last_j or first_i > last_i:
            continue
        # Edge planes n_k = p_(k+1) x p_(k+2); volume = p_0 . n_0.
        a0 = corner[1, 1] * corner[2, 2] - corner[1, 2] * corner[2, 1]
        b0 = corner[1, 2] * corner[2, 0] - corner[1, 0] * corner[2, 2]
        c0 = corner[1, 0] * corner[2, 1] - corner[1, 1] * corner[2, 0]
        a1 = corner[2, 1] * corner[0, 2] - corner[2, 2] * corner[0, 1]
        b1 = corner[2, 2] * corner[0, 0] - corner[2, 0] * corner[0, 2]
        c1 = corner[2, 0] * corner[0, 1] - corner[2, 1] * corner[0, 0]
        a2 = corner[0, 1] * corner[1, 2] - corner[0, 2] * corner[1, 1]
        b2 = corner[0, 2] * corner[1, 0] - corner[0, 0] * corner[1, 2]
        c2 = corner[0, 0] * corner[1, 1] - corner[0, 1] * corner[1, 0]
        volume = corner[0, 0] * a0 + corner[0, 1] * b0 + corner[0, 2] * c0
        if volume == 0.0:
            continue
        g = 1.0 / volume
        a0, b0, c0, a1, b1, c1, a2, b2, c2 = a0 * g, b0 * g, c0 * g, a1 * g, b1 * g, c1 * g, a2 * g, b2 * g, c2 * g
        step = b0 + b1 + b2
        body = owner[f]
        t0, t1, t2 = -1.0 / b0, -1.0 / b1, -1.0 / b2
        for j in range(first_j, last_j + 1):
            # The range of columns in which no edge function is negative.
            e0, e1, e2 = a0 + c0 * j, a1 + c1 * j, a2 + c2 * j
            low, high = float(first_i), float(last_i)
            for e, b, t in ((e0, b0, t0), (e1, b1, t1), (e2, b2, t2)):
                if b > 0.0:
                    low = max(low, e * t - 1e-9)
                elif b < 0.0:
                    high = min(high, e * t + 1e-9)
                elif e < 0.0:
                    high = -1.0
            if low > high:
                continue
            base = e0 + e1 + e2
            start, end = math.ceil(low), math.floor(high) + 1
            line, bodies = depth[j, start:end], segments[j, start:end]
            for i in range(len(line)):
                inverse = base + step * (start + i)
                nearer = inverse > line[i]
                line[i] = inverse if nearer else line[i]
                bodies[i] = body if nearer else bodies[i]
    for j in range(height):
        for i in range(width):
            depth[j, i] = 1.0 / depth[j, i] if depth[j, i] > 0.0 else np.inf


@jit
def pixels_of(segments: Segments, depth: Array, wanted: NDArray[np.bool_], range_m: float) -> int:
    """Count the pixels that show a wanted body within range.

    Args:
        segments: (H, W) index of the visible body; -1 for none.
        depth: (H, W) [m].
        wanted: (B,) whether each body counts.
        range_m: greatest depth that counts [m].
    """
    count = 0
    for j in range(segments.shape[0]):
        for i in range(segments.shape[1]):
            body = segments[j, i]
            if body >= 0 and wanted[body] and depth[j, i] <= range_m:
                count += 1
    return count


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
        width, height: columns and rows of the picture [pixels].
        fov_deg: width of the view [deg].
        ahead_m: how far ahead of the vehicle's centre the camera sits [m].
        min_m, max_m: a surface nearer or farther than these gives no depth [m].
        sigma_per_m: standard deviation of depth z is `sigma_per_m` z^2 [1/m].
        best: probability of a depth at full signal.
        snr_half, snr_width: signal at which half of that probability remains, and width of the logistic curve.
        passive, passive_range_m: signal of visible texture in full light, and the range up to which it is constant [m].
        active: signal of the infrared pattern on a white surface at 1 m.
        latency_s: from measurement to delivery [s].
    """

    width: Annotated[int, Bounds(least=2, most=MOST_PIXELS)]
    height: Annotated[int, Bounds(least=2, most=MOST_PIXELS)]
    fov_deg: Annotated[float, Bounds(least=1.0, most=150.0)]
    ahead_m: float
    min_m: NotNegative
    max_m: float
    sigma_per_m: NotNegative
    best: Share
    snr_half: float
    snr_width: Positive
    passive: NotNegative
    passive_range_m: Annotated[float, Bounds(least=1e-3)]
    active: NotNegative
    latency_s: Latency

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a reach that ends before it begins."""
        if self.max_m <= self.min_m:
            yield item.need("max_m").error(f"> {self.min_m:g}")

    @cached_property
    def camera(self) -> Camera:
        """Geometry of the camera."""
        return Camera(self.width, self.height, math.radians(self.fov_deg), self.ahead_m)

    def numbers(self) -> Array:
        """Argument of `sense`, (9,)."""
        # the fields from min_m to active, in their order
        return np.array(astuple(self)[4:-1])


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
    depth: Array, segments: Segments, reflectivity: Array, light: float, haze_per_m: float, numbers: Array,
    key: np.uint64, frame: np.uint64, out: Array,
) -> None:  # fmt: skip
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
    min_m, max_m, sigma_per_m, best = numbers[0], numbers[1], numbers[2], numbers[3]
    half, width = numbers[4], numbers[5]
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


SENSORS.declare("depth", SensorKind(DepthSensor, DepthFrame, DepthConfig, latency_s=OWN_LATENCY, required=True))


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
