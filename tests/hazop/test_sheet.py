"""Sheets of other tools: heads in any language, merged and blank cells, guidewords as heads, what is refused."""

from __future__ import annotations

import zipfile
from datetime import datetime
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openpyxl import Workbook
from openpyxl.styles import Font
from options import cases
from refused import refusal

from scaloft_fi.errors import InputError
from scaloft_fi.hazop import sheet as sheets
from scaloft_fi.hazop.load import load_matrix

MATRIX = load_matrix(Path(__file__).parents[2] / "hazop")


def sheet(folder: Path, text: str, name: str = "sheet.csv", encoding: str = "utf-8") -> Path:
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


def cells(lines: tuple[sheets.Line, ...], **words: str) -> list[str]:
    return [row.cell for row in sheets.sort(lines, MATRIX, words, {}).rows]


ENGLISH = """Node,Guide word,Deviation,Cause,Consequence
Radar link,NO,No echo,cable,hits rock
Radar link,LATE,late,load,hits
"""
GERMAN = """Knoten;Leitwort;Abweichung;Ursache;Auswirkung
Radarverbindung;Kein;kein Echo;Kabel;Stoß
;Zu spät;spät;Last;Stoß
"""
FRENCH = """Nœud\tMot-guide\tÉcart\tCauses\tConséquences
Radar\tPas de\taucun écho\tcâble\tchoc
Radar\tTrop tard\ttard\tcharge\tchoc
"""
SPANISH = """Nodo|Palabra guía|Desviación|Causas|Consecuencias
Radar|Ninguno|sin eco|cable|choque
Radar|Tarde|tarde|carga|choque
"""


@pytest.mark.parametrize(
    ("text", "encoding", "parameter"),
    [
        (ENGLISH, "utf-8", "radar_link"),
        (GERMAN, "cp1252", "radarverbindung"),
        (FRENCH, "utf-16", "radar"),
        (SPANISH, "utf-8-sig", "radar"),
    ],
)
def test_heads_and_guidewords_of_four_languages_are_known(tmp_path: Path, text: str, encoding: str, parameter: str):
    lines = sheets.read_sheet(sheet(tmp_path, text, encoding=encoding))
    assert cells(lines) == [f"NO-{parameter}", f"LATE-{parameter}"]
    assert all(line.texts["causes"] and line.texts["effect"] for line in lines)


def test_a_parameter_of_the_study_is_found_anywhere_in_a_deviation_in_small_and_capital_letters(tmp_path: Path):
    worded = "Guideword,Deviation,Cause\nLATE,The Person Detection comes too late,load\nNO,The persons,x\n"
    assert cells(sheets.read_sheet(sheet(tmp_path, worded))) == ["LATE-human", ""]
    bare = "Deviation,Cause,Effect\nVelocity command reversed,a,b\nNo valid waypoint sequence,c,d\n"
    assert cells(sheets.read_sheet(sheet(tmp_path, bare))) == ["REVERSE-velcmd", "NO-waypoint"]


def test_any_other_head_and_word_is_named_by_an_option(tmp_path: Path):
    path = sheet(tmp_path, "部件,引导词,偏差\n雷达,无,没有回波\n")
    with pytest.raises(InputError, match="--column deviation=HEAD"):
        sheets.read_sheet(path)
    lines = sheets.read_sheet(path, {"node": "部件", "guideword": "引导词", "deviation": "偏差"})
    assert sheets.sort(lines, MATRIX, {}, {}).rows[0].why == "'无' is not one guideword: --guideword TEXT=WORD"
    assert sheets.sort(lines, MATRIX, {"无": "NO"}, {"雷达": "radar"}).rows[0].cell == "NO-radar"
    with pytest.raises(InputError, match="no column is headed '零件'"):
        sheets.read_sheet(path, {"node": "零件", "guideword": "引导词"})


@pytest.fixture
def book(tmp_path: Path) -> Path:
    """Two sheets: merged nodes and heads in two rows; and one that is no sheet of deviations."""
    made = Workbook()
    page = made.active
    page.title = "HAZOP"
    for row in (
        ["Project X"],
        ["Study node", "Guideword", "Deviation", "Analysis", "", "Risk", ""],
        ["", "", "", "Possible causes", "Consequences", "Severity", "Likelihood"],
        ["Radar link", "NO", "no echo", "cable", "hits rock", 4, 0.5],
        ["", "", "", "power", "", "", ""],
        ["", "MORE", "too strong", "gain", "stops", "", ""],
        [],
        ["Compass", "", "", "", "", "", ""],
        ["", "REVERSE", "turned round", "iron", "lost", "", ""],
    ):
        page.append(row)
    page.merge_cells("D2:E2")
    page.merge_cells("A4:A6")
    made.create_sheet("Team").append(["Name", "Phone"])
    made.save(tmp_path / "book.xlsx")
    return tmp_path / "book.xlsx"


def test_merged_and_blank_cells_mean_what_stands_above(book: Path):
    lines = sheets.read_sheet(book)
    found = sheets.sort(lines, MATRIX, {}, {})
    assert [(row.place, row.cell) for row in found.rows] == [
        ("HAZOP:4", "NO-radar_link"),
        ("HAZOP:5", "NO-radar_link"),
        ("HAZOP:6", "MORE-radar_link"),
        ("HAZOP:9", "REVERSE-compass"),
    ]
    draft = found.drafts["NO-radar_link"]
    assert (draft.texts["causes"], draft.told("severity"), draft.told("likelihood")) == (["cable", "power"], "4", "0.5")


GROUPED = """,Deviation,,,,Cause,,Consequence,
Case,HAZOP node,Guideword,Parameter,Description,HAZOPNode,Description,HAZOPNode,Description
1,Tank,Mehr,Druck,too much,Inlet,valve open,Tank,bursts
2,Tank,Anderer/Anders als,Medium,other,Inlet,mixed up,Tank,burns
"""
CONTINUED = """Ref.,Deviation,Cause,Consequence,Safeguards,Action
1,No flow,tank empty,delay,alarm,A1
,,,,,A2
,,pump off,,,
2,Lower pressure,leak,fire,,A3
"""


def test_below_groups_of_heads_each_column_tells_of_its_group(tmp_path: Path):
    found = sheets.sort(sheets.read_sheet(sheet(tmp_path, GROUPED)), MATRIX, {}, {})
    draft = found.drafts["MORE-druck"]
    assert (draft.told("deviation"), draft.told("causes"), draft.told("effect")) == (
        "too much",
        "Inlet; valve open",
        "Tank; bursts",
    )
    assert list(found.drafts) == ["MORE-druck", "OTHERTHAN-medium"]


def test_a_row_without_a_deviation_goes_on_with_the_one_above_which_names_what_deviates(tmp_path: Path):
    found = sheets.sort(sheets.read_sheet(sheet(tmp_path, CONTINUED)), MATRIX, {}, {})
    assert list(found.drafts) == ["NO-flow", "LESS-pressure"]
    draft = found.drafts["NO-flow"]
    assert (draft.places, draft.texts["recommendation"], draft.texts["causes"]) == (
        ["2", "3", "4"],
        ["A1", "A2"],
        ["tank empty", "pump off"],
    )


def test_of_a_workbook_the_sheets_that_are_named_are_read(book: Path):
    assert len(sheets.read_sheet(book, sheets=["HAZOP"])) == 4
    with pytest.raises(InputError, match=r"no sheet .HAZARD.; did you mean .HAZOP."):
        sheets.read_sheet(book, sheets=["HAZARD"])


STPA = (
    "Control action,Not provided causes hazard,Provided causes hazard,"
    '"Too early, too late, out of order","Stopped too soon, applied too long"\n'
    "Climb,UCA1: no climb before rock,UCA2: climbs below a roof,UCA3: too late for the rock,UCA4: applied too long\n"
    "Hover,UCA5: no hover,N/A,-,\n"
)


def test_the_four_ways_of_stpa_are_guidewords(tmp_path: Path):
    lines = sheets.read_sheet(sheet(tmp_path, STPA))
    assert cells(lines) == ["NO-climb", "UNINTENDED-climb", "LATE-climb", "MORE-climb", "NO-hover"]
    only = MATRIX.only(["NO", "ASWELLAS", "LATE"])
    assert [row.cell for row in sheets.sort(lines, only, {}, {}).rows][1] == "ASWELLAS-climb"


def test_two_ways_in_one_cell_are_two_cells_and_what_is_not_hazardous_is_none(tmp_path: Path):
    head = STPA.splitlines()[0]
    row = "Climb,not hazardous,n/a,UCA-3: too late for the rock; UCA-4: too early for the waypoint,not applicable"
    assert cells(sheets.read_sheet(sheet(tmp_path, f"{head}\n{row}\n"))) == ["EARLY-climb", "LATE-climb"]


def test_a_page_may_have_tables_with_other_heads(tmp_path: Path):
    text = "Node,Guideword,Deviation,Cause,Note\nA,NO,none,x,n\n\nGuide word,Deviation,Element,Reason\nLATE,late,B,y\n"
    unread = dict[str, list[str]]()
    lines = sheets.read_sheet(sheet(tmp_path, text), unread=unread)
    assert [(line.place, line.texts["node"]) for line in lines] == [("2", "A"), ("5", "B")]
    assert cells(lines) == ["NO-a", "LATE-b"]
    assert unread == {"": ["Note", "Reason"]}


def test_a_matrix_with_guidewords_for_heads_has_a_deviation_in_each_cell(tmp_path: Path):
    path = sheet(tmp_path, "Parameter,NO,MORE,Zu spät\nRange,nothing,too long,\nBearing,,turned,late\n")
    assert cells(sheets.read_sheet(path)) == ["NO-range", "MORE-range", "MORE-bearing", "LATE-bearing"]


@cases("row", "said")
def test_a_row_that_makes_no_draft_says_why(tmp_path: Path, row: str, said: str):
    lines = sheets.read_sheet(sheet(tmp_path, f"Node,Guideword,Deviation,Cause,Consequence\n{row}\n"))
    assert [one.why for one in sheets.sort(lines, MATRIX, {}, {}).rows] == [said]


def test_without_a_column_of_guidewords_the_deviation_begins_with_one(tmp_path: Path):
    lines = sheets.read_sheet(
        sheet(tmp_path, "Component,Deviation,Effect\nRadar,No echo,x\nRadar,More range,y\nRadar,as well as,z\n")
    )
    assert cells(lines) == ["NO-radar", "MORE-radar", "ASWELLAS-radar"]


def test_two_guidewords_in_one_cell_are_two_cells(tmp_path: Path):
    lines = sheets.read_sheet(sheet(tmp_path, "Node,Guideword,Deviation\nRadar,EARLY / LATE,at another time\n"))
    assert cells(lines) == ["EARLY-radar", "LATE-radar"]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.pdf", b"%PDF", "must end in .xlsx"),
        ("a.xlsx", b"PK\x03\x04 cut", "is no workbook that can be read"),
        ("a.csv", b"one,two\n1,2\n", "no row has the heads of a HAZOP or STPA sheet"),
        ("a.csv", b"", "no row has the heads"),
        (
            "a.csv",
            b"Node,Guideword,Deviation" + b",x" * sheets.MOST_COLUMNS + b"\n",
            "it must have at most 20,000 rows",
        ),
    ],
)
def test_what_is_no_sheet_is_refused_in_a_sentence(tmp_path: Path, name: str, content: bytes, said: str):
    path = tmp_path / name
    path.write_bytes(content)
    told = refusal(sheets.read_sheet, path)
    assert said in told
    assert told.startswith(str(path))


def test_a_workbook_that_unpacks_to_too_much_is_refused_before_it_is_read(tmp_path: Path):
    path = tmp_path / "bomb.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("xl/sharedStrings.xml", b" " * (sheets.SHEET_BYTES + 1))
    with pytest.raises(InputError, match=r"bomb\.xlsx: it unpacks to 67,108,865 bytes of XML, and may to 67,108,864"):
        sheets.read_sheet(path)


@pytest.mark.parametrize("row", [30_000, 1_048_576])
def test_a_sheet_ends_where_its_texts_end_not_where_its_colours_do(tmp_path: Path, row: int):
    made = Workbook()
    for texts in (("Node", "Guideword", "Deviation", "Cause"), ("radar", "No", "no echo", 1234567.25)):
        made.active.append(texts)
    made.active.cell(row, 600).font = Font(bold=True)
    made.save(tmp_path / "a.xlsx")
    (line,) = sheets.read_sheet(tmp_path / "a.xlsx")
    assert line.texts["causes"] == "1234567.25"
    made.active.cell(row, 1).value = "too far"
    made.save(tmp_path / "a.xlsx")
    with pytest.raises(InputError, match=f"has {row:,} rows"):
        sheets.read_sheet(tmp_path / "a.xlsx")


@pytest.mark.parametrize(
    ("typed", "read"),
    [
        (datetime.fromisoformat("2027-03-01"), "2027-03-01"),
        (datetime.fromisoformat("2027-03-01T09:30"), "2027-03-01 09:30:00"),
        ("01.03.2027", "01.03.2027"),
    ],
)
def test_a_day_that_somebody_typed_into_a_workbook_is_read_as_a_day(tmp_path: Path, typed: object, read: str):
    made = Workbook()
    for texts in (("Node", "Guideword", "Deviation", "Due date"), ("radar", "No", "no echo", typed)):
        made.active.append(texts)
    made.save(tmp_path / "a.xlsx")
    assert [line.texts["due"] for line in sheets.read_sheet(tmp_path / "a.xlsx")] == [read]


@pytest.mark.parametrize("title", ["", "HAZOP, of the drone, in May, first part, second part\n"])
@pytest.mark.parametrize("comma", [";", "\t", "|"])
def test_the_sign_between_cells_is_the_one_that_parts_the_heads(tmp_path: Path, comma: str, title: str):
    rows = (("Knoten", "Leitwort", "Abweichung", "Ursache"), ("radar", "kein", "a, b, c, d, e", "f, g, h, i"))
    text = title + "\n".join(map(comma.join, rows))
    assert cells(sheets.read_sheet(sheet(tmp_path, text))) == ["NO-radar"]


@pytest.mark.parametrize("head", ["UCA type", "Guide word", "Type of UCA"])
def test_a_table_of_stpa_may_have_a_row_for_each_way(tmp_path: Path, head: str):
    ways = ("Not provided", "Provided", "Too late", "Stopped too soon", "Applied too long", "Wrong order")
    rows = (f"1,brake,{way},it is so" for way in ways)
    text = "\n".join((f"UCA ID,Control action,{head},Unsafe control action", *rows))
    words = ("NO", "UNINTENDED", "LATE", "LESS", "MORE", "BEFORE")
    assert cells(sheets.read_sheet(sheet(tmp_path, text))) == [f"{word}-brake" for word in words]


def test_a_refusal_names_the_heads_that_were_read_in_their_order(tmp_path: Path):
    with pytest.raises(InputError, match=r"read: 'zzz', 'causes', 'aaa', '7'"):
        sheets.read_sheet(sheet(tmp_path, "Zzz,Causes,Aaa\n7,cause,x\n"))


def test_every_word_stands_for_one_guideword():
    for word, known in sheets.WORDS.items():
        assert {sheets.guideword_of(one) for one in known.split("|")} == {word}


@given(text=st.text(), taken=st.sets(st.from_regex(r"[a-z][a-z0-9_]{0,5}", fullmatch=True)))
def test_every_text_gives_a_name_that_no_other_parameter_has(text: str, taken: set[str]):
    name = sheets.parameter_name(text, taken)
    assert name not in taken
    assert f"NO-{name}" not in MATRIX or name in {one.id for one in MATRIX.parameters}
    assert name.isascii()
    assert name[0].isalpha()
    assert name.replace("_", "a").isalnum()
    assert name == name.lower()
