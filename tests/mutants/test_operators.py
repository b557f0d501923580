"""What holds for every operator, on every seam it is declared for."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from scaloft_fi.mutants.check_operator import check_operator
from scaloft_fi.mutants.operator import Operator, TapContext
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.stack.declaration import Seam
from scaloft_fi.stack.messages import field_type, number_fields, vector_fields
from scaloft_fi.stack.reference.declaration import REFERENCE


def same(a: Any, b: Any) -> bool:
    """Equal to the bit."""
    if isinstance(a, tuple):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and np.array_equal(a, b)
    return bool(a == b) and type(a) is type(b)


def arguments_on(operator: Operator, seam: str) -> Mapping[str, Any] | None:
    """The example's arguments, with a field that the seam's message has; None where it has no such field."""
    arguments, message = dict(operator.example.arguments), REFERENCE.by_name[seam].message
    if "field" not in operator.arguments:
        return operator.check(seam, message, arguments)
    fields = number_fields(message)
    if operator.name == "set":
        fields = tuple(f for f in fields if field_type(message, f) is float)
        arguments["value"] = 0.25
    if arguments.get("component"):
        fields = tuple(f for f in fields if f in vector_fields(message))
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
    assert arguments is not None
    rng = np.random.Generator(np.random.Philox(7))
    declared = REFERENCE.by_name[seam]
    facts = replace(operator.example.facts, duration_s=1.0)
    return operator.tap(TapContext(1 / declared.rate_hz, rng, facts), arguments)


@pytest.mark.parametrize("name", OPERATORS)
def test_an_operator_does_what_its_example_says(name: str) -> None:
    assert check_operator(name).failures == ()


@pytest.mark.parametrize("name", sorted(set(OPERATORS) - {"identity"}))
def test_an_operator_tells_the_consumer_something_else_in_its_example(name: str) -> None:
    example = OPERATORS[name].example
    context = example.context()
    tap = OPERATORS[name].tap(context, OPERATORS[name].check("example", example.message, example.arguments))
    effects = {declared.message: declared.effect for declared in REFERENCE.seams}
    effect = effects.get(example.message, lambda sample: sample)
    seam = Seam("example", example.message, example.rate_hz, "one -> other", effect)
    assert any(seam.differ(sample, tap(k * context.period_s, sample)) for k, sample in enumerate(example.before))


@pytest.mark.parametrize("name", OPERATORS)
def test_an_operator_says_what_it_does_and_what_it_needs(name: str) -> None:
    operator = OPERATORS[name]
    assert operator.summary.endswith(".")
    assert operator.need.words


@pytest.mark.parametrize(("name", "seam"), EVERYWHERE)
def test_fresh_taps_of_one_flight_agree_and_write_into_nothing(name: str, seam: str, stream: Any) -> None:
    polls = stream(seam)
    kept = copy.deepcopy(polls)
    first, second = tap_on(name, seam), tap_on(name, seam)
    for t_s, sample in polls:
        arrived = first(t_s, sample)
        assert same(arrived, second(t_s, sample))
        assert arrived is None or type(arrived) is REFERENCE.by_name[seam].message
    assert same(tuple(kept), tuple(polls))


@pytest.mark.parametrize(("name", "seam"), EVERYWHERE)
def test_a_tap_copied_in_flight_goes_on_by_itself(name: str, seam: str, stream: Any) -> None:
    polls = stream(seam)
    tap = tap_on(name, seam)
    for t_s, sample in polls[:17]:
        tap(t_s, sample)
    branch = copy.deepcopy(tap)
    rest = [branch(t_s, sample) for t_s, sample in polls[17:]]
    assert same(tuple(rest), tuple(tap(t_s, sample) for t_s, sample in polls[17:]))


@pytest.mark.parametrize(("name", "seam"), EVERYWHERE)
def test_a_tap_survives_a_seam_on_which_nothing_is_ever_sent(name: str, seam: str) -> None:
    tap = tap_on(name, seam)
    arrived = [tap(k / REFERENCE.by_name[seam].rate_hz, None) for k in range(100)]
    assert all(sample is None or type(sample) is REFERENCE.by_name[seam].message for sample in arrived)
