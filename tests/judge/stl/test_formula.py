from __future__ import annotations

import logging
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.judge.stl import LARGEST, SAMPLE_MS, Formula, FormulaError, inside_always, tokenize

SIGNALS = ("a", "b", "speed_mps", "person_sight_m")


def rho(text: str, **signals: list[float]) -> list[float]:
    return Formula.parse(text, signals).robustness(signals)


def test_a_comparison_is_the_margin_to_its_limit() -> None:
    assert rho("a > 2", a=[5, 2, 1.5]) == [3, 0, -0.5]
    assert rho("a <= 2", a=[5, 2, 1.5]) == [-3, 0, 0.5]


def test_historically_is_the_worst_of_its_window_both_ends_included() -> None:
    # 0.1 s are two sample periods: the window holds three samples
    assert rho("historically[0:0.1](a > 0)", a=[3, 1, 2, 5, 4, 6]) == [3, 1, 1, 1, 2, 4]


def test_once_is_the_best_of_its_window() -> None:
    assert rho("once[0:0.05](a > 0)", a=[3, 1, 2, 5, 4]) == [3, 3, 2, 5, 5]


def test_implies_is_the_larger_of_the_denied_condition_and_the_consequence() -> None:
    assert rho("a > 0 implies b > 0", a=[2, -1, 3], b=[-1, -5, 4]) == [-1, 1, 4]


def test_always_is_the_worst_still_to_come() -> None:
    assert rho("always(a > 0)", a=[3, -1, 2, 1]) == [-1, -1, 1, 1]


def test_eventually_is_the_best_still_to_come() -> None:
    assert rho("eventually(a < -1)", a=[0, -3, 2, 1]) == [2, 2, -2, -2]


def test_a_window_before_the_flight_is_a_number_that_json_can_hold() -> None:
    assert rho("historically[1:2](a > 0)", a=[1, 2, 3]) == [LARGEST] * 3
    assert rho("once[1:2](a > 0)", a=[1, 2, 3]) == [-LARGEST] * 3


def test_one_sample_is_enough() -> None:
    assert rho("always(a > 0)", a=[7]) == [7]


def test_arrays_and_lists_say_the_same() -> None:
    formula = Formula.parse("a / 3 <= 1 and b > 0", SIGNALS)
    assert formula.robustness({"a": np.array([3.0, 1.5]), "b": np.array([1.0, 2.0])}) == [0, 0.5]


def test_names_and_numbers_need_no_spaces_around_a_stroke() -> None:
    assert rho("a/2<=1", a=[4, 1]) == [-1, 0.5]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("sped_mps > 0", "unknown signal 'sped_mps'; did you mean 'speed_mps'"),
        ("a > 0 b > 1", "is not a formula"),
        ("a >", "is not a formula"),
        ("(a > 0", "brackets that do not match"),
        ("a > 0) and (b > 0", "brackets that do not match"),
        ("a == 1", "has '== 1'"),
        ("a > 0 & b > 0", "has '& b > 0'"),
        ("historically[2:1](a > 0)", "must not end before it begins"),
        ("historically[0:0.03](a > 0)", "must be of two times that are multiples of 0.05 s"),
        ("historically[a:1](a > 0)", "must be of two times"),
        ("historically[0,1](a > 0)", "has ',1](a > 0)'"),
        ("a[0:1] > 0", "must be of two times"),
        ("alwys(a > 0)", "did you mean 'always'"),
        ("1 > 0", "reads no signal"),
        ("", "reads no signal"),
        ("__import__ > 0", "unknown signal"),
    ],
)
def test_a_text_that_is_no_formula_is_refused_with_the_reason(text: str, said: str) -> None:
    with pytest.raises(FormulaError) as caught:
        Formula.parse(text, SIGNALS)
    assert said in str(caught.value)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_sample_that_is_no_number_is_no_evidence(value: float) -> None:
    with pytest.raises(ValueError, match=r"signal a is (nan|inf) at sample 1"):
        rho("a > 0", a=[1, value])


def test_signals_of_different_length_are_refused() -> None:
    with pytest.raises(ValueError, match="differ in length"):
        rho("a > b", a=[1, 2], b=[1])


def test_parsing_and_evaluating_say_nothing(
    capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.DEBUG):
        rho("historically[0:1](a + b > 3) implies b > 1.25", a=[1, 2], b=[1, 2])
        with pytest.raises(FormulaError):
            Formula.parse("a > > 3", SIGNALS)
    assert capfd.readouterr() == ("", "")
    assert caplog.records == []
    logging.getLogger("someone.else").warning("still heard")
    assert [record.message for record in caplog.records] == ["still heard"]


def test_only_brackets_around_everything_are_the_inside_of_always() -> None:
    assert inside_always("always((a > 0) or (b > 0))") == "( a > 0 ) or ( b > 0 )"
    assert inside_always("always(a > 0) or always(b > 0)") is None
    assert inside_always("a > 0") is None
    assert inside_always("always[0:2](a > 0)") is None


@given(
    st.lists(st.sampled_from(["a", "speed_mps", "2", "0.25", "<=", "->", "(", ")", "historically", "/"]), max_size=12)
)
def test_tokens_joined_by_spaces_are_the_same_tokens(tokens: list[str]) -> None:
    assert tokenize(" ".join(tokens)) == tokens


values = st.floats(-100, 100, allow_nan=False).map(lambda value: round(value, 3))
traces = st.integers(1, 60).flatmap(lambda length: st.tuples(*[st.lists(values, min_size=length, max_size=length)] * 2))


def window(column: np.ndarray, samples: int, best: bool) -> np.ndarray:
    """Worst or best of each sample and the `samples` before it, by a definition of its own."""
    pick = np.max if best else np.min
    return np.array([pick(column[max(0, i - samples) : i + 1]) for i in range(len(column))])


@settings(deadline=None)
@given(traces)
def test_it_agrees_with_an_oracle_of_its_own(trace: tuple[list[float], list[float]]) -> None:
    a, b = map(np.array, trace)
    near = 1 - a / 3
    slow = 1 - b / 0.25
    expected = np.minimum(np.maximum(-window(near, 40, best=False), slow), window(b - 1, 3, best=True))
    text = "(historically[0:2](a / 3 <= 1) implies b / 0.25 <= 1) and once[0:0.15](b >= 1)"
    assert rho(text, a=a.tolist(), b=b.tolist()) == expected.tolist()


@settings(deadline=None)
@given(traces)
def test_always_of_a_formula_is_the_least_of_its_robustness(trace: tuple[list[float], list[float]]) -> None:
    signals = {"a": trace[0], "b": trace[1]}
    body = "a > 0 implies b <= 1"
    assert rho(f"always({body})", **signals)[0] == min(rho(body, **signals))


def test_the_sampling_period_is_that_of_the_flight_log() -> None:
    assert SAMPLE_MS == 1000 / 20
