"""Flights that no longer count are told by every verb that reads a campaign, with the command that flies them again."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result

Call = Callable[..., Result]
VERBS = ("score", "kills", "coverage", "worksheet", "report")
HERE = ("--situation", "T0O0W0D0H?")


def _edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def _another_delay(call: Call, study: Path) -> None:
    arguments = "operator: delay\n      arguments: {keep_first: true}\n"
    _edit(study / "hazop" / "matrix" / "human.yaml", "operator: delay\n", arguments)
    assert call("mutants", "--write", study=study, campaign=False).exit_code == 0


def _told(call: Call, study: Path, verbs: Iterable[str] = VERBS) -> list[dict[str, Any]]:
    return [json.loads(call(verb, "--format", "json", study=study).stdout)["stale"] for verb in verbs]


def test_what_no_longer_counts_is_told_by_every_verb_until_the_command_has_flown_it_again(
    call: Call, copy: Path
) -> None:
    call("run", "--mutant", "LATE-human", "--mutant", "NO-human", *HERE, "--quiet", study=copy)
    nothing = {"flights": 0, "reasons": [], "command": None}
    assert _told(call, copy) == [nothing] * len(VERBS)
    assert not [verb for verb in VERBS if "no longer count" in call(verb, study=copy).output]
    _another_delay(call, copy)
    stale, *others = _told(call, copy)
    assert others == [stale] * len(others)
    assert (stale["flights"], stale["reasons"]) == (2, [{"why": "mutant LATE-human@3s changed", "flights": 2}])
    for verb in VERBS:
        said = " ".join(call(verb, study=copy).stderr.split())
        assert "2 stored flights no longer count: mutant LATE-human@3s changed; `scaloft-fi run " in said
    words = shlex.split(stale["command"])
    assert words[:2] == ["scaloft-fi", "run"]
    assert words[words.index("--mutant") + 1] == "LATE-human@3s"
    again = call(*words[1:], "--format", "json", "--quiet", study=copy, campaign=False)
    assert json.loads(again.stdout)["stale"] == nothing
    assert _told(call, copy) == [nothing] * len(VERBS)
    status = json.loads(call("status", "--format", "json", study=copy).stdout)
    assert (status["stale"], status["flown_again"], status["command"]) == (2, 2, None)


def test_a_run_tells_what_it_left_stale(call: Call, copy: Path) -> None:
    call("run", "--mutant", "LATE-human", *HERE, "--quiet", study=copy)
    _another_delay(call, copy)
    ran = call("run", "--mutant", "NO-human", *HERE, "--quiet", study=copy)
    assert "2 stored flights no longer count" in " ".join(ran.stderr.split())


@pytest.mark.parametrize("seeds", [(), ("--seeds", "3"), ("--seeds", "4-5", "--baseline-seeds", "12")])
def test_the_command_flies_stale_baselines_with_all_their_seeds(call: Call, copy: Path, seeds: tuple[str, ...]) -> None:
    def status() -> dict[str, Any]:
        told: dict[str, Any] = json.loads(call("status", "--format", "json", study=copy).stdout)
        return told

    call("run", "--mutant", "LATE-human", *HERE, *seeds, "--quiet", study=copy)
    flights = status()["counted"]
    _edit(copy / "sim" / "situations.yaml", "eventually(x_m < -1)", "eventually(x_m < -2)")
    stale = status()
    assert [one["why"] for one in stale["reasons"]] == ["how the situation's values come true changed"]
    assert 0 < stale["counted"] < flights
    call(*shlex.split(stale["command"])[1:], "--quiet", study=copy, campaign=False)
    assert (status()["counted"], status()["command"]) == (flights, None)


def test_what_the_study_has_no_more_is_told_without_a_command(call: Call, copy: Path) -> None:
    call("run", "--mutant", "LATE-human", *HERE, "--quiet", study=copy)
    cells = copy / "hazop" / "matrix" / "human.yaml"
    before, _, after = cells.read_text().partition("\nLATE:\n")
    gone = "LATE:\n  status: not_meaningful\n  reason: Nobody is late.\n"
    cells.write_text(f"{before}\n{gone}BEFORE:\n{after.partition('BEFORE:' + chr(10))[2]}")
    call("mutants", "--write", study=copy, campaign=False)
    (stale,) = _told(call, copy, ["score"])
    assert (stale["flights"], stale["command"]) == (2, None)
    said = " ".join(call("score", study=copy).stderr.split())
    assert "mutant LATE-human@3s is not in the matrix any more; the study has no such flight any more" in said
