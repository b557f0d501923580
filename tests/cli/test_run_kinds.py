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
    from conftest import Paper

Call = Callable[..., Result]


def test_a_budget_that_is_no_time_is_refused(call: Call) -> None:
    assert "--budget='10'" in sentence(call("run", "--mutant", "LATE-human", "--budget", "10"))


def test_a_run_whose_time_is_up_names_what_it_left(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scaloft_fi.campaign.runs.budget.Budget.left_s", 0.0)
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--budget", "1h", "--quiet")
    result = call(*words, "--format", "json")
    assert result.exit_code == 0, result.output
    left = json.loads(result.stdout)["not_flown_by_parameter"]
    assert {"parameter": "human", "planned": 2, "flown": 0, "not flown": 2} in left
    assert "6 of 6 planned flights were not flown" in call(*words).stdout
    assert "planned, not flown" in call("status").stdout


def test_the_declared_share_of_invalid_flights_is_an_option(call: Call, paper: Paper) -> None:
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    assert call(*words, "--max-invalid", "0").exit_code == 0
    assert call(*words, "--max-invalid", "2").exit_code == 2


def test_sequential_looks_fly_on_what_is_undecided_and_print_how_it_went(call: Call) -> None:
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    result = call("run", *words, "--sequential", "--baseline-seeds", "50", "--format", "json")
    assert result.exit_code == 0, result.output
    first, *_ = json.loads(result.stdout)["looks"]
    assert (first["seeds"], first["pairs"], first["flights"]) == (3, 2, 6)
    rows = json.loads(call("export").stdout)
    assert sum(row["mutant"] == "baseline" for row in rows) == 2 * 50
    assert "Looks" in call("run", *words, "--sequential", "--baseline-seeds", "50").stdout


@pytest.mark.parametrize("other", [("--seeds", "4"), ("--budget", "10m"), ("--shard", "1/2")])
def test_sequential_goes_alone(call: Call, other: tuple[str, ...]) -> None:
    assert "do not go together" in sentence(call("run", "--mutant", "LATE-human", "--sequential", *other))


def test_a_pool_is_flown_with_the_baseline_alone_and_changes_no_rate(call: Call) -> None:
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    plain = json.loads(call("run", *words, "--format", "json").stdout)
    pooled = json.loads(call("run", *words, "--baseline-seeds", "2-9", "--format", "json").stdout)
    assert (plain["coverage"].pop("draws"), pooled["coverage"].pop("draws")) == (2, 18)
    assert (plain["coverage"].pop("pool"), pooled["coverage"].pop("pool")) == (0, 16)
    # what the baseline does by chance is known better, and that is what a pool is for
    assert plain.pop("redraw")["rate"]["whole"] == 0 < pooled.pop("redraw")["rate"]["whole"]
    assert pooled == plain
    seeds = {row["seed"] for row in json.loads(call("export").stdout) if row["mutant"] == "baseline"}
    assert seeds == {0, *range(2, 10)}
    assert "pool" in call("score").stdout
    assert "One seed" in call("score").stdout


def test_bad_baseline_seeds_are_named_as_such(call: Call) -> None:
    assert "--baseline-seeds='x'" in sentence(call("run", "--baseline-seeds", "x"))


def test_another_campaigns_baselines_decide_and_are_only_read(call: Call, tmp_path: Path) -> None:
    where = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    lender = str(tmp_path / "lender" / "c")
    call("run", *where, "--baseline-seeds", "50", "--campaign", lender, campaign=False)
    before = call("export", "--campaign", lender, campaign=False).stdout
    lone = call("run", *where, "--seeds", "3").stdout
    pooled = call("run", *where, "--seeds", "3", "--baseline-from", lender).stdout
    assert "0+0 1?" in lone
    assert "1+0" in pooled
    assert call("score", "--baseline-from", lender).stdout == pooled
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
    monkeypatch.setattr("scaloft_fi.campaign.runs.baseline_pool.fingerprint", lambda: {"machine": "PDP-11"})
    assert "was flown on another platform" in sentence(call("run", *where, "--baseline-from", lender))
