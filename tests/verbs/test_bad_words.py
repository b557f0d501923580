"""Words that verbs refuse: one sentence, and nothing is flown or written; `RECORD=1` writes the sentences anew."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner
from refusal import sentence

from scaloft_fi.cli import main

STUDY = Path(__file__).parents[2]
RECORD = Path(__file__).with_suffix(".txt")
"""A line with the words, and a line with what is said of them."""
ALONE = ("new", "completion", "matrx")
"""Verbs that take no study."""
HELD = ("run", "margin", "replay", "score", "kills", "worksheet", "dispositions", "report", "export", "seek")
"""Verbs that take a campaign."""


def _lines() -> list[str]:
    return RECORD.read_text(encoding="utf-8").splitlines()


def said_of(line: str, places: dict[str, str]) -> str:
    """The sentence about the words of a line, in which names stand for places."""
    verb, *words = [places.get(word, word) for word in shlex.split(line)]
    study = [] if verb in ALONE or "--study" in words else ["--study", str(STUDY)]
    campaign = ["--campaign", "./none"] if verb in HELD and "--campaign" not in words else []
    campaign += ["--into", "./none"] if verb == "seek" else []
    said = sentence(CliRunner().invoke(main, [verb, *study, *campaign, *words], catch_exceptions=False))
    for name, place in places.items():
        said = said.replace(place, name)
    return said


def test_bad_words_are_one_sentence_and_nothing_is_written(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("scaloft_fi.campaign.runs.run.Physics", lambda: pytest.fail("it flew"))
    Path("file").write_text("mine")
    lines = _lines()
    places = {"CAMPAIGN": str(folder), "HERE": str(tmp_path), "STUDY": str(STUDY)}
    said = {line: said_of(line, places) for line in lines[::2]}
    if os.environ.get("RECORD"):
        RECORD.write_text("".join(f"{line}\n{told}\n" for line, told in said.items()), encoding="utf-8")
    assert [path.read_text() for path in tmp_path.rglob("*")] == ["mine"]
    assert said == dict(zip(lines[::2], _lines()[1::2], strict=True)), "if it is right: RECORD=1"
