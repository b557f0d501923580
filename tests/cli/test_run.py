"""`run`, and what reads a campaign afterwards, without physics."""

from __future__ import annotations

import csv
import io
import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from click.testing import Result

from scaloft_fi.campaign.held.folder import STORE_NAME
from scaloft_fi.campaign.plan.strategy import remembered
from scaloft_fi.results.store import Store

if TYPE_CHECKING:
    from conftest import Paper

Call = Callable[..., Result]


def _sentence(result: Result) -> str:
    """The one sentence of a refusal: exit code 2, nothing else printed."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    (line,) = result.stderr.strip().splitlines()
    assert line.startswith("error: ")
    assert "Traceback" not in line
    return line


def test_a_run_prints_score_rungs_findings_and_coverage(call: Call) -> None:
    result = call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?")
    assert result.exit_code == 0, result.output
    for title in ("Mutation score", "Mutants", "Where the faults stopped", "Findings about the unmutated drone"):
        assert title in result.stdout
    assert "LATE-human@3s" in result.stdout
    assert "Situation coverage" in result.stdout
    assert "warning: SR2 violated at 8.00 s" in result.stderr


def test_quiet_says_nothing_but_the_tables(call: Call) -> None:
    assert call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet").stderr == ""


def test_without_mutant_every_cells_default_and_every_control_flies(call: Call) -> None:
    assert call("run", "--situation", "T0O0W0D0H1", "--quiet").exit_code == 0
    flown = {row["mutant"] for row in json.loads(call("export").stdout)}
    from scaloft_fi.hazop.cell import CellStatus
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


def test_an_export_has_one_row_per_flight_in_order_and_csv_says_the_same(call: Call) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    rows = json.loads(call("export").stdout)
    assert [(row["mutant"], row["situation"]) for row in rows] == [
        (mutant, f"T0O0W0D0H{h}") for mutant in ("baseline", "PLACEBO", "LATE-human@3s") for h in (0, 1)
    ] + [("REVERSE-velcmd", "T0O0W0D0H0")]
    assert rows[-2]["violated"] == ["SR2"]
    table = list(csv.DictReader(io.StringIO(call("export", "--format", "csv").stdout)))
    assert [row["digest"] for row in table] == [row["digest"] for row in rows]


def test_an_export_can_go_to_a_file(call: Call, tmp_path: Path) -> None:
    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet")
    assert call("export", "--output", str(tmp_path / "e.json")).stdout == ""
    assert json.loads((tmp_path / "e.json").read_text())[0]["mutant"] == "baseline"
    assert "cannot be written" in _sentence(call("export", "--output", str(tmp_path / "no" / "e.json")))


def test_score_prints_the_tables_of_the_run_again(call: Call) -> None:
    flown = call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    assert call("score").stdout == flown.stdout


@pytest.mark.parametrize("style", ["markdown", "csv", "latex"])
def test_tables_come_in_other_formats(call: Call, style: str) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    result = call("score", "--format", style, "--by", "guideword")
    assert result.exit_code == 0
    assert "LATE" in result.stdout


def test_the_score_as_json_has_the_keys_of_the_contract(call: Call) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    score = json.loads(call("score", "--format", "json").stdout)
    assert {"ratios", "mutants", "coverage", "baseline"} <= score.keys()
    assert score["ratios"]["mutation_score"]["part"] == 1
    assert score["mutants"][0]["kill_rate_flown"] == {"part": 1, "whole": 2}
    assert set(score["coverage"]["t_way"]) == {"1", "2", "3", "4", "5"}


def test_below_the_asked_score_the_exit_code_is_3(call: Call) -> None:
    words = ("--mutant", "LATE-human", "--mutant", "NO-human", "--situation", "T0O0W0D0H1", "--quiet")
    assert call("run", *words, "--fail-under", "1").exit_code == 0
    call("run", "--mutant", "MORE-goal", "--situation", "T0O0W0D0H0", "--quiet")
    empty = ("--campaign", "./other/c")
    below = call("run", "--mutant", "MORE-goal", "--quiet", "--fail-under", "0.1", *empty, campaign=False)
    assert below.exit_code == 3
    assert "below --fail-under" in below.stderr


def test_a_surviving_control_is_a_gate_and_prints_no_score(call: Call, paper: Paper) -> None:
    paper.tame = True
    result = call("run", "--mutant", "LATE-human", "--quiet")
    assert (result.exit_code, result.stdout) == (4, "")
    assert "a control survives" in result.stderr


def test_status_counts_flights(call: Call) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    out = call("status").stdout
    assert "killed" in out
    assert "stale" in out


def test_flights_whose_baseline_is_not_home_wait_for_it_and_are_not_called_invalid(call: Call, tmp_path: Path) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    with closing(sqlite3.connect(tmp_path / "campaign" / STORE_NAME)) as connection:
        connection.execute("DELETE FROM outcomes WHERE mutant = 'baseline' AND situation = 'T0O0W0D0H1'")
        connection.commit()
    counted = {
        row["flights"]: row["number"] for row in json.loads(call("status", "--format", "json").stdout)[0]["rows"]
    }
    rows = json.loads(call("export").stdout)
    assert counted["waiting for their baseline"] == sum(row["situation"] == "T0O0W0D0H1" for row in rows) >= 2
    assert "invalid" not in counted


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
    assert said in _sentence(call("run", *words))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_no_study_is_one_sentence(call: Call, tmp_path: Path) -> None:
    assert "--study=" in _sentence(call("run", study=tmp_path))


def test_a_campaign_that_was_never_flown_is_one_sentence(call: Call, tmp_path: Path) -> None:
    for verb in ("score", "export", "status"):
        assert "no campaign was flown here" in _sentence(call(verb))
    assert list(tmp_path.iterdir()) == []


def test_results_that_cannot_be_written_are_one_sentence(call: Call, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    words = ("--campaign", str(tmp_path / "file" / "c"))
    assert "cannot be written" in _sentence(call("run", "--mutant", "LATE-human", *words, campaign=False))


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
    assert "the catalogue is stale" in _sentence(call("run", "--mutant", "LATE-human", study=copy))


def test_a_cell_that_names_no_requirement_is_refused_with_file_and_line(call: Call, copy: Path) -> None:
    _edit(copy / "hazop" / "matrix" / "human.yaml", "requirements: [SR2]", "requirements: [SR7]")
    line = _sentence(call("run", "--mutant", "LATE-human", study=copy))
    assert "human.yaml:" in line
    assert "'SR7'" in line


def test_a_predicate_that_is_no_formula_is_refused(call: Call, copy: Path) -> None:
    _edit(copy / "sim" / "situations.yaml", "eventually(x_m < -1)", "eventually(x_n < -1)")
    assert "situations.yaml: realised of T1" in _sentence(call("run", "--mutant", "LATE-human", study=copy))


def test_an_edited_number_flies_again_and_an_edited_comment_does_not(call: Call, copy: Path) -> None:
    words = ("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0")
    assert "3 of 3 flights flown" in call(*words, study=copy).stderr
    _edit(copy / "sim" / "world.yaml", "light: 0.9", "light: 0.9 # bright")
    assert "flown" not in call(*words, study=copy).stderr
    _edit(copy / "sim" / "world.yaml", "light: 0.9", "light: 0.8")
    assert "3 of 3 flights flown" in call(*words, study=copy).stderr
    status = call("status", study=copy).stdout.splitlines()
    assert "sim/ changed  3" in [" ".join(line.split()).replace("changed ", "changed  ") for line in status]
    (_, stale) = json.loads(call("status", "--format", "json", study=copy).stdout)
    assert stale["rows"] == [{"why": "sim/ changed", "number": 3}]


def test_an_axis_value_that_a_situation_does_not_have_does_not_fly_it_again(call: Call, copy: Path) -> None:
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?")
    call(*words, study=copy)
    _edit(copy / "sim" / "situations.yaml", "set: {light: 0.003}", "set: {light: 0.004}")
    assert "flown" not in call(*words, study=copy).stderr


def test_chosen_situations_are_flown_and_the_choice_is_kept(call, tmp_path: Path) -> None:
    done = call(
        "run", "--mutant", "LATE-human", "--choose", "2-way", "--choose-seed", "1", "--quiet", "--format", "json"
    )
    assert done.exit_code == 0
    covered = json.loads(done.stdout)["coverage"]
    assert (covered["situations"]["part"], covered["draws"], covered["t_way"]["2"]["part"]) == (6, 6, 40)
    with Store(tmp_path / "campaign" / "outcomes.sqlite", create=False) as store:
        assert [(one.text, one.seed) for one in remembered(store)] == [("2-way", 1)]


def test_draws_are_counted_beside_distinct_situations(call) -> None:
    done = call("run", "--mutant", "LATE-human", "--choose", "draws:40", "--quiet", "--format", "json")
    covered = json.loads(done.stdout)["coverage"]
    assert covered["draws"] == 40
    assert covered["situations"]["part"] < 32


def test_draws_are_not_looked_at_again(call) -> None:
    refused = call("run", "--choose", "draws:9", "--sequential", "--quiet")
    assert "--sequential and --choose=draws:9 do not go together" in _sentence(refused)


def test_a_choice_that_cannot_be_writes_nothing(call, tmp_path: Path) -> None:
    refused = call("run", "--choose", "random:99", "--quiet")
    assert "must ask for at most 32" in _sentence(refused)
    assert not (tmp_path / "campaign").exists()
