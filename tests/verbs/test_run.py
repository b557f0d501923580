"""`run` without physics."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from click.testing import Result
from refusal import sentence

if TYPE_CHECKING:
    from paper_flyer import Paper

Call = Callable[..., Result]


def test_a_run_prints_four_answers_the_mutants_by_verdict_and_two_lines(call: Call) -> None:
    result = call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?")
    assert result.exit_code == 0, result.output
    for name in ("Shown", "Not shown", "How sure", "What next", "Situations", "Unmutated drone"):
        assert f"\n{name}  " in f"\n{result.stdout}"
    assert "Undecided: 1\n" in result.stdout
    assert "LATE-human@3s" in result.stdout
    assert "Where the faults stopped" not in result.stdout
    assert "violations: 2 (mutants 2); all of them are in " in result.stderr
    assert "warning" not in result.stderr


def test_warnings_tell_each_violation_of_however_many_mutants(call: Call) -> None:
    for words in (("--mutant", "LATE-human"), ("--seeds", "1-1")):
        said = call("run", "--situation", "T0O0W0D0H1", "--warnings", *words).stderr.splitlines()
        (counted,) = (line for line in said if line.startswith("violations: "))
        warnings = [line for line in said if line.startswith("warning: ")]
        assert any(line.startswith("warning: SR2 violated at 8.00 s") for line in warnings)
        assert counted.startswith(f"violations: {len(warnings)} (mutants {len(warnings)}); ")


def test_quiet_says_nothing_but_the_tables(call: Call) -> None:
    assert call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet").stderr == ""


def test_without_mutant_every_cells_default_and_every_control_flies(call: Call) -> None:
    assert call("run", "--situation", "T0O0W0D0H1", "--quiet").exit_code == 0
    flown = {row["mutant"] for row in json.loads(call("export").stdout)}
    from scaloft_fi.hazop.matrix import CellStatus
    from scaloft_fi.study import Study

    matrix = Study.open(Path(__file__).parents[2]).matrix
    assert len(flown) == 2 + sum(cell.status is not CellStatus.NOT_MEANINGFUL for cell in matrix)


def test_the_same_command_in_any_number_of_jobs_exports_the_same_bytes(call: Call, tmp_path: Path) -> None:
    exports = []
    for name, jobs in (("one", "1"), ("two", "2"), ("two", "1")):
        words = ("--campaign", str(tmp_path / name / "c"))
        flown = call("run", "--mutant", "LATE-human*", "--jobs", jobs, "--quiet", *words, campaign=False)
        assert flown.exit_code == 0, flown.output
        exports.append(call("export", *words, campaign=False).stdout)
    assert exports[0] == exports[1] == exports[2]


def test_a_control_that_shows_nothing_is_a_gate_and_prints_no_score(call: Call, paper: Paper) -> None:
    paper.tame = True
    result = call("run", "--mutant", "LATE-human", "--quiet")
    assert (result.exit_code, result.stdout) == (4, "")
    assert "a control shows nothing" in result.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--mutant", "LATE-humna"), "did you mean 'LATE-human'?"),
        (("--mutant", "LATE-human@3kg"), "'LATE-human@3kg'"),
        (("--mutant", "LATE-human@-3s"), "LATE-human@-3s"),
        (("--mutant", "LTE*"), "no mutant matches 'LTE*'"),
        (("--mutant", "what"), "must be of the form"),
        (("--situation", "T0O0W0D0H9"), "no situation 'T0O0W0D0H9'"),
        (("--situation", "X*"), "no situation 'X*'"),
        (("--seeds", "0"), "--seeds='0' must be"),
        (("--jobs", "0"), "--jobs"),
        (("--fail-under", "2"), "--fail-under"),
        (("--format", "xml"), "--format"),
    ],
)
def test_bad_words_are_one_sentence_and_nothing_is_written(
    call: Call, tmp_path: Path, words: tuple[str, ...], said: str
) -> None:
    assert said in sentence(call("run", *words))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_no_study_is_onesentence(call: Call, tmp_path: Path) -> None:
    assert "--study=" in sentence(call("run", study=tmp_path))


def test_results_that_cannot_be_written_are_onesentence(call: Call, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    words = ("--campaign", str(tmp_path / "file" / "c"))
    assert "cannot be written" in sentence(call("run", "--mutant", "LATE-human", *words, campaign=False))


def test_a_bare_campaign_name_is_a_folder_of_the_study(call: Call, copy: Path) -> None:
    words = ("--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet", "--campaign", "mine")
    assert call("run", *words, study=copy, campaign=False).exit_code == 0
    assert (copy / "results" / "campaigns" / "mine" / "outcomes.sqlite").is_file()


def _edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_a_stale_catalogue_is_refused(call: Call, copy: Path) -> None:
    _edit(copy / "hazop" / "matrix" / "human.yaml", "ladder: [0.5, 1, 3, 5]", "ladder: [0.5, 1, 2, 3, 5]")
    assert "the catalogue is stale" in sentence(call("run", "--mutant", "LATE-human", study=copy))


def test_a_cell_that_names_no_requirement_is_refused_with_file_and_line(call: Call, copy: Path) -> None:
    _edit(copy / "hazop" / "matrix" / "human.yaml", "requirements: [SR2]", "requirements: [SR7]")
    line = sentence(call("run", "--mutant", "LATE-human", study=copy))
    assert "human.yaml:" in line
    assert "'SR7'" in line


def test_a_predicate_that_is_no_formula_is_refused(call: Call, copy: Path) -> None:
    _edit(copy / "sim" / "situations.yaml", "eventually(x_m < -1)", "eventually(x_n < -1)")
    line = sentence(call("run", "--mutant", "LATE-human", study=copy))
    assert re.search(r"situations.yaml:\d+: realised names the unknown signal 'x_n'", line)


def test_an_edited_number_flies_again_and_an_edited_comment_does_not(call: Call, copy: Path) -> None:
    words = ("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0")
    assert "3 of 3 flights flown" in call(*words, study=copy).stderr
    _edit(copy / "sim" / "world.yaml", "light: 0.9", "light: 0.9 # bright")
    assert "flown" not in call(*words, study=copy).stderr
    _edit(copy / "sim" / "world.yaml", "light: 0.9", "light: 0.8")
    assert "3 of 3 flights flown" in call(*words, study=copy).stderr
    status = call("status", study=copy).stdout.splitlines()
    assert "sim/ changed  3" in [" ".join(line.split()).replace("changed ", "changed  ") for line in status]
    told = json.loads(call("status", "--format", "json", study=copy).stdout)
    assert told["reasons"] == [{"why": "sim/ changed", "flights": 3}]


def test_an_axis_value_that_a_situation_does_not_have_does_not_fly_it_again(call: Call, copy: Path) -> None:
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?")
    call(*words, study=copy)
    _edit(copy / "sim" / "situations.yaml", "set: {light: 0.003}", "set: {light: 0.004}")
    assert "flown" not in call(*words, study=copy).stderr
