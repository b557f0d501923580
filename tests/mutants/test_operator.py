"""Declaring operators and checking their arguments."""

from __future__ import annotations

from typing import Any

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.mutants.operator import IMAGE, Example, Tap, TapContext, operator
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.stack.messages import Battery, DepthFrame
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.messages import Target

BAD = [
    ("delay", "person", {"delay_s": -1.0}, "operator 'delay': delay_s=-1 must be >= 0"),
    ("delay", "person", {"delay_s": "3"}, "delay_s='3' must be a number"),
    ("delay", "person", {"delay_s": float("nan")}, "must be a number"),
    ("delay", "person", {"delay_s": True}, "delay_s=True must be a number"),
    ("delay", "person", {"delay": 3.0}, "operator 'delay' has no argument 'delay'; did you mean 'delay_s'?"),
    ("delay", "person", {}, "operator 'delay' lacks the argument 'delay_s'"),
    ("delay", "person", {"delay_s": 1.0, "keep_first": 1}, "keep_first=1 must be true or false"),
    ("drop", "person", {"share": 1.5}, "share=1.5 must be >= 0 and <= 1"),
    ("reorder", "depth", {"count": 1}, "count=1 must be >= 2"),
    ("reorder", "depth", {"count": 2.5}, "count=2.5 must be a whole number"),
    ("throttle", "pose", {"rate_hz": 0.0}, "rate_hz=0 must be > 0"),
    (
        "scale",
        "velcmd",
        {"field": "velocty", "factor": 2.0},
        "is no numeric field of VelocityCommand; did you mean 'velocity'?",
    ),
    ("scale", "speedlimit", {"field": "norm", "factor": 2.0}, "field='norm' is no numeric field of SpeedLimit"),
    ("set", "speedlimit", {"field": "norm", "value": 1.0}, "value=1.0 must be a text, as SpeedLimit.norm is"),
    ("set", "battery", {"field": "cells", "value": 3.5}, "must be a whole number, as Battery.cells is"),
    ("set", "pose", {"field": "position", "value": 1.0}, "field='position' of PoseEstimate holds no single value"),
    ("bias", "pose", {"field": "yaw_rad", "amount": 1.0, "component": "x"}, "field='yaw_rad' has no components"),
    ("bias", "pose", {"field": "position", "amount": 1.0, "component": "w"}, "component='w' is not known"),
    ("mirror", "person", {}, "operator 'mirror' needs an image, but seam 'person' carries Detections"),
    ("ignore_axis", "goal", {"axis": "q"}, "axis='q' is not known; allowed: 'x', 'y', 'z'"),
]


@pytest.mark.parametrize(("name", "seam", "arguments", "sentence"), BAD)
def test_a_wrong_use_is_one_sentence_that_says_what_is_allowed(
    name: str, seam: str, arguments: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(InputError) as caught:
        OPERATORS[name].check(seam, REFERENCE.by_name[seam].message, arguments)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_unknown_operator_is_answered_with_the_nearest_name() -> None:
    with pytest.raises(InputError, match=r"no operator 'dealy'; did you mean 'delay'\?"):
        OPERATORS["dealy"]


def test_whole_numbers_arrive_as_such_however_they_were_written() -> None:
    assert OPERATORS["reorder"].check("depth", DepthFrame, {"count": 2.0}) == {"count": 2}
    assert OPERATORS["set"].check("battery", Battery, {"field": "cells", "value": 3.0})["value"] == 3


def test_a_name_is_declared_once_and_with_an_example_that_it_fits() -> None:
    def factory(_context: TapContext) -> Tap:
        return lambda _t_s, sample: sample

    example = Example(Target, {}, (None,), (None,))
    with pytest.raises(ValueError, match="'delay' is declared twice"):
        operator("delay", example=example)(factory)
    with pytest.raises(ValueError, match="operator 'new' needs an image, which its example's message lacks"):
        operator("new", need=IMAGE, example=example)
