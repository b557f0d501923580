from __future__ import annotations

import pytest
from hypothesis import given, settings

from scaloft_fi.judge.stl import tokenize
from scaloft_fi.judge.stl.parse import parse
from scaloft_fi.judge.stl.tree import Node
from scaloft_fi.judge.stl.write import written
from tests.support.stl_trees import trees


@settings(deadline=None)
@given(trees)
def test_the_text_of_a_tree_is_read_as_the_same_tree(tree: Node) -> None:
    assert repr(parse(tokenize(written(tree)))) == repr(tree)


@pytest.mark.parametrize(
    "text",
    [
        "a / 2 < 30",
        "a - (b + c) > 0.123456789",
        "(a - b) + c > -3",
        "(a / b) * c > 1",
        "(a < b) < c",
        "(a implies b) implies c",
        "a implies (b implies c)",
        "not (a > 0) and once[0:2](b > 0) since[0.05:600] c",
        "a + (not (b > 0))",
        "abs(a) * sqrt(b) > 1",
    ],
)
def test_it_has_the_brackets_that_it_needs(text: str) -> None:
    assert written(parse(tokenize(text))) == text
