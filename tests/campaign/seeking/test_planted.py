"""Searches of the real code for a fault that does nothing, over planted outcomes: how many report a find.

The mutant violates as often as the unmutated drone: in each situation at a rate of its own, from 0 to a half, drawn for
each flight alone.  The project's bar is one false find in a hundred searches, the alpha of one mutant.
"""

from __future__ import annotations

import io
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest
from finding import small_study
from options import usually
from paper_flyer import Whole

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.seeking.finds import Allowance, SeekReport
from scaloft_fi.campaign.seeking.seek import seek
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study

SEARCHES, MOST = usually(4, release=1_000), 0.01
FLIGHTS = 200
"""Budget of a search."""
LATE = "LATE-human@3s"


@dataclass(frozen=True)
class Planted(Whole):
    """Flies without physics; search: the number of the search, which draws its own rates."""

    search: int

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        readings, violations = [], []
        for name in ("SR1", "SR2"):
            rate = self._chance("rate", name, flight.situation.key) / 2
            own = ("flight", name, flight.situation.key, flight.subject.id, flight.seed)
            violated = self._chance("violated", *own) < rate
            rho = (-0.3 if violated else 0.3) * (0.1 + 0.9 * self._chance("rho", *own))
            readings.append(Reading(name, Kind.SAFETY, rho, 7.0 if violated else None, 1, open=False))
            violations += [Violation(name, Kind.SAFETY, 7.0, 0.0, 1.0, 1.6, "")] * violated
        readings.append(Reading("OP1", Kind.OPERABILITY, 0.5, None, 1, open=False))
        mutated = flight.mutant is not None
        return Outcome(
            flight.subject,
            flight.situation.key,
            flight.seed,
            ending="landed",
            readings=tuple(readings),
            violations=tuple(violations),
            carried=10 * mutated,
            altered=3 * mutated,
            infected_at_s=1.0 if mutated else None,
            duration_s=40.0,
            digest=flight.name,
            perceived_digest="p",
            realised=() if mutated else tuple((axis.id, True) for axis in study.grid.axes),
        )

    def _chance(self, *words: object) -> float:
        return key_words("planted", self.search, *words)[0] / 2**64


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return small_study(tmp_path_factory.mktemp("planted"))


def searched(study: Study, folder: Path, number: int) -> SeekReport:
    return seek(
        study,
        [realise(study.matrix, LATE)],
        folder,
        RunOptions(jobs=1),
        seed=number,
        allowance=Allowance(flights=FLIGHTS),
        progress=Progress(stream=io.StringIO()),
        save=lambda _finds: None,
        flyer=Planted(number),
    )


def test_at_most_one_search_in_a_hundred_finds_something_for_a_fault_that_does_nothing(study: Study, tmp_path: Path):
    reports = []
    for number in range(SEARCHES):
        reports.append(searched(study, tmp_path / str(number), number))
        shutil.rmtree(tmp_path / str(number))
    tested = sum(report.sought[0].candidates for report in reports)
    false = sum(bool(report.finds) for report in reports)
    assert tested >= SEARCHES // 4, "the confirmation is put to the test"
    assert false <= MOST * SEARCHES
