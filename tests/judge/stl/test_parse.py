from __future__ import annotations

import time

import pytest
from hypothesis import given, settings

from scaloft_fi.judge.stl import Formula, FormulaError, tokenize
from scaloft_fi.judge.stl.parse import parse
from scaloft_fi.judge.stl.tree import Comparison, Function, Interval, Logic, Node, Number, Signal, Window
from tests.support.stl_trees import trees, written

A, B, C = map(Signal, "abc")


def test_a_formula_is_a_tree() -> None:
    assert parse(tokenize("historically[0:2](a > -1) implies not b <= c")) == Logic(
        "implies",
        Window("historically", Comparison(">", A, Number(-1.0)), Interval(0, 40)),
        Function("not", Comparison("<=", B, C)),
    )


@settings(deadline=None)
@given(trees)
def test_a_text_in_brackets_has_the_tree_it_was_written_from(tree: Node) -> None:
    assert repr(parse(tokenize(written(tree)))) == repr(tree)


@pytest.mark.parametrize(
    ("loose", "brackets"),
    [
        ("a + b * c > 1", "(a + (b * c)) > 1"),
        ("a * b / c > 1", "((a * b) / c) > 1"),
        ("a + b - c > 1", "((a + b) - c) > 1"),
        ("a - b - c > 1", "((a - b) - c) > 1"),
        ("not a > 1 and b or c", "((not (a > 1)) and b) or c"),
        ("not a until b", "(not a) until b"),
        ("once a > 1 since b", "(once (a > 1)) since b"),
        ("a since b until c", "a since (b until c)"),
        ("a and b since c", "a and (b since c)"),
        ("a or b and c implies a iff b", "((a or (b and c)) implies a) iff b"),
        ("a -> b", "a implies b"),
        ("a iff b iff c", "(a iff b) iff c"),
        ("a + not b > c", "a + (not (b > c))"),
    ],
)
def test_operators_bind_in_their_order(loose: str, brackets: str) -> None:
    assert parse(tokenize(loose)) == parse(tokenize(brackets))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a - b + c > 1", "needs brackets at '+' after 'a - b': a - b + c is read as a - (b + c)"),
        ("a - b * c + a > 1", "needs brackets at '+' after '... - b * c'"),
        ("a / b * c > 1", "needs brackets at '*' after 'a / b': a / b * c is read as a / (b * c)"),
        ("0 < a <= 1", "needs brackets at '<=' after '0 < a': a < b < c compares the robustness of a < b with c; for"),
        ("a implies b -> c", "needs brackets at '->' after 'a implies b'"),
        ("a >", "is not a formula: it ends after 'a >', where is allowed: a signal, a number, '(', abs, sqrt, not,"),
        ("a > > 3", "is not a formula: it has '>' after 'a >', where is allowed: a signal"),
        ("a > 0 b > 1", "is not a formula: it has 'b' after 'a > 0', where is allowed: *, /, +, -, <, <="),
        ("(a > 0 b)", "is not a formula: it has 'b' after '( a > 0', where"),
        ("a b", "it has 'b' after 'a'"),
        ("and a", "it has 'and' at the beginning"),
        ("abs a > 1", "it has 'a' after 'abs', where is allowed: '('"),
        ("-a > 1", "it has 'a' after '-', where is allowed: a number; the negative of a signal is 0 - signal"),
        ("a > --1", "it has '-' after 'a > -'"),
        ("(a > 0", "has brackets that do not match: '(' at the beginning is not closed"),
        ("a > 0) and (b > 0", "has brackets that do not match: ')' after 'a > 0' closes none"),
        ("a[0:1] > 0", "has an interval after 'a'; an interval must be of two times in seconds, after historically,"),
        ("a and[0:1] b", "it has '[' after 'a and'"),
        ("once[0:1][0:1] a", "it has '[' after '... 0 : 1 ]'"),
        ("once[0 a", "has an interval after 'once' that must be of two times in seconds"),
        ("once[0:1e1] a", "has an interval after 'once' that must be of two times in seconds"),
        ("once[0:0.0500000000000000000001] a", "must be of two times that are multiples of 0.05 s"),
        ("once[0:600.05] a", "has once[0:600.05], which must end within 600 s; without times it has no end"),
        ("a since[2:1] b", "has since[2:1], which must not end before it begins"),
        ("a > 1e999", "has the number 1e999 after 'a >', which must be at most 1e308"),
    ],
)
def test_what_is_no_formula_is_told_with_its_place_and_what_is_allowed(text: str, said: str) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(tokenize(text))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "not " * 499 + "a",
        "a" + "+a" * 900,
        "a" + " and a" * 333,
        "once[0:1]" * 220 + "a",
        "a" + "-(a" * 19 + "+a" * 400 + ")" * 19,
    ],
)
def test_operators_too_deep_inside_one_another_are_refused_at_once(text: str) -> None:
    start = time.process_time()
    with pytest.raises(FormulaError, match="more than 200 operators inside one another"):
        parse(tokenize(text))
    assert time.process_time() - start < 1


@pytest.mark.parametrize("text", ["not " * 199 + "a", "a" + "+a" * 200, "(" * 20 + "not " * 170 + "a" + ")" * 20])
def test_what_is_nested_as_deep_as_allowed_is_evaluated(text: str) -> None:
    assert len(Formula.parse(text, "a").robustness({"a": [1.0, 2.0]})) == 2
