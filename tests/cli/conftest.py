"""The command line on the reference study, with a flyer that needs no physics."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from paper_flyer import Paper

from scaloft_fi.cli.main import main

STUDY = Path(__file__).parents[2]


@pytest.fixture
def paper(monkeypatch: pytest.MonkeyPatch) -> Paper:
    flyer = Paper()
    monkeypatch.setattr("scaloft_fi.campaign.runs.campaign.Physics", lambda: flyer)
    return flyer


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, paper: Paper) -> Callable[..., Result]:
    """Call the command in an empty folder, on the reference study, with a campaign of its own."""
    monkeypatch.chdir(tmp_path)

    def calling(verb: str, *words: str, study: Path = STUDY, campaign: bool = True) -> Result:
        where = ["--campaign", f"{tmp_path}/campaign"] if campaign else []
        return CliRunner().invoke(main, [verb, *words, "--study", str(study), *where], catch_exceptions=False)

    return calling


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A study of one's own: a copy of the reference study."""
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(STUDY / name, tmp_path / "study" / name, ignore=shutil.ignore_patterns("found.yaml"))
    return tmp_path / "study"
