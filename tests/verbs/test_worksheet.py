"""The verb `worksheet` on the reference study without physics, with a study that is hostile."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from openpyxl import load_workbook
from refusal import sentence

Call = Callable[..., Result]
FLOWN = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H*", "--seeds", "3", "--jobs", "1", "--quiet")
EVIL = "=cmd|' /C calc'!A0 <script>x</script> 50 % \\\\input{a} 人"


@pytest.fixture
def flown(call: Call) -> Call:
    assert call(*FLOWN).exit_code == 0
    return call


def test_the_terminal_sees_findings_the_log_and_no_line_beyond_120_columns(flown: Call) -> None:
    text = flown("worksheet").stdout
    assert "LATE-human" in text
    assert "LATE-human injury detected not detected 1 of 1" in " ".join(text.split())
    assert "Deviations not credible" in text
    assert max(map(len, text.splitlines())) <= 120


def test_csv_has_a_row_for_each_of_the_156_cells(flown: Call) -> None:
    rows = list(csv.DictReader(io.StringIO(flown("worksheet", "--format", "csv").stdout)))
    assert len(rows) == 156
    late = next(row for row in rows if row["cell"] == "LATE-human")
    told = (late["verdict"], late["kill_rate"], late["margin"], late["recommendation"])
    assert told == ("detected", "1 of 1", "<= 3 s", "")


def test_xlsx_goes_into_a_file_only(flown: Call, tmp_path: Path) -> None:
    refused = flown("worksheet", "--format", "xlsx")
    assert refused.exit_code == 2
    assert "name it with --output" in refused.stderr
    path = tmp_path / "sheet.xlsx"
    assert flown("worksheet", "--format", "xlsx", "--output", str(path)).exit_code == 0
    assert load_workbook(path).sheetnames == ["HAZOP worksheet", "Deviations not credible", "About"]


@pytest.mark.parametrize("style", ["table", "markdown", "csv", "json", "latex"])
def test_a_file_has_what_would_be_printed(flown: Call, tmp_path: Path, style: str) -> None:
    path = tmp_path / "sheet"
    done = flown("worksheet", "--format", style, "--output", str(path))
    assert (done.exit_code, done.stdout) == (0, "")
    assert path.read_text(encoding="utf-8") == flown("worksheet", "--format", style).stdout


def test_what_a_hostile_study_says_is_only_said(call: Call, copy: Path) -> None:
    path = copy / "hazop" / "matrix" / "human.yaml"
    text = path.read_text(encoding="utf-8")
    told = EVIL.replace("'", "''")
    path.write_text(text.replace("deviation: Detection delivered late.", f"deviation: '{told}'"), encoding="utf-8")
    (copy / "hazop" / "dispositions.yaml").write_text(
        f"LATE-human: {{status: accepted, owner: '{told}', reason: '{told}', expires: 2027-01-31}}\n", encoding="utf-8"
    )
    assert call(*FLOWN, study=copy).exit_code == 0
    records = json.loads(call("worksheet", "--format", "json", study=copy).stdout)["rows"]
    late = next(record for record in records if record["cell"] == "LATE-human")
    assert late["deviation"] == EVIL
    assert late["disposition"] == {"owner": EVIL, "reason": EVIL, "expires": "2027-01-31", "situations": []}
    rows = csv.DictReader(io.StringIO(call("worksheet", "--format", "csv", study=copy).stdout))
    assert next(row for row in rows if row["cell"] == "LATE-human")["deviation"] == f"'{EVIL}"
    for style in ("table", "markdown", "latex"):
        assert call("worksheet", "--format", style, study=copy).exit_code == 0
    sheet = copy / "sheet.xlsx"
    assert call("worksheet", "--format", "xlsx", "--output", str(sheet), study=copy).exit_code == 0
    (cell,) = [c for line in load_workbook(sheet)["HAZOP worksheet"].iter_rows() for c in line if c.value == EVIL]
    assert cell.data_type == "s"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--output", "/nowhere/sheet.csv"), "there is no folder"),
        (("--format", "xls"), "'xls'"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(flown: Call, words: tuple[str, ...], says: str) -> None:
    assert says in sentence(flown("worksheet", *words))
