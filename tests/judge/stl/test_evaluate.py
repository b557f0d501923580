from __future__ import annotations

import time

import pytest
from effort import usually
from hypothesis import given, settings

from scaloft_fi.judge.stl import LARGEST, Formula
from scaloft_fi.judge.stl.evaluate import robustness
from scaloft_fi.judge.stl.tree import Node
from tests.support.stl_trees import EDGES, ZEROS, Column, defined, traces, trees


def agrees(tree: Node, signals: dict[str, Column]) -> None:
    try:
        expected = [min(LARGEST, max(-LARGEST, value)) for value in defined(tree, signals)]
    except (ZeroDivisionError, ValueError) as error:
        with pytest.raises(type(error)):
            robustness(tree, signals, LARGEST)
    else:
        assert list(map(repr, robustness(tree, signals, LARGEST))) == list(map(repr, expected))


@settings(deadline=None, max_examples=usually(25, release=300))
@given(trees, traces(1))
def test_robustness_is_to_the_bit_that_of_the_definition(tree: Node, signals: dict[str, Column]) -> None:
    agrees(tree, signals)


@pytest.mark.parametrize("edge", EDGES)
def test_an_edge_is_to_the_bit_that_of_the_definition(edge: str) -> None:
    agrees(EDGES[edge], ZEROS)


@pytest.mark.parametrize(
    ("text", "error", "said"),
    [
        ("1 / a > 0", ZeroDivisionError, "division by 0 at sample 1"),
        ("sqrt(a - 1) > 0", ValueError, "sqrt of -1 at sample 1"),
    ],
)
def test_what_arithmetic_does_not_know_is_told_with_its_sample(text: str, error: type[Exception], said: str) -> None:
    with pytest.raises(error, match=said):
        Formula.parse(text, "a").robustness({"a": [1, 0, -1]})


def test_no_sample_is_no_evidence() -> None:
    with pytest.raises(ValueError, match="have no sample"):
        Formula.parse("a > 0", "a").robustness({"a": []})


def test_the_samples_of_a_signal_stay_as_they_are() -> None:
    signals = {"a": [1.0, -1.0, 2.0]}
    Formula.parse("always[0:1] a and eventually[0:1] a and (a since[0:1] a)", "a").robustness(signals)
    assert signals == {"a": [1.0, -1.0, 2.0]}


@pytest.mark.parametrize("formula", ["historically[0:600](a > 0)", "eventually[1:600](a > 0)", "a since[0:600] a"])
def test_the_longest_interval_over_a_long_flight_is_evaluated_at_once(formula: str) -> None:
    samples = [float(place % 7) for place in range(6_000)]
    start = time.process_time()
    Formula.parse(formula, "a").robustness({"a": samples})
    assert time.process_time() - start < 5
