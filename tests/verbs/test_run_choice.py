from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from click.testing import Result
from refusal import sentence

from scaloft_fi.campaign.runs.request import remembered
from scaloft_fi.campaign.store.store import Store

Call = Callable[..., Result]


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


def test_draws_are_counted_beside_distinct_situations(call: Call) -> None:
    done = call("run", "--mutant", "LATE-human", "--choose", "draws:40", "--quiet", "--format", "json")
    covered = json.loads(done.stdout)["coverage"]
    assert covered["draws"] - covered["pool"] == 40
    assert covered["situations"]["part"] < 32


def test_draws_are_not_looked_at_again(call: Call) -> None:
    refused = call("run", "--choose", "draws:9", "--sequential", "--quiet")
    assert "--sequential and --choose=draws:9 do not go together" in sentence(refused)


def test_a_choice_that_cannot_be_writes_nothing(call: Call, tmp_path: Path) -> None:
    refused = call("run", "--choose", "random:99", "--quiet")
    assert "must ask for at most 32" in sentence(refused)
    assert not (tmp_path / "campaign").exists()
