from __future__ import annotations

from typing import NamedTuple

import pytest

from scaloft_fi.mutants.operator import ANYTHING, IMAGE, NUMBERS, STAMP, Need, the
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.stack.messages import Image, Stamp


class Nothing(NamedTuple):
    label: str


class Timed(NamedTuple):
    stamp_s: Stamp
    label: str


class Picture(NamedTuple):
    pixels: Image


@pytest.mark.parametrize(
    ("need", "met"),
    [
        (ANYTHING, {Nothing, Timed, Picture}),
        (NUMBERS, {Timed, Picture}),
        (STAMP, {Timed}),
        (IMAGE, {Picture}),
        (the(Timed), {Timed}),
    ],
)
def test_a_need_is_met_by_the_messages_that_have_it(need: Need, met: set[type]) -> None:
    assert {message for message in (Nothing, Timed, Picture) if need.met_by(message)} == met


def test_a_message_derived_from_another_meets_the_need_for_it() -> None:
    class Better(Timed):
        pass

    assert the(Timed).met_by(Better)
    assert not the(Better).met_by(Timed)


def test_every_operators_example_meets_its_need_and_some_need_refuses_something() -> None:
    assert all(operator.need.met_by(operator.example.message) for operator in OPERATORS.values())
    assert any(not operator.need.met_by(Nothing) for operator in OPERATORS.values())
