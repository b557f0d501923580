from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from scaloft_fi.cli import GROUPS, VERBS, Pipeline, main
from scaloft_fi.errors import GateError, InputError, ScaloftError
from scaloft_fi.version import __version__

ROOT = Path(__file__).parents[2]


def _call(*words: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(main, list(words), catch_exceptions=False)
    return result.exit_code, result.stdout, result.stderr


def _verb(monkeypatch: pytest.MonkeyPatch, raising: BaseException) -> None:
    def fail() -> None:
        raise raising

    command = click.Command("matrix", callback=fail)
    monkeypatch.setattr(Pipeline, "get_command", lambda *_: command)


def test_the_version_is_told() -> None:
    assert _call("--version") == (0, f"scaloft-fi {__version__}\n", "")


@pytest.mark.parametrize("words", [(), ("--help",), ("-h",)])
def test_help_lists_the_groups_and_their_verbs_in_order(words: tuple[str, ...]) -> None:
    code, out, _ = _call(*words)
    told = [name for heading, verbs in GROUPS.items() for name in (f"{heading}:", *(f"  {verb} " for verb in verbs))]
    places = [out.index(f"\n{name}", out.index(next(iter(GROUPS))) - 1) for name in told]
    assert code == 0
    assert places == sorted(places)


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_help(verb: str) -> None:
    code, out, _ = _call(verb, "--help")
    assert code == 0
    assert ("--study DIR" in out) == (verb not in ("new", "completion")), "every other verb works on a study"


def test_an_unknown_verb_names_the_nearest() -> None:
    code, out, err = _call("matrx")
    assert (code, out) == (2, "")
    assert err == "error: scaloft-fi: no verb 'matrx'; did you mean 'matrix'?; see scaloft-fi --help\n"


def test_an_option_without_its_value_names_the_verb() -> None:
    code, out, err = _call("run", "--mutant")
    assert (code, out) == (2, "")
    assert err == "error: scaloft-fi run: option '--mutant' requires an argument; see scaloft-fi run --help\n"


def test_a_study_that_is_named_like_an_argument_is_told_its_option(tmp_path: Path) -> None:
    code, _, err = _call("check", str(tmp_path))
    assert code == 2
    assert f"unexpected extra argument ({tmp_path}); a study is named by --study {tmp_path}; see" in err


def test_an_unknown_option_is_one_sentence() -> None:
    code, _, err = _call("run", "--mutants", "LATE-human")
    assert code == 2
    assert err.count("\n") == 1
    assert "--mutant" in err


@pytest.mark.parametrize(
    ("raised", "code", "said"),
    [
        (InputError("a:1: b=2 must be 3"), 2, "error: a:1: b=2 must be 3\n"),
        (GateError("PLACEBO differs"), 4, "error: PLACEBO differs\n"),
        (ScaloftError("lost"), 70, "error: lost\n"),
        (KeyboardInterrupt(), 130, "\nerror: interrupted\n"),
        (ValueError("odd\nvalue"), 70, "error: internal error: ValueError: odd value (SCALOFT_DEBUG=1 shows where)\n"),
    ],
)
def test_an_error_is_one_sentence_and_an_exit_code(
    monkeypatch: pytest.MonkeyPatch, raised: BaseException, code: int, said: str
) -> None:
    monkeypatch.delenv("SCALOFT_DEBUG", raising=False)
    _verb(monkeypatch, raised)
    assert _call("matrix") == (code, "", said)


def test_debugging_shows_where(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SCALOFT_DEBUG", "1")
    _verb(monkeypatch, ValueError("odd"))
    code, _, err = _call("matrix")
    assert code == 70
    assert "Traceback" in err


def test_the_matrix_starts_without_numpy() -> None:
    program = (
        "import sys; from scaloft_fi.cli import main; sys.argv = ['scaloft-fi', 'matrix']\n"
        "try: main()\n"
        "except SystemExit as done: assert done.code == 0\n"
        "heavy = {'numpy', 'numba', 'pybullet', 'scipy', 'sqlite3'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_closed_pipe_is_no_error() -> None:
    command = f"{sys.executable} -m scaloft_fi matrix | head -1"
    done = subprocess.run(["bash", "-c", command], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stderr == ""
