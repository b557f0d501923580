"""The command line on the reference study, with a flyer that needs no physics."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import Result
from paper_flyer import Paper, Whole
from papers import flight
from printed import STUDY, Call, invoked
from studies import copied

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

NO_CAMPAIGN = (
    "mutants",
    "compare",
    "diff",
    "doctor",
    "signals",
    "seams",
    "operators",
    "axes",
    "map",
    "schema",
    "check",
    "judge",
)


@pytest.fixture
def paper(monkeypatch: pytest.MonkeyPatch) -> Paper:
    flyer = Paper()
    monkeypatch.setattr("scaloft_fi.campaign.flights.physics.Physics", lambda: flyer)
    return flyer


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, paper: Paper) -> Call:
    """Call the command in an empty folder, on the reference study, with a campaign of its own."""
    monkeypatch.chdir(tmp_path)

    def calling(verb: str, *words: str, study: Path = STUDY, campaign: bool = True) -> Result:
        where = ["--campaign", f"{tmp_path}/campaign"] if campaign else []
        return invoked(verb, *words, "--study", str(study), *where)

    return calling


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A study of one's own: a copy of the reference study."""
    return copied(tmp_path / "study", "found.yaml")


class Papers(Whole):
    """A flyer without physics, whose flights are those of `papers`."""

    def __call__(self, study: Study, flown: Flight) -> Outcome:
        return flight(study, flown.subject.id, flown.situation.key, flown.seed)


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of a detected mutant, a survivor and a control, over two situations."""
    folder = tmp_path_factory.mktemp("forms") / "campaign"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scaloft_fi.campaign.flights.physics.Physics", Papers)
        words = ("--mutant", "LATE-human", "--mutant", "MORE-goal", "--mutant", "REVERSE-velcmd", "--situation")
        where = ("--study", str(STUDY), "--campaign", str(folder))
        asked = ("run", *words, "T0O0W0D0H?", "--seeds", "3", "--choose", "all", "--quiet", "--jobs", "1", *where)
        done = invoked(*asked, "--format", "json")
    assert done.exit_code == 0, done.output
    (folder / "run.json").write_text(done.stdout, encoding="utf-8")
    return folder


@pytest.fixture
def told(folder: Path) -> Call:
    """Call a verb on that campaign."""

    def telling(verb: str, *words: str) -> Result:
        named = [str(folder) if word == "CAMPAIGN" else word for word in words]
        where = () if verb in NO_CAMPAIGN else ("--campaign", str(folder))
        asked = [verb, *named, "--study", str(STUDY), *where]
        return invoked(*asked)

    return telling
