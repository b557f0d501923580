"""Killed or not, in PyBullet: the answers and the kills are those of whole flights."""

from __future__ import annotations

from pathlib import Path

import pytest

from scaloft_fi.campaign.plan.plan import plan
from scaloft_fi.campaign.progress.progress import Silence
from scaloft_fi.campaign.runs.first_kill import first_kills
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.run import run
from scaloft_fi.mutants.derive import realise
from scaloft_fi.results.flights import flights_of
from scaloft_fi.results.status import Status
from scaloft_fi.study import Study

pytestmark = pytest.mark.flight

MUTANTS = ("UNINTENDED-collision@20s", "MORE-goal@1m", "REVERSE-velcmd", "LATE-battery")


def test_the_first_kill_of_a_cut_flight_is_that_of_the_whole_one(tmp_path: Path) -> None:
    study = Study.open(Path(__file__).parents[3])
    mutants = [realise(study.matrix, name) for name in MUTANTS]
    planned = plan(study.grid.select(["T0O0W0D0H0", "T0O1W0D0H0"]), (0,), mutants, None)
    options = RunOptions(jobs=2, max_invalid=1.0)
    found = first_kills(study, planned, tmp_path / "few", options, progress=Silence())
    report = run(study, planned, tmp_path / "all", options, progress=Silence())
    whole = {flight.outcome.name: flight for flight in flights_of(report.outcomes)}
    killed = {flight.outcome.mutant for flight in whole.values() if flight.status is Status.KILLED and flight.eligible}
    killed.discard("PLACEBO")
    assert {answer.subject.id for answer in found.answers if answer.killed} == killed
    kills = [answer for answer in found.answers if answer.kill is not None]
    assert kills
    for answer in kills:
        assert answer.kill is not None
        twin = whole[answer.kill.outcome.name]
        assert answer.requirement == (twin.kills or twin.operability_kills)[0]
        assert answer.t_s == twin.killed_at_s
        assert answer.kill.outcome.duration_s <= twin.outcome.duration_s
