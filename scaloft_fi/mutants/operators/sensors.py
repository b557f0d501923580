"""Operators on what sensors send: boxes of persons, images, inertial samples, time stamps, the battery.

Where a sensor saw nothing, a pixel is 0.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np

from scaloft_fi.mutants.operator import (
    IMAGE,
    STAMP,
    TOLERANCE_S,
    Factor,
    Facts,
    Hold,
    Metres,
    Number,
    Period,
    Range,
    Samples,
    Seconds,
    Share,
    Tap,
    TapContext,
    Windows,
    on,
)
from scaloft_fi.mutants.sample import Remembering, drawn, on_each, reclocked, redrawn, within
from scaloft_fi.stack.declaration import STEP_HZ
from scaloft_fi.stack.messages import Array, Battery, DepthFrame, Detections, Imu, Person, Stamps, Thrust

on_boxes = partial(on, Detections)

_SILENCE_S = 0.5  # a detector that was silent for this time reports nobody
_NEAR = Person("person", 0.9, 0.1, 3.0)
_FAR = Person("person", 0.7, -0.4, 6.0)


def _boxes(*persons: Person, t_s: float = 0.0) -> Detections:
    return Detections(t_s, persons)


def _phantom(range_m: float) -> Person:
    """A detection with high confidence, straight ahead."""
    return Person("person", 0.9, 0.0, range_m)


@on_boxes(
    "scale_range",
    {"factor": 2.0},
    (_boxes(_NEAR, _FAR),),
    (_boxes(_NEAR._replace(range_m=6.0), _FAR._replace(range_m=12.0)),),
)
def scale_range(_context: TapContext, *, factor: Factor) -> Tap:
    """Multiply every person's range by `factor`: a wrong focal length or a wrong assumed body height."""
    return on_each(
        lambda boxes: boxes._replace(persons=tuple(p._replace(range_m=p.range_m * factor) for p in boxes.persons))
    )


def _keep(boxes: Detections, keep: Any) -> Detections | None:
    persons = tuple(filter(keep, boxes.persons))
    return boxes._replace(persons=persons) if persons else None


@on_boxes("min_score", {"score": 0.8}, (_boxes(_NEAR, _FAR), _boxes(_FAR), None), (_boxes(_NEAR), None, None))
def min_score(_context: TapContext, *, score: Share) -> Tap:
    """Lose every box with a confidence below `score` (0..1): a threshold tuned against false alarms."""
    return on_each(lambda boxes: _keep(boxes, lambda p: p.score >= score))


@on_boxes("narrow", {"share": 0.5}, (_boxes(_NEAR, _FAR), _boxes(_FAR)), (_boxes(_NEAR), None))
def narrow(context: TapContext, *, share: Share) -> Tap:
    """Lose every box outside the middle `share` (0..1) of the camera's view.

    A cropped image, a lens hood.
    """
    half_rad = context.facts.view_rad * share / 2
    return on_each(lambda boxes: _keep(boxes, lambda p: abs(p.bearing_rad) <= half_rad))


@on_boxes("ghost", {"distance_m": 2.0}, (_boxes(_NEAR), None), (_boxes(_NEAR, _NEAR._replace(range_m=5.0)), None))
def ghost(_context: TapContext, *, distance_m: Metres) -> Tap:
    """Report a second person `distance_m` [m] behind the nearest real one: a shadow, a reflection, a double box."""

    def doubled(boxes: Detections) -> Detections:
        nearest = min(boxes.persons, key=lambda p: p.range_m)
        return boxes._replace(persons=(*boxes.persons, nearest._replace(range_m=nearest.range_m + distance_m)))

    return on_each(doubled)


@on_boxes("invert_presence", {"range_m": 2.0}, (None, _boxes(_NEAR), None), (_boxes(_phantom(2.0)), None, None))
def invert_presence(_context: TapContext, *, range_m: Metres = 3.0) -> Tap:
    """Report a person `range_m` [m] ahead while the detector reports none, and nobody while it reports one.

    Wrong polarity.  A detector that was silent for 0.5 s reports nobody.
    """

    def step(own: Any, t_s: float, sample: Any | None) -> Any | None:
        if sample is not None:
            own.reported_s = t_s
            return None
        if t_s - own.reported_s < _SILENCE_S - TOLERANCE_S:
            return None
        return _boxes(_phantom(range_m), t_s=t_s)

    return Remembering(step, reported_s=-math.inf)


@on_boxes(
    "relabel", {"share": 1.0, "label": "cart"}, (_boxes(_NEAR), None), (_boxes(_NEAR._replace(label="cart")), None)
)
def relabel(context: TapContext, *, share: Share = 1.0, label: str = "cart") -> Tap:
    """Give each box the class `label` with probability `share` (0..1).

    A classifier that takes people for something else.
    """

    def relabelled(rng: np.random.Generator, boxes: Detections) -> Detections:
        persons = zip(boxes.persons, rng.random(len(boxes.persons)) < share, strict=True)
        return boxes._replace(persons=tuple(p._replace(label=label) if wrong else p for p, wrong in persons))

    return drawn(context.rng, relabelled)


@on_boxes(
    "early_report",
    {"lead_s": 0.05},
    (None, None, _boxes(_NEAR, t_s=0.1), None),
    (None, _boxes(_phantom(3.0), t_s=0.05), _boxes(_NEAR, t_s=0.1), None),
    facts=Facts(sighting_s=0.1),
)
def early_report(context: TapContext, *, lead_s: Seconds, range_m: Metres = 3.0) -> Tap:
    """Report a person `range_m` [m] ahead from `lead_s` [s] before the nominal flight first sees one until then.

    A warning by radio or from a map, a replayed detection.  Without a person in the nominal flight nothing changes.
    """
    known_s = context.facts.sighting_s
    sighting_s = math.inf if known_s is None else known_s
    start_s = max(0.0, sighting_s - lead_s) if math.isfinite(sighting_s) else math.inf

    def tap(t_s: float, sample: Any | None) -> Any | None:
        early = start_s - TOLERANCE_S <= t_s < sighting_s - TOLERANCE_S
        return _boxes(_phantom(range_m), t_s=t_s) if sample is None and early else sample

    return tap


@on_boxes(
    "phantom_person",
    {"hold_s": 0.05, "period_s": 0.05, "phase_s": 0.05, "range_m": 4.0},
    (None, None, None, _boxes(_NEAR, t_s=0.15)),
    (None, None, _boxes(_phantom(4.0), t_s=0.1), _boxes(_NEAR, _phantom(4.0), t_s=0.15)),
)
def phantom_person(
    context: TapContext, *, hold_s: Hold = 2.0, period_s: Period = 20.0, phase_s: Seconds = 0.0, range_m: Metres = 3.0
) -> Tap:
    """Report a person `range_m` [m] ahead who is not there, for `hold_s` [s] each `period_s` [s].

    A poster, a coat on a hook.
    """
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))

    def tap(t_s: float, sample: Any | None) -> Any | None:
        if not windows.open(t_s):
            return sample
        phantom = _phantom(range_m)
        return _boxes(phantom, t_s=t_s) if sample is None else sample._replace(persons=(*sample.persons, phantom))

    return tap


on_image = partial(on, need=IMAGE)
on_stamped = partial(on, need=STAMP)
on_inertial = partial(on, Imu)
on_battery = partial(on, Battery)

_ROW = DepthFrame(0.0, np.array([[1.0, 2.0, 3.0, 0.0]] * 4))


def _rows(*rows: tuple[float, ...]) -> DepthFrame:
    return DepthFrame(0.0, np.array(rows))


def _seen_pixels_differ(before: Samples, after: Samples) -> bool:
    return all(np.array_equal(a.depth != b.depth, b.depth > 0.0) for b, a in zip(before, after, strict=True))


@on_image(DepthFrame, "range_noise", {"share": 0.05}, (_ROW, _ROW), _seen_pixels_differ)
def range_noise(context: TapContext, *, share: Share) -> Tap:
    """Add Gaussian noise of standard deviation `share` (0..1) of the range to every pixel that sees something.

    Dust, flying pixels.
    """

    def noisy(rng: np.random.Generator, frame: Any) -> Any:
        return redrawn(frame, lambda seen: seen * np.maximum(1.0 + share * rng.standard_normal(seen.shape), 0.0))

    return drawn(context.rng, noisy)


@on_image(DepthFrame, "lose_columns", {"share": 0.5}, (_ROW, None), (_rows(*[(1.0, 0.0, 0.0, 0.0)] * 4), None))
def lose_columns(_context: TapContext, *, share: Share, side: Literal["left", "centre", "right"] = "centre") -> Tap:
    """Let a block of `share` (0..1) of the image's columns, at `side`, see nothing: dirt on the lens, a lost stripe."""

    def blinded(image: Array) -> Array:
        width = image.shape[1]
        lost = round(share * width)
        first = {"left": 0, "centre": (width - lost) // 2, "right": width - lost}[side]
        seen = image.copy()
        seen[:, first : first + lost] = 0.0
        return seen

    return on_each(lambda sample: redrawn(sample, blinded))


@on_image(DepthFrame, "mirror", {}, (_ROW, None), (_rows(*[(0.0, 3.0, 2.0, 1.0)] * 4), None))
def mirror(_context: TapContext) -> Tap:
    """Swap left and right of the image: columns published in reverse order (seen in PX4 pull request 22418)."""
    return on_each(lambda sample: redrawn(sample, lambda image: np.ascontiguousarray(image[:, ::-1])))


@on_image(
    DepthFrame,
    "phantom_blob",
    {"range_m": 1.5, "hold_s": 0.05, "period_s": 0.05, "share": 0.5},
    (_ROW, _ROW, None),
    (_ROW, _rows((1.0, 2.0, 3.0, 0.0), (1.0, 1.5, 1.5, 0.0), (1.0, 1.5, 1.5, 0.0), (1.0, 2.0, 3.0, 0.0)), None),
)
def phantom_blob(
    context: TapContext,
    *,
    range_m: Metres = 1.0,
    hold_s: Hold = 1.0,
    period_s: Period = 20.0,
    phase_s: Seconds = 0.0,
    share: Share = 0.3,
) -> Tap:
    """Show an object `range_m` [m] ahead over `share` (0..1) of width and height, for `hold_s` [s] each `period_s` [s].

    Dust, a drop.
    """
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))

    def blotted(image: Array) -> Array:
        seen = image.copy()
        (top, high), (left, wide) = (((n - round(share * n)) // 2, round(share * n)) for n in seen.shape)
        blot = seen[top : top + high, left : left + wide]
        blot[(blot == 0.0) | (blot > range_m)] = range_m
        return seen

    return within(windows, lambda sample: redrawn(sample, blotted))


Positive = Annotated[float, Range(above=0.0, most=1e6)]
_REST = Imu(0.0, np.array([0.1, -0.2, 0.3]), np.array([0.5, 0.0, 9.81]))


def _all_axes_shake(before: Samples, after: Samples) -> bool:
    return all(np.all(a.rate != b.rate) and np.all(a.force != b.force) for b, a in zip(before, after, strict=True))


@on_inertial("vibration", {"factor": 10.0}, (_REST, _REST), _all_axes_shake)
def vibration(context: TapContext, *, factor: Annotated[float, Range(least=1.0, most=1e6)]) -> Tap:
    """Raise the white noise of both sensors to `factor` times the nominal sigma per sample.

    An unbalanced propeller, a loose mount.
    """
    extra = math.sqrt(factor**2 - 1.0)  # variances add up
    rate_radps, force_mps2 = extra * context.facts.gyro_sigma_radps, extra * context.facts.accel_sigma_mps2

    def shaken(rng: np.random.Generator, imu: Imu) -> Imu:
        rate, force = rng.standard_normal((2, 3))
        return imu._replace(rate=imu.rate + rate_radps * rate, force=imu.force + force_mps2 * force)

    return drawn(context.rng, shaken)


@on_inertial("remount", {}, (_REST, None), (Imu(0.0, np.array([-0.1, 0.2, 0.3]), np.array([-0.5, 0.0, 9.81])), None))
def remount(_context: TapContext) -> Tap:
    """Turn the sensor by 180 deg about the body's z axis: mounted the wrong way round, or a wrong rotation setting."""
    signs = np.array([-1.0, -1.0, 1.0])
    return on_each(lambda imu: imu._replace(rate=imu.rate * signs, force=imu.force * signs))


def _second_is_garbage(before: Samples, after: Samples) -> bool:
    return after[0] is before[0] and bool(np.all(after[1].rate != before[1].rate)) and after[2] is None


@on_inertial(
    "garbage", {"hold_s": 1 / 240, "period_s": 1 / 240}, (_REST, _REST, None), _second_is_garbage, rate_hz=STEP_HZ
)
def garbage(
    context: TapContext,
    *,
    hold_s: Hold,
    period_s: Period = 20.0,
    phase_s: Seconds = 0.0,
    rate_span_radps: Positive = 34.9,
    force_span_mps2: Positive = 157.0,
) -> Tap:
    """Replace both readings by uniform random ones for `hold_s` [s], each `period_s` [s].

    A broken bus (PX4's failure type `garbage`).  The spans are the ranges of a common sensor, 2000 deg/s and 16 g.
    """
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))

    def replaced(rng: np.random.Generator, imu: Imu) -> Imu:
        rate, force = rng.uniform(-1.0, 1.0, (2, 3))
        return imu._replace(rate=rate_span_radps * rate, force=force_span_mps2 * force)

    return drawn(context.rng, replaced, windows)


def _stamps(t_s: float) -> Stamps:
    return Stamps(t_s, t_s, t_s)


@on_stamped(Stamps, "clock_rate", {"share": 0.1}, (_stamps(0.0), _stamps(10.0)), (_stamps(0.0), _stamps(11.0)))
def clock_rate(_context: TapContext, *, share: Annotated[float, Range(above=-1.0, most=10.0)]) -> Tap:
    """Let the sender's clock run fast (slow where negative) by `share` of the time since take-off.

    A wrong oscillator setting.
    """
    return on_each(lambda stamps: reclocked(stamps, lambda t_s: t_s * (1.0 + share)))


@on_stamped(Stamps, "epoch", {"offset_s": 1000.0}, (_stamps(1.0), None), (_stamps(1001.0), None))
def epoch(_context: TapContext, *, offset_s: Number = 1.7e9) -> Tap:
    """Count the sender's clock from another epoch, `offset_s` [s] earlier.

    Wall-clock time (1.7e9 s since 1970) for time since take-off.
    """
    return on_each(lambda stamps: reclocked(stamps, lambda t_s: t_s + offset_s))


@on_stamped(
    Stamps,
    "disorder",
    {"count": 2},
    tuple(_stamps(i / 20) for i in range(4)),
    tuple(_stamps(i / 20) for i in (0, -1, 2, 1)),
)
def disorder(context: TapContext, *, count: Annotated[int, Range(least=2, most=1000)]) -> Tap:
    """Give every `count` stamps in reverse order: the messages arrive in time, each with the stamp of another."""
    poll_s = context.period_s

    def step(own: Any, _t_s: float, sample: Any | None) -> Any | None:
        if sample is None:
            return None
        back_s = 2 * own.place * poll_s
        own.place = (own.place + 1) % count
        return reclocked(sample, lambda t_s: t_s - back_s)

    return Remembering(step, place=0)


@on_stamped(
    Stamps,
    "stale_pulse",
    {"hold_s": 0.05, "period_s": 0.05, "age_s": 0.05, "phase_s": 0.05},
    (_stamps(0.0), _stamps(0.05), _stamps(0.1)),
    (_stamps(0.0), _stamps(0.05), _stamps(0.05)),
)
def stale_pulse(
    context: TapContext, *, age_s: Seconds = 1.0, hold_s: Hold = 1.0, period_s: Period = 20.0, phase_s: Seconds = 0.0
) -> Tap:
    """Let every stamp be `age_s` [s] old for `hold_s` [s], each `period_s` [s]: a spurious time-out."""
    windows = context.windows(period_s, phase_s, max(hold_s, context.period_s))
    return within(windows, lambda stamps: reclocked(stamps, lambda t_s: t_s - age_s))


_FULL = Battery(0.0, 0.9, 16.0, 4)


def _depleted(battery: Battery, charge: float) -> Battery:
    """Change the charge only: the voltage is measured by another sensor."""
    return battery._replace(charge=charge)


@on(Thrust, "sag", {"share": 0.5}, (Thrust(np.full(4, 4.0)), None), (Thrust(np.full(4, 1.0)), None))
def sag(_context: TapContext, *, share: Share) -> Tap:
    """Multiply the thrust of every rotor by (1 - `share`)^2.

    The voltage under load sags by `share`, thrust goes with its square.
    """
    factor = (1.0 - share) ** 2
    return on_each(lambda thrust: thrust._replace(rotors=thrust.rotors * factor))


@on_battery(
    "early_depletion",
    {"share": 0.5},
    (_FULL, _FULL, _FULL, None),
    (_FULL, _FULL._replace(charge=0.0), _FULL._replace(charge=0.0), None),
    facts=Facts(duration_s=0.1),
)
def early_depletion(context: TapContext, *, share: Share, charge: Share = 0.0) -> Tap:
    """Report a state of charge of `charge` (0..1) from `share` (0..1) of the nominal mission time on.

    A gauge that drops too early.
    """
    return within(Windows.since(share * context.facts.duration_s), lambda battery: _depleted(battery, charge))


@on_battery(
    "depleted_pulse", {"hold_s": 0.05, "at_s": 0.1}, (_FULL,) * 4, (_FULL, _FULL, _FULL._replace(charge=0.0), _FULL)
)
def depleted_pulse(
    context: TapContext, *, hold_s: Hold = 2.0, at_s: Seconds = 20.0, phase_s: Seconds = 0.0, charge: Share = 0.0
) -> Tap:
    """Report a state of charge of `charge` (0..1) for `hold_s` [s] from `at_s` + `phase_s` [s] on: a glitch."""
    windows = context.window(at_s + phase_s, max(hold_s, context.period_s))
    return within(windows, lambda battery: _depleted(battery, charge))
