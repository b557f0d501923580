"""The guides in `docs/` do what they say: their files are installed as a package, their commands run on a study."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from processes import ROOT, call, install_project
from shown_commands import GUIDES, update
from studies import copied

BLOCK = re.compile(r"^```(\w+) ?(\S*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
OFTEN = {"stack", "operator"}
"""The guides that every run follows; a release follows all."""
EXAMPLES = """
from scaloft_fi.api import check_operator, operators_of
assert operators_of("clip") == ("clip", "fade")
for name in operators_of("clip"):
    assert not check_operator(name).failures, check_operator(name)
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    return copied(tmp_path / "study")


def _follow(guide: str, tmp_path: Path, study: Path) -> tuple[Path, list[str]]:
    """Do what the guide says up to its commands; returns the folder with its package installed, and the commands."""
    project, commands = tmp_path / "project", list[str]()
    for language, mark, text in BLOCK.findall((ROOT / "docs" / f"{guide}.md").read_text()):
        how, _, name = mark.partition("=")
        if language == "console":
            commands += [line.removeprefix("$ ") for line in text.splitlines()]
        elif how == "update":
            update(study / name, text)
        else:
            assert how == "file", f"a block of {guide}.md says not where it goes"
            path = (study if language == "yaml" else project) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
            if language == "python":
                (path.parent / "__init__.py").touch()
    install_project(tmp_path / "site", project)
    return tmp_path / "site", commands


@pytest.mark.flight
@pytest.mark.parametrize(
    "guide", [pytest.param(one, marks=[pytest.mark.release] * (one not in OFTEN)) for one in GUIDES]
)
def test_its_commands_run(guide: str, tmp_path: Path, study: Path):
    site, commands = _follow(guide, tmp_path, study)
    assert commands
    for command in commands:
        program, *words = shlex.split(command)
        verb = ("-m", "scaloft_fi") if program == "scaloft-fi" else ()
        done = call(site, *verb, *words, cwd=study)
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
        if guide == "stack":
            assert "it keeps its contract" in done.stdout, done.stdout


def test_the_operators_of_the_guide_do_what_their_examples_say(tmp_path: Path, study: Path):
    site, _ = _follow("operator", tmp_path, study)
    done = call(site, "-c", EXAMPLES, cwd=study)
    assert done.returncode == 0, done.stderr


def test_a_guide_is_one_page():
    lengths = {guide: len((ROOT / "docs" / f"{guide}.md").read_text().splitlines()) for guide in GUIDES}
    assert {guide: lines for guide, lines in lengths.items() if lines > 120} == {}
