from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.matrix import Cell, CellStatus, Guideword, Matrix, Parameter

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
def test_the_counts_of_the_statuses_sum_to_the_cells(matrix: Matrix) -> None:
    assert sum(matrix.counts().values()) == len(matrix) == len(list(matrix))
    assert len(matrix) == len(matrix.guidewords) * len(matrix.parameters)


@given(matrices())
def test_every_cell_is_found_by_its_name(matrix: Matrix) -> None:
    assert all(cell.name in matrix and matrix.cell(cell.name) is cell for cell in matrix)


@given(matrices(), st.data())
def test_a_part_of_a_matrix_is_a_matrix_with_the_same_cells(matrix: Matrix, data: st.DataObject) -> None:
    words = [word.id for word in matrix.guidewords]
    chosen = data.draw(st.lists(st.sampled_from(words), unique=True) if words else st.just([]))
    part = matrix.only(guidewords=chosen)
    assert list(part) == [cell for cell in matrix if cell.guideword in chosen or not chosen]


CELL = Cell("LATE", "human", CellStatus.CREDIBLE)
LATE, HUMAN = Guideword("LATE", "LATE", ""), Parameter("human", "", "", "", "")


def test_a_matrix_with_a_hole_is_no_matrix() -> None:
    with pytest.raises(ValueError, match="not total"):
        Matrix((LATE,), (HUMAN,), {})


def test_a_cell_under_another_name_is_refused() -> None:
    with pytest.raises(ValueError, match="MORE-human stands under"):
        Matrix((LATE,), (HUMAN,), {("LATE", "human"): Cell("MORE", "human", CellStatus.CREDIBLE)})


@pytest.mark.parametrize("miss", ["LATE-humna", "late-human", "LATE-human@3s"])
def test_a_miss_names_the_nearest_cell(miss: str) -> None:
    with pytest.raises(InputError, match=f"no cell '{miss}'; did you mean 'LATE-human'"):
        Matrix((LATE,), (HUMAN,), {("LATE", "human"): CELL}).cell(miss)


def test_an_unknown_guideword_or_parameter_of_a_filter_names_the_nearest() -> None:
    matrix = Matrix((LATE,), (HUMAN,), {("LATE", "human"): CELL})
    with pytest.raises(InputError, match="no guideword 'LATTE'; did you mean 'LATE'"):
        matrix.only(guidewords=["LATTE"])
    with pytest.raises(InputError, match="no parameter 'humans'; did you mean 'human'"):
        matrix.only(parameters=["humans"])
