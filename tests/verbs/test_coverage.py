"""`coverage`, and a study of 59,049 situations, without physics."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from effort import usually

from scaloft_fi.sim.load import Scenario, SimConfig
from scaloft_fi.study import Study

Call = Callable[..., Result]


def flown(call: Call, *words: str) -> None:
    assert call("run", "--mutant", "LATE-human", "--quiet", *words).exit_code == 0


def test_json_counts_what_was_chosen_and_flown(call: Call) -> None:
    flown(call, "--choose", "draws:40")
    flown(call, "--choose", "first:1", "--seeds", "9-9")
    said = json.loads(call("coverage", "--format", "json").stdout)
    draws, first = said["choices"]
    assert (draws["choose"], draws["pool"], len(draws["draws"])) == ("draws:40", 32, 40)
    assert (first["choose"], first["draws"]) == ("first:1", [{"situation": "T0O0W0D0H0", "seed": 9}])
    cases = {tuple(draw.values()) for draw in [*draws["draws"], *first["draws"]]}
    assert said["coverage"]["draws"] - said["coverage"]["pool"] == len(cases)
    assert said["coverage"]["situations"] == {"part": len({key for key, _ in cases}), "whole": 32}


def test_coverage_and_score_say_the_same(call: Call) -> None:
    flown(call, "--choose", "random:7")
    scored = json.loads(call("score", "--format", "json").stdout)["coverage"]
    said = json.loads(call("coverage", "--format", "json").stdout)["coverage"]
    assert scored == said


@pytest.fixture
def large(copy: Path) -> Path:
    """Ten axes of three values: 59,049 situations, of which the constraint leaves 52,488."""
    axes = "".join(
        f"\n  A{letter}: {{title: axis {letter}, category: c, values: [{{id: 0, title: benign}}, "
        "{id: 1, title: one, realised: always(light <= 1)}, {id: 2, title: two, realised: always(light <= 1)}]}"
        for letter in "abcdefghij"
    )
    constraints = "\nconstraints:\n  - exclude: {Aa: 0, Ab: 2}\n    reason: they do not go together\n"
    (copy / "sim" / "situations.yaml").write_text(f"axes:{axes}\n{constraints}", encoding="utf-8")
    return copy


@pytest.mark.parametrize("how", usually(["2-way"], release=["2-way", "random:50"]))
def test_a_large_grid_is_sampled_and_scored_without_making_every_world(
    call: Call, large: Path, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    made: list[str] = []
    begin = SimConfig.scenario

    def scenario(self: SimConfig, situation) -> Scenario:
        made.append(situation.key)
        return begin(self, situation)

    monkeypatch.setattr(SimConfig, "scenario", scenario)
    assert len(Study.open(large).grid) == 52_488
    done = call("run", "--mutant", "LATE-human", "--choose", how, "--quiet", "--format", "json", study=large)
    covered = json.loads(done.stdout)["coverage"]
    assert len(set(made)) == covered["situations"]["part"]
    assert covered["situations"]["whole"] == 52_488
    # the pair that no situation has is none of the 405; of the 3-way combinations it takes 8 x 3
    assert (covered["t_way"]["2"]["whole"], covered["t_way"]["3"]["whole"]) == (404, 3240 - 24)
    if how == "2-way":
        assert covered["t_way"]["2"]["part"] == 404
        assert covered["situations"]["part"] <= 18
        assert covered["t_way"]["5"]["whole"] == 61_236 - 56 * 27


def test_a_situation_that_a_large_grid_lacks_is_refused_fast(call: Call, large: Path) -> None:
    refused = call("run", "--situation", "Aa0Ab2Ac0Ad0Ae0Af0Ag0Ah0Ai0Aj0", study=large)
    assert "is excluded by" in refused.stderr
    assert "they do not go together" in refused.stderr
