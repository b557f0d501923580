"""Formulas: their text, their tree, their robustness."""

from __future__ import annotations

import csv
import io
import json
import logging
import math
import re
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest
from builders import GRID, KINDS, ROSTER, outcome, pool
from hypothesis import assume, event, example, given, settings
from hypothesis import strategies as st
from options import cases, usually

from scaloft_fi.analysis.detection import tallies
from scaloft_fi.analysis.margin import margins
from scaloft_fi.analysis.score import score
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Compliance, Kind, Reading
from scaloft_fi.judge.stl import (
    BINDING,
    LARGEST,
    SAMPLE_MS,
    Formula,
    FormulaError,
    Infix,
    Interval,
    Node,
    Number,
    Prefix,
    Signal,
    inside_always,
    mean,
    parse,
    parts,
    tokenize,
    written,
)
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.verbs.export.dossier import columns, export_rows, parquet, to_csv, to_json
from scaloft_fi.verbs.first_screen import requirement_table
from scaloft_fi.verbs.margin import Margins, margin_tables
from tests.support.rtamt_oracle import rtamt_robustness, rtamt_tree
from tests.support.stl_trees import EDGES, NAMES, ZEROS, Column, agrees, all_trees, bracketed, defined, traces, trees

SIGNALS = ("a", "b", "speed_mps", "person_sight_m")


def rho(text: str, **signals: list[float]) -> list[float]:
    return Formula.parse(text, signals).robustness(signals)


@pytest.mark.parametrize(
    ("text", "signals", "robustness"),
    [
        ("a > 2", {"a": [5, 2, 1.5]}, [3, 0, -0.5]),
        ("a <= 2", {"a": [5, 2, 1.5]}, [-3, 0, 0.5]),
        # 0.1 s are two sample periods: the window holds three samples
        ("historically[0:0.1](a > 0)", {"a": [3, 1, 2, 5, 4, 6]}, [3, 1, 1, 1, 2, 4]),
        ("once[0:0.05](a > 0)", {"a": [3, 1, 2, 5, 4]}, [3, 3, 2, 5, 5]),
        ("a > 0 implies b > 0", {"a": [2, -1, 3], "b": [-1, -5, 4]}, [-1, 1, 4]),
        ("always(a > 0)", {"a": [3, -1, 2, 1]}, [-1, -1, 1, 1]),
        ("eventually(a < -1)", {"a": [0, -3, 2, 1]}, [2, 2, -2, -2]),
        # a window before the flight is a number that JSON can hold
        ("historically[1:2](a > 0)", {"a": [1, 2, 3]}, [LARGEST] * 3),
        ("once[1:2](a > 0)", {"a": [1, 2, 3]}, [-LARGEST] * 3),
        ("always(a > 0)", {"a": [7]}, [7]),
        # before 0.1 s have passed the mean is that of what there is
        ("mean[0:0.1](a) <= 2", {"a": [3, 1, 2, 6, 4]}, [-1, 0, 0, -1, -2]),
        ("mean[0:0.05](a - b) - a > 0", {"a": [3, 1], "b": [0, 2]}, [0, 0]),
        ("a/2<=1", {"a": [4, 1]}, [-1, 0.5]),
    ],
)
def test_a_formula_has_the_robustness_of_its_definition(
    text: str, signals: dict[str, list[float]], robustness: list[float]
):
    assert rho(text, **signals) == robustness


def test_arrays_and_lists_say_the_same():
    formula = Formula.parse("a / 3 <= 1 and b > 0", SIGNALS)
    assert formula.robustness({"a": np.array([3.0, 1.5]), "b": np.array([1.0, 2.0])}) == [0, 0.5]


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_sample_that_is_no_number_is_no_evidence(value: float):
    with pytest.raises(ValueError, match=r"signal a is (nan|inf) at sample 1"):
        rho("a > 0", a=[1, value])


def test_signals_of_different_length_are_refused():
    with pytest.raises(ValueError, match="differ in length"):
        rho("a > b", a=[1, 2], b=[1])


def test_parsing_and_evaluating_say_nothing(capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture):
    with caplog.at_level(logging.DEBUG):
        rho("historically[0:1](a + b > 3) implies b > 1.25", a=[1, 2], b=[1, 2])
        with pytest.raises(FormulaError):
            Formula.parse("a > > 3", SIGNALS)
    assert capfd.readouterr() == ("", "")
    assert caplog.records == []
    logging.getLogger("someone.else").warning("still heard")
    assert [record.message for record in caplog.records] == ["still heard"]


def test_only_brackets_around_everything_are_the_inside_of_always():
    assert inside_always("always((a > 0) or (b > 0))") == "( a > 0 ) or ( b > 0 )"
    assert inside_always("always(a > 0) or always(b > 0)") is None
    assert inside_always("a > 0") is None
    assert inside_always("always[0:2](a > 0)") is None


@pytest.mark.parametrize(
    ("text", "flaw"),
    [
        ("always(a > 0", "lacks ')'"),
        ("always((a > 0) and (b > 0)", "lacks ')'"),
        ("always((a > 0", "lacks '))'"),
        ("always(a > 0))", "has ')' too many"),
    ],
)
def test_a_bracket_of_always_that_is_missing_or_left_over_is_named(text: str, flaw: str):
    with pytest.raises(FormulaError, match=f"has brackets that do not match: it {re.escape(flaw)}$"):
        inside_always(text)


@given(
    st.lists(st.sampled_from(["a", "speed_mps", "2", "0.25", "<=", "->", "(", ")", "historically", "/"]), max_size=12)
)
def test_tokens_joined_by_spaces_are_the_same_tokens(tokens: list[str]):
    assert tokenize(" ".join(tokens)) == tokens


def test_the_sampling_period_is_that_of_the_flight_log():
    assert SAMPLE_MS == 1000 / 20


A, B, C = map(Signal, "abc")


def test_a_formula_is_a_tree():
    assert parse(tokenize("historically[0:2](a > -1) implies not b <= c")) == Infix(
        "implies",
        Prefix("historically", Infix(">", A, Number(-1.0)), Interval(0, 40)),
        Prefix("not", Infix("<=", B, C)),
    )


@settings(deadline=None)
@given(all_trees)
def test_a_text_in_brackets_has_the_tree_it_was_written_from(tree: Node):
    assert repr(parse(tokenize(bracketed(tree)))) == repr(tree)


@cases("loose", "brackets")
def test_operators_bind_in_their_order(loose: str, brackets: str):
    assert parse(tokenize(loose)) == parse(tokenize(brackets))


@cases("text", "said")
def test_what_is_no_formula_is_told_with_its_place_and_what_is_allowed(text: str, said: str):
    with pytest.raises(FormulaError) as caught:
        Formula.parse(text, (*SIGNALS, "c"))
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
def test_operators_too_deep_inside_one_another_are_refused_at_once(text: str):
    start = time.process_time()
    with pytest.raises(FormulaError, match="more than 200 operators inside one another"):
        parse(tokenize(text))
    assert time.process_time() - start < 1


@pytest.mark.parametrize("text", ["not " * 199 + "a", "a" + "+a" * 200, "(" * 20 + "not " * 170 + "a" + ")" * 20])
def test_what_is_nested_as_deep_as_allowed_is_evaluated(text: str):
    assert len(Formula.parse(text, "a").robustness({"a": [1.0, 2.0]})) == 2


@settings(deadline=None)
@given(all_trees)
def test_the_text_of_a_tree_is_read_as_the_same_tree(tree: Node):
    assert repr(parse(tokenize(written(tree)))) == repr(tree)


@cases("text")
def test_it_has_the_brackets_that_it_needs(text: str):
    assert written(parse(tokenize(text))) == text


@settings(deadline=None, max_examples=usually(25, release=300))
@given(all_trees, traces(1))
def test_robustness_is_to_the_bit_that_of_the_definition(tree: Node, signals: dict[str, Column]):
    agrees(tree, signals, defined)


@pytest.mark.parametrize("edge", EDGES)
def test_an_edge_is_to_the_bit_that_of_the_definition(edge: str):
    agrees(EDGES[edge], ZEROS, defined)


@pytest.mark.parametrize(
    ("text", "error", "said"),
    [
        ("1 / a > 0", ZeroDivisionError, "division by 0 at sample 1"),
        ("sqrt(a - 1) > 0", ValueError, "sqrt of -1 at sample 1"),
    ],
)
def test_what_arithmetic_does_not_know_is_told_with_its_sample(text: str, error: type[Exception], said: str):
    with pytest.raises(error, match=said):
        Formula.parse(text, "a").robustness({"a": [1, 0, -1]})


def test_no_sample_is_no_evidence():
    with pytest.raises(ValueError, match="have no sample"):
        Formula.parse("a > 0", "a").robustness({"a": []})


def test_the_samples_of_a_signal_stay_as_they_are():
    signals = {"a": [1.0, -1.0, 2.0]}
    Formula.parse("always[0:1] a and eventually[0:1] a and (a since[0:1] a)", "a").robustness(signals)
    assert signals == {"a": [1.0, -1.0, 2.0]}


@pytest.mark.parametrize("formula", ["historically[0:600](a > 0)", "eventually[1:600](a > 0)", "a since[0:600] a"])
def test_the_longest_interval_over_a_long_flight_is_evaluated_at_once(formula: str):
    samples = [float(place % 7) for place in range(6_000)]
    start = time.process_time()
    Formula.parse(formula, "a").robustness({"a": samples})
    assert time.process_time() - start < 5


@cases("foreign", "ours")
def test_units_commas_and_equality_of_rtamt_are_read(foreign: str, ours: str):
    assert written(Formula.parse(foreign, ["a", "b"]).tree) == ours


@cases("text", "remedy")
def test_what_is_of_rtamt_and_not_of_ours_is_named_with_its_remedy(text: str, remedy: str):
    with pytest.raises(FormulaError, match=remedy):
        Formula.parse(text, ["a", "b"])


def test_a_signal_may_have_the_name_of_a_foreign_word():
    assert Formula.parse("rise > 1", ["rise"]).names == ("rise",)


@pytest.mark.parametrize("divisor", ["0", "0.0", "(1 - 1)", "(2 * 0)", "(0 / 3)", "abs(0)", "sqrt(2 - 2)"])
def test_a_division_by_a_constant_zero_is_no_formula(divisor: str):
    with pytest.raises(FormulaError, match="divides by 0"):
        Formula.parse(f"a > 1 / {divisor}", ["a"])
    with pytest.raises(FormulaError, match="divides by 0"):
        Formula.parse(f"a / {divisor} > 1", ["a"])


def test_a_root_of_a_negative_constant_is_no_formula():
    with pytest.raises(FormulaError, match="root of a negative number"):
        Formula.parse("a > sqrt(0 - 1)", ["a"])


@given(first=st.integers(0, 100), length=st.integers(0, 100))
def test_a_window_is_the_same_in_seconds_milliseconds_and_with_a_comma(first: int, length: int):
    last = first + length
    texts = (
        f"once[{first / 20}:{last / 20}](a)",
        f"once[{first * 50}ms:{last * 50}ms](a)",
        f"once[{first * 50_000}us,{last * 50_000}us](a)",
    )
    assert len({Formula.parse(text, ["a"]).tree for text in texts}) == 1


samples = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=40).map(np.array)
windows = st.integers(0, 50)


@given(samples, windows)
def test_a_mean_is_that_of_a_loop_over_the_window(values: Any, last: int):
    for place, found in enumerate(mean(values, last)):
        window = values[max(0, place - last) : place + 1]
        assert found == pytest.approx(math.fsum(window) / len(window), rel=1e-12, abs=1e-9)
        assert min(window) <= found <= max(window)


@given(st.floats(-1e9, 1e9), st.integers(1, 40), windows)
def test_the_mean_of_a_constant_is_the_constant_and_that_of_one_sample_the_sample(value: float, count: int, last: int):
    assert mean(np.full(count, value), last).tolist() == [value] * count
    assert mean(np.array([value, 0.5]), 0).tolist() == [value, 0.5]


@given(samples, windows, st.sampled_from([-1e6, -0.1, 3.0, 1e9]), st.sampled_from([-2.0, 0.5, 8.0]))
def test_a_mean_moves_and_grows_with_its_samples(values: Any, last: int, shift: float, scale: float):
    assert mean(values * scale, last) == pytest.approx(mean(values, last) * scale, rel=1e-14, abs=1e-300)
    assert mean(values + shift, last) == pytest.approx(mean(values, last) + shift, rel=1e-9, abs=1e-6)


@given(st.lists(st.floats(-100, 100), min_size=1, max_size=40), st.floats(-100, 100), st.integers(1, 30))
def test_the_robustness_of_a_limit_on_a_mean_is_how_far_the_mean_is_from_it(a: list[float], limit: float, last: int):
    found = rho(f"mean[0:{last / 20:g}](a) <= {limit!r}", a=a)
    assert found == (limit - mean(np.array(a), last)).tolist()


SENTINEL = 24.0
HUMAN = "T0O0W0D0H1"


def untested(flown: Outcome, name: str = "SR2") -> Outcome:
    """The flight in which the condition of a requirement never came true."""
    return replace(
        flown,
        readings=tuple(replace(r, rho=SENTINEL, triggered=0) if r.requirement == name else r for r in flown.readings),
    )


@pytest.mark.parametrize(
    ("reading", "compliance", "told"),
    [
        (Reading("SR2", Kind.SAFETY, 0.3, None, 1, open=False), Compliance.HELD, 0.3),
        (Reading("SR2", Kind.SAFETY, 0.3, None, 1, open=True), Compliance.OPEN, 0.3),
        (Reading("SR2", Kind.SAFETY, SENTINEL, None, 0, open=False), Compliance.VACUOUS, None),
        (Reading("SR2", Kind.SAFETY, SENTINEL, None, 0, open=True), Compliance.OPEN, None),
        (Reading("SR2", Kind.SAFETY, -0.1, 5.0, 0, open=False), Compliance.VIOLATED, -0.1),
    ],
)
def test_robustness_is_told_of_what_was_put_to_the_test_or_violated(
    reading: Reading, compliance: Compliance, told: float | None
):
    assert reading.compliance is compliance
    assert reading.robustness == told


def test_a_row_of_the_export_has_nothing_there_in_every_format():
    rows = export_rows([untested(outcome())], ROSTER, GRID)
    (as_json,) = json.loads(to_json(rows))
    (as_csv,) = csv.DictReader(io.StringIO(to_csv((row.values() for row in rows), columns(rows))))
    assert (as_json["rho_SR1"], as_json["rho_SR2"]) == (0.3, None)
    assert (as_csv["rho_SR1"], as_csv["rho_SR2"]) == ("0.3", "")
    assert as_json["held"] == list(KINDS)


def test_a_column_of_nothing_is_still_one_of_numbers_in_parquet():
    rows = export_rows([untested(outcome())], ROSTER, GRID)
    table = pyarrow.parquet.read_table(io.BytesIO(parquet(rows, columns(rows))))
    assert str(table.schema.field("rho_SR2").type) == "double"
    assert table.column("rho_SR2").to_pylist() == [None]


def test_the_least_robustness_is_that_of_the_flights_that_put_it_to_the_test():
    flights = [outcome(seed=0), untested(outcome(seed=1)), untested(outcome(seed=1), "OP1")]
    assert {t.requirement: t.least_rho for t in tallies(flights)}["SR2"] == 0.3
    alone = [untested(outcome())]
    assert {t.requirement: t.least_rho for t in tallies(alone)}["SR2"] is None
    rows = {row[0]: row[-1] for row in requirement_table(tallies(alone)).rows}
    assert (rows["SR1"], rows["SR2"]) == ("0.300", "n/a")


def test_an_end_of_a_margin_that_tests_nothing_has_no_robustness():
    matrix = load_matrix(Path(__file__).parents[2] / "hazop", REFERENCE.by_name)
    kills = [outcome("LATE-human@3s", HUMAN, seed, violated={"SR2": 8.0}) for seed in range(3)]
    flights = [*pool(HUMAN), untested(outcome("LATE-human@1s", HUMAN)), *kills]
    found = margins(flights, score(flights, ROSTER, GRID), matrix)
    (table,) = margin_tables(found, (), 1)
    assert table.rows[0][6] == "SR2 ? / -0.1"
    assert ["SR2" in tried.rho for tried in Margins.of(found).tried] == [False, True]


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
def test_a_text_in_brackets_has_the_tree_that_rtamt_reads_too(tree: Node):
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
