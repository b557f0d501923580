from __future__ import annotations

import math

from hypothesis import assume, example, given, settings

from scaloft_fi.judge.stl.evaluate import robustness
from scaloft_fi.judge.stl.tree import Arithmetic, Hold, Interval, Logic, Node, Number, Signal, Window, parts
from tests.support.rtamt_oracle import rtamt_robustness
from tests.support.stl_trees import NAMES, Column, traces, trees, written


def overwrites(node: Node) -> bool:
    """Whether RTAMT appends to the samples of a signal, which it then reads elsewhere in the formula."""
    if isinstance(node, Window) and isinstance(node.of, Signal):
        return node.word in ("always", "eventually") and node.interval is not None
    return any(map(overwrites, parts(node)))


ZEROS = {"a": [0.0, -0.0, 1.0, 0.0], "b": [-0.0, 0.0, -0.0, 0.0], "c": [-0.0, -0.0, 0.0, 2.0]}
A, B, C = map(Signal, NAMES)
NONE = Arithmetic("-", Window("once", A, Interval(1, 2)), Window("once", B, Interval(1, 2)))
"""No number at the first sample: infinity less infinity."""


@settings(deadline=None, max_examples=400)
@given(trees, traces(2))
@example(Window("once", Logic("and", A, B), Interval(0, 2)), ZEROS)
@example(Window("historically", B), ZEROS)
@example(Hold("since", A, B, Interval(0, 3)), ZEROS)
@example(Hold("until", B, C, Interval(1, 2)), ZEROS)
@example(Window("historically", NONE, Interval(0, 2)), ZEROS)
@example(Window("always", NONE), ZEROS)
@example(Hold("since", NONE, B, Interval(0, 2)), ZEROS)
@example(Hold("until", A, NONE), ZEROS)
@example(Arithmetic("/", A, B), ZEROS)
@example(Arithmetic("*", Number(1e300), Arithmetic("*", Number(1e300), A)), ZEROS)
def test_robustness_is_to_the_bit_that_of_rtamt(tree: Node, signals: dict[str, Column]) -> None:
    assume(not overwrites(tree))
    text = written(tree)
    try:
        expected = rtamt_robustness(text, {name: list(column) for name, column in signals.items()})
    except (ZeroDivisionError, ValueError) as error:
        try:
            robustness(tree, signals, math.inf)
        except type(error):
            return
        raise AssertionError(text) from error
    assert list(map(repr, robustness(tree, signals, 1e9))) == [
        repr(float(min(1e9, max(-1e9, value)))) for value in expected
    ]
