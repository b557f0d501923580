"""The tutorial is a transcript: a new user with the wheel and this page gets what the page shows."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import wheel_of
from tutorial import BLOCK, PAGE, PICTURES, Follower

REMEDY = "what changed on purpose comes into the page with `python tests/support/tutorial.py`"


def test_every_block_of_the_page_is_run_or_written():
    page = PAGE.read_text()
    blocks = BLOCK.findall(page)
    assert 2 * len(blocks) == len(re.findall(r"^```", page, re.MULTILINE))
    assert [text for language, name, text in blocks if language != "console" and not name] == []


@pytest.fixture
def home() -> Iterator[Path]:
    """A folder of a short name: a line with its path is wrapped as on the page."""
    with tempfile.TemporaryDirectory() as made:
        yield Path(made)


@pytest.mark.release
@pytest.mark.flight
def test_each_command_prints_and_draws_what_the_page_shows(home: Path):
    follower = Follower(home, wheel_of(home))
    page = follower.followed(PAGE.read_text())
    assert _masked(page) == _masked(PAGE.read_text()), REMEDY
    assert follower.pictures(page) == {path.name: path.read_bytes() for path in PICTURES.iterdir()}, REMEDY


def _masked(page: str) -> str:
    """The page without digests, which are of one platform."""
    return re.sub(r"\b[0-9a-f]{64}\b", "digest", page)


def test_the_page_shows_faults_survivors_and_an_own_mine_with_an_own_operator():
    page = PAGE.read_text()
    first = page.split("$ scaloft-fi run --quiet\n")[1].split("```")[0]
    assert len(re.findall("  detected  ", first)) == 2
    assert len(re.findall("  not detected  ", first)) == 3
    assert re.search(r"^Controls +1 of 1 show ", first, re.MULTILINE)
    last = page.split("--campaign branch --mutant")[1].split("```")[0]
    assert re.search(r"^PARTOF-human@2m .*SR2", last, re.MULTILINE), last
    score = page.split("$ scaloft-fi score --campaign branch")[1].split("```")[0]
    assert re.search(r"REVERSE-human .*OP1", score), score
