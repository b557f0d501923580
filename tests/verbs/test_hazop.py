"""Sheets brought into a study: drafts that load and never fly, and edits of a worksheet that change single values."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openpyxl import load_workbook
from options import cases, usually
from printed import invoked, of_form, sentence
from processes import ROOT
from studies import copied

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import CellStatus, Matrix, Team
from scaloft_fi.hazop.sheet import read_sheet
from scaloft_fi.output import write_named
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.study import Study
from scaloft_fi.verbs import hazop as verb
from scaloft_fi.verbs.hazop import edits_of
from scaloft_fi.verbs.worksheet import bare_rows, to_csv, to_xlsx

MATRIX = load_matrix(ROOT / "hazop", REFERENCE.by_name)
SHEET = """Node,Guideword,Deviation,Possible causes,Consequence,Safeguards,Severity,Action
Depth camera,LATE,Image comes late,overload,hits rock,bumper,high,measure it
Depth camera,NO,No image,cable,hits rock,,,
Depth camera,NO,,power,,,,
Weather radar,MORE,Too many clouds,,turns back,,,
,Blue,,x,,,,
person detection,LATE,late,x,y,,,
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    copied(tmp_path / "study")
    (tmp_path / "sheet.csv").write_text(SHEET)
    return tmp_path / "study"


def told(folder: Path, action: str, file: Path, *words: str) -> dict[str, Any]:
    call = ["hazop", action, str(file), "--study", str(folder), "--format", "json", *words]
    return of_form("hazop", invoked(*call).stdout)


def content(folder: Path) -> Mapping[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_an_import_says_row_by_row_what_it_would_do_and_writes_nothing(folder: Path):
    before = content(folder)
    rows = told(folder, "import", folder.parent / "sheet.csv")["rows"]
    assert [(row["place"], row["state"], row["cell"]) for row in rows] == [
        ("2", "drafted", "LATE-depth_camera"),
        ("3", "drafted", "NO-depth_camera"),
        ("4", "drafted", "NO-depth_camera"),
        ("5", "drafted", "MORE-weather_radar"),
        ("6", "left_out", None),
        ("7", "in_the_study", "LATE-human"),
    ]
    assert rows[0]["proposed"].startswith("delay at depth")
    assert rows[3]["proposed"] is None
    assert content(folder) == before


def test_drafts_load_are_counted_and_never_fly(folder: Path):
    before, mutants = content(folder), [mutant.id for mutant in Study.open(folder).catalogue]
    answer = told(folder, "import", folder.parent / "sheet.csv", "--write")
    assert answer["to_do"] == 24
    study = Study.open(folder)
    cell = study.matrix.cell("LATE-depth_camera")
    assert (cell.status, cell.deviation, cell.causes, cell.effect) == (
        CellStatus.TO_DO,
        "Image comes late",
        ("overload",),
        "hits rock",
    )
    assert (cell.drafted, cell.team.safeguards, cell.team.recommendation) == ("high", "bumper", "measure it")
    assert [fault.operator for fault in cell.proposed] == ["delay"]
    assert study.matrix.cell("NO-depth_camera").causes == ("cable", "power")
    assert study.matrix.counts()[CellStatus.TO_DO] == 24
    assert [mutant.id for mutant in study.catalogue] == mutants
    after = content(folder)
    assert {name for name in after if after[name] != before.get(name)} == {
        "hazop/parameters.yaml",
        "hazop/matrix/depth_camera.yaml",
        "hazop/matrix/weather_radar.yaml",
    }
    assert after["hazop/parameters.yaml"].startswith(before["hazop/parameters.yaml"].rstrip(b"\n"))
    call = ["run", "--mutant", "LATE-depth_camera", "--study", str(folder)]
    assert "the cell is to do" in sentence(invoked(*call))
    assert "24 to do" in invoked("matrix", "--study", str(folder)).stdout
    assert "cells to do" in invoked("check", "--study", str(folder)).output


def test_guidewords_that_a_small_study_lacks_come_with_the_sheet(tmp_path: Path):
    invoked("new", str(tmp_path / "small"))
    (tmp_path / "sheet.csv").write_text(SHEET)
    told(tmp_path / "small", "import", tmp_path / "sheet.csv", "--write")
    matrix = Study.open(tmp_path / "small").matrix
    assert [word.id for word in matrix.guidewords] == ["NO", "REVERSE", "LATE", "MORE"]
    assert matrix.cell("MORE-human").status is CellStatus.TO_DO


def test_a_second_import_finds_every_cell_there(folder: Path):
    told(folder, "import", folder.parent / "sheet.csv", "--write")
    again = told(folder, "import", folder.parent / "sheet.csv", "--write")
    assert again["files"] == []
    assert {row["state"] for row in again["rows"]} == {"in_the_study", "left_out"}


def test_a_sheet_fills_the_cells_that_are_to_do_and_say_nothing(folder: Path):
    told(folder, "import", folder.parent / "sheet.csv", "--write")
    path = folder / "hazop" / "matrix" / "depth_camera.yaml"
    more = folder.parent / "more.csv"
    head = SHEET.splitlines()[0]
    more.write_text(
        f"{head}\nDepth camera,MORE,Too far,fog,hits rock,,,\nDepth camera,LATE,Image comes late,other,,,,\n"
    )
    bare, before = Study.open(folder).matrix.counts(), path.read_text()
    answer = told(folder, "import", more, "--write")
    assert [(row["state"], row["cell"]) for row in answer["rows"]] == [
        ("drafted", "MORE-depth_camera"),
        ("in_the_study", "LATE-depth_camera"),
    ]
    assert answer["rows"][1]["why"] == "the study has this cell; the sheet's text differs, and is not taken: causes"
    matrix = Study.open(folder).matrix
    cell = matrix.cell("MORE-depth_camera")
    assert (cell.deviation, cell.causes, cell.effect) == ("Too far", ("fog",), "hits rock")
    assert answer["to_do"] == bare[CellStatus.TO_DO] == matrix.counts()[CellStatus.TO_DO]
    assert all(line in path.read_text().splitlines() for line in before.splitlines())


def test_a_new_parameter_of_an_option_is_told_with_the_nearest_that_the_study_has(folder: Path):
    call = ["hazop", "import", str(folder.parent / "sheet.csv"), "--study", str(folder)]
    warned = invoked(*call, "--parameter", "Weather radar=zzz", "--parameter", "Depth camera=velcmt").stderr
    assert "'Weather radar' is a new parameter, 'zzz'\n" in warned
    assert "'Depth camera' is a new parameter, 'velcmt'; did you mean 'velcmd'?\n" in warned
    assert "new parameter" not in invoked(*call, "--parameter", "Weather radar=depth").stderr


def test_a_worksheet_needs_no_words_of_the_user(folder: Path, worksheet: Path):
    call = ["hazop", "diff", str(worksheet), "--study", str(folder), "--guideword", "Blue=LATE"]
    assert "only `hazop import` reads them" in sentence(invoked(*call))


TEXTS = st.text(st.characters(codec="utf-8", exclude_characters="\r"), min_size=1, max_size=30).filter(str.strip)


@st.composite
def matrices(draw: st.DrawFn) -> Matrix:
    """A part of the reference matrix, whose texts say anything."""
    part = MATRIX.only(draw(st.sets(st.sampled_from(["NO", "LATE", "REVERSE"]), min_size=1)), ["human", "velcmd"])
    fields = ("safeguards", "likelihood", "recommendation", "responsible", "due", "action_status")

    def drawn(cell):
        team = Team(**{name: draw(st.one_of(st.none(), TEXTS)) for name in fields})
        if not cell.flown:
            return replace(cell, reason=draw(TEXTS), team=team)
        causes = tuple(draw(st.lists(TEXTS, min_size=1, max_size=3)))
        return replace(cell, deviation=draw(TEXTS), effect=draw(TEXTS), predicted=draw(TEXTS), causes=causes, team=team)

    parameters = tuple(replace(one, title=draw(TEXTS), node=draw(TEXTS), intent=draw(TEXTS)) for one in part.parameters)
    return replace(part, parameters=parameters, cells={key: drawn(cell) for key, cell in part.cells.items()})


@settings(max_examples=usually(10, release=100))
@given(matrix=matrices())
def test_the_worksheet_that_a_study_writes_changes_nothing(matrix: Matrix, tmp_path_factory: pytest.TempPathFactory):
    folder, rows = tmp_path_factory.mktemp("sheets"), bare_rows(matrix)
    (folder / "a.xlsx").write_bytes(to_xlsx(rows))
    (folder / "a.csv").write_text(to_csv(rows), encoding="utf-8")
    for name in ("a.xlsx", "a.csv"):
        lines = read_sheet(folder / name)
        assert {line.texts["cell"] for line in lines} == {cell.name for cell in matrix}
        assert list(edits_of(rows, folder, lines)) == []


@pytest.mark.parametrize("text", ["'=1", "''=1", "'-a", "''x", "=1+1", "_x0041_", "'", "a [cut]", "a; b", "x" * 40_000])
def test_a_text_with_marks_of_a_spreadsheet_comes_back_as_it_was(tmp_path: Path, text: str):
    part = MATRIX.only(["LATE"], ["human"])
    (cell,) = (replace(one, deviation=text, causes=(text, "b"), effect=text) for one in part)
    rows = bare_rows(replace(part, cells={("LATE", "human"): cell}))
    (tmp_path / "a.xlsx").write_bytes(to_xlsx(rows))
    (tmp_path / "a.csv").write_text(to_csv(rows), encoding="utf-8")
    for name in ("a.xlsx", "a.csv"):
        assert list(edits_of(rows, tmp_path, read_sheet(tmp_path / name))) == []


@pytest.fixture
def worksheet(folder: Path) -> Path:
    """The worksheet of the study as a workbook."""
    return worksheet_of(folder)


def worksheet_of(folder: Path) -> Path:
    study, path = Study.open(folder), folder.parent / "worksheet.xlsx"
    path.write_bytes(to_xlsx(bare_rows(study.matrix, study.dispositions)))
    return path


def test_a_mark_that_a_program_saved_from_our_csv_into_a_workbook_is_no_edit(tmp_path: Path):
    part = MATRIX.only(["LATE"], ["human"])
    rows = bare_rows(replace(part, cells={("LATE", "human"): replace(*part, effect="=1+1")}))
    (tmp_path / "a.xlsx").write_bytes(to_xlsx(rows))
    edit(tmp_path / "a.xlsx", "LATE-human", Consequence="'=1+1")
    assert list(edits_of(rows, tmp_path, read_sheet(tmp_path / "a.xlsx"))) == []


def edit(path: Path, cell: str, **texts: str | None) -> None:
    book = load_workbook(path)
    page = book.worksheets[0]
    heads = {head.value: head.column for head in page[1]}
    (row,) = (row for row in page.iter_rows(min_row=2) if row[0].value == cell)
    for head, text in texts.items():
        row[heads[head.replace("_", " ")] - 1].value = text
    book.save(path)


def test_what_people_edited_is_shown_and_changes_single_values_in_place(folder: Path, worksheet: Path):
    assert told(folder, "diff", worksheet)["edits"] == []
    edit(
        worksheet, "LATE-human", Consequence="The drone: passes at speed.", Recommendation="measure", Severity="damage"
    )
    causes = Study.open(folder).matrix.cell("NO-human").causes
    edit(worksheet, "NO-human", Possible_causes="; ".join([*causes[:-1], "A moth.", "Fog."]))
    before = content(folder)
    edits = told(folder, "diff", worksheet)["edits"]
    assert {(one["cell"], one["key"], one["after"], one["written"]) for one in edits} == {
        ("LATE-human", "effect", "The drone: passes at speed.", False),
        ("LATE-human", "severity", "damage", False),
        ("LATE-human", "team.recommendation", "measure", False),
        ("NO-human", "causes[2]", "A moth.", False),
        ("NO-human", "causes[3]", "Fog.", False),
    }
    assert content(folder) == before
    assert all(one["written"] for one in told(folder, "diff", worksheet, "--write")["edits"])
    after = content(folder)
    (changed,) = (name for name in after if after[name] != before[name])
    lines = difflib.unified_diff(before[changed].decode().split("\n"), after[changed].decode().split("\n"), n=0)
    touched = [line for line in lines if line[0] in "+-" and line[:3] not in ("+++", "---")]
    assert len(touched) == 8
    assert '+  effect: "The drone: passes at speed."' in touched
    assert told(folder, "diff", worksheet)["edits"] == []


NOT_TAKEN_BACK = {
    "NO-human": ("Severity", "dreadful", "severity='dreadful' is not known"),
    "MORE-human": ("Requirements", "SR1, SR9", "'SR9' of MORE-human is no requirement; did you mean 'SR2'?"),
    "LESS-human": ("Due_date", "2027-13-45", "due='2027-13-45' must be a date, as 2027-01-31, or words"),
    "ASWELLAS-human": ("Consequence", None, "ASWELLAS lacks the key 'effect'"),
    "PARTOF-human": ("Status", "kontrolle", "'kontrolle' is no status; did you mean 'control'?"),
    "EARLY-human": ("Status", "not_meaningful", "a cell that is not meaningful has a reason, and no effect"),
    "NO-velcmd": ("Status", "to do", "a cell that is to do has no requirements"),
    "MORE-velcmd": ("Guideword", "EARLY", "guideword or parameter are not those of the id"),
    "LESS-velcmd": ("Faults", "delay 1 s", "faults are not taken back"),
    "LATE-velcmd": ("Default_mutant", "LATE-velcmd@1s", "the default magnitude is not taken back"),
    "REVERSE-velcmd": ("Disposition", "accepted by me", "hazop/dispositions.yaml has it"),
}


def test_an_edit_that_is_not_taken_back_is_told_and_stops_no_other(folder: Path, worksheet: Path):
    edit(worksheet, "LATE-human", Recommendation="measure")
    for cell, (head, text, _) in NOT_TAKEN_BACK.items():
        edit(worksheet, cell, **{head: text})
    before = content(folder)
    dry = told(folder, "diff", worksheet)["edits"]
    for cell, (*_, said) in NOT_TAKEN_BACK.items():
        assert all(said in one["why"] for one in dry if one["cell"] == cell)
    assert {one["cell"] for one in dry if one["why"]} == {*NOT_TAKEN_BACK}
    assert content(folder) == before
    made = told(folder, "diff", worksheet, "--write")["edits"]
    assert made == [{**one, "written": one["why"] is None} for one in dry]
    now = MATRIX.cell("LATE-human")
    taken = replace(now, team=replace(now.team, recommendation="measure"))
    assert [one for one in Study.open(folder).matrix if one not in MATRIX.cells.values()] == [taken]


def test_edits_by_hand_are_counted_with_their_place(folder: Path, worksheet: Path):
    edit(worksheet, "LATE-human", Faults="delay 1 s", Recommendation="measure")
    screen = invoked("hazop", "diff", str(worksheet), "--study", str(folder)).stdout
    assert "2 edits, 1 of them to be made by hand." in screen
    assert "Findings are not compared." in screen
    assert "`--write` makes the others in the study." in screen
    assert f"human.yaml:{MATRIX.cell('LATE-human').place.rpartition(':')[2]}: faults" in screen


def test_a_rationale_beside_a_changed_status_is_no_prediction(folder: Path, worksheet: Path):
    edit(worksheet, "LATE-human", Status="not_meaningful", Rationale="It cannot be.")
    edit(worksheet, "NO-human", Status="Control", Rationale="crude")
    before = content(folder)
    edits = told(folder, "diff", worksheet, "--write")["edits"]
    assert [(one["cell"], one["key"], one["written"]) for one in edits] == [
        ("NO-human", "rationale", False),
        ("NO-human", "status", False),
        ("LATE-human", "reason", False),
        ("LATE-human", "status", False),
    ]
    assert content(folder) == before


def test_a_status_is_taken_back_where_the_cell_can_have_it(folder: Path):
    told(folder, "import", folder.parent / "sheet.csv", "--write")
    sheet = worksheet_of(folder)
    edit(sheet, "REVERSE-collision", Status="credible")
    edit(sheet, "NO-human", Status="control", Severity=None)
    edit(sheet, "REVERSE-depth_camera", Status="not meaningful", Rationale="Nothing can be turned round.")
    assert all(one["written"] for one in told(folder, "diff", sheet, "--write")["edits"])
    study = Study.open(folder)
    cells = [study.matrix.cell(name) for name in ("REVERSE-collision", "NO-human", "REVERSE-depth_camera")]
    statuses = [CellStatus.CREDIBLE, CellStatus.CONTROL, CellStatus.NOT_MEANINGFUL]
    assert [cell.status for cell in cells] == statuses
    assert cells[2].reason == "Nothing can be turned round."


def test_a_draft_is_completed_in_the_worksheet(folder: Path):
    told(folder, "import", folder.parent / "sheet.csv", "--write")
    sheet = worksheet_of(folder)
    edit(sheet, "LATE-depth_camera", Status="credible", Requirements="SR1, SR2", Severity=None, Deviation="It is late.")
    edit(sheet, "EARLY-depth_camera", Possible_causes="a clock; a queue", Due_date="soon")
    edit(sheet, "NO-depth_camera", Status="credible", Requirements="SR1, SR9")
    edits = told(folder, "diff", sheet, "--write")["edits"]
    assert {one["cell"] for one in edits if not one["written"]} == {"NO-depth_camera"}
    matrix = Study.open(folder).matrix
    done, begun, refused = (matrix.cell(f"{word}-depth_camera") for word in ("LATE", "EARLY", "NO"))
    assert (done.status, done.requirements) == (CellStatus.CREDIBLE, ("SR1", "SR2"))
    assert [fault.operator for fault in done.faults] == ["delay"]
    assert (begun.causes, begun.team.due) == (("a clock", "a queue"), "soon")
    assert (refused.status, refused.requirements) == (CellStatus.TO_DO, ())


def test_an_edit_that_stands_in_two_sheets_of_a_workbook_is_one(folder: Path, worksheet: Path):
    book = load_workbook(worksheet)
    page = book.create_sheet("More")
    for texts in (("Deviation id", "Consequence", "Severity"), ("LATE-human", "It is fast.", "injury")):
        page.append(texts)
    book.save(worksheet)
    edit(worksheet, "LATE-human", Consequence="It is fast.")
    assert [one["key"] for one in told(folder, "diff", worksheet)["edits"]] == ["effect"]


@pytest.mark.parametrize("in_main", [True, False])
def test_copies_of_a_text_that_differ_are_left_to_a_person_however_often_the_sheet_is_read(
    folder: Path, worksheet: Path, in_main: bool
):
    was = Study.open(folder).matrix.cell("LATE-human").effect
    book = load_workbook(worksheet)
    page = book.create_sheet("Survivors, worst class first")
    texts = ("LATE-human", was if in_main else "It is fast.", "injury")
    for row in (("Deviation id", "Consequence", "Severity"), texts):
        page.append(row)
    book.save(worksheet)
    edit(worksheet, "LATE-human", Recommendation="measure", **({"Consequence": "It is fast."} if in_main else {}))
    edit(worksheet, "NO-human", Parameter="people")
    for _ in range(2):
        edits = {(one["cell"], one["key"]): one for one in told(folder, "diff", worksheet, "--write")["edits"]}
        assert Study.open(folder).matrix.cell("LATE-human").effect == was
        why = edits["LATE-human", "effect"]["why"]
        assert "its copies differ: " in why
        assert "'It is fast.' at " in why
        assert "Survivors, worst class first:2" in why
        assert "'people' at HAZOP worksheet:" in edits["NO-human", "parameter"]["why"]
    assert Study.open(folder).matrix.cell("LATE-human").team.recommendation == "measure"


def test_a_row_whose_guideword_or_parameter_is_not_that_of_its_id_is_held_back_whole(folder: Path, worksheet: Path):
    swapped = {"NO-human": "NO-velcmd", "NO-velcmd": "NO-human", "LATE-human": "MORE-human", "MORE-human": "LATE-human"}
    book = load_workbook(worksheet)
    for row in book.worksheets[0].iter_rows(min_row=2):
        row[0].value = swapped.get(row[0].value, row[0].value)
    book.save(worksheet)
    before = content(folder)
    edits = told(folder, "diff", worksheet, "--write")["edits"]
    assert {one["cell"] for one in edits} == {*swapped}
    assert {one["why"] for one in edits} == {
        "guideword or parameter are not those of the id; nothing of the row is taken"
    }
    assert content(folder) == before


def test_each_row_without_an_id_is_told(folder: Path, worksheet: Path):
    book = load_workbook(worksheet)
    page, log = book.worksheets[:2]
    page["A2"].value = log["A2"].value = None
    page.insert_rows(4)
    for column, text in ((3, "person detection"), (5, "LATE"), (6, "new deviation, consequence not known")):
        page.cell(4, column).value = text
    book.save(worksheet)
    edits = told(folder, "diff", worksheet)["edits"]
    assert [one["where"] for one in edits] == [f"{page.title}:2", f"{page.title}:4", f"{log.title}:2"]
    assert all("no Deviation id; `scaloft-fi hazop import` drafts what is new" in one["why"] for one in edits)
    page.delete_cols(1)
    book.save(worksheet)
    assert len(told(folder, "diff", worksheet)["edits"]) == page.max_row


def test_columns_and_sheets_that_are_not_read_are_named(folder: Path, worksheet: Path):
    call = ["hazop", "diff", str(worksheet), "--study", str(folder)]
    assert "not read" not in invoked(*call).stderr
    book = load_workbook(worksheet)
    page = book.worksheets[0]
    heads = {head.value: head for head in page[1]}
    heads["Consequence"].value = "What then"
    page.cell(1, len(heads) + 1).value = "Remarks"
    book.create_sheet("Team").append(["Name", "Phone"])
    book.save(worksheet)
    said = invoked(*call).stderr
    assert "warning: HAZOP worksheet: not read: 'What then', 'Remarks'\n" in said
    assert "warning: Team: not read: 'the sheet, whose heads are not known'\n" in said


@pytest.mark.parametrize("lost", ["=K4", "#REF!"])
def test_a_formula_without_a_value_and_an_error_empty_no_text(folder: Path, worksheet: Path, lost: str):
    edit(worksheet, "LATE-human", Severity=lost, Recommendation="measure")
    call = ["hazop", "diff", str(worksheet), "--study", str(folder), "--write"]
    assert re.search(r"not read: 'severity of row \d+, a formula without a value or an error'", invoked(*call).stderr)
    study = Study.open(folder)
    assert study.matrix.severities["LATE-human"].id == "injury"
    assert study.matrix.cell("LATE-human").team.recommendation == "measure"


def test_where_one_file_cannot_be_written_none_is(folder: Path, monkeypatch: pytest.MonkeyPatch):
    before = content(folder)

    def full(path: Path, content: bytes, name: str) -> None:
        if path.name == "weather_radar.yaml":
            raise InputError("no room")
        write_named(path, content, name)

    monkeypatch.setattr(verb, "write_named", full)
    files = {
        folder / "hazop" / name: "" for name in ("matrix/new.yaml", "parameters.yaml", "matrix/weather_radar.yaml")
    }
    with pytest.raises(InputError, match="no room"):
        verb.write_all(files)
    assert content(folder) == before


def test_a_line_break_in_a_list_parts_its_entries(folder: Path, worksheet: Path):
    causes = Study.open(folder).matrix.cell("NO-human").causes
    edit(worksheet, "NO-human", Possible_causes="; ".join(causes) + "\nA moth.", Requirements="SR1\nSR2")
    edits = told(folder, "diff", worksheet, "--write")["edits"]
    assert (f"causes[{len(causes)}]", "A moth.") in {(one["key"], one["after"]) for one in edits}
    cell = Study.open(folder).matrix.cell("NO-human")
    assert (cell.causes, cell.requirements) == ((*causes, "A moth."), ("SR1", "SR2"))
    (folder.parent / "more.csv").write_text('Node,Guideword,Deviation,Cause\nSonar,NO,silent,"a plug\na moth; fog"\n')
    told(folder, "import", folder.parent / "more.csv", "--write")
    assert Study.open(folder).matrix.cell("NO-sonar").causes == ("a plug", "a moth", "fog")


def test_a_prediction_that_comes_with_the_findings_is_warned_of(folder: Path, worksheet: Path):
    edit(worksheet, "LATE-human", Rationale="It shows.")
    said = invoked("hazop", "diff", str(worksheet), "--study", str(folder), "--write").stderr
    assert "warning: LATE-human: a prediction that is written after the flights is worth nothing\n" in said
    edit(worksheet, "LATE-human", Rationale=None)
    (kept,) = told(folder, "diff", worksheet, "--write")["edits"]
    assert (kept["key"], kept["why"]) == ("predicted", "a prediction stands, whatever was flown since")
    assert Study.open(folder).matrix.cell("LATE-human").predicted == "It shows."


def test_an_import_counts_rows_and_cells(folder: Path):
    text = "Node,Guideword,Deviation,Cause\nSonar,EARLY / LATE,badly timed,x\nSonar,LATE,later,y\nSonar,NO,n/a,z\n"
    (folder.parent / "more.csv").write_text(text)
    screen = invoked("hazop", "import", str(folder.parent / "more.csv"), "--study", str(folder)).stdout
    assert "3 rows: 2 drafted into 2 cells, 0 in the study already, 1 left out." in screen


def test_a_team_clears_what_it_filled_in(folder: Path, worksheet: Path):
    edit(worksheet, "LATE-human", Likelihood="2", Due_date="soon")
    told(folder, "diff", worksheet, "--write")
    edit(worksheet, "LATE-human", Likelihood=None)
    assert all(one["written"] for one in told(folder, "diff", worksheet, "--write")["edits"])
    assert Study.open(folder).matrix.cell("LATE-human").team == Team(due="soon")


def test_what_is_taken_out_of_a_list_is_left_to_a_person(folder: Path, worksheet: Path):
    edit(worksheet, "NO-human", Possible_causes="Only this.")
    (one,) = told(folder, "diff", worksheet, "--write")["edits"]
    assert (one["key"], one["written"]) == ("causes", False)
    assert one["why"] == "an entry was taken out"


def test_a_row_of_a_cell_that_the_study_lacks_is_told(folder: Path, worksheet: Path):
    edit(worksheet, "NO-human", Deviation_id="NO-humann")
    (one,) = told(folder, "diff", worksheet, "--write")["edits"]
    assert (one["cell"], one["written"]) == ("NO-humann", False)
    assert "the study has no such cell; did you mean 'NO-human'?" in one["why"]


def test_a_sheet_of_others_has_nothing_to_compare(folder: Path):
    refused = invoked("hazop", "diff", str(folder.parent / "sheet.csv"), "--study", str(folder))
    assert "hazop import" in sentence(refused)


@cases("words", "said")
def test_options_that_do_not_fit_are_refused(folder: Path, words: tuple[str, ...], said: str):
    call = ["hazop", "import", str(folder.parent / "sheet.csv"), "--study", str(folder), *words]
    assert said in sentence(invoked(*call))
