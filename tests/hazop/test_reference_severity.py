"""The classes of the reference study follow from the texts of its cells by the written rule, and from nothing else."""

from __future__ import annotations

import re
import shutil
from collections import Counter
from pathlib import Path

import pytest

from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import Cell, CellStatus
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.study import Study

HAZOP = Path(__file__).resolve().parents[2] / "hazop"
MATRIX = load_matrix(HAZOP, REFERENCE.by_name)
CREDIBLE = [cell for cell in MATRIX if cell.status is CellStatus.CREDIBLE]
RULE = [
    (row[1], row[2].split(", "))
    for row in re.finditer(r"^\| \d \| (\w+) \| (.*?) \|", (HAZOP / "README.md").read_text(), re.MULTILINE)
]
"""The rows of the table in the page: class and words; the last row is for all other texts."""


def derived(effect: str) -> str:
    found = (name for name, words in RULE[:-1] if any(re.search(rf"\b{re.escape(w)}\b", effect, re.I) for w in words))
    return next(found, RULE[-1][0])


def test_the_page_has_the_rule_and_its_last_row_is_for_all_other_texts() -> None:
    assert len(RULE) == 5
    assert RULE[-1] == ("damage", ["any other text"])
    assert {name for name, _ in RULE} == {one.id for one in MATRIX.classes}


@pytest.mark.parametrize("cell", CREDIBLE, ids=lambda cell: cell.name)
def test_the_class_of_a_cell_follows_from_its_effect_by_the_rule(cell: Cell) -> None:
    assert MATRIX.severities[cell.name].id == derived(cell.effect)


def test_every_class_has_cells_and_only_credible_cells_have_one() -> None:
    assert MATRIX.severities.keys() == {cell.name for cell in CREDIBLE}
    assert Counter(one.id for one in MATRIX.severities.values()) == {
        "injury": 25,
        "damage": 72,
        "mission": 12,
        "delay": 5,
    }


def test_classes_change_no_mutant_and_no_part_of_the_keys_of_flights(tmp_path: Path) -> None:
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(HAZOP.parent / name, tmp_path / name)
    (tmp_path / "hazop" / "severities.yaml").unlink()
    for path in (tmp_path / "hazop" / "matrix").glob("*.yaml"):
        path.write_text(re.sub(r"^  severity: \w+\n", "", path.read_text(), flags=re.MULTILINE))
    plain, classed = Study.open(tmp_path), Study.open(HAZOP.parent)
    assert plain.matrix.severities == {}
    assert plain.catalogue == classed.catalogue
    assert plain.inputs == classed.inputs
