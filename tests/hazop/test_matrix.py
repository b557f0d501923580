from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import (
    Cell,
    CellStatus,
    Expected,
    Fault,
    Guideword,
    Magnitude,
    Matrix,
    Parameter,
    SeverityClass,
    Worse,
    falls_unsaid,
    mild_to_strong,
    neutral,
    worse,
    worst_first,
)
from scaloft_fi.stack.reference.declaration import REFERENCE

WORDS = st.lists(st.from_regex(r"[A-Z][A-Z0-9]{0,12}", fullmatch=True), max_size=8, unique=True)
NAMES = st.lists(st.from_regex(r"[a-z][a-z0-9_]{0,12}", fullmatch=True), max_size=8, unique=True)


@st.composite
def matrices(draw: st.DrawFn) -> Matrix:
    words = tuple(Guideword(word, word, "meaning") for word in draw(WORDS))
    parameters = tuple(Parameter(name, name, "intent", "a -> b", "m") for name in draw(NAMES))
    statuses = st.sampled_from(CellStatus)
    text = st.text("abc ", min_size=1, max_size=200).map(lambda t: "x" + t)
    cells = {
        (w.id, p.id): Cell(w.id, p.id, status, reason=draw(text))
        if (status := draw(statuses)) is CellStatus.NOT_MEANINGFUL
        else Cell(w.id, p.id, status, draw(text), ("cause",), "effect", ("SR1",))
        for w in words
        for p in parameters
    }
    return Matrix(words, parameters, cells)


@given(matrices())
def test_the_counts_of_the_statuses_sum_to_the_cells(matrix: Matrix):
    assert sum(matrix.counts().values()) == len(matrix) == len(list(matrix))
    assert len(matrix) == len(matrix.guidewords) * len(matrix.parameters)


@given(matrices())
def test_every_cell_is_found_by_its_name(matrix: Matrix):
    assert all(cell.name in matrix and matrix.cell(cell.name) is cell for cell in matrix)


@given(matrices(), st.data())
def test_a_part_of_a_matrix_is_a_matrix_with_the_same_cells(matrix: Matrix, data: st.DataObject):
    words = [word.id for word in matrix.guidewords]
    chosen = data.draw(st.lists(st.sampled_from(words), unique=True) if words else st.just([]))
    part = matrix.only(guidewords=chosen)
    assert list(part) == [cell for cell in matrix if cell.guideword in chosen or not chosen]


CELL = Cell("LATE", "human", CellStatus.CREDIBLE)
LATE, HUMAN = Guideword("LATE", "LATE", ""), Parameter("human", "", "", "", "")


def test_a_matrix_with_a_hole_is_no_matrix():
    with pytest.raises(ValueError, match="not total"):
        Matrix((LATE,), (HUMAN,), {})


def test_a_cell_under_another_name_is_refused():
    with pytest.raises(ValueError, match="MORE-human stands under"):
        Matrix((LATE,), (HUMAN,), {("LATE", "human"): Cell("MORE", "human", CellStatus.CREDIBLE)})


@pytest.mark.parametrize("miss", ["LATE-humna", "late-human", "LATE-human@3s"])
def test_a_miss_names_the_nearest_cell(miss: str):
    with pytest.raises(InputError, match=f"no cell '{miss}'; did you mean 'LATE-human'"):
        Matrix((LATE,), (HUMAN,), {("LATE", "human"): CELL}).cell(miss)


def test_an_unknown_guideword_or_parameter_of_a_filter_names_the_nearest():
    matrix = Matrix((LATE,), (HUMAN,), {("LATE", "human"): CELL})
    with pytest.raises(InputError, match="no guideword 'LATTE'; did you mean 'LATE'"):
        matrix.only(guidewords=["LATTE"])
    with pytest.raises(InputError, match="no parameter 'humans'; did you mean 'human'"):
        matrix.only(parameters=["humans"])


LADDER = Magnitude("delay_s", "s", (0.5, 3.0), 3.0)


@pytest.mark.parametrize(
    ("magnitude", "rung", "text", "value"),
    [
        (LADDER, 0.5, "0.5s", 0.5),
        (Magnitude("delay_s", "ms", (5.0,), 5.0, 0.001), 5.0, "5ms", 0.005),
        (Magnitude("amount", "EV", (2.0,), 2.0, -1.0), 2.0, "2EV", -2.0),
        (Magnitude("share", "%", (70.0,), 70.0, 0.01), 70.0, "70%", 0.7),
        (Magnitude("hold_s", "s", (math.inf,), math.inf), math.inf, "infs", math.inf),
        (Magnitude("axis", "", ("x", "yaw"), "yaw"), "yaw", "yaw", "yaw"),
        (Magnitude("index", "", (1.0,), 1.0), 1.0, "1", 1.0),
    ],
)
def test_a_magnitude_has_a_text_for_the_id_and_a_value_for_the_operator(
    magnitude: Magnitude, rung: float | str, text: str, value: float | str
):
    assert magnitude.text(rung) == text
    assert magnitude.value(rung) == value


@given(st.integers(0, 10_000))
def test_a_share_in_percent_is_the_nearest_decimal_fraction(percent: int):
    magnitude = Magnitude("share", "%", (1.0,), 1.0, 0.01)
    assert magnitude.value(float(percent)) == percent / 100


def test_the_place_is_not_part_of_what_a_fault_is():
    assert Fault("person", "drop", place="a:1") == Fault("person", "drop", place="b:2")
    assert Magnitude("delay_s", "s", (1.0,), 1.0, place="a:1") == Magnitude("delay_s", "s", (1.0,), 1.0)


def test_an_expectation_without_magnitudes_speaks_of_all_and_else_of_those_named():
    every = Fault("failsafe", "delay", {}, LADDER, expected=Expected("never fires"))
    one = Fault("failsafe", "delay", {}, LADDER, expected=Expected("too short", (0.5,)))
    assert every.expects(0.5) == every.expects(3.0) == every.expected
    assert one.expects(0.5) == one.expected
    assert one.expects(3.0) is None


def test_a_fault_that_strikes_once_is_shifted_by_shares_of_its_time():
    cell = Cell("UNINTENDED", "battery", CellStatus.CREDIBLE)
    fault = Fault("battery", "depleted_pulse", {"at_s": 20.0}, phases=True)
    assert cell.mutant_ids(fault, None) == tuple("UNINTENDED-battery" + tail for tail in ("", "#5s", "#10s", "#15s"))


def test_events_stand_after_the_times_and_those_that_cannot_come_are_left_out():
    cell, events = Cell("UNINTENDED", "battery", CellStatus.CREDIBLE), {"sight": "", "light": "nothing changes it"}
    fault = Fault("battery", "depleted_pulse", {"at_s": 20.0}, phases=True, events=events)
    assert cell.mutant_ids(fault, None)[3:] == ("UNINTENDED-battery#15s", "UNINTENDED-battery#sight")


def test_a_fault_without_phases_has_one_id_for_each_magnitude():
    cell = Cell("LATE", "human", CellStatus.CREDIBLE)
    assert [cell.mutant_ids(Fault("person", "delay", {}, LADDER), rung) for rung in LADDER.ladder] == [
        ("LATE-human@0.5s",),
        ("LATE-human@3s",),
    ]


REFERENCE = load_matrix(Path(__file__).parents[2] / "hazop", REFERENCE.by_name)
LADDERS = [
    pytest.param(fault.magnitude, id=f"{cell.name} {fault.magnitude.unit}")
    for cell in REFERENCE
    for fault in cell.faults
    if fault.magnitude
]


@given(st.lists(st.floats(0.001, 1e6), min_size=2, max_size=6, unique=True))
def test_a_ladder_that_is_sorted_has_the_direction_it_is_written_in(numbers: list[float]):
    rising = sorted(numbers)
    assert worse(Magnitude("v", "s", tuple(rising), rising[0])) is Worse.LARGER
    assert worse(Magnitude("v", "s", tuple(rising[::-1]), rising[0])) is Worse.SMALLER
    assert mild_to_strong(Magnitude("v", "s", tuple(rising[::-1]), rising[0])) == tuple(rising[::-1])


@given(st.lists(st.floats(0.001, 1e6), min_size=2, max_size=6, unique=True), st.randoms())
def test_what_the_study_says_outweighs_the_order_of_the_ladder(numbers: list[float], random: object):
    told = Magnitude("v", "s", tuple(numbers), numbers[0], worse="smaller")
    assert mild_to_strong(told) == tuple(sorted(numbers, reverse=True))


@pytest.mark.parametrize("ladder", [("x", "y"), (2.0,), (1.0, 3.0, 2.0)])
def test_names_single_rungs_and_mixed_ladders_have_no_order(ladder: tuple[float | str, ...]):
    magnitude = Magnitude("v", "", ladder, ladder[0])
    assert worse(magnitude) is Worse.UNORDERED
    assert mild_to_strong(magnitude) == ()
    assert neutral(magnitude) is None


@pytest.mark.parametrize("magnitude", LADDERS)
def test_in_the_reference_study_the_neutral_magnitude_is_milder_than_the_ladder(magnitude: Magnitude):
    nothing, ladder = neutral(magnitude), mild_to_strong(magnitude)
    if nothing is None or not ladder:
        return
    assert nothing < ladder[0] if worse(magnitude) is Worse.LARGER else nothing > ladder[0]


@pytest.mark.parametrize("magnitude", LADDERS)
def test_in_the_reference_study_each_ladder_that_falls_says_so_by_worse_neutral_unit_or_period(magnitude: Magnitude):
    assert not falls_unsaid(magnitude)


@pytest.mark.parametrize(
    ("magnitude", "unsaid"),
    [
        (Magnitude("hold_s", "s", (3.0, 1.0), 1.0), True),
        (Magnitude("hold_s", "s", (3.0, 1.0), 1.0, worse="smaller"), False),
        (Magnitude("hold_s", "s", (3.0, 1.0), 1.0, neutral=5.0), False),
        (Magnitude("factor", "x", (3.0, 1.5), 3.0), True),
        (Magnitude("factor", "x", (0.9, 0.5), 0.5), False),
        (Magnitude("share", "%", (100.0, 50.0), 50.0), True),
    ],
)
def test_a_ladder_falls_unsaid_where_its_mildest_magnitude_is_not_below_what_changes_nothing(
    magnitude: Magnitude, unsaid: bool
):
    assert falls_unsaid(magnitude) is unsaid


@given(st.lists(st.tuples(st.integers(), st.none() | st.integers(0, 3))))
def test_worst_first_sorts_by_class_alone_and_keeps_the_order_within_it(entries: list[tuple[int, int | None]]):
    def severity(entry: tuple[int, int | None]) -> SeverityClass | None:
        return None if entry[1] is None else SeverityClass(entry[1], "x", "", "")

    found = worst_first(entries, severity)
    for rank in (0, 1, 2, 3, None):
        assert [one for one in found if one[1] == rank] == [one for one in entries if one[1] == rank]
    ranks = [9 if one[1] is None else one[1] for one in found]
    assert ranks == sorted(ranks)
