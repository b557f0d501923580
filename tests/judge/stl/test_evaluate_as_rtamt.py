from __future__ import annotations

import pytest
from effort import usually
from hypothesis import assume, given, settings

from scaloft_fi.judge.stl import LARGEST
from scaloft_fi.judge.stl.evaluate import robustness
from scaloft_fi.judge.stl.tree import Node, Signal, Window, parts
from tests.support.rtamt_oracle import rtamt_robustness
from tests.support.stl_trees import EDGES, ZEROS, Column, traces, trees, written


def overwrites(node: Node) -> bool:
    """Whether RTAMT appends to the samples of a signal, which it then reads elsewhere in the formula."""
    if isinstance(node, Window) and isinstance(node.of, Signal):
        return node.word in ("always", "eventually") and node.interval is not None
    return any(map(overwrites, parts(node)))


def agrees(tree: Node, signals: dict[str, Column]) -> None:
    text = written(tree)
    try:
        expected = rtamt_robustness(text, {name: list(column) for name, column in signals.items()})
    except (ZeroDivisionError, ValueError) as error:
        with pytest.raises(type(error)):
            robustness(tree, signals, LARGEST)
    else:
        bounded = [min(LARGEST, max(-LARGEST, value)) for value in expected]
        assert list(map(repr, robustness(tree, signals, LARGEST))) == list(map(repr, bounded))


@settings(deadline=None, max_examples=usually(25, release=200))
@given(trees, traces(2))
def test_robustness_is_to_the_bit_that_of_rtamt(tree: Node, signals: dict[str, Column]) -> None:
    assume(not overwrites(tree))
    agrees(tree, signals)


@pytest.mark.parametrize("edge", EDGES)
def test_an_edge_is_to_the_bit_that_of_rtamt(edge: str) -> None:
    agrees(EDGES[edge], ZEROS)
