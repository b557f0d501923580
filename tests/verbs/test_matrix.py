"""`matrix`, the mutants that follow from it, and their margins."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from options import cases
from printed import STUDY, Call, no_terms, of_form, run, sentence
from studies import copied, edit_in

from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import Cell, CellStatus, Guideword, Matrix, Parameter
from scaloft_fi.hazop.render import overview, sheet
from scaloft_fi.output import PIPED
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.verbs.matrix import matrix_command

MATRIX = load_matrix(STUDY / "hazop", REFERENCE.by_name)


Printed = Callable[..., str]


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> Printed:
    """What `matrix` prints of a copy of the study, in which nothing was flown."""
    bare = copied(tmp_path_factory.mktemp("bare"))

    def printing(*arguments: str) -> str:
        outcome = CliRunner().invoke(matrix_command, ["--study", str(bare), *arguments])
        assert outcome.exit_code == 0, outcome.exception
        return outcome.output

    return printing


@pytest.mark.parametrize("columns", [60, 80, 100, 160])
def test_the_matrix_fits_the_terminal_in_plain_ascii(columns: int, printed: Printed, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    text = printed()
    assert max(map(len, text.splitlines())) <= columns
    assert text.isascii()


def test_the_matrix_shows_the_grid_the_legend_and_the_counts(printed: Printed, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COLUMNS", "120")
    lines = printed("--grid").splitlines()
    assert lines[0].split() == [word.id for word in MATRIX.guidewords]
    assert lines[2].split()[:2] == ["human", "100%"]
    assert [line.split()[0] for line in lines[2:15]] == [parameter.id for parameter in MATRIX.parameters]
    assert lines[-1] == "13 parameters x 12 guidewords = 156 cells: 114 credible, 11 control, 31 not meaningful"


def test_the_matrix_tells_every_cell_with_its_deviation_or_reason(printed: Printed):
    text = " ".join(printed().split())
    assert all(" ".join(cell.told.split()) in text for cell in MATRIX)


def test_filters_keep_only_what_they_name_in_any_case(printed: Printed):
    words = ("--guideword", "late", "--guideword", "MORE", "--parameter", "Human")
    cells = json.loads(printed(*words, "--format", "json"))["cells"]
    assert [cell["cell"] for cell in cells] == ["MORE-human", "LATE-human"]


def test_one_cell_is_told_whole(printed: Printed):
    text = printed("--cell", "LATE-human")
    for fragment in (
        "Detection delivered late.",
        "The network runs on a throttled processor.",
        "SR2",
        "person (person detector -> speed limit)",
        "delay_s = 0.5 s, 1 s, 3 s*, 5 s",
        "LATE-human@0.5s, LATE-human@1s, LATE-human@3s*, LATE-human@5s",
    ):
        assert fragment in text


def test_every_cell_fits_the_terminal():
    for cell in MATRIX:
        assert max(map(len, sheet(MATRIX, cell, {}, PIPED).splitlines())) <= PIPED, cell.name


def process(*arguments: str, **extra: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, *arguments]
    environment = os.environ | {"PYTHONPATH": str(STUDY)} | extra
    return subprocess.run(command, capture_output=True, text=True, cwd=STUDY, env=environment, check=False)


def test_the_matrix_is_printed_without_what_takes_long_to_import(tmp_path: Path):
    source = (
        "import sys\n"
        "from scaloft_fi.cli import main\n"
        f"sys.argv[1:] = ['matrix', '--study', {str(copied(tmp_path))!r}]\n"
        "try:\n    main()\n"
        "finally:\n    assert not {'numpy', 'numba', 'pybullet', 'tabulate'} & set(sys.modules)\n"
    )
    ended = process("-c", source)
    assert ended.returncode == 0, ended.stderr


def test_the_matrix_has_the_sign_of_each_verdict_where_a_campaign_was_flown(
    call: Call, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("COLUMNS", "200")
    assert "no campaign was flown here" in sentence(call("matrix", "--campaign", "absent", campaign=False))
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    lines = call("matrix", "--grid").stdout.splitlines()
    assert next(line.split() for line in lines if line.startswith("human "))[9:11] == ["?", "3s"]
    assert lines[-1] == "? undecided"
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert "\x1b[33m?\x1b[0m 3s" in call("matrix").stdout


@given(st.integers(0, 30), st.integers(0, 6), st.integers(1, 20))
def test_a_study_with_many_guidewords_still_fits(words: int, parameters: int, length: int):
    guidewords = tuple(Guideword(f"{'W' * length}{i}", "", "") for i in range(words))
    rows = tuple(Parameter(f"p{i}", "", "", "", "") for i in range(parameters))
    cells = {(w.id, p.id): Cell(w.id, p.id, CellStatus.CONTROL) for w in guidewords for p in rows}
    text = overview(Matrix(guidewords, rows, cells), PIPED, {})
    assert max(map(len, text.splitlines())) <= PIPED
    assert all(word.id in text for word in guidewords)


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """A copy of the study that a test may change."""
    return copied(tmp_path)


def test_the_table_fits_a_terminal_and_marks_the_defaults(capsys: pytest.CaptureFixture[str]):
    assert run("mutants", "--study", STUDY) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 120
    assert [line.split()[1] for line in lines if line.startswith("LATE-human@3s")] == ["*"]


def test_patterns_cells_and_defaults_choose(capsys: pytest.CaptureFixture[str]):
    assert run("mutants", "LATE-human", "LATE-human@2.5s", "--study", STUDY, "--format", "json") == 0
    rows = json.loads(capsys.readouterr().out)["mutants"]
    assert [(row["id"], row["default"]) for row in rows] == [("LATE-human@3s", True), ("LATE-human@2.5s", False)]
    assert run("mutants", "--cell", "LATE-human", "--study", STUDY, "--format", "csv") == 0
    table = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert [row["id"] for row in table] == ["LATE-human@0.5s", "LATE-human@1s", "LATE-human@3s", "LATE-human@5s"]
    assert run("mutants", "--defaults", "*-human@*", "--study", STUDY, "--format", "markdown") == 0
    assert "LATE-human@3s" in (shown := capsys.readouterr().out)
    assert "LATE-human@5s" not in shown


def test_check_proves_the_catalogue_current_and_write_makes_it_so(study: Path, capsys: pytest.CaptureFixture[str]):
    assert run("mutants", "--check", "--study", study) == 0
    edit_in(
        study / "hazop" / "matrix" / "human.yaml",
        "ladder: [0.5, 1, 3, 5], default: 3",
        "ladder: [0.5, 1, 3], default: 3",
    )
    assert run("mutants", "--check", "--study", study) == 2
    assert "the catalogue is stale: 'LATE-human@5s' stands where the matrix gives" in capsys.readouterr().err
    assert run("mutants", "LATE-human", "--study", study) == 0
    assert "warning: " in capsys.readouterr().err
    assert run("mutants", "--write", "--study", study) == 0
    assert run("mutants", "--check", "--study", study) == 0


@cases("old", "new", "sentence")
def test_a_fault_that_cannot_be_made_is_one_sentence_with_file_and_line(
    study: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, sentence: str
):
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


HUMAN = ("--situation", "T0O0W0D0H1", "--jobs", "1", "--quiet")
THRICE = ("--seeds", "3", *HUMAN)


def test_a_fault_that_is_killed_at_every_magnitude_is_told_as_such_in_every_format(call: Call):
    told = of_form("margin", call("margin", "LATE-human", *THRICE, "--format", "json").stdout)
    (fault,), (situation,) = told["faults"], told["situations"]
    assert (fault["cell"], fault["unit"], fault["phase_s"]) == ("LATE-human", "s", 0.0)
    assert (situation["survives"], situation["kills"], situation["monotone"]) == (None, 0.0625, True)
    assert [entry["magnitude"] for entry in told["tried"]] == [0.0625, 0.125, 0.25, 0.5, 1.0, 3.0, 5.0]
    assert situation["requirements"] == ["SR2"]
    for style in ("table", "markdown", "latex"):
        text = call("margin", "LATE-human", *THRICE, "--format", style).stdout
        assert "T0O0W0D0H1" in text
        assert "0.0625 s" in text
        assert no_terms(text) == []
    shown = call("matrix", "--margins", "--format", "csv").stdout
    rows = {row["parameter"]: row for row in csv.DictReader(io.StringIO(shown))}
    assert (rows["human"]["LATE"], rows["human"]["NO"]) == ("<= 0.0625 s", "?")
    assert (rows["collision"]["EARLY"], rows["human"]["REVERSE"]) == ("-", "CONTROL")
    text = call("matrix", "--margins").stdout
    assert "<= 0.0625 s" in text
    assert max(map(len, text.splitlines())) <= 120
    cells = of_form("matrix", call("matrix", "--margins", "--parameter", "human", "--format", "json").stdout)["cells"]
    ((late,),) = [cell["margins"] for cell in cells if cell["cell"] == "LATE-human"]
    assert (late["unit"], late["survives"], late["kills"]) == ("s", None, 0.0625)


def test_one_seed_in_one_situation_is_seen_and_says_how_many_seeds_decide(call: Call):
    done = call("margin", "LATE-human", *HUMAN)
    assert "seen <= 0.0625 s" in done.stdout
    told = " ".join(done.stdout.replace("\\\n", "").split())  # where a long command is broken
    assert re.search(r"`scaloft-fi margin.* --campaign .+ LATE-human@0\.0625s --seeds 5`", told)


@pytest.mark.parametrize(("words", "told"), [((), 0), (("--warnings",), 7)])
def test_violations_are_counted_and_told_only_when_asked(call: Call, words: tuple[str, ...], told: int):
    said = call("margin", "LATE-human", *HUMAN[:-1], *words).stderr.splitlines()
    assert sum(line.startswith("warning: SR2 violated at ") for line in said) == told
    assert any(line.startswith("violations: ") for line in said)


def test_operability_has_margins_of_its_own(call: Call):
    done = call("margin", "LATE-human", *THRICE, "--operability", "--format", "json")
    (fault,) = of_form("margin", done.stdout)["faults"]
    assert (fault["survives"], fault["kills"]) == (40.0, None)
    words = ("matrix", "--margins", "--operability", "--parameter", "human", "--format", "json")
    ((late,),) = [cell["margins"] for cell in json.loads(call(*words).stdout)["cells"] if cell["cell"] == "LATE-human"]
    assert (late["survives"], late["kills"]) == (40.0, None)


def test_when_a_fault_is_killed_is_shown_of_the_flights_of_a_campaign(call: Call):
    only = ("--mutant", "NO-velcmd@1s", "--situation", "T0O0W0D0H1", "--quiet", "--jobs", "1")
    assert call("run", *only).exit_code == 0
    command = "scaloft-fi run --mutant 'NO-velcmd@1s' --mutant 'NO-velcmd@1s#*'"
    assert command in sentence(call("margin", "NO-velcmd", "--when"))
    assert call("run", "--mutant", "NO-velcmd@1s#*", *only).exit_code == 0
    for style in ("table", "markdown", "latex", "json"):
        text = call("margin", "NO-velcmd", "--when", "--format", style).stdout.replace("\\", "")
        assert no_terms(text) == []
        assert all(phase in text for phase in ("#5s", "#10s", "#15s", "#sight", "#waypoint", "#recoil"))
    phases = of_form("margin", call("margin", "NO-velcmd", "--when", "--format", "json").stdout)["phases"]
    assert {phase["verdict"] for phase in phases} == {"not_tested"} or len(phases) > 4
    assert "Detected at 0 of 4 times" in call("margin", "NO-velcmd@1s#5s", "--when").stdout


def test_margins_of_a_campaign_that_does_not_exist_are_refused(call: Call):
    assert call("matrix", "--margins").exit_code == 2
