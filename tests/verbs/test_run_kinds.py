"""Other runs than the whole one: a budget, looks, a pool of baselines; without physics."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from click.testing import Result
from refusal import sentence

if TYPE_CHECKING:
    from paper_flyer import Paper

Call = Callable[..., Result]


def test_a_budget_that_is_no_time_is_refused(call: Call) -> None:
    assert "--budget='10'" in sentence(call("run", "--mutant", "LATE-human", "--budget", "10"))


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


@pytest.mark.parametrize("other", [("--seeds", "4"), ("--budget", "10m"), ("--shard", "1/2")])
def test_sequential_goes_alone(call: Call, other: tuple[str, ...]) -> None:
    assert "do not go together" in sentence(call("run", "--mutant", "LATE-human", "--sequential", *other))


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


def test_bad_baseline_seeds_are_named_as_such(call: Call) -> None:
    assert "--baseline-seeds='x'" in sentence(call("run", "--baseline-seeds", "x"))


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
