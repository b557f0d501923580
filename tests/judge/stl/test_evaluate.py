from __future__ import annotations

import math
import time

import pytest
from hypothesis import given, settings

from scaloft_fi.judge.stl import LARGEST, Formula
from scaloft_fi.judge.stl.evaluate import robustness
from scaloft_fi.judge.stl.tree import Node
from tests.support.stl_trees import Column, defined, traces, trees


@settings(deadline=None, max_examples=500)
@given(trees, traces(1))
def test_robustness_is_to_the_bit_that_of_the_definition(tree: Node, signals: dict[str, Column]) -> None:
    try:
        expected = [min(LARGEST, max(-LARGEST, value)) for value in defined(tree, signals)]
    except (ZeroDivisionError, ValueError) as error:
        with pytest.raises(type(error)):
            robustness(tree, signals, LARGEST)
    else:
        assert list(map(repr, robustness(tree, signals, LARGEST))) == list(map(repr, expected))
