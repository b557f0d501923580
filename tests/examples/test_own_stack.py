"""The example of a stack from outside: installed, checked, flown; every verb shows it without the reference stack."""

from __future__ import annotations

import csv
import io
import json
import re
import shutil
from pathlib import Path

import pytest
from options import usually
from processes import ROOT, called, install, install_project, printed

from scaloft_fi.stack.reference.declaration import SEAMS

EXAMPLE = ROOT / "examples" / "own_stack"
FOREIGN = ("scaloft_fi.stack.reference", "scaloft_fi.mutants.reference")
GUARD = f"""
import sys

class Guard:
    def find_spec(self, name, path=None, target=None):
        if name.startswith({FOREIGN!r}):
            raise AssertionError(f"{{name}} is imported")

assert not [name for name in sys.modules if name.startswith({FOREIGN!r})]
sys.meta_path.insert(0, Guard())
"""
"""A plugin that refuses the reference stack in its process: of the verb, and of each worker."""

SITUATION = "O1D0"
FLOWN = ("run", "--situation", SITUATION, "--quiet", "--all")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    install_project(folder, EXAMPLE)
    install(folder, "guard", {"guard": "guard"})
    (folder / "guard.py").write_text(GUARD)
    return folder


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(shutil.copytree(EXAMPLE / "study", tmp_path_factory.mktemp("own") / "study"))


def _verb(site: Path, study: Path, *words: str | Path) -> str:
    return printed("-m", "scaloft_fi", *words, "--study", study, site=site, cwd=study)


@pytest.fixture(scope="module")
def campaign(site: Path, study: Path) -> str:
    return _verb(site, study, *FLOWN)


def test_the_six_cells_are_read_and_their_catalogue_is_current(site: Path, study: Path):
    assert "2 parameters x 3 guidewords = 6 cells: 4 credible, 1 control, 1 not meaningful" in _verb(
        site, study, "matrix"
    )
    assert "current, 9 mutants of 5 cells" in _verb(site, study, "mutants", "--check")


def test_its_seams_are_its_own(site: Path, study: Path):
    code = "from scaloft_fi.api import Study; print(*Study.open('.').stack.by_name)"
    seams = set(printed("-c", code, site=site, cwd=study).split())

    assert seams == {"gyro", "place", "height", "sight", "range", "drive", "rotors"}
    assert not seams & {seam.name for seam in SEAMS}


@pytest.mark.release
@pytest.mark.flight
def test_it_keeps_its_contract(site: Path, study: Path):
    code = f"from scaloft_fi.api import check_stack; print(check_stack('.', situation={SITUATION!r}))"
    assert "it keeps its contract" in printed("-c", code, site=site, cwd=study)


@pytest.mark.release
@pytest.mark.flight
def test_a_run_scores_it_and_its_control_shows_itself(campaign: str):
    assert "Controls, in no ratio: 1 of 1 show" in campaign
    assert re.search(r"REVERSE-drive .*SR2", campaign), campaign
    assert "1 situations with a pool it holds steadily SR1 in 1, SR2 in 1" in campaign


VERBS = [
    ("matrix", "--cell", "LATE-drive"),
    ("matrix", "--margins"),
    ("mutants", "LATE-drive"),
    ("mutants", "--format", "csv"),
    ("status",),
    ("score",),
    ("score", "--all"),
    ("worksheet",),
    ("dispositions",),
    ("kills",),
    ("kills", "LATE-drive"),
    ("kills", "--show", "survivors"),
    ("coverage",),
    ("export", "--format", "csv"),
    ("export", "--format", "gsn"),
    ("export", "--format", "json"),
    ("export", "--format", "junit"),
    ("export", "--format", "mutation-testing"),
    ("export", "--format", "sace"),
    ("export", "--format", "sarif"),
    ("export", "--format", "verdicts"),
    ("report", "--output", "page.html"),
    ("replay", f"LATE-drive@1s/{SITUATION}/0", "--output", "map.svg"),
    ("merge", "results/campaigns/default", "--campaign", "whole"),
    ("diff", "default", "whole"),
    *usually((), release=(("margin", "LATE-range", "--situation", SITUATION, "--campaign", "margins"),)),
]


@pytest.fixture(scope="module")
def told(site: Path, study: Path, campaign: str) -> dict[str, tuple[int, str]]:
    """By verb, its exit code and what it printed."""
    return {" ".join(words): said for words, said in zip(VERBS, called(site, *VERBS, cwd=study), strict=True)}


@pytest.mark.release
@pytest.mark.flight
def test_every_verb_runs_without_the_reference_stack(told: dict[str, tuple[int, str]], study: Path):
    assert {words: said for words, said in told.items() if said[0] != 0} == {}
    late = next(row for row in json.loads(told["export --format json"][1]) if row["mutant"] == "LATE-drive@1s")
    assert late["status"] == "revealed"  # a delay reaches the flight on its own seam
    assert late["altered"] > 0
    rows = list(csv.reader(io.StringIO(told["export --format verdicts"][1])))  # its own format
    assert [mutant for mutant, _ in rows] == ["MORE-range@1.5m", "LATE-range@2s", "MORE-drive@3x", "LATE-drive@1s"]
    assert "flies leg home" in (study / "map.svg").read_text()  # what its beliefs mark
    assert "0 differ" in told["diff default whole"][1]


TWO = """
import json, sys
from scaloft_fi.campaign.flights.fly import fly_log
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

def digest(study, mutant, situation):
    return fly_log(study, Flight(realise(study.matrix, mutant), study.grid.situation(situation), 0)).digest

own, reference = Study.open(sys.argv[1]), Study.open(sys.argv[2])
print(json.dumps({
    "seams": [sorted(own.stack.by_name), sorted(reference.stack.by_name)],
    "before": digest(own, "LATE-range", "O1D0"),
    "between": digest(reference, "LATE-human", "T0O0W0D0H1"),
    "after": digest(own, "LATE-range", "O1D0"),
    "again": digest(reference, "LATE-human", "T0O0W0D0H1"),
}))
"""


@pytest.mark.release
@pytest.mark.flight
def test_two_stacks_in_one_process_fly_as_each_does_alone(tmp_path: Path):
    install_project(tmp_path, EXAMPLE)
    answer = json.loads(printed("-c", TWO, EXAMPLE / "study", ROOT, site=tmp_path).splitlines()[-1])
    own, reference = answer["seams"]
    assert not set(own) & set(reference)
    assert answer["before"] == answer["after"]
    assert answer["between"] == answer["again"]
    assert answer["before"] != answer["between"]
