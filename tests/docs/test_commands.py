"""Every command that README and the site show is run by a test, or stands here with the reason why not."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import pytest
from click.exceptions import Exit
from processes import call
from shown_commands import GUIDES, Shown, named_commands, shown_commands, stray_commands
from studies import copied

from scaloft_fi.cli import command_of
from scaloft_fi.verbs import VERBS

RUN_BY_GUIDES = {f"{name}.md" for name in GUIDES}
"""The pages that `tests/test_guides.py` follows from an empty folder."""
WHOLE = {"tutorial.md"}
"""The page that `tests/docs/test_tutorial.py` follows from its first command to its last."""
PAGES = ("ci.md", "hazop_workshop.md", "judge.md")
"""The pages whose commands are run here, in their order, each in the reference study without its further grids."""
FLY = {"judge.md"}
"""Those that fly for more than some seconds: before a release."""
LONG = "it flies for minutes to hours"
ELSEWHERE = {
    "README.md": ".ci/run runs the second command word for word, and with it what the first one does",
    "archive.md": "tests/verbs/test_archive.py tries an archive, tests/views/test_table.py the tables for LaTeX",
    "check.md": "tests/checks checks studies with planted defects",
    "CONTRIBUTING.md": "they are the tests themselves",
    "cluster.md": "it needs several machines; tests/campaign/workers flies with a scheduler and workers on one",
    "firmware.md": "it needs a firmware; tests/firmware builds Betaflight and flies such a study",
    "index.md": "it is README's first command",
    "install.md": "tests/packaging installs the wheel, README's test command the clone",
    "outside.md": "tests/outside/test_outside_flights.py flies this study",
    "outside_ros1.md": "it needs ROS 1; tests/examples/test_testbed.py flies this study where it is installed",
    "outside_ros2.md": "it needs ROS 2; tests/outside/test_ros2.py flies this study where it is installed",
    "own_planner.md": "tests/examples/test_own_planner.py follows the page",
    "own_simulator.md": "tests/examples/test_own_simulator.py flies these studies",
    "own_tests.md": "tests/verbs/test_suite.py runs planted tests, tests/examples/test_own_tests.py the example",
    "trust.md": "tests/verbs/test_trust.py asks of this study",
    "requirements.md": f"{LONG}; tests/verbs/test_propose.py proposes in a small study",
    "seek.md": f"{LONG}; tests/campaign/seeking searches small grids",
}
"""Pages whose commands are not run as they stand, and why."""
NOT_RUN = {
    "pip install 'scaloft-fi'": "packages are installed by tests/packaging",
    "scaloft-fi run --budget 20m --quiet": LONG,
    "scaloft-fi export --format junit --output faults.xml": "tests/verbs/test_export.py writes it",
    "scaloft-fi export --format sarif --output faults.sarif": "tests/verbs/test_export.py writes it",
    'scaloft-fi export --format markdown >> "$GITHUB_STEP_SUMMARY"': "tests/verbs/test_export.py writes it",
    "scaloft-fi report --output faults.html": "tests/verbs/report writes it",
    "scaloft-fi score --ratchet --fail-under-firm 0.25": "tests/verbs tries both",
}
"""Commands of the other pages that are not run, and why."""


def test_every_command_stands_where_a_test_finds_it():
    assert stray_commands() == []


def test_every_command_is_run_or_listed():
    left = {
        shown.command for shown in shown_commands() if shown.page not in {*RUN_BY_GUIDES, *WHOLE, *PAGES, *ELSEWHERE}
    }
    assert left == set()
    steps = {shown.command for shown in shown_commands() if shown.page in PAGES} - {
        command for page in PAGES for command in _of(page)
    }
    assert steps == set(NOT_RUN)


def test_no_page_is_listed_in_vain():
    assert {*PAGES, *ELSEWHERE} <= {shown.page for shown in shown_commands()}


def _of(page: str) -> Mapping[str, str]:
    """The commands of a page that are run, with the output that it shows."""
    return {
        shown.command: shown.output for shown in shown_commands() if shown.page == page and shown.command not in NOT_RUN
    }


@pytest.mark.flight
@pytest.mark.parametrize("page", [pytest.param(page, marks=[pytest.mark.release] * (page in FLY)) for page in PAGES])
def test_its_commands_print_what_it_shows(page: str, tmp_path: Path):
    copied(tmp_path, "grids", "found.yaml")
    commands = _of(page)
    assert commands
    for command, shown in commands.items():
        program, *words = Shown(page, command).words
        assert program == "scaloft-fi", command
        done = call(tmp_path / "none", "-m", "scaloft_fi", *words, cwd=tmp_path)
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
        assert not shown or shown == done.stdout, f"{page} shows another output of {command}:\n{done.stdout}"


@pytest.mark.parametrize("shown", shown_commands(), ids=str)
def test_a_command_that_is_shown_can_be_called(shown: Shown):
    for words in filter(None, _calls(shown)):
        with suppress(Exit):  # of --help
            command_of(words[0]).make_context(words[0], words[1:])


@pytest.mark.parametrize("shown", named_commands(), ids=str)
def test_a_command_that_a_sentence_names_has_this_verb_and_these_options(shown: Shown):
    for verb, *words in filter(None, _calls(shown)):
        assert verb in {*VERBS, "VERB"}
        names = {option for parameter in command_of(verb).params for option in parameter.opts} if verb in VERBS else {}
        options = [word.partition("=")[0] for word in words if word.startswith("--")]
        assert [option for option in options if option not in {*names, "--help"}] == []


def _calls(shown: Shown) -> list[list[str]]:
    """The words behind `scaloft-fi` of each call in a command line."""
    calls = [Shown(shown.page, part).words for part in re.split(r"&&|>>?", shown.command)]
    return [words[at + 1 :] for words in calls for at, word in enumerate(words) if word.endswith("scaloft-fi")]
