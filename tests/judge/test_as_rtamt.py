"""Formulas mean what RTAMT, the field's library, makes of them."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from hypothesis import assume, event, example, given, settings
from hypothesis import strategies as st
from options import usually

from scaloft_fi.judge.stl import (
    BINDING,
    FormulaError,
    Node,
    Prefix,
    Signal,
    parse,
    parts,
    tokenize,
)
from tests.support.rtamt_oracle import rtamt_robustness, rtamt_tree
from tests.support.stl_trees import EDGES, NAMES, ZEROS, Column, agrees, bracketed, traces, trees

INTERVALS = ["", "", "[0:0.1]", "[.05:2.]"]
joins = st.builds(
    lambda operator, interval: operator + (interval if operator in ("since", "until") else ""),
    st.sampled_from([operator for operators in BINDING for operator in operators]),
    st.sampled_from(INTERVALS),
)
befores = st.builds(
    lambda word, interval: word + ("" if word in ("", "not") else interval),
    st.sampled_from(["", "", "", "not", "historically", "once", "always", "eventually"]),
    st.sampled_from(INTERVALS),
)
operands = st.recursive(
    st.sampled_from([*NAMES, "2", "-0.5", "1e3"]),
    lambda inner: st.one_of(
        st.builds("{} ({} {} {})".format, befores, inner, joins, inner),
        st.builds("{} {}".format, befores, inner),
        st.builds("{}({} {} {})".format, st.sampled_from(["abs", "sqrt", "rise", "fall", "prev"]), inner, joins, inner),
    ),
    max_leaves=4,
)
chains = st.lists(st.tuples(operands, joins), min_size=1, max_size=6).map(
    lambda pairs: " ".join(word for pair in pairs for word in pair) + " a"
)
"""Operands and operators in turn, with few brackets, so that the texts ask for precedence."""
words = st.lists(
    st.sampled_from([*NAMES, *"+-*/()[]:", "2", "<", "->", "not", "and", "once", "since", "abs", "[0:0.1]"]), max_size=9
).map(" ".join)


def ours(text: str) -> Node | str:
    try:
        return parse(tokenize(text))
    except FormulaError as error:
        return str(error)


def theirs(text: str) -> Node | None:
    try:
        return rtamt_tree(text, NAMES)
    except Exception:  # noqa: BLE001 - RTAMT raises what its parser happens to meet
        return None


@settings(deadline=None, max_examples=usually(25, release=250))
@given(chains)
@example("a - 2 - b + c > 0")
@example("a / 2 * b > 0")
@example("a < b <= c")
@example("a -> b implies c")
def test_a_chain_of_operators_has_the_tree_of_rtamt_or_needs_brackets(text: str):
    mine = ours(text)
    if isinstance(mine, str):
        assert mine.startswith("needs brackets")
        event("needs brackets")
    else:
        assert mine == theirs(text)


@settings(deadline=None, max_examples=usually(25, release=250))
@given(words)
@example("a - - 2")
@example("- a")
@example("not not - 2 < a")
@example("once [ 0 : 0.1 ] a since [0:0.1] b")
def test_any_words_have_the_tree_of_rtamt_or_are_refused_by_both(text: str):
    mine = ours(text)
    if not isinstance(mine, str):
        assert mine == theirs(text)
        event("a formula")
    elif not mine.startswith("needs brackets"):
        assert theirs(text) is None


@settings(deadline=None, max_examples=usually(25, release=150))
@given(trees)
def test_a_text_in_brackets_has_the_tree_it_was_written_from(tree: Node):
    text = bracketed(tree)
    assert repr(ours(text)) == repr(tree) == repr(theirs(text))


def overwrites(node: Node) -> bool:
    """Whether RTAMT appends to the samples of a signal, which it then reads elsewhere in the formula."""
    if isinstance(node, Prefix) and isinstance(node.of, Signal):
        return node.word in ("always", "eventually") and node.interval is not None
    return any(map(overwrites, parts(node)))


def as_rtamt(tree: Node, signals: Mapping[str, Column]) -> Column:
    return rtamt_robustness(bracketed(tree), {name: list(column) for name, column in signals.items()})


@settings(deadline=None, max_examples=usually(25, release=200))
@given(trees, traces(2))
def test_robustness_is_to_the_bit_that_of_rtamt(tree: Node, signals: dict[str, Column]):
    assume(not overwrites(tree))
    agrees(tree, signals, as_rtamt)


@pytest.mark.parametrize("edge", EDGES)
def test_an_edge_is_to_the_bit_that_of_rtamt(edge: str):
    agrees(EDGES[edge], ZEROS, as_rtamt)
