"""What every verb that reads a campaign opens: one moment, fast; what is stale or asks beyond a cap is told by each."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from printed import STUDY, Call, sentence
from studies import edit_in

from scaloft_fi.campaign.store.store import Store

LATE = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
READ = (
    *(("score",), ("coverage",), ("kills",), ("worksheet",), ("dispositions",), ("matrix", "--margins")),
    *(("export", "--format", "csv"), ("export", "--format", "junit"), ("report", "--output", "page.html")),
)


def test_a_verb_opens_the_store_once_and_reads_one_moment(told: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    opened: list[Path] = []
    begin = Store.__init__

    def opening(self: Store, path: Path, *rest: object, **named: object) -> None:
        opened.append(path)
        begin(self, path, *rest, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(Store, "__init__", opening)
    for number, words in enumerate(READ, 1):
        assert told(*words).exit_code == 0
        assert len(opened) == number, words


PROGRAM = """
import json, sys
from scaloft_fi.cli import main
for words in json.loads(sys.argv[1]):
    try:
        main(words)
    except SystemExit as done:
        assert done.code == 0, words
    heavy = {"numba", "pybullet", "filterpy", "distributed", "scipy"} & set(sys.modules)
    assert not heavy, (words, heavy)
"""


def test_who_reads_results_waits_for_no_compiler(call: Call, tmp_path: Path):
    """Of flights without tracks: those are held to the time limit of their situation, which is of the simulator."""
    call(*LATE)
    where = ("--study", str(STUDY), "--campaign", f"{tmp_path}/campaign")
    commands = [[*words, *where] for words in (("status",), *READ)]
    words = [sys.executable, "-c", PROGRAM, json.dumps(commands)]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("situations.yaml", "eventually(person_sight_m <= 3)", "eventually(clearance_person_m < 1)"),
        ("requirements.yaml", "person_sight_m / 3 <= 1", "person_sight_m / 3 <= 3"),
    ],
)
def test_a_study_that_asks_a_signal_for_more_than_is_measured_of_it_is_neither_flown_nor_read(
    call: Call, copy: Path, tmp_path: Path, name: str, old: str, new: str
):
    assert call(*LATE, study=copy).exit_code == 0
    edit_in(copy / "sim" / name, old, new)
    for verb in ("score", "status", "export", "kills", "worksheet", "coverage"):
        assert "it must be compared with" in sentence(call(verb, study=copy))
    assert "it must be compared with" in sentence(call("report", "--output", f"{tmp_path}/page.html", study=copy))
    assert f"{name}:" in sentence(call(*LATE, "--campaign", f"{tmp_path}/c", study=copy, campaign=False))
    assert {path.name for path in tmp_path.iterdir()} == {"campaign", "study"}


VERBS = ("score", "kills", "coverage", "worksheet", "report")
NOTHING = {"flights": 0, "reasons": [], "command": None, "differed": [], "invalid": [], "broken": 0}


def _another_delay(call: Call, study: Path) -> None:
    arguments = "operator: delay\n      arguments: {keep_first: true}\n"
    edit_in(study / "hazop" / "matrix" / "human.yaml", "operator: delay\n", arguments)
    assert call("mutants", "--write", study=study, campaign=False).exit_code == 0


def _stale(call: Call, study: Path, *verbs: str) -> list[dict[str, Any]]:
    return [json.loads(call(verb, "--format", "json", study=study).stdout)["stale"] for verb in verbs]


def test_what_no_longer_counts_is_told_by_every_verb_until_the_command_has_flown_it_again(call: Call, copy: Path):
    call(*LATE, "--mutant", "NO-human", study=copy)
    assert _stale(call, copy, *VERBS) == [NOTHING] * len(VERBS)
    assert "no longer count" not in call("score", study=copy).output
    _another_delay(call, copy)
    stale, *others = _stale(call, copy, *VERBS)
    assert others == [stale] * len(others)
    assert (stale["flights"], stale["reasons"]) == (2, [{"why": "mutant LATE-human@3s changed", "flights": 2}])
    for verb in VERBS:
        said = " ".join(call(verb, study=copy).stderr.split())
        assert "2 stored flights no longer count: mutant LATE-human@3s changed; `scaloft-fi run " in said
    ran = call("run", "--mutant", "NO-human", "--situation", "T0O0W0D0H?", "--quiet", study=copy)
    assert "2 stored flights no longer count" in " ".join(ran.stderr.split())
    words = shlex.split(stale["command"])
    assert words[:2] == ["scaloft-fi", "run"]
    assert words[words.index("--mutant") + 1] == "LATE-human@3s"
    again = call(*words[1:], "--format", "json", "--quiet", study=copy, campaign=False)
    assert json.loads(again.stdout)["stale"] == NOTHING
    assert _stale(call, copy, "score") == [NOTHING]
    status = json.loads(call("status", "--format", "json", study=copy).stdout)
    assert (status["stale"], status["flown_again"], status["command"]) == (2, 2, None)


@pytest.mark.parametrize("seeds", [(), ("--seeds", "4-5", "--baseline-seeds", "12")])
def test_the_command_flies_stale_baselines_with_all_their_seeds(call: Call, copy: Path, seeds: tuple[str, ...]):
    def status() -> dict[str, Any]:
        return json.loads(call("status", "--format", "json", study=copy).stdout)

    call(*LATE, *seeds, study=copy)
    flights = status()["counted"]
    edit_in(copy / "sim" / "situations.yaml", "eventually(x_m < -1)", "eventually(x_m < -2)")
    stale = status()
    assert [one["why"] for one in stale["reasons"]] == ["how the situation's values come true changed"]
    assert 0 < stale["counted"] < flights
    call(*shlex.split(stale["command"])[1:], "--quiet", study=copy, campaign=False)
    assert (status()["counted"], status()["command"]) == (flights, None)


def test_what_the_study_has_no_more_is_told_without_a_command(call: Call, copy: Path):
    call(*LATE, study=copy)
    cells = copy / "hazop" / "matrix" / "human.yaml"
    before, _, after = cells.read_text().partition("\nLATE:\n")
    gone = "LATE:\n  status: not_meaningful\n  reason: Nobody is late.\n"
    cells.write_text(f"{before}\n{gone}BEFORE:\n{after.partition('BEFORE:' + chr(10))[2]}")
    call("mutants", "--write", study=copy, campaign=False)
    (stale,) = _stale(call, copy, "score")
    assert (stale["flights"], stale["command"]) == (2, None)
    said = " ".join(call("score", study=copy).stderr.split())
    assert "mutant LATE-human@3s is not in the matrix any more; the study has no such flight any more" in said
