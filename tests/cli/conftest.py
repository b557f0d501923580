"""The command line on the reference study, with a flyer that needs no physics."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from scaloft_fi.campaign.plan.batch import Batch
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.cli.main import main
from scaloft_fi.judge.outcome import BASELINE, Outcome, Violation
from scaloft_fi.judge.requirement import Reading
from scaloft_fi.study import Study

STUDY = Path(__file__).parents[2]


@dataclass
class Paper:
    """A flyer whose verdicts are a rule: controls strike the wall, LATE-human is too fast where a person is."""

    tame: bool = False

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        pass

    def share(self, study: Study, batch: Batch, home: Callable[[Outcome], None]) -> None:
        for flight in batch.flights:
            home(self(study, flight))

    def __call__(self, study: Study, flight: Flight, baseline: Outcome | None = None) -> Outcome:
        subject, key = flight.subject, flight.situation.key
        control = subject.guideword == "REVERSE"
        late = subject.guideword == "LATE" and key.endswith("H1")
        violated = {"SR1": 5.0} if control and not self.tame else {"SR2": 8.0} if late else {}
        altered = 3 if control or late else 0
        readings = tuple(
            Reading(r.name, r.kind, -1.0 if r.name in violated else 1.0, violated.get(r.name), 1, open=False)
            for r in study.requirements
        )
        kinds = {r.name: r.kind for r in study.requirements}
        return Outcome(
            subject,
            key,
            flight.seed,
            ending="landed",
            readings=readings,
            violations=tuple(Violation(name, kinds[name], t, 0.0, 1.0, 1.6, "") for name, t in violated.items()),
            carried=0 if subject.id == BASELINE else 10,
            altered=altered,
            infected_at_s=1.0 if altered else None,
            duration_s=40.0,
            digest=f"{subject.id if altered else ''}{key}{flight.seed}",
            perceived_digest="p",
            realised=tuple((axis.id, True) for axis in study.grid.axes) if subject.id == BASELINE else (),
        )


@pytest.fixture
def paper(monkeypatch: pytest.MonkeyPatch) -> Paper:
    flyer = Paper()
    monkeypatch.setattr("scaloft_fi.campaign.runs.campaign.Physics", lambda: flyer)
    return flyer


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, paper: Paper) -> Callable[..., Result]:
    """Call the command in an empty folder, on the reference study, with a campaign of its own."""
    monkeypatch.chdir(tmp_path)

    def calling(verb: str, *words: str, study: Path = STUDY, campaign: bool = True) -> Result:
        where = ["--campaign", f"{tmp_path}/campaign"] if campaign else []
        return CliRunner().invoke(main, [verb, *words, "--study", str(study), *where], catch_exceptions=False)

    return calling


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A study of one's own: a copy of the reference study."""
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(STUDY / name, tmp_path / "study" / name, ignore=shutil.ignore_patterns("found.yaml"))
    return tmp_path / "study"
