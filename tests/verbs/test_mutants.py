"""`scaloft-fi mutants`."""

from __future__ import annotations

import csv
import io
import json
import shutil
from pathlib import Path

import pytest
from refusal import run

STUDY = Path(__file__).parents[2]


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """A copy of the study that a test may change."""
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(STUDY / name, tmp_path / name)
    return tmp_path


def test_the_table_fits_a_terminal_and_marks_the_defaults(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("mutants", "--study", STUDY) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 120
    assert [line.split()[1] for line in lines if line.startswith("LATE-human@3s")] == ["*"]


def test_patterns_cells_and_defaults_choose(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("mutants", "LATE-human", "LATE-human@2.5s", "--study", STUDY, "--format", "json") == 0
    rows = json.loads(capsys.readouterr().out)["mutants"]
    assert [(row["id"], row["default"]) for row in rows] == [("LATE-human@3s", True), ("LATE-human@2.5s", False)]
    assert run("mutants", "--cell", "LATE-human", "--study", STUDY, "--format", "csv") == 0
    table = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert [row["id"] for row in table] == ["LATE-human@0.5s", "LATE-human@1s", "LATE-human@3s", "LATE-human@5s"]
    assert run("mutants", "--defaults", "*-human@*", "--study", STUDY, "--format", "markdown") == 0
    assert "LATE-human@3s" in (shown := capsys.readouterr().out)
    assert "LATE-human@5s" not in shown


def test_check_proves_the_catalogue_current_and_write_makes_it_so(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("mutants", "--check", "--study", study) == 0
    sheet = study / "hazop" / "matrix" / "human.yaml"
    sheet.write_text(sheet.read_text().replace("ladder: [0.5, 1, 3, 5], default: 3", "ladder: [0.5, 1, 3], default: 3"))
    assert run("mutants", "--check", "--study", study) == 2
    assert "the catalogue is stale: 'LATE-human@5s' stands where the matrix gives" in capsys.readouterr().err
    assert run("mutants", "LATE-human", "--study", study) == 0
    assert "warning: " in capsys.readouterr().err
    assert run("mutants", "--write", "--study", study) == 0
    assert run("mutants", "--check", "--study", study) == 0


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("operator: drop\n", "operator: dorp\n", "no operator 'dorp'; did you mean 'drop'?"),
        ("ladder: [0.5, 1, 3, 5], default: 3}", "ladder: [-1, 3], default: 3}", "delay_s=-1 must be >= 0"),
        ("argument: delay_s", "argument: delay", "operator 'delay' has no argument 'delay'; did you mean 'delay_s'?"),
        (
            "seam: person\n      operator: drop",
            "seam: depth\n      operator: ghost",
            "operator 'ghost' needs the message Detections, but seam 'depth' carries DepthFrame",
        ),
    ],
)
def test_a_fault_that_cannot_be_made_is_one_sentence_with_file_and_line(
    study: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, sentence: str
) -> None:
    sheet = study / "hazop" / "matrix" / "human.yaml"
    assert old in sheet.read_text()
    sheet.write_text(sheet.read_text().replace(old, new, 1))
    before = (study / "mutants" / "catalogue.jsonl").read_bytes()
    assert run("mutants", "--write", "--study", study) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert f"{sheet}:" in error
    assert sentence in error
    assert (study / "mutants" / "catalogue.jsonl").read_bytes() == before
