"""Survivors and what was accepted, on the command line."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest
from click.testing import CliRunner
from paper_flyer import Paper
from printed import STUDY, Call

from scaloft_fi.analysis.survivor import Disposition, Judged, Standing
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.cli import main
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study
from scaloft_fi.verbs.score import complaint

FLOWN = ("--situation", "T0O0W0D0H*", "--seeds", "3", "--jobs", "1", "--quiet")


class Mild(Paper):
    """LATE-human is detected, MORE-goal survives in two situations, NO-goal changes nothing."""

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        outcome = super().__call__(study, flight)
        mild = flight.subject.guideword == "MORE"
        return replace(outcome, altered=3, infected_at_s=1.0, digest=flight.name) if mild else outcome


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dispositions") / "campaign"
    words = ("--mutant", "LATE-human", "--mutant", "MORE-goal", "--mutant", "NO-goal", "--campaign", str(folder))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scaloft_fi.campaign.flights.physics.Physics", Mild)
        assert CliRunner().invoke(main, ["run", *words, *FLOWN, "--study", str(STUDY)]).exit_code == 0
    return folder


@pytest.fixture
def flown(campaign: Path, copy: Path, tmp_path: Path) -> Path:
    """A study of one's own with that campaign."""
    shutil.copytree(campaign, tmp_path / "campaign")
    return copy


def accept(study: Path, mutant: str, expires: str = "2099-01-01", more: str = "") -> None:
    path = study / "hazop" / "dispositions.yaml"
    entry = f"{mutant}: {{status: accepted, owner: me, reason: why, expires: {expires}{more}}}\n"
    path.write_text((path.read_text() if path.exists() else "") + entry)


def states(call: Call, study: Path, *words: str) -> dict[str, str]:
    told = json.loads(call("dispositions", "--format", "json", *words, study=study).stdout)
    return {row["mutant"]: row["state"] for row in told["survivors"]}


def test_survivors_stand_beside_what_was_accepted(call: Call, flown: Path):
    assert states(call, flown) == {"MORE-goal@0.6m": "open"}
    accept(flown, "MORE-goal")
    accept(flown, "LATE-human")
    assert states(call, flown) == {"MORE-goal@0.6m": "accepted", "LATE-human@3s": "stale"}
    assert states(call, flown, "--today", "2099-01-02") == {"MORE-goal@0.6m": "expired", "LATE-human@3s": "stale"}


def test_what_is_written_is_refused_until_somebody_has_decided(call: Call, flown: Path):
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


def test_writing_keeps_what_stands_there_with_its_comments(call: Call, flown: Path):
    accept(flown, "LATE-human")
    path = flown / "hazop" / "dispositions.yaml"
    path.write_text("# mine\n" + path.read_text())
    before = path.read_text()
    assert call("dispositions", "--write", study=flown).exit_code == 0
    assert path.read_text().startswith(before)
    assert "\nMORE-goal@0.6m:\n" in path.read_text()


def test_the_rest_of_the_study_works_beside_a_file_that_is_not_filled_in(call: Call, flown: Path):
    assert call("dispositions", "--write", study=flown).exit_code == 0
    assert call("run", "--mutant", "LATE-human", *FLOWN, study=flown).exit_code == 0
    assert call("score", study=flown).exit_code == 0
    assert call("score", "--ratchet", study=flown).exit_code == 2


@pytest.mark.parametrize(
    ("accepted", "more", "words", "code", "said"),
    [
        ((), "", (), 3, "ratchet: MORE-goal@0.6m is not detected (tested in T0O0W0D0H0, T0O0W0D0H1) and not accepted"),
        (("MORE-goal",), "", (), 0, ""),
        (("MORE-goal",), "", ("--today", "2099-01-01"), 0, ""),
        (("MORE-goal",), "", ("--today", "2099-01-02"), 3, "its disposition expired on 2099-01-01"),
        (("MORE-goal",), ", situations: [T0O0W0D0H0]", (), 3, "survives in T0O0W0D0H1, which its disposition does not"),
        (("MORE-goal", "LATE-human"), "", (), 0, "warning: LATE-human@3s is detected now; its disposition can go"),
        (("MORE-goal",), "", ("--fail-under", "1"), 3, "below --fail-under 1"),
    ],
)
def test_the_ratchet_fails_on_a_survivor_that_nobody_accepts_today(
    call: Call, flown: Path, accepted: tuple[str, ...], more: str, words: tuple[str, ...], code: int, said: str
):
    for mutant in accepted:
        accept(flown, mutant, more=more)
    done = call("score", "--ratchet", *words, study=flown)
    assert done.exit_code == code
    assert said in done.stderr
    assert "by safety requirements" in done.stdout
    assert ("ratchet: " in done.stderr) == (code == 3 and "--fail-under" not in words)


def test_a_campaign_in_which_nothing_was_tested_passes_no_ratchet(call: Call, flown: Path):
    words = ("--campaign", f"{flown}/other", "--study", str(flown))
    assert call("run", "--mutant", "NO-goal", *FLOWN, *words, campaign=False).exit_code == 0
    done = call("score", "--ratchet", *words, campaign=False)
    assert done.exit_code == 3
    assert "nothing to hold" in done.stderr


def test_an_undecided_mutant_is_a_survivor_whose_verdict_is_told(call: Call, flown: Path):
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
):
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


def test_every_sentence_names_the_mutant_and_what_to_do():
    known = Disposition("LATE-human@3s", "me", "why", date(2027, 1, 31), ("D0",), "f.yaml:3")
    for state in Standing:
        judged = Judged("LATE-human@3s", state, ("D0", "D1"), None if state is Standing.OPEN else known)
        assert "LATE-human@3s" in complaint(judged)
        assert state is Standing.OPEN or "f.yaml:3" in complaint(judged)
