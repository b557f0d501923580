"""What the study in the repository promises."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest
from studies import copied

from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import Cell, CellStatus, Magnitude
from scaloft_fi.mutants.catalogue import derive
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.study import Study

HAZOP = Path(__file__).resolve().parents[2] / "hazop"
MATRIX = load_matrix(HAZOP, REFERENCE.by_name)
MEANINGFUL = [cell for cell in MATRIX if cell.status is not CellStatus.NOT_MEANINGFUL]
IEC_61882 = ["NO", "MORE", "LESS", "ASWELLAS", "PARTOF", "REVERSE", "OTHERTHAN", "EARLY", "LATE", "BEFORE", "AFTER"]


def test_twelve_guidewords_are_asked_of_thirteen_parameters():
    assert [word.id for word in MATRIX.guidewords] == [*IEC_61882, "UNINTENDED"]
    assert " ".join(parameter.id for parameter in MATRIX.parameters) == (
        "human collision goal depth pose velcmd waypoint map imu speedlimit exposure clock battery"
    )
    assert len(MATRIX) == 156


def test_every_cell_is_credible_a_control_or_not_meaningful():
    statuses = {CellStatus.CREDIBLE: 114, CellStatus.CONTROL: 11, CellStatus.NOT_MEANINGFUL: 31, CellStatus.TO_DO: 0}
    assert MATRIX.counts() == statuses


def test_only_unintended_is_an_extension_and_says_why():
    assert [word.id for word in MATRIX.guidewords if word.extension] == ["UNINTENDED"]
    assert MATRIX.guidewords[-1].reason


@pytest.mark.parametrize("cell", MEANINGFUL, ids=lambda cell: cell.name)
def test_a_meaningful_cell_is_worked_out(cell: Cell):
    assert cell.deviation
    assert cell.causes
    assert cell.effect
    assert cell.faults
    assert set(cell.requirements) <= {"SR1", "SR2", "OP1"}


def test_each_cell_that_is_not_meaningful_gives_its_reason():
    assert all(len(cell.reason) > 20 for cell in MATRIX if cell.status is CellStatus.NOT_MEANINGFUL)


def test_the_papers_three_faults_are_cells_at_the_papers_magnitudes():
    assert MATRIX.cell("LATE-human").default_magnitude == "3s"
    assert MATRIX.cell("UNINTENDED-collision").default_magnitude == "20s"
    assert MATRIX.cell("MORE-goal").faults[0].magnitude == Magnitude(
        "value", "m", (0.3, 0.6, 1.0, 3.0), 0.6, neutral=0.15
    )


def test_what_is_known_not_to_infect_is_declared_with_its_reason():
    known = {cell.name: fault.expected for cell in MATRIX for fault in cell.faults if fault.expected}
    assert known.keys() == {"PARTOF-goal", "AFTER-speedlimit", "LATE-battery"}
    assert known["PARTOF-goal"].magnitudes == ("z",)


def test_a_cell_with_two_faults_tells_them_apart_by_unit():
    pairs = {
        cell.name: [fault.magnitude.unit for fault in cell.faults if fault.magnitude]
        for cell in MATRIX
        if len(cell.faults) > 1
    }
    assert pairs == {"NO-depth": ["s", "%"], "LESS-pose": ["x", "Hz"], "OTHERTHAN-map": ["m", "deg"]}


def test_every_seam_of_a_fault_exists_and_most_seams_are_used():
    used = {fault.seam for cell in MATRIX for fault in cell.faults}
    assert used <= REFERENCE.by_name.keys()
    assert len(used) >= 18


def test_the_matrix_names_exactly_the_ids_that_are_derived():
    told = [
        name
        for cell in MATRIX
        for fault in cell.faults
        for rung in fault.rungs
        for name in cell.mutant_ids(fault, rung)
    ]
    assert told == [mutant.id for mutant in derive(MATRIX)]
    assert len(set(told)) == len(told)


CREDIBLE = [cell for cell in MATRIX if cell.status is CellStatus.CREDIBLE]
RULE = [
    (row[1], row[2].split(", "))
    for row in re.finditer(r"^\| \d \| (\w+) \| (.*?) \|", (HAZOP / "README.md").read_text(), re.MULTILINE)
]
"""The rows of the table in the page: class and words; the last row is for all other texts."""


def derived(effect: str) -> str:
    found = (name for name, words in RULE[:-1] if any(re.search(rf"\b{re.escape(w)}\b", effect, re.I) for w in words))
    return next(found, RULE[-1][0])


def test_the_page_has_the_rule_and_its_last_row_is_for_all_other_texts():
    assert len(RULE) == 5
    assert RULE[-1] == ("damage", ["any other text"])
    assert {name for name, _ in RULE} == {one.id for one in MATRIX.classes}


@pytest.mark.parametrize("cell", CREDIBLE, ids=lambda cell: cell.name)
def test_the_class_of_a_cell_follows_from_its_effect_by_the_rule(cell: Cell):
    assert MATRIX.severities[cell.name].id == derived(cell.effect)


def test_every_class_has_cells_and_only_credible_cells_have_one():
    assert MATRIX.severities.keys() == {cell.name for cell in CREDIBLE}
    assert Counter(one.id for one in MATRIX.severities.values()) == {
        "injury": 25,
        "damage": 72,
        "mission": 12,
        "delay": 5,
    }


def test_classes_change_no_mutant_and_no_part_of_the_keys_of_flights(tmp_path: Path):
    copied(tmp_path)
    (tmp_path / "hazop" / "severities.yaml").unlink()
    for path in (tmp_path / "hazop" / "matrix").glob("*.yaml"):
        path.write_text(re.sub(r"^  severity: \w+\n", "", path.read_text(), flags=re.MULTILINE))
    plain, classed = Study.open(tmp_path), Study.open(HAZOP.parent)
    assert plain.matrix.severities == {}
    assert plain.catalogue == classed.catalogue
    assert plain.inputs == classed.inputs
