"""Programs of a study's own: they are named before they start, refused by `--untrusted`, never started by who reads."""

from __future__ import annotations

import io
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import crafted
import pytest
from click.testing import Result
from printed import invoked
from processes import ROOT, marked, soon
from studies import copied, edit_in, example

from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.cli import main
from scaloft_fi.errors import ExitCode, InputError
from scaloft_fi.outside.exchange import FlightFolder, Processes
from scaloft_fi.study import Study
from scaloft_fi.verbs import VERBS, options

FLOWN = "baseline/T0O0W0D0H1/0"
FLIES = {
    "run": ("--mutant", "LATE-human"),
    "margin": ("LATE-human",),
    "seek": ("LATE-human", "--grid", "paper"),
    "propose": ("LATE-human",),
    "suite": ("suite.yaml",),
    "replay": (FLOWN,),
    "check": ("--fly",),
}
"""The verbs that fly a study, with words that make them fly."""
READS = {
    "new": ("another",),
    "margin": ("LATE-human", "--when"),
    "merge": ("results/campaigns/default",),
    "export": ("--output", "flights.json"),
    "judge": ("record.csv",),
    "hazop": ("import", "sheet.csv"),
    **dict.fromkeys(("compare", "diff"), ("default", "default")),
    "mutants": ("--write",),
    "report": ("--output", "report.html"),
    "doctor": ("--no-flight",),
    "completion": ("bash",),
}
"""Words of the verbs that fly nothing, where they need some."""
REFUSED = ("judge", "margin", "hazop")
"""The verbs that find nothing to read here: a record, flights of several magnitudes, a sheet."""


@pytest.fixture(scope="session")
def outside(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study with a stage of its own, and a campaign."""
    folder = tmp_path_factory.mktemp("trust") / "study"
    example("outside_planner", folder)
    store = folder / "results" / "campaigns" / "default" / STORE_NAME
    store.parent.mkdir(parents=True)
    crafted.campaign(Study.open(folder), store)
    return folder


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A file that is there once anything was about to start a program."""
    file = tmp_path / "started"

    def start(*_: object) -> None:
        file.touch()
        raise AssertionError

    monkeypatch.setattr(Processes, "start", start)
    monkeypatch.setattr(FlightFolder, "__init__", start)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    return file


def call(study: Path, verb: str, *words: str) -> Result:
    takes_study = any(parameter.name in ("study", "study_folder") for parameter in main.get_command(None, verb).params)
    return invoked(verb, *words, *(["--study", str(study)] if takes_study else []))


@pytest.mark.parametrize("verb", FLIES)
def test_untrusted_refuses_a_study_with_programs_and_names_them(outside: Path, started: Path, verb: str):
    told = call(outside, verb, *FLIES[verb], "--untrusted")
    assert told.exit_code == ExitCode.BAD_INPUT
    sentence = told.stderr.splitlines()[-1]
    assert sentence.startswith(f"error: --untrusted refuses that {outside} starts programs of its own: ")
    assert "{python} {study}/sim/over_lines.py" in sentence
    assert not started.exists()


@pytest.mark.parametrize("verb", [verb for verb in VERBS if verb not in FLIES or verb in (*READS, "check")])
def test_a_verb_that_reads_starts_no_program_and_asks_nothing(
    outside: Path, started: Path, verb: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    shutil.copytree(outside, tmp_path / "study")
    monkeypatch.chdir(tmp_path / "study")
    told = call(tmp_path / "study", verb, *READS.get(verb, ()))
    assert told.exit_code == (ExitCode.BAD_INPUT if verb in REFUSED else ExitCode.DONE), told.output
    assert "programs of its own" not in told.stderr
    assert not started.exists()


class Terminal(io.StringIO):
    """A terminal, as far as the question asks."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def asked(started: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], list[str]]:
    """Allow a study on a terminal where a person answers so; the questions that were asked."""

    def allow(study: Path, *, says: bool) -> list[str]:
        questions: list[str] = []
        monkeypatch.setattr(sys, "stdin", Terminal())
        monkeypatch.setattr(sys, "stderr", Terminal())
        monkeypatch.setattr(options.click, "confirm", lambda text, **_: questions.append(text) or says)
        options.allow(Study.open(study), untrusted=False)
        return questions

    return allow


def test_a_terminal_asks_once_for_a_folder_and_its_commands(
    outside: Path, asked: Callable[..., list[str]], tmp_path: Path
):
    with pytest.raises(InputError, match="its programs were not allowed, so nothing was flown"):
        asked(outside, says=False)
    assert asked(outside, says=True) == ["Start them, now and whenever this study flies?"]
    assert asked(outside, says=False) == []
    (tmp_path / "link").symlink_to(outside)
    assert asked(tmp_path / "link", says=False) == []
    shutil.copytree(outside, tmp_path / "copy")
    assert len(asked(tmp_path / "copy", says=True)) == 1, "another folder"
    edit_in(tmp_path / "copy" / "sim" / "stack.yaml", "sim/over_lines.py", "sim/other.py")
    assert len(asked(tmp_path / "copy", says=True)) == 1, "another command"
    assert asked(outside, says=False) == []


def test_without_a_terminal_the_programs_are_named_in_a_line(
    outside: Path, started: Path, capsys: pytest.CaptureFixture[str]
):
    options.allow(Study.open(outside), untrusted=False)
    (told,) = capsys.readouterr().err.splitlines()
    assert told.startswith(f"study: {outside} starts programs of its own: {{python}} {{study}}/sim/over_lines.py ")
    options.allow(Study.open(ROOT), untrusted=True)
    assert capsys.readouterr().err == ""


def test_a_command_that_flies_is_named_with_its_environment(tmp_path: Path, started: Path):
    copied(tmp_path / "study")
    flyer = """\
flyer: command
run: ["{python}", fly it.py, "{record}", "{fault}"]
env: {WHERE: "a b"}
record: flight.csv
limit_s: 10
seams: {every: {parameter: true}}
"""
    (tmp_path / "study" / "sim" / "flyer.yaml").write_text(flyer)
    with pytest.raises(InputError, match=r"WHERE='a b' \{python\} 'fly it.py' \{record\} \{fault\}$"):
        options.allow(Study.open(tmp_path / "study"), untrusted=True)


KILLS = [("replay", signal.SIGKILL), ("run", signal.SIGTERM), ("replay", signal.SIGTERM), ("run", signal.SIGKILL)]


@pytest.mark.flight
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks through /proc")
@pytest.mark.parametrize(
    ("verb", "number"), [KILLS[0], *(pytest.param(*each, marks=pytest.mark.release) for each in KILLS[1:])]
)
def test_no_folder_and_no_process_stays_after_a_signal(
    outside: Path, tmp_path: Path, verb: str, number: signal.Signals
):
    shutil.copytree(outside, tmp_path / "study")
    (tmp_path / "study" / "sim" / "over_lines.py").write_text("import time; time.sleep(60)")
    edit_in(tmp_path / "study" / "sim" / "stack.yaml", "ready_s: 20.0", "ready_s: 3.0")
    folder, mark = tmp_path / "tmp", str(tmp_path)
    folder.mkdir()
    words = [sys.executable, "-m", "scaloft_fi", verb, *FLIES[verb], "--study", str(tmp_path / "study")]
    path = os.pathsep.join([str(ROOT), *filter(None, sys.path)])
    environment = {**os.environ, "TMPDIR": str(folder), "MARK": mark, "PYTHONPATH": path}
    nothing = subprocess.DEVNULL
    with subprocess.Popen(words, env=environment, stdin=nothing, stdout=nothing, stderr=nothing) as process:
        assert soon(lambda: any(folder.glob("scaloft-*/output")), 120.0)
        process.send_signal(number)
    assert soon(lambda: marked(mark) == []), marked(mark)
    assert list(folder.iterdir()) == []
