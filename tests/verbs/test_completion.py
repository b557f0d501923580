"""Completion as real shells get it: bash, and zsh and fish where they are installed."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from options import as_recorded
from printed import STUDY, invoked
from processes import install

from scaloft_fi.cli import main
from scaloft_fi.study import Study
from scaloft_fi.verbs.completion import COMPLETION, answered
from scaloft_fi.verbs.listing import Listing, operator_list, seam_list
from scaloft_fi.verbs.names import OPERATOR, declared
from scaloft_fi.verbs.signals import signal_list
from scaloft_fi.verbs.situations import axis_list

BREAKS = " \t\n\"'@><=;|&(:"
"""What bash breaks words at, unless somebody changes it."""
LISTS: dict[str, Callable[[Study], Listing[Any]]] = {
    "signals": signal_list,
    "seams": seam_list,
    "operators": operator_list,
    "axes": lambda study: axis_list(study.grid),
}
needs_bash = pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")


def offered(line: str, monkeypatch: pytest.MonkeyPatch, breaks: str = "") -> list[str]:
    """What bash is answered for a line with the cursor at its end."""
    monkeypatch.setenv("COMP_LINE", line)
    monkeypatch.setenv("COMP_WORDBREAKS", breaks)
    return [entry.partition(",")[2] for entry in answered(main, "bash_complete").splitlines()]


@pytest.fixture
def complete(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], list[str]]:
    monkeypatch.chdir(STUDY)
    return lambda line: offered(f"scaloft-fi {line}", monkeypatch)


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with what completion reads of a study, and nothing else."""
    (tmp_path / "hazop").mkdir()
    (tmp_path / "sim" / "grids").mkdir(parents=True)
    (tmp_path / "mutants").mkdir()
    (tmp_path / "results" / "campaigns" / "night").mkdir(parents=True)
    (tmp_path / "sim" / "situations.yaml").write_text(
        "name: hall\naxes:\n  D: {values: [{id: 0}, {id: 1}]}\n  H: {values: [{id: 0}, {id: 1}]}\n"
        "constraints:\n  - {exclude: {D: [1], H: 1}, reason: no}\naliases: {dark: D1H0}\n"
    )
    monkeypatch.chdir(tmp_path)
    return tmp_path


def catalogue(study: Path, *ids: str) -> None:
    lines = (json.dumps({"id": id_, "guideword": id_.partition("-")[0], "parameter": "human"}) for id_ in ids)
    (study / "mutants" / "catalogue.jsonl").write_text("\n".join(lines))


LINES = (
    *("", "wor", "run --mut", "score --by g", "score --format ", "export --format ", "completion "),
    *(f"{words} LATE-hu" for words in ("run --mutant", "margin", "kills", "mutants", "seek", "matrix --cell")),
    *("kills NO-human LATE-human@3", "run --mutant NO-depth@3s#w", "matrix --guideword UN", "seek b", "run --grid "),
    *("run --situation T1O1W1D1", "kills --situation 3", "run --grid wide --situation T0O2"),
    *("run --grid paper+found --situation shows-ASWELLAS-w", "replay LATE-human@3s/T0O0W0D0H", "replay PLA"),
)


def test_verbs_options_and_the_names_of_a_study_are_completed(complete: Callable[[str], list[str]]):
    as_recorded(__file__, {line: "\n".join(complete(line)) for line in LINES})


@pytest.mark.parametrize("verb", LISTS)
def test_what_a_study_has_is_completed_without_reading_more_than_texts(verb: str, complete: Callable[[str], list[str]]):
    """Whoever declares something in another way than the sources are read for fails here."""
    of_other_stacks = set(declared(OPERATOR, "outside"))
    assert sorted(complete(f"{verb} ")) == sorted(set(LISTS[verb](Study.open(STUDY)).by_name) - of_other_stacks)


def test_what_an_installed_package_declares_is_completed_and_not_imported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(STUDY)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "declaring").mkdir()
    (tmp_path / "declaring" / "__init__.py").write_text("raise SystemExit('imported')\n")
    (tmp_path / "declaring" / "all.py").write_text('@export_format("zebra", "")\n@operator(\n    "zigzag",\n)\n')
    install(tmp_path, "declaring-package", {"all": "declaring.all"})
    assert offered("scaloft-fi export --format z", monkeypatch) == ["zebra"]
    assert offered("scaloft-fi operators zig", monkeypatch) == ["zigzag"]


def test_campaigns_grids_and_excluded_situations_of_a_study_of_ones_own(small: Path, monkeypatch: pytest.MonkeyPatch):
    for words in ("score --campaign ", "diff ", "diff night ", "merge ", "run --baseline-from "):
        assert offered(f"scaloft-fi {words}", monkeypatch) == ["night"]
    assert offered("scaloft-fi run --situation ", monkeypatch) == ["D0H0", "D0H1", "D1H0", "dark"]
    monkeypatch.chdir("/")
    assert offered(f"scaloft-fi score --study {small} --campaign n", monkeypatch) == ["night"]


def test_what_bash_takes_for_an_earlier_word_is_left_out(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(STUDY)
    assert offered("scaloft-fi run --mutant LATE-human@", monkeypatch, BREAKS) == ["0.5s", "1s", "3s", "5s"]
    assert offered("scaloft-fi run --mutant=LATE-human@3", monkeypatch, BREAKS) == ["3s"]


@needs_bash
@pytest.mark.parametrize(
    ("line", "replies"), [("scaloft-fi run --mutant LATE-human@3", ["3s"]), ("scaloft-fi wor", ["worksheet"])]
)
def test_a_bash_that_sourced_the_script_completes(tmp_path: Path, line: str, replies: list[str]):
    assert _in_bash(tmp_path, line, STUDY).splitlines() == replies


@needs_bash
def test_hostile_names_do_nothing_in_a_bash(small: Path):
    marker = small / "done"
    evil = [
        f"$(touch {marker})",
        f"`touch {marker}`",
        f"x; touch {marker}",
        "a b",
        "*",
        "~root",
        "-e\\n",
        "\x1b[2J",
        "'",
        "é",
    ]
    catalogue(small, *evil, "NO-human@1s")
    for name in evil:
        if "/" not in name:
            (small / "results" / "campaigns" / name).mkdir()
    assert _in_bash(small, "scaloft-fi run --mutant ", small).split() == ["NO-human", "NO-human@1s"]
    assert _in_bash(small, "scaloft-fi score --campaign ", small).split() == ["night"]
    assert _in_bash(small, f"scaloft-fi run --mutant $(touch {marker})", small).split() == []
    assert not marker.exists()


def _sourced(folder: Path, shell: str) -> dict[str, str]:
    """The environment in which the program is found, with the path of its script for a shell in $SCRIPT."""
    program, script = folder / "bin" / "scaloft-fi", folder / f"script.{shell}"
    program.parent.mkdir(exist_ok=True)
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m scaloft_fi "$@"\n')
    program.chmod(0o755)
    script.write_text(_call(shell).stdout)
    path = f"{program.parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "SCRIPT": str(script), "PYTHONPATH": str(STUDY)}


def _in_bash(folder: Path, line: str, study: Path) -> str:
    """The replies of the script's function in a bash, for a line with the cursor at its end."""
    asked = (
        'source "$SCRIPT"; COMP_LINE=$LINE; COMP_POINT=${#LINE}; $(complete -p scaloft-fi | sed "s/.*-F //; s/ .*//") '
    )
    asked += 'scaloft-fi 2>/dev/null; printf "%s\\n" "${COMPREPLY[@]}"'
    env = _sourced(folder, "bash") | {"LINE": line}
    done = subprocess.run(
        ["bash", "--norc", "-c", asked], cwd=study, env=env, capture_output=True, text=True, check=True
    )
    assert done.stderr == ""
    return done.stdout


@pytest.mark.skipif(shutil.which("fish") is None, reason="there is no fish")
def test_a_fish_that_sourced_the_script_completes(tmp_path: Path):
    asked = 'source $SCRIPT; complete -C "scaloft-fi run --mutant LATE-human@3"; complete -C "scaloft-fi seams pr"'
    words = ["fish", "--no-config", "-c", asked]
    done = subprocess.run(words, cwd=STUDY, env=_sourced(tmp_path, "fish"), capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["LATE-human@3s", "proximity"]
    assert done.stderr == ""


@pytest.mark.parametrize("spoilt", ["mutants/catalogue.jsonl", "sim/situations.yaml", "sim/found.yaml"])
def test_a_broken_study_has_no_names_and_nothing_is_said_of_it(
    small: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], spoilt: str
):
    (small / spoilt).write_bytes(b"\xff{[")
    for line in ("run --mutant ", "run --situation ", "run --grid ", "run --grid hall+found --situation s", "replay x"):
        offered(f"scaloft-fi {line}", monkeypatch)
    assert offered("scaloft-fi bogus ", monkeypatch) == []
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_are_answered_in_their_own_way(shell: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(STUDY)
    monkeypatch.setenv("COMP_WORDS", "scaloft-fi run --mutant LATE-human@")
    monkeypatch.setenv("COMP_CWORD", "LATE-human@" if shell == "fish" else "3")
    assert "LATE-human@3s" in answered(main, f"{shell}_complete")


def test_the_program_itself_answers_without_numpy_and_fast(tmp_path: Path):
    """The time of the processor counts: the wall's depends on what else the machine does."""
    line = "scaloft-fi run --mutant LATE-human@3"
    env = {**os.environ, COMPLETION: "bash_complete", "COMP_LINE": line, "PYTHONPATH": str(STUDY)}
    program = (
        "import sys, time, atexit\n"
        "atexit.register(lambda: print(time.process_time(), 'numpy' in sys.modules))\n"
        "from scaloft_fi.cli import main\nmain()"
    )
    words = [sys.executable, "-c", program]
    done = [subprocess.run(words, cwd=STUDY, env=env, capture_output=True, text=True, check=True) for _ in range(3)]
    told = [one.stdout.replace("plain,LATE-human@3s", "").split() for one in done]
    assert [numpy for _, numpy in told] == ["False"] * 3
    assert min(float(seconds) for seconds, _ in told) < 0.3


def test_a_shell_that_is_not_known_is_refused():
    assert answered(main, "tcsh_complete") == answered(main, "bash_source") == answered(main, "") == ""


def _call(shell: str) -> Result:
    return invoked("completion", shell)
