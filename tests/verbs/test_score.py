from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from refusal import sentence

Call = Callable[..., Result]


def test_all_shows_every_table_and_by_one_of_them(call: Call) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    whole, part = call("score", "--all").stdout, call("score", "--by", "guideword").stdout
    for title in (
        "Mutation score",
        "Where the faults stopped",
        "Pairs that put no fault",
        "Findings about the unmutated",
    ):
        assert title in whole
        assert title not in part
    assert "Score by guideword" in part
    assert json.loads(call("score", "--by", "axis", "--format", "json").stdout)["groups"]


def test_score_prints_what_the_run_printed_again(call: Call) -> None:
    flown = call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    assert call("score").stdout == flown.stdout


@pytest.mark.parametrize("style", ["markdown", "latex"])
def test_tables_come_in_other_formats(call: Call, style: str) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    result = call("score", "--format", style, "--by", "guideword")
    assert result.exit_code == 0
    assert "LATE" in result.stdout


def test_the_score_as_json_has_the_keys_of_the_contract(call: Call) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--seeds", "3", "--quiet")
    score = json.loads(call("score", "--format", "json").stdout)
    assert {"version", "alpha", "ratios", "expected_false", "mutants", "pairs", "coverage", "baseline"} <= score.keys()
    assert score["ratios"]["mutation_score"]["part"] == 1
    assert score["mutants"][0]["kill_rate_flown"] == {"part": 1, "whole": 2}
    assert set(score["coverage"]["t_way"]) == {"1", "2", "3", "4", "5"}


def test_below_the_asked_score_the_exit_code_is_3(call: Call) -> None:
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    assert call("run", *words, "--seeds", "3", "--fail-under", "1").exit_code == 0
    call("run", "--mutant", "MORE-goal", "--situation", "T0O0W0D0H0", "--quiet")
    empty = ("--campaign", "./other/c")
    below = call("run", "--mutant", "MORE-goal", "--quiet", "--fail-under", "0.1", *empty, campaign=False)
    assert below.exit_code == 3
    assert "below --fail-under 0.1" in below.stderr


def test_a_mutant_with_too_few_seeds_counts_for_the_bar_of_detected_mutants_and_not_for_that_of_firm_ones(
    call: Call,
) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--seeds", "3", "--quiet")
    assert call("score", "--fail-under", "1").exit_code == 0
    below = call("score", "--fail-under", "1", "--fail-under-firm", "0.1")
    assert below.exit_code == 3
    assert "mutation score 1/1 = 100 %, firm 0/1 = 0 %: below --fail-under-firm 0.1" in below.stderr


def test_a_campaign_without_a_flight_that_counts_has_no_score(call: Call, tmp_path: Path, copy: Path) -> None:
    assert "no campaign was flown here; `scaloft-fi run` flies one" in sentence(call("score"))
    assert list(tmp_path.iterdir()) == [copy]
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    assert call("run", *words, study=copy).exit_code == 0
    world = copy / "sim" / "world.yaml"
    world.write_text(world.read_text().replace("light: 0.9", "light: 0.8", 1))
    assert "flights are stale" in sentence(call("score", study=copy))


def test_the_score_is_told_with_and_without_accepted_survivors(call: Call, copy: Path) -> None:
    call("run", "--mutant", "LATE-human", "--mutant", "MORE-human", "--situation", "T0O0W0D0H?", "--quiet", study=copy)
    before = json.loads(call("score", "--format", "json", study=copy).stdout)
    survivors = [one["id"] for one in before["mutants"] if one["verdict"] in ("not_detected", "undecided")]
    assert before["accepted"] == []
    assert before["ratios"]["without_accepted"] == before["ratios"]["mutation_score"]
    assert "Accepted" not in call("score", study=copy).stdout
    known = f"{survivors[0]}: {{status: accepted, owner: A. Owner, reason: known, expires: 2027-01-31}}\n"
    (copy / "hazop" / "dispositions.yaml").write_text(known)
    days = {"2027-01-31": 1, "2027-02-01": 0}
    for day, accepted in days.items():
        told = json.loads(call("score", "--format", "json", "--today", day, study=copy).stdout)
        assert [one["mutant"] for one in told["accepted"]] == survivors[:accepted]
        assert told["ratios"]["mutation_score"] == before["ratios"]["mutation_score"]
        whole = told["ratios"]["mutation_score"]["whole"] - accepted
        assert told["ratios"]["without_accepted"] == told["ratios"]["mutation_score"] | {"whole": whole}
    said = " ".join(call("score", "--today", "2027-01-31", study=copy).stdout.split())
    assert "(by A. Owner). Shown: " in said
