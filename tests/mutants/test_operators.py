from __future__ import annotations

import copy
import math
import random
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from refused import refusal

from scaloft_fi.errors import InputError
from scaloft_fi.mutants import operator as operators
from scaloft_fi.mutants.check_operator import check_operator, operators_of
from scaloft_fi.mutants.operator import operator
from scaloft_fi.mutants.operators import OPERATORS, sensors
from scaloft_fi.mutants.reference.surroundings import invert_map
from scaloft_fi.stack import messages
from scaloft_fi.stack.declaration import Seam
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.messages import ObstacleMap, Route, Target


def same(a: Any, b: Any) -> bool:
    """Equal to the bit."""
    if isinstance(a, tuple):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and np.array_equal(a, b)
    return bool(a == b) and type(a) is type(b)


def arguments_on(operator: operators.Operator, seam: str) -> Mapping[str, Any] | None:
    """The example's arguments, with a field that the seam's message has; None where it has no such field."""
    arguments, message = dict(operator.example.arguments), REFERENCE.by_name[seam].message
    if "field" not in operator.arguments:
        return operator.check(seam, message, arguments)
    fields = messages.number_fields(message)
    if operator.name == "set":
        fields = tuple(f for f in fields if messages.field_type(message, f) is float)
        arguments["value"] = 0.25
    if arguments.get("component"):
        fields = tuple(f for f in fields if f in messages.vector_fields(message))
    if not fields:
        return None
    return operator.check(seam, message, arguments | {"field": fields[-1]})


EVERYWHERE = sorted(
    {
        (name, REFERENCE.by_name[seam].message): (name, seam)
        for name, operator in OPERATORS.items()
        for seam in reversed(REFERENCE.by_name)
        if operator.need.met_by(REFERENCE.by_name[seam].message) and arguments_on(operator, seam) is not None
    }.values()
)
"""A seam for each operator and message that it fits."""


def tap_on(name: str, seam: str) -> Any:
    operator = OPERATORS[name]
    arguments = arguments_on(operator, seam)
    rng = np.random.Generator(np.random.Philox(7))
    declared = REFERENCE.by_name[seam]
    facts = replace(operator.example.facts, duration_s=1.0)
    return operator.tap(operators.TapContext(1 / declared.rate_hz, rng, facts), arguments)


@pytest.mark.parametrize("name", OPERATORS)
def test_an_operator_does_what_its_example_says(name: str):
    assert check_operator(name).failures == ()


@pytest.mark.parametrize("name", sorted(set(OPERATORS) - {"identity"}))
def test_an_operator_tells_the_consumer_something_else_in_its_example(name: str):
    example = OPERATORS[name].example
    context = example.context()
    tap = OPERATORS[name].tap(context, OPERATORS[name].check("example", example.message, example.arguments))
    effects = {declared.message: declared.effect for declared in REFERENCE.seams}
    effect = effects.get(example.message, lambda sample: sample)
    seam = Seam("example", example.message, example.rate_hz, "one -> other", effect)
    assert any(seam.differ(sample, tap(k * context.period_s, sample)) for k, sample in enumerate(example.before))


@pytest.mark.parametrize(("name", "seam"), EVERYWHERE)
def test_fresh_taps_of_one_flight_agree_and_write_into_nothing(name: str, seam: str, stream: Any):
    polls = stream(seam)
    kept = copy.deepcopy(polls)
    first, second = tap_on(name, seam), tap_on(name, seam)
    for t_s, sample in polls:
        arrived = first(t_s, sample)
        assert same(arrived, second(t_s, sample))
        assert arrived is None or type(arrived) is REFERENCE.by_name[seam].message
    assert same(tuple(kept), tuple(polls))


@pytest.mark.parametrize(("name", "seam"), EVERYWHERE)
def test_a_tap_copied_in_flight_goes_on_by_itself(name: str, seam: str, stream: Any):
    polls = stream(seam)
    tap = tap_on(name, seam)
    for t_s, sample in polls[:17]:
        tap(t_s, sample)
    branch = copy.deepcopy(tap)
    rest = [branch(t_s, sample) for t_s, sample in polls[17:]]
    assert same(tuple(rest), tuple(tap(t_s, sample) for t_s, sample in polls[17:]))


@pytest.mark.parametrize(("name", "seam"), EVERYWHERE)
def test_a_tap_survives_a_seam_on_which_nothing_is_ever_sent(name: str, seam: str):
    tap = tap_on(name, seam)
    arrived = [tap(k / REFERENCE.by_name[seam].rate_hz, None) for k in range(100)]
    assert all(sample is None or type(sample) is REFERENCE.by_name[seam].message for sample in arrived)


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
):
    assert sentence in refusal(OPERATORS[name].check, seam, REFERENCE.by_name[seam].message, arguments)


@pytest.mark.parametrize("asked", [OPERATORS.__getitem__, check_operator])
def test_an_unknown_operator_is_answered_with_the_nearest_name(asked: Callable[[str], object]):
    with pytest.raises(InputError, match=r"no operator 'dealy'; did you mean 'delay'\?"):
        asked("dealy")


def test_whole_numbers_arrive_as_such_however_they_were_written():
    assert OPERATORS["reorder"].check("depth", messages.DepthFrame, {"count": 2.0}) == {"count": 2}
    assert OPERATORS["set"].check("battery", messages.Battery, {"field": "cells", "value": 3.0})["value"] == 3


def test_a_name_is_declared_once_and_with_an_example_that_it_fits():
    def factory(_context: operators.TapContext) -> operators.Tap:
        return lambda _t_s, sample: sample

    example = operators.Example(Target, {}, (None,), (None,))
    with pytest.raises(ValueError, match="'delay' is declared twice"):
        operator("delay", example=example)(factory)
    with pytest.raises(ValueError, match="operator 'new' needs an image, which its example's message lacks"):
        operator("new", need=operators.IMAGE, example=example)


class Nothing(NamedTuple):
    label: str


class Timed(NamedTuple):
    stamp_s: messages.Stamp
    label: str


class Picture(NamedTuple):
    pixels: messages.Image


@pytest.mark.parametrize(
    ("need", "met"),
    [
        (operators.ANYTHING, {Nothing, Timed, Picture}),
        (operators.NUMBERS, {Timed, Picture}),
        (operators.STAMP, {Timed}),
        (operators.IMAGE, {Picture}),
        (operators.the(Timed), {Timed}),
    ],
)
def test_a_need_is_met_by_the_messages_that_have_it(need: operators.Need, met: set[type]):
    assert {message for message in (Nothing, Timed, Picture) if need.met_by(message)} == met


def test_a_message_derived_from_another_meets_the_need_for_it():
    class Better(Timed):
        pass

    assert operators.the(Timed).met_by(Better)
    assert not operators.the(Better).met_by(Timed)


def _undocumented(*_: Any, **__: Any) -> Any:
    return lambda _t_s, sample: sample


def _random(*_: Any, **__: Any) -> Any:
    """Lose samples at random from 1 s on."""
    return lambda t_s, sample: None if t_s >= 1.0 and random.random() < 0.5 else sample


def _raising(*_: Any, **__: Any) -> Any:
    """Raise from 1 s on."""
    return lambda t_s, sample: sample if t_s < 1.0 else sample.nothing


def _unbuilt(*_: Any, **__: Any) -> Any:
    raise RuntimeError("no antenna")


def _lost(_t_s: float, sample: Any) -> Any:
    return sample.lost


DELAY = OPERATORS["delay"].example
HELD = replace(DELAY, after=DELAY.before)
BROKEN: Mapping[str, tuple[dict[str, Any], str]] = {
    "another sample": ({"example": replace(DELAY, after=DELAY.before)}, "sample 0 of its example: "),
    "too few samples": ({"example": replace(DELAY, after=())}, "has 0 samples after, and "),
    "a predicate": ({"example": replace(DELAY, after=lambda _before, _after: False)}, "its example does not hold"),
    "random numbers of its own": ({"make": _random, "example": HELD}, "two flights differ at 1"),
    "an error that comes late": (
        {"make": _raising, "example": HELD},
        "of its example, sent again at 1 s: AttributeError",
    ),
    "an operator that raises": ({"make": _unbuilt}, "operator 'delay' raises when it is built: RuntimeError: no"),
    "no tap": ({"make": lambda *_, **__: 5}, "operator 'delay' must return a tap, and returns 5"),
    "a tap that raises": (
        {"make": lambda *_, **__: _lost},
        "'delay' raises at sample 0 of its example: AttributeError",
    ),
    "another message": ({"make": lambda *_, **__: lambda *_: "x"}, "returns 'x' at sample 0 of its example, no "),
    "no docstring": ({"make": _undocumented}, "its docstring must begin with a sentence"),
}


@pytest.mark.parametrize("what", BROKEN)
def test_what_does_not_hold_is_a_sentence(what: str, monkeypatch: pytest.MonkeyPatch):
    changed, said = BROKEN[what]
    monkeypatch.setitem(OPERATORS._entries, "delay", replace(OPERATORS["delay"], **changed))
    check = check_operator("delay")
    assert any(said in failure for failure in check.failures)
    assert said in str(check)


def test_the_operators_of_a_package_are_those_of_its_modules():
    assert set(operators_of(sensors.__name__)) < set(operators_of("scaloft_fi.mutants.operators")) < set(OPERATORS)
    assert operators_of("scaloft_fi.mut") == ()


SENT = st.lists(st.one_of(st.none(), st.integers(0, 10_000)), max_size=60)


def fly(name: str, polls: list[Any], seed: int = 0, **arguments: Any) -> list[Any]:
    operator = OPERATORS[name]
    context = operators.TapContext(0.05, np.random.Generator(np.random.Philox(seed)))
    tap = operator.tap(context, operator.check("target", Target, arguments))
    return [tap(k / 20, sample) for k, sample in enumerate(polls)]


def targets(sent: list[int | None]) -> list[Target | None]:
    return [None if leg is None else Target(leg, (0.0, float(k), 1.65)) for k, leg in enumerate(sent)]


def arrived(samples: list[Any]) -> list[Any]:
    return [sample for sample in samples if sample is not None]


@given(SENT, st.floats(0.0, 2.0))
def test_delay_keeps_every_sample_and_their_order(sent: list[int | None], delay_s: float):
    polls = targets(sent) + [None] * 61
    assert arrived(fly("delay", polls, delay_s=delay_s)) == arrived(polls)


@given(SENT, st.integers(0, 30))
def test_delay_by_whole_polls_shifts_by_as_many_polls(sent: list[int | None], polls_late: int):
    polls = targets(sent) + [None] * polls_late
    late = fly("delay", polls, delay_s=polls_late / 20)
    assert late[polls_late:] == polls[: len(polls) - polls_late]


@given(SENT, st.integers(0, 5))
def test_dropping_no_share_is_the_identity_and_dropping_all_leaves_nothing(sent: list[int | None], seed: int):
    polls = targets(sent)
    assert fly("drop", polls, seed, share=0.0) == polls
    assert arrived(fly("drop", polls, seed, share=1.0)) == []


def test_drop_loses_about_the_share_it_is_told():
    kept = arrived(fly("drop", targets(list(range(4000))), share=0.25))
    assert 0.72 < len(kept) / 4000 < 0.78


@given(SENT, st.integers(2, 7))
def test_reorder_permutes_all_but_the_last_incomplete_block(sent: list[int | None], count: int):
    polls = targets(sent) + [None] * count
    whole = len(arrived(polls)) // count * count
    reordered = arrived(fly("reorder", polls, count=count))
    assert sorted(reordered) == sorted(arrived(polls)[:whole])
    assert reordered == [s for k in range(0, whole, count) for s in arrived(polls)[k : k + count][::-1]]


@given(SENT, st.sampled_from([10.0, 5.0, 4.0]))
def test_throttle_passes_at_most_its_rate(sent: list[int | None], rate_hz: float):
    times_s = [k / 20 for k, sample in enumerate(fly("throttle", targets(sent), rate_hz=rate_hz)) if sample]
    slots = [round(t_s * rate_hz * 1e6) // 1_000_000 for t_s in times_s]
    assert len(slots) == len(set(slots))


@given(st.integers(2, 400), st.integers(0, 400), st.integers(1, 400), st.sampled_from([20, 240]), st.integers(0, 2000))
def test_windows_recur_with_their_period_and_none_is_open_before_the_first(
    period: int, phase: int, length: int, rate_hz: int, k: int
):
    windows = operators.Windows.periodic(period / rate_hz, phase / rate_hz, min(length, period) / rate_hz)
    since = k - period - phase
    assert windows.open(k / rate_hz) == (since >= 0 and since % period < min(length, period))


@given(st.integers(1, 40), st.integers(0, 40))
def test_outage_is_silent_in_its_windows_and_transparent_outside(burst: int, phase: int):
    polls = targets(list(range(200)))
    silent = [
        k
        for k, sample in enumerate(fly("outage", polls, burst_s=burst / 20, period_s=2.0, phase_s=phase / 20))
        if sample is None
    ]
    assert silent == [k for k in range(200) if k - 40 - phase >= 0 and (k - 40 - phase) % 40 < burst]


def test_an_endless_freeze_repeats_the_sample_before_it():
    held = fly("freeze", targets(list(range(20))), hold_s=float("inf"), period_s=0.5)
    assert held[:10] == targets(list(range(20)))[:10]
    assert set(held[10:]) == {held[9]}


def test_seven_in_ten_of_a_narrow_view_is_measured_in_degrees():
    operator = OPERATORS["narrow"]
    tap = operator.tap(operators.TapContext(0.05, np.random.default_rng(0)), {"share": 0.5})
    inside, outside = (
        messages.Person("person", 0.9, np.radians(14.0), 3.0),
        messages.Person("person", 0.9, np.radians(-15.5), 3.0),
    )
    boxes = operator.example.before[0]._replace(persons=(inside, outside))
    assert tap(0.0, boxes).persons == (inside,)  # type: ignore[union-attr]


@given(st.floats(0.0, 0.6))
def test_the_inserted_waypoint_keeps_its_clearance_from_the_wall(clearance_m: float):
    operator = OPERATORS["insert_near_wall"]
    tap = operator.tap(operators.TapContext(0.05, np.random.default_rng(0)), {"clearance_m": clearance_m})
    route = tap(0.0, Route(((0.0, 7.0, 1.65), (0.0, 0.0, 1.65))))
    assert abs(1.5 - (route.points[0][0] + 0.235) - clearance_m) < 1e-9


@given(
    origin=arrays(np.float64, 3, elements=st.floats(-20.0, 20.0)),
    off=arrays(np.float64, st.tuples(st.integers(0, 30), st.just(3)), elements=st.floats(-2.0, 2.0)),
    cell_m=st.sampled_from([0.1, 0.15, 0.25]),
    radius_m=st.sampled_from([0.3, 0.7, 1.5]),
)
def test_an_inverted_map_has_every_cell_around_that_is_not_occupied_once_and_in_order(origin, off, cell_m, radius_m):
    here, reach = np.floor(origin / cell_m).astype(int), math.ceil(radius_m / cell_m)
    taken = {tuple(cell) for cell in np.floor((origin + off) / cell_m).astype(int).tolist()}
    free = [
        cell
        for i in range(-reach, reach + 1)
        for j in range(-reach, reach + 1)
        for k in (-1, 0, 1)
        if np.hypot(i, j) * cell_m <= radius_m and (cell := tuple((here + np.array([i, j, k])).tolist())) not in taken
    ]
    context = operators.TapContext(
        0.05, np.random.default_rng(0), facts=operators.Facts(settings={"memory": {"voxel_m": cell_m}})
    )
    told = invert_map(context, radius_m=radius_m)(0.0, ObstacleMap(0.0, origin + off, 1.0, origin))
    assert told.points.tobytes() == ((np.array(free, dtype=float).reshape(-1, 3) + 0.5) * cell_m).tobytes()
