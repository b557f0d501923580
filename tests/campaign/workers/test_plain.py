from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.flights.fly import invalid
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.workers.plain import (
    batch_from_plain,
    batch_to_plain,
    flyer_from_plain,
    flyer_to_plain,
    outcome_from_plain,
    outcome_to_plain,
)
from scaloft_fi.errors import InputError
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.study import Study


@pytest.fixture(scope="module")
def batch(reference: Study) -> Batch:
    """A flight of everything that may be flown: baseline, PLACEBO, default, magnitude off the ladder, phase."""
    names = ("LATE-human", "LATE-human@2.5s", "UNINTENDED-collision@20s#5s")
    mutants = [None, PLACEBO, *(realise(reference.matrix, name) for name in names)]
    return Batch(tuple(Flight(mutant, reference.grid.situations[5], 3) for mutant in mutants))


def test_a_batch_comes_back_as_it_was(reference: Study, batch: Batch) -> None:
    assert batch_from_plain(reference, batch_to_plain(batch)) == batch
    shared = replace(batch.without([f"PLACEBO/{batch.flights[0].situation.key}/3"]) or batch, shared=True)
    assert batch_from_plain(reference, batch_to_plain(shared)) == shared
    for flight in (["LATE-humna", "T0O0W0D0H0", 0], ["baseline", "T9", 0]):
        with pytest.raises(InputError):
            batch_from_plain(reference, {"flights": [flight], "shared": False})


def test_a_flyer_is_named_with_its_settings(flyer: Any) -> None:
    assert type(flyer_from_plain(flyer_to_plain(Physics()))) is Physics
    assert flyer_from_plain(flyer_to_plain(flyer(slow_s=0.5))) == flyer(slow_s=0.5)
    for name in ("os:system", "subprocess:Popen", "scaloft_fi.study:Study", "os:nothing"):
        with pytest.raises(ValueError, match="is no flyer"):
            flyer_from_plain({"name": name, "settings": {}})


def test_an_outcome_is_taken_for_a_flight_of_its_batch_only(batch: Batch) -> None:
    outcome = invalid(batch.flights[2], "its worker died")
    assert outcome_from_plain(batch, outcome_to_plain(outcome)) == outcome
    strange = (
        replace(outcome, seed=4),
        replace(outcome, situation="T0O0W0D0H0"),
        replace(outcome, subject=replace(outcome.subject, id="LATE-human@4s")),
        replace(outcome, subject=replace(outcome.subject, guideword="MORE")),
    )
    for other in strange:
        with pytest.raises(ValueError, match="was not asked for"):
            outcome_from_plain(batch, outcome_to_plain(other))
    plain = outcome_to_plain(outcome)
    for nonsense in (None, [], {}, {**plain, "more": 1}, {**plain, "track": None}, {**plain, "track": "="}, {"row": 1}):
        with pytest.raises(ValueError, match=r"."):
            outcome_from_plain(batch, nonsense)
