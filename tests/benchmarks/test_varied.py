from __future__ import annotations

from pathlib import Path

import pytest

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.flights.fly import fly_log
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[2]


@pytest.mark.flight
def test_without_a_changed_number_the_flights_are_those_of_a_campaign() -> None:
    from experiments.varied import Beside, flown

    study, situation = Study.open(ROOT), "T0O0W0D0H0"
    mutant = realise(study.matrix, "REVERSE-velcmd")
    logs = [log.digest for _, log in flown(Beside(ROOT, {}, situation, 0, (mutant.id,)))]
    flights = [Flight(subject, study.grid.situation(situation), 0) for subject in (None, mutant)]
    assert logs == [fly_log(study, flight).digest for flight in flights]
