"""From what a user writes to mutants."""

from __future__ import annotations

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants.catalogue import default_of, derive, select


def ids(matrix: Matrix, *patterns: str) -> list[str]:
    return [mutant.id for mutant in select(patterns, matrix, derive(matrix))]


def test_a_bare_cell_name_is_its_default(matrix: Matrix) -> None:
    assert ids(matrix, "LATE-human") == ["LATE-human@3s"]
    assert ids(matrix, "LATE-human", "LATE-human@3s", "LATE-human@3.0s") == ["LATE-human@3s"]


def test_a_pattern_is_the_whole_ladder_with_its_phases(matrix: Matrix) -> None:
    assert ids(matrix, "LATE-human*") == ["LATE-human@0.5s", "LATE-human@1s", "LATE-human@3s", "LATE-human@5s"]
    assert ids(matrix, "UNINTENDED-collision@20s*") == [
        f"UNINTENDED-collision@20s{phase}"
        for phase in ("", "#5s", "#10s", "#15s", "#sight", "#obstacle", "#waypoint", "#person", "#recoil", "#mode")
    ]
    assert ids(matrix, "UNINTENDED-collision@20s#*s") == [f"UNINTENDED-collision@20s#{p}s" for p in (5, 10, 15)]


def test_a_pattern_of_cell_names_is_their_defaults(matrix: Matrix) -> None:
    human = [default_of(cell).id for cell in matrix if cell.parameter == "human" and cell.faults]
    assert len(human) > 5
    assert ids(matrix, "*-human") == human
    assert ids(matrix, "LATE-huma?") == ["LATE-human@3s"]


def test_the_unit_picks_the_operator_where_a_cell_has_two(matrix: Matrix) -> None:
    chosen = select(["NO-depth@3s", "NO-depth@50%"], matrix, derive(matrix))
    assert [mutant.operator for mutant in chosen] == ["outage", "drop"]


def test_a_magnitude_and_a_phase_off_the_catalogue_are_accepted(matrix: Matrix) -> None:
    assert ids(matrix, "LATE-human@2.5s", "UNINTENDED-collision#7s") == [
        "LATE-human@2.5s",
        "UNINTENDED-collision@20s#7s",
    ]


@pytest.mark.parametrize(
    ("pattern", "sentence"),
    [
        ("LATE-humna", "no mutant 'LATE-humna'; did you mean 'LATE-human'?"),
        ("LATE-humna*", "no mutant matches 'LATE-humna*'; did you mean 'LATE-human'?"),
        ("late-human", "did you mean 'LATE-human'?"),
        ("LATE-human@-1s", "delay_s=-1 must be >= 0"),
        ("EARLY-goal", "the cell is not meaningful"),
    ],
)
def test_a_miss_names_the_nearest_id_or_the_reason(matrix: Matrix, pattern: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        ids(matrix, pattern)
    assert sentence in str(caught.value)
