"""The tutorial is a transcript: a new user with the wheel and this page gets what the page shows."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest
from tutorial import BLOCK, PAGE, PICTURES, Follower
from wheels import wheel_of

REMEDY = "what changed on purpose comes into the page with `python tests/support/tutorial.py`"


@dataclass(frozen=True)
class Transcript:
    """What came of following the page."""

    page: str
    pictures: Mapping[str, bytes]
    folder: Path


@pytest.fixture(scope="module")
def transcript(tmp_path_factory: pytest.TempPathFactory) -> Transcript:
    folder = tmp_path_factory.mktemp("user")
    follower = Follower(folder, wheel_of(folder))
    page = follower.followed(PAGE.read_text())
    return Transcript(page, follower.pictures(page), follower.folder)


def test_every_block_of_the_page_is_run_or_written() -> None:
    page = PAGE.read_text()
    blocks = BLOCK.findall(page)
    assert 2 * len(blocks) == len(re.findall(r"^```", page, re.MULTILINE))
    assert [text for language, name, text in blocks if language != "console" and not name] == []


@pytest.mark.flight
def test_each_command_prints_what_the_page_shows(transcript: Transcript) -> None:
    assert _masked(transcript.page) == _masked(PAGE.read_text()), REMEDY


def _masked(page: str) -> str:
    """The page without digests, which are of one platform."""
    return re.sub(r"\b[0-9a-f]{64}\b", "digest", page)


@pytest.mark.flight
def test_the_pictures_are_those_of_the_page(transcript: Transcript) -> None:
    assert transcript.pictures == {path.name: path.read_bytes() for path in PICTURES.iterdir()}, REMEDY


@pytest.mark.flight
def test_the_first_run_shows_faults_and_leaves_survivors(transcript: Transcript) -> None:
    screen = transcript.page.split("$ scaloft-fi run --quiet\n")[1].split("```")[0]
    assert "Detected: 2" in screen
    assert "Not detected: 3" in screen
    assert re.search(r"^REVERSE-velcmd +SR1 ", screen, re.MULTILINE)
    assert "it holds steadily SR1 in 6, SR2 in 4" in screen


@pytest.mark.flight
def test_the_last_score_is_of_an_own_mine_two_axes_a_requirement_and_an_operator(transcript: Transcript) -> None:
    study = transcript.folder / "corridor"
    assert "mesh: branch.obj" in (study / "sim" / "world.yaml").read_text()
    assert '"operator": "my_faults_short_sight"' in (study / "mutants" / "catalogue.jsonl").read_text()
    screen = transcript.page.split("--campaign branch --mutant")[1].split("```")[0]
    assert re.search(r"^PARTOF-human@2m .*SR2", screen, re.MULTILINE), screen
    score = transcript.page.split("$ scaloft-fi score --campaign branch")[1].split("```")[0]
    assert re.search(r"REVERSE-human .*OP1", score), score
