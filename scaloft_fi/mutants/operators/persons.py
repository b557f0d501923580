"""Operators on the boxes of a person detector (message `Detections`)."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from scaloft_fi.mutants.operator import (
    TOLERANCE_S,
    Factor,
    Facts,
    Hold,
    Metres,
    Period,
    Seconds,
    Share,
    Tap,
    TapContext,
    on,
)
from scaloft_fi.mutants.sample import Remembering, drawn, on_each
from scaloft_fi.stack.messages import Detections, Person

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
