"""The guides in `docs/` do what they say, word for word, from an empty folder on."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from subprocess import CompletedProcess

import pytest
from processes import ROOT, call, install_project
from shown_commands import GUIDES, update

BLOCK = re.compile(r"^```(\w+) ?(\S*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
OFTEN = {"stack", "operator"}
"""The guides that every run follows; a release follows all."""
EXAMPLES = """
from scaloft_fi.api import check_operator, operators_of
assert operators_of("clip") == ("clip", "fade")
for name in operators_of("clip"):
    assert not check_operator(name).failures, check_operator(name)
"""


def _follow(guide: str, folder: Path) -> Iterator[tuple[str, CompletedProcess[str]]]:
    """Do what a guide says, word for word, in an empty folder; gives each command that is called, and what it did."""
    site, cwd = folder / "site", folder
    for language, mark, text in BLOCK.findall((ROOT / "docs" / f"{guide}.md").read_text()):
        how, _, name = mark.partition("=")
        if how == "update":
            update(folder / name, text)
        elif how == "file":
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text)
            if language == "python":
                (folder / name).with_name("__init__.py").touch()  # pip needs none, a link to the folder does
        for command in text.splitlines() if language == "console" else ():
            program, *words = shlex.split(command.removeprefix("$ "))
            if program == "cd":
                cwd /= words[0]
            elif program == "pip":
                assert words[:2] == ["install", "-e"], command
                install_project(site, cwd / words[2])
            else:
                verb = ("-m", "scaloft_fi") if program == "scaloft-fi" else ()
                yield command, call(site, *verb, *words, cwd=cwd)


@pytest.mark.flight
@pytest.mark.parametrize(
    "guide", [pytest.param(one, marks=[pytest.mark.release] * (one not in OFTEN)) for one in GUIDES]
)
def test_its_commands_run(guide: str, tmp_path: Path):
    done = list(_follow(guide, tmp_path))
    assert done[0][0] == "$ scaloft-fi new my_mine"
    assert len(done) > 1
    assert [f"{command}\n{of.stdout}{of.stderr}" for command, of in done if of.returncode] == []
    if guide == "stack":
        assert "it keeps its contract" in done[-1][1].stdout


def test_the_operators_of_the_guide_do_what_their_examples_say(tmp_path: Path):
    assert list(_follow("operator", tmp_path))
    done = call(tmp_path / "site", "-c", EXAMPLES, cwd=tmp_path)
    assert done.returncode == 0, done.stderr


def test_a_guide_is_one_page():
    lengths = {guide: len((ROOT / "docs" / f"{guide}.md").read_text().splitlines()) for guide in GUIDES}
    assert {guide: lines for guide, lines in lengths.items() if lines > 120} == {}
