"""`run` without physics: the whole one, a choice, a budget, looks, a pool of baselines."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from harmful import edit_in
from paper_flyer import Paper
from refusal import sentence

from scaloft_fi.campaign.runs.request import remembered
from scaloft_fi.campaign.store.store import Store

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


def test_a_bare_campaign_name_is_a_folder_of_the_study(call: Call, copy: Path) -> None:
    words = ("--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet", "--campaign", "mine")
    assert call("run", *words, study=copy, campaign=False).exit_code == 0
    assert (copy / "results" / "campaigns" / "mine" / "outcomes.sqlite").is_file()


def test_an_edited_number_flies_again_and_an_edited_comment_does_not(call: Call, copy: Path) -> None:
    words = ("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0")
    assert "3 of 3 flights flown" in call(*words, study=copy).stderr
    edit_in(copy / "sim" / "world.yaml", "light: 0.9", "light: 0.9 # bright")
    assert "flown" not in call(*words, study=copy).stderr
    edit_in(copy / "sim" / "world.yaml", "light: 0.9", "light: 0.8")
    assert "3 of 3 flights flown" in call(*words, study=copy).stderr
    status = call("status", study=copy).stdout.splitlines()
    assert "sim/ changed  3" in [" ".join(line.split()).replace("changed ", "changed  ") for line in status]
    told = json.loads(call("status", "--format", "json", study=copy).stdout)
    assert told["reasons"] == [{"why": "sim/ changed", "flights": 3}]


def test_chosen_situations_are_flown_and_the_choice_is_kept(call: Call, tmp_path: Path) -> None:
    done = call(
        "run", "--mutant", "LATE-human", "--choose", "2-way", "--choose-seed", "1", "--quiet", "--format", "json"
    )
    assert done.exit_code == 0
    covered = json.loads(done.stdout)["coverage"]
    assert (covered["situations"]["part"], covered["draws"] - covered["pool"]) == (6, 6)
    assert covered["t_way"]["2"]["part"] == 40
    with Store(tmp_path / "campaign" / "outcomes.sqlite", create=False) as store:
        assert [(one.text, one.seed) for one in remembered(store)] == [("2-way", 1)]


def test_a_run_whose_time_is_up_names_what_it_left(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scaloft_fi.campaign.runs.run.Budget.left_s", 0.0)
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--budget", "1h", "--quiet")
    result = call(*words, "--format", "json")
    assert result.exit_code == 0, result.output
    left = json.loads(result.stdout)["unflown"]
    assert {"by": "parameter", "name": "human", "planned": 2, "flown": 0, "not_flown": 2} in left
    assert "6 of 6 planned flights were not flown" in call(*words).stdout
    assert "planned, not flown" in call("status").stdout


def test_the_declared_share_of_invalid_flights_is_an_option(call: Call, paper: Paper) -> None:
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    assert call(*words, "--max-invalid", "0").exit_code == 0
    assert call(*words, "--max-invalid", "2").exit_code == 2


def test_sequential_looks_fly_on_what_is_undecided_and_print_how_it_went(call: Call) -> None:
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    result = call("run", *words, "--sequential", "--format", "json")
    assert result.exit_code == 0, result.output
    first, *_ = json.loads(result.stdout)["looks"]
    assert (first["seeds"], first["mutants"], first["flights"]) == (1, 1, 2)
    assert "Looks" in call("run", *words, "--sequential").stdout


def test_a_pool_of_ten_is_flown_by_default_where_the_mutant_infects(call: Call) -> None:
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    found = json.loads(call("run", *words, "--format", "json").stdout)
    seeds = {key: set() for key in ("T0O0W0D0H0", "T0O0W0D0H1")}
    for row in json.loads(call("export").stdout):
        if row["mutant"] == "baseline":
            seeds[row["situation"]].add(row["seed"])
    assert seeds == {"T0O0W0D0H0": {0}, "T0O0W0D0H1": set(range(10))}
    assert found["pooled"]
    assert found["coverage"]["pool"] == 9


def test_without_a_pool_the_score_has_counts_and_the_command_that_decides(call: Call) -> None:
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    text = call("run", *words, "--baseline-seeds", "1").stdout
    assert "not known: there is no baseline pool. 1 of 1 fault violated a safety requirement" in " ".join(text.split())
    assert "`scaloft-fi run " in text
    assert json.loads(call("score", "--format", "json").stdout)["ratios"]["mutation_score"] == {"part": 0, "whole": 0}


def test_fail_under_without_a_pool_is_refused(call: Call, tmp_path: Path) -> None:
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet", "--baseline-seeds", "5")
    assert "--fail-under=0.5 needs a baseline pool of at least 10 seeds" in sentence(
        call(*words, "--fail-under", "0.5")
    )
    assert not (tmp_path / "campaign").exists()
    assert call(*words).exit_code == 0
    assert "--fail-under=0.5 needs a baseline pool: campaign" in sentence(call("score", "--fail-under", "0.5"))


def test_a_campaign_that_grows_spends_its_alpha_by_looks(call: Call) -> None:
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet", "--format", "json")
    (late,) = json.loads(call(*words, "--seeds", "3").stdout)["mutants"]
    assert (late["verdict"], late["decided_at"]["alpha"]) == ("detected", 0.01)
    (late,) = json.loads(call(*words, "--seeds", "5").stdout)["mutants"]
    assert (late["verdict"], late["decided_at"]["alpha"]) == ("detected", 0.0025)
    (late,) = json.loads(call("score", "--format", "json").stdout)["mutants"]
    assert (late["verdict"], late["decided_at"]["seeds"]) == ("detected", 5)


def test_another_campaigns_baselines_decide_and_are_only_read(call: Call, tmp_path: Path) -> None:
    where = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    lender = str(tmp_path / "lender" / "c")
    call("run", *where, "--baseline-seeds", "50", "--campaign", lender, campaign=False)
    before = call("export", "--campaign", lender, campaign=False).stdout
    lone = call("run", *where, "--seeds", "3", "--baseline-seeds", "3").stdout
    lent = call("run", *where, "--seeds", "3", "--baseline-from", lender).stdout
    assert "there is no baseline pool" in lone
    assert "1 of 1 fault would have been shown" in lent
    assert "Detected: 1" in call("score", "--baseline-from", lender).stdout
    assert call("export", "--campaign", lender, campaign=False).stdout == before


def test_a_lender_that_does_not_fit_is_onesentence(call: Call, tmp_path: Path, copy: Path) -> None:
    lender = str(tmp_path / "lender" / "c")
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H0", "--quiet", "--baseline-from", lender)
    assert "no campaign was flown here" in sentence(call(*words))
    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H1", "--quiet", "--campaign", lender, campaign=False)
    assert "has no baseline of T0O0W0D0H0" in sentence(call(*words))
    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet", "--campaign", lender, campaign=False)
    world = copy / "sim" / "world.yaml"
    world.write_text(world.read_text().replace("light: 0.9", "light: 0.8", 1))
    assert "baseline/T0O0W0D0H0/0 was flown with other data or code" in sentence(call(*words, study=copy))
    assert not (tmp_path / "campaign").exists()


def test_a_lender_from_another_platform_is_onesentence(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    lender = str(tmp_path / "lender" / "c")
    where = ("--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet")
    call("run", *where, "--campaign", lender, campaign=False)
    monkeypatch.setattr("scaloft_fi.campaign.runs.run.fingerprint", lambda: {"machine": "PDP-11"})
    assert "was flown on another platform" in sentence(call("run", *where, "--baseline-from", lender))
