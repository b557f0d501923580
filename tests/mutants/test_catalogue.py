"""The committed catalogue."""

from __future__ import annotations

from pathlib import Path

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants import catalogue
from scaloft_fi.mutants.catalogue import derive

STUDY = Path(__file__).parents[2]


def test_the_committed_catalogue_is_what_the_matrix_gives(matrix: Matrix) -> None:
    assert catalogue.check_catalogue(STUDY / "mutants", matrix) == derive(matrix)


def test_writing_twice_gives_the_same_bytes_and_reading_gives_the_mutants_back(matrix: Matrix, tmp_path: Path) -> None:
    derived = derive(matrix)
    first = catalogue.write_catalogue(tmp_path / "a", derived).read_bytes()
    assert catalogue.write_catalogue(tmp_path / "b", derived).read_bytes() == first
    assert catalogue.read_catalogue(tmp_path / "a") == derived


def stale(tmp_path: Path, matrix: Matrix, lines: list[str]) -> str:
    (tmp_path / catalogue.CATALOGUE).write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        catalogue.check_catalogue(tmp_path, matrix)
    return str(caught.value)


def test_a_stale_catalogue_is_refused_at_the_first_id_that_differs(matrix: Matrix, tmp_path: Path) -> None:
    lines = catalogue.catalogue_lines(derive(matrix))
    first, second = derive(matrix)[0].id, derive(matrix)[1].id
    place = f"{tmp_path / catalogue.CATALOGUE}"
    assert stale(tmp_path, matrix, lines[1:]).startswith(
        f"{place}:1: the catalogue is stale: {second!r} stands where the matrix gives {first!r}; write it with"
    )
    assert f"{derive(matrix)[-1].id!r} is missing" in stale(tmp_path, matrix, lines[:-1])
    assert f"{first!r} is not in the matrix" in stale(tmp_path, matrix, [*lines, lines[0]])
    changed = [lines[0].replace('"share": 0.25', '"share": 0.3'), *lines[1:]]
    assert f"{first!r} differs from the matrix" in stale(tmp_path, matrix, changed)


def test_a_missing_or_broken_catalogue_is_one_sentence_with_the_remedy(matrix: Matrix, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read: No such file or directory; write it with"):
        catalogue.check_catalogue(tmp_path, matrix)
    assert ":1: not a mutant in JSON; write it with" in stale(tmp_path, matrix, ["{"])
    (tmp_path / catalogue.CATALOGUE).write_text('{"id": "x"}\n', encoding="utf-8")
    with pytest.raises(InputError, match=r":1: key 'arguments' is missing"):
        catalogue.read_catalogue(tmp_path)


def test_a_folder_that_cannot_be_written_is_refused(matrix: Matrix, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be written"):
        catalogue.write_catalogue(tmp_path / "file", derive(matrix))
