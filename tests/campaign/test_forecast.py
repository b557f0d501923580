"""How well the rest of a campaign is foretold."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.plan import plan
from scaloft_fi.campaign.progress import FLIGHT_S, SHARE, Forecast
from scaloft_fi.mutants.catalogue import defaults


def _flights(study: Any, mutants: int = 10) -> list[Flight]:
    planned = plan(study.grid, (0,), defaults(study.matrix)[:mutants], None)
    return [*planned.baselines, *planned.mutants]


@pytest.mark.parametrize(("share", "of_a_mutant"), [(True, SHARE), (False, 1.0)])
def test_a_mutant_is_expected_to_cost_its_share_of_the_mission(study: Any, *, share: bool, of_a_mutant: float) -> None:
    forecast = Forecast(share=share)
    for flight in _flights(study):
        assert forecast.expect(flight, flight.situation.nominal_s)
    missions_s = sum(situation.nominal_s for situation in study.grid)
    assert forecast.left_s == pytest.approx(missions_s * (2 + 10 * of_a_mutant) + 4 * 12 * FLIGHT_S)


def test_what_is_flown_is_not_left_and_in_the_end_nothing_is(study: Any) -> None:
    forecast, flights = Forecast(share=True), _flights(study)
    for flight in flights:
        forecast.expect(flight, flight.situation.nominal_s)
    whole_s = forecast.left_s
    Random(0).shuffle(flights)
    for flight in flights:
        assert forecast.arrived(flight, flight.situation.nominal_s)
        assert forecast.done_s + forecast.left_s == pytest.approx(whole_s)
    assert forecast.left_s == 0.0


def test_a_flight_that_is_announced_twice_is_expected_once(study: Any) -> None:
    forecast, flight = Forecast(share=True), _flights(study)[0]
    assert forecast.expect(flight, 30.0)
    assert not forecast.expect(flight, 30.0)
    assert forecast.left_s == 30.0 + FLIGHT_S


def test_a_carrier_flown_again_is_flown_but_was_not_expected(study: Any) -> None:
    forecast = Forecast(share=True)
    assert not forecast.arrived(_flights(study)[0], 30.0)
    assert (forecast.done_s, forecast.left_s) == (30.0 + FLIGHT_S, 0.0)
