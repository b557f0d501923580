from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from scaloft_fi.outside.border import PORTS, CameraInfo, Goal, Land, MisfitError, Motion, from_plain, taken, to_plain
from scaloft_fi.outside.border import given as mapped_out
from scaloft_fi.stack.messages import Battery, Bumper, DepthFrame, Detections, Imu, Person
from scaloft_fi.stack.reference.messages import PoseEstimate, SpeedLimit

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
VECTORS = arrays(np.float64, 3, elements=NUMBERS)
WORDS = st.text(max_size=20)
SAMPLES = {
    Imu: st.builds(Imu, NUMBERS, VECTORS, VECTORS),
    DepthFrame: st.builds(DepthFrame, NUMBERS, arrays(np.float64, (3, 4), elements=NUMBERS)),
    Detections: st.builds(
        Detections, NUMBERS, st.lists(st.builds(Person, WORDS, NUMBERS, NUMBERS, NUMBERS), max_size=3).map(tuple)
    ),
    Battery: st.builds(Battery, NUMBERS, NUMBERS, NUMBERS, st.integers(0, 12)),
    Bumper: st.builds(Bumper, NUMBERS, st.booleans(), st.booleans()),
    PoseEstimate: st.builds(PoseEstimate, NUMBERS, VECTORS, VECTORS, NUMBERS, arrays(np.float64, 4, elements=NUMBERS)),
    CameraInfo: st.builds(
        CameraInfo, NUMBERS, st.integers(1, 640), st.integers(1, 480), NUMBERS, NUMBERS, NUMBERS, NUMBERS
    ),
    Motion: st.builds(Motion, VECTORS, NUMBERS),
    Goal: st.builds(Goal, st.tuples(NUMBERS, NUMBERS, NUMBERS)),
    SpeedLimit: st.builds(SpeedLimit, NUMBERS, NUMBERS, WORDS),
    Land: st.builds(Land, NUMBERS),
}
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


def same(one: Any, other: Any) -> bool:
    """Whether two samples have the same bits."""
    return all(np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b for a, b in zip(one, other, strict=True))


def test_every_port_has_samples_here():
    assert {port.message for port in PORTS.values()} == SAMPLES.keys()


@pytest.mark.parametrize("message", SAMPLES)
@given(data=st.data())
@settings(max_examples=10, deadline=None)
def test_a_sample_comes_back_bit_for_bit(message, data):
    sample = data.draw(SAMPLES[message])
    again = from_plain(message, json.loads(json.dumps(to_plain(sample))))
    assert type(again) is message
    assert same(sample, again)


@pytest.mark.parametrize("message", SAMPLES)
@given(value=JSON, field=st.integers(0, 6))
@settings(max_examples=20, deadline=None)
def test_whatever_json_holds_is_a_sample_or_refused_by_name(message, value, field):
    names = list(message._fields)
    plain = {name: [0.0, 0.0, 0.0] for name in names} | {names[field % len(names)]: value}
    for candidate in (value, plain):
        try:
            sample = from_plain(message, candidate)
        except MisfitError as error:
            named = str(error).startswith("data")
        else:
            named = type(sample) is message
        assert named


def test_a_refusal_names_the_field():
    with pytest.raises(MisfitError, match=r"data.turn_radps=nan must be finite"):
        from_plain(Motion, {"velocity": [0, 0, 0], "turn_radps": float("nan")})
    with pytest.raises(MisfitError, match=r"data.velocity must be a list of 3 numbers"):
        from_plain(Motion, {"velocity": [0, 0], "turn_radps": 0})
    with pytest.raises(MisfitError, match=r"data.speed is no field of Motion: velocity, turn_radps"):
        from_plain(Motion, {"velocity": [0, 0, 0], "turn_radps": 0, "speed": 1})
    with pytest.raises(MisfitError, match=r"data.depth must have height"):
        from_plain(DepthFrame, {"stamp_s": 0, "depth": {"height": 10**9, "width": 10**9, "data": ""}})


def test_fields_are_mapped_there_and_back_with_their_factor():
    fields = {"twist.linear.x": "velocity.x * 100", "twist.linear.y": "velocity.y", "rate": "turn_radps"}
    plain = {"velocity": [1.5, 2.0, 0.0], "turn_radps": 0.25}
    message = mapped_out(plain, fields)
    assert message == {"twist": {"linear": {"x": 150.0, "y": 2.0}}, "rate": 0.25}
    assert taken(message, fields) == plain
    with pytest.raises(MisfitError, match="rate is missing"):
        taken({"twist": message["twist"]}, fields)
    with pytest.raises(MisfitError, match=r"twist.linear.x must be a number"):
        taken({"twist": {"linear": {"x": "fast", "y": 0}}, "rate": 0}, fields)
