"""Two stacks with different seams in one process do not disturb each other."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from plugins import ROOT, call, install_project

PROGRAM = """
import json, sys
from scaloft_fi.campaign.flights.fly import fly_log
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

def digests(study, mutant, situation):
    place = study.grid.situation(situation)
    subjects = (None, realise(study.matrix, mutant))
    return [fly_log(study, Flight(subject, place, 0)).digest for subject in subjects]

own, reference = Study.open(sys.argv[1]), Study.open(sys.argv[2])
print(json.dumps({
    "seams": [sorted(own.stack.by_name), sorted(reference.stack.by_name)],
    "before": digests(own, "LATE-range", "O1D0"),
    "between": digests(reference, "LATE-human", "T0O0W0D0H1"),
    "after": digests(own, "LATE-range", "O1D0"),
    "again": digests(reference, "LATE-human", "T0O0W0D0H1"),
}))
"""


@pytest.mark.flight
def test_each_flies_as_it_does_alone_whatever_flew_before(tmp_path: Path) -> None:
    install_project(tmp_path, ROOT / "examples" / "own_stack")
    done = call(tmp_path, "-c", PROGRAM, ROOT / "examples" / "own_stack" / "study", ROOT, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout.splitlines()[-1])
    own, reference = answer["seams"]
    assert not set(own) & set(reference)
    assert answer["before"] == answer["after"]
    assert answer["between"] == answer["again"]
    assert len({*answer["before"], *answer["between"]}) == 4
