"""A search in PyBullet: the flights of the paper's situations have the paper's digests, and a search flies."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.seeking.finds import Allowance
from scaloft_fi.campaign.seeking.seek import seek
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[3]
pytestmark = pytest.mark.flight


def test_the_search_grid_flies_the_papers_situations_bit_for_bit() -> None:
    fly, digests = Physics(), set()
    for study in (Study.open(ROOT), Study.open(ROOT, "search")):
        mutant = realise(study.matrix, "LATE-human")
        outcome = fly(study, Flight(mutant, study.grid.situation("T0O0W0D0H1"), 0))
        digests.add((outcome.digest, outcome.perceived_digest, outcome.altered))
    assert len(digests) == 1


def test_a_short_search_flies_what_its_budget_allows_and_resumes(tmp_path: Path) -> None:
    study = Study.open(ROOT, "search")
    mutants = [realise(study.matrix, "LATE-depth")]

    def search(budget: str) -> tuple[int, int]:
        report = seek(
            study,
            mutants,
            tmp_path / "c",
            RunOptions(jobs=1),
            seed=0,
            allowance=Allowance.parse(budget),
            progress=Progress(stream=io.StringIO()),
            save=lambda _finds: None,
        )
        return report.used, report.flown

    used, flown = search("20flights")
    assert 0 < used == flown <= 20
    assert search("20flights") == (used, 0)
