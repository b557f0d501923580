"""The example of a simulator of one's own: flown by the command and judged from its record, as the built-in flyer."""

from __future__ import annotations

import re
import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from options import usually
from processes import ROOT, call
from studies import RECORDS, own_simulator

from scaloft_fi.campaign.flights.fly import fly_log, judged
from scaloft_fi.campaign.flights.physics import Commanded
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.outside.command import load_command
from scaloft_fi.outside.records import load_record_map
from scaloft_fi.study import Study

VIOLATES = {
    "baseline/T1O0W0D1H0/0": True,
    "PLACEBO/T0O0W0D0H1/0": False,
    "LATE-human@3s/T0O0W0D0H1/0": True,
    "REVERSE-velcmd/T0O0W0D0H0/0": True,
}
MUTANTS = ("baseline", "PLACEBO", "LATE-human@3s", "UNINTENDED-collision@20s", "REVERSE-velcmd")
SITUATIONS = ("T0O0W0D0H0", "T0O0W0D0H1", "T1O0W0D1H0", "T1O1W1D0H1")
EVERY = [f"{mutant}/{situation}/0" for mutant in MUTANTS for situation in SITUATIONS]
"""Every kind of flight: nothing violated, a person passed too fast, a contact, one not landed."""
FEW_SEEDS = ["--baseline-seeds", "1"]
"""Whether a command runs shows in few flights."""


@pytest.fixture(scope="module", params=usually(RECORDS[:1], release=RECORDS))
def study(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Study:
    """The study that records a table, and the one that records a rosbag2."""
    folder = tmp_path_factory.mktemp("own") / request.param
    own_simulator(folder, request.param)
    return Study.open(folder)


def _fly(study: Study, name: str) -> Outcome:
    mutant, situation, seed = name.split("/")
    flight = flight_named(study, mutant, situation, int(seed))
    return Commanded()(study, flight) if study.command else judged(study, flight, fly_log(study, flight))


def test_the_study_can_be_flown_and_nothing_in_it_counts_as_unmet(study: Study):
    said: list[str] = []
    study.check()
    Commanded().prepare(study, said.append)
    assert said == []


@pytest.fixture(scope="module")
def ours() -> dict[str, Outcome]:
    return {name: _fly(Study.open(ROOT), name) for name in EVERY}


@pytest.mark.release
@pytest.mark.flight
def test_its_verdicts_are_those_of_the_built_in_flyer(study: Study, ours: dict[str, Outcome]):
    for name in EVERY:
        one, other = ours[name], _fly(study, name)
        assert one.readings == other.readings
        assert one.violations == other.violations
        assert (one.ending, one.struck, one.realised) == (other.ending, other.struck, other.realised)
        assert (one.carried, one.altered, one.infected_at_s) == (other.carried, other.altered, other.infected_at_s)
        assert bool(other.first_violation) == VIOLATES.get(name, bool(one.first_violation))


@pytest.mark.parametrize(
    ("guide", "key", "load"), [("own_simulator", "flyer:", load_command), ("judge", "signals:", load_record_map)]
)
def test_the_documents_of_the_guides_can_be_read(guide: str, key: str, load: Callable[[Path], object], tmp_path: Path):
    blocks = re.findall(r"^```yaml\n(.*?)^```$", (ROOT / "docs" / f"{guide}.md").read_text(), re.MULTILINE | re.DOTALL)
    assert [key in block for block in blocks] == [True]
    (tmp_path / "document.yaml").write_text(blocks[0])
    load(tmp_path / "document.yaml")


@pytest.mark.flight
@pytest.mark.release
def test_the_commands_of_the_guide_run(tmp_path: Path):
    commands = re.findall(r"^\$ (.*)$", (ROOT / "docs" / "own_simulator.md").read_text(), re.MULTILINE)
    assert commands
    for command in commands:
        program, *words = shlex.split(command)
        words += FEW_SEEDS if words[0] == "run" else []
        if program == "scaloft-fi":
            done = call(tmp_path, "-m", "scaloft_fi", *words, cwd=tmp_path)
        else:
            done = subprocess.run([program, *words], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
