"""Survivors and what was accepted, on the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result

Call = Callable[..., Result]
FLOWN = ("--situation", "T0O0W0D0H*", "--seeds", "3", "--jobs", "1", "--quiet")


@pytest.fixture
def flown(call: Call, copy: Path, paper: Any, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A campaign in which LATE-human is detected, MORE-goal survives in two situations, NO-goal changes nothing."""
    fly = type(paper).__call__

    def flying(self: Any, study: Any, flight: Any, baseline: Any = None) -> Any:
        outcome = fly(self, study, flight, baseline)
        mild = flight.subject.guideword == "MORE"
        return replace(outcome, altered=3, infected_at_s=1.0, digest=flight.name) if mild else outcome

    monkeypatch.setattr(type(paper), "__call__", flying)
    words = ("--mutant", "LATE-human", "--mutant", "MORE-goal", "--mutant", "NO-goal")
    assert call("run", *words, *FLOWN, study=copy).exit_code == 0
    return copy


def accept(study: Path, mutant: str, expires: str = "2099-01-01", more: str = "") -> None:
    path = study / "hazop" / "dispositions.yaml"
    entry = f"{mutant}: {{status: accepted, owner: me, reason: why, expires: {expires}{more}}}\n"
    path.write_text((path.read_text() if path.exists() else "") + entry)


def states(call: Call, study: Path, *words: str) -> dict[str, str]:
    told = json.loads(call("dispositions", "--format", "json", *words, study=study).stdout)
    return {row["mutant"]: row["state"] for row in told["survivors"]}


def test_survivors_stand_beside_what_was_accepted(call: Call, flown: Path) -> None:
    assert states(call, flown) == {"MORE-goal@0.6m": "open"}
    accept(flown, "MORE-goal")
    accept(flown, "LATE-human")
    assert states(call, flown) == {"MORE-goal@0.6m": "accepted", "LATE-human@3s": "stale"}
    assert states(call, flown, "--today", "2099-01-02") == {"MORE-goal@0.6m": "expired", "LATE-human@3s": "stale"}


def test_what_is_written_is_refused_until_somebody_has_decided(call: Call, flown: Path) -> None:
    path = flown / "hazop" / "dispositions.yaml"
    done = call("dispositions", "--write", study=flown)
    assert done.exit_code == 0
    assert "1 survivor to decide on" in done.stderr
    refused = call("dispositions", study=flown)
    assert refused.exit_code == 2
    assert "owner='' must be a text" in refused.stderr
    text = path.read_text().replace('owner: ""', "owner: me").replace('reason: ""', "reason: why")
    path.write_text(text.replace('expires: ""', "expires: 2099-01-01"))
    assert states(call, flown) == {"MORE-goal@0.6m": "accepted"}
    before = path.read_text()
    assert call("dispositions", "--write", study=flown).exit_code == 0
    assert path.read_text() == before


def test_writing_keeps_what_stands_there_with_its_comments(call: Call, flown: Path) -> None:
    accept(flown, "LATE-human")
    path = flown / "hazop" / "dispositions.yaml"
    path.write_text("# mine\n" + path.read_text())
    before = path.read_text()
    assert call("dispositions", "--write", study=flown).exit_code == 0
    assert path.read_text().startswith(before)
    assert "\nMORE-goal@0.6m:\n" in path.read_text()


def test_a_date_that_is_none_is_refused(call: Call, flown: Path) -> None:
    done = call("dispositions", "--today", "2099-02-30", study=flown)
    assert done.exit_code == 2
    assert "'2099-02-30' is not a date" in done.stderr


def test_the_rest_of_the_study_works_beside_a_file_that_is_not_filled_in(call: Call, flown: Path) -> None:
    assert call("dispositions", "--write", study=flown).exit_code == 0
    assert call("run", "--mutant", "LATE-human", *FLOWN, study=flown).exit_code == 0
    assert call("score", study=flown).exit_code == 0


def test_the_ratchet_fails_on_a_survivor_that_nobody_accepted(call: Call, flown: Path) -> None:
    done = call("score", "--ratchet", study=flown)
    assert done.exit_code == 3
    assert "ratchet: MORE-goal@0.6m is not detected (tested in T0O0W0D0H0, T0O0W0D0H1) and not accepted" in done.stderr
    assert "would have been shown" in done.stdout


def test_the_ratchet_passes_what_is_accepted_until_its_day(call: Call, flown: Path) -> None:
    accept(flown, "MORE-goal")
    assert call("score", "--ratchet", study=flown).exit_code == 0
    assert call("score", "--ratchet", "--today", "2099-01-01", study=flown).exit_code == 0
    done = call("score", "--ratchet", "--today", "2099-01-02", study=flown)
    assert done.exit_code == 3
    assert "its disposition expired on 2099-01-01" in done.stderr


def test_the_ratchet_fails_on_a_survival_in_a_new_situation(call: Call, flown: Path) -> None:
    accept(flown, "MORE-goal", more=", situations: [T0O0W0D0H0]")
    done = call("score", "--ratchet", study=flown)
    assert done.exit_code == 3
    assert "survives in T0O0W0D0H1, which its disposition does not name" in done.stderr


def test_the_ratchet_says_which_dispositions_can_go_and_passes(call: Call, flown: Path) -> None:
    accept(flown, "MORE-goal")
    accept(flown, "LATE-human")
    done = call("score", "--ratchet", study=flown)
    assert done.exit_code == 0
    assert "warning: LATE-human@3s is detected now; its disposition can go" in done.stderr


def test_the_ratchet_and_the_threshold_fail_each_for_itself(call: Call, flown: Path) -> None:
    accept(flown, "MORE-goal")
    done = call("score", "--ratchet", "--fail-under", "1", study=flown)
    assert done.exit_code == 3
    assert "below --fail-under 1" in done.stderr
    assert "ratchet" not in done.stderr


def test_a_campaign_in_which_nothing_was_tested_passes_no_ratchet(call: Call, flown: Path) -> None:
    words = ("--campaign", f"{flown}/other", "--study", str(flown))
    assert call("run", "--mutant", "NO-goal", *FLOWN, *words, campaign=False).exit_code == 0
    done = call("score", "--ratchet", *words, campaign=False)
    assert done.exit_code == 3
    assert "nothing to hold" in done.stderr


def test_an_undecided_mutant_is_a_survivor_whose_verdict_is_told(call: Call, flown: Path) -> None:
    words = ("--campaign", f"{flown}/other", "--study", str(flown))
    once = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--jobs", "1", "--quiet", "--baseline-seeds", "10")
    assert call("run", *once, *words, campaign=False).exit_code == 0
    done = call("score", "--ratchet", *words, campaign=False)
    assert done.exit_code == 3
    assert "ratchet: LATE-human@3s is undecided (tested in T0O0W0D0H1) and not accepted" in done.stderr
    told = json.loads(call("dispositions", "--format", "json", *words, campaign=False).stdout)
    assert [(row["mutant"], row["state"], row["verdict"]) for row in told["survivors"]] == [
        ("LATE-human@3s", "open", "undecided")
    ]


@pytest.mark.parametrize("verb", [("score", "--ratchet"), ("dispositions",), ("dispositions", "--write")])
def test_without_a_pool_it_is_refused_and_the_command_is_named_that_flies_one(
    call: Call, flown: Path, verb: tuple[str, ...]
) -> None:
    words = ("--campaign", f"{flown}/other", "--study", str(flown))
    assert call("run", "--mutant", "LATE-human", *FLOWN, "--baseline-seeds", "1", *words, campaign=False).exit_code == 0
    done = call(*verb, *words, campaign=False)
    assert done.exit_code == 2
    (line,) = done.stderr.strip().splitlines()
    assert line.startswith(
        "error: no mutant is known to survive: no situation in which a mutant changes a sample has 10"
    )
    assert "`scaloft-fi run` with the same mutants flies them" in line
    assert not (flown / "hazop" / "dispositions.yaml").exists()


def test_a_file_that_is_not_filled_in_fails_the_ratchet_as_bad_input(call: Call, flown: Path) -> None:
    assert call("dispositions", "--write", study=flown).exit_code == 0
    assert call("score", "--ratchet", study=flown).exit_code == 2
