"""How well the rest of a campaign is foretold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from random import Random
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.plan.plan import plan
from scaloft_fi.campaign.progress.forecast import FLIGHT_S, PRIOR_FLOWN, PRIOR_SHARE, Forecast
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.derive import defaults

EACH_S = FLIGHT_S * (2 + 10 * PRIOR_FLOWN)
"""What baseline, PLACEBO and ten mutants are expected to cost beside their length, in each of four situations [s]."""


def _flights(study: Any, mutants: int = 10) -> list[Flight]:
    planned = plan(study.grid, (0,), defaults(study.matrix)[:mutants], None)
    return [*planned.baselines, *planned.mutants]


def _flown(log: Any, flight: Flight, share: float) -> Outcome:
    """A flight that leaves its baseline so late that `share` of it is flown."""
    outcome: Outcome = log(None, flight)
    if flight.subject.id in ("baseline", "PLACEBO"):
        return outcome
    return replace(outcome, infected_at_s=outcome.duration_s * (1 - share) if share else None)


def test_before_anything_is_home_a_mutant_costs_the_prior_share_of_its_mission(study: Any) -> None:
    forecast = Forecast(share=True)
    for flight in _flights(study):
        forecast.expect(flight, flight.situation.nominal_s)
    missions_s = sum(situation.nominal_s for situation in study.grid)
    assert forecast.left_s == pytest.approx(missions_s * (2 + 10 * PRIOR_SHARE) + 4 * EACH_S)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(random=st.randoms(use_true_random=False))
def test_when_all_is_home_nothing_is_left_and_the_cost_is_what_was_flown(study: Any, log: Any, random: Random) -> None:
    planned = plan(study.grid, (0, 1), defaults(study.matrix)[:5], None)
    flights = [*planned.baselines, *planned.mutants]
    forecast, cost_s = Forecast(share=True), 0.0
    for flight in flights:
        assert forecast.expect(flight, flight.situation.nominal_s)
    random.shuffle(flights)
    for flight in flights:
        outcome = _flown(log, flight, random.choice((0.0, 0.3, 1.0)))
        whole = flight.subject.id in ("baseline", "PLACEBO")
        infected_s = outcome.infected_at_s
        if whole or infected_s is not None:
            cost_s += outcome.duration_s - (infected_s or 0.0) + FLIGHT_S
        assert forecast.home(flight, outcome, flight.situation.nominal_s)
        assert forecast.left_s >= 0.0
    assert forecast.left_s == pytest.approx(0.0, abs=1e-6)
    assert forecast.done_s == pytest.approx(cost_s)


def _home(forecast: Forecast, log: Any, flights: Sequence[Flight], share: float) -> None:
    for flight in flights:
        forecast.home(flight, _flown(log, flight, share), flight.situation.nominal_s)


def test_within_a_draw_only_what_comes_after_the_latest_leaving_is_expected(study: Any, log: Any) -> None:
    flights = [flight for flight in _flights(study) if flight.situation.key == "D0H0"]
    forecast = Forecast(share=True)
    for flight in flights:
        forecast.expect(flight, flight.situation.nominal_s)
    left_s = [forecast.left_s]
    for flight, share in zip(flights[2:6], (1.0, 0.5, 0.25, 0.05), strict=True):
        _home(forecast, log, [flight], share)
        left_s.append(forecast.left_s)
    assert left_s == sorted(left_s, reverse=True)
    whole_s = 2 * flights[0].situation.nominal_s
    assert left_s[-1] - whole_s < 0.1 * (left_s[0] - whole_s)


def test_shares_are_learnt_when_the_draw_is_complete(study: Any, log: Any) -> None:
    flights = _flights(study)
    forecast = Forecast(share=True)
    for flight in flights:
        forecast.expect(flight, flight.situation.nominal_s)
    elsewhere_s = sum(situation.nominal_s for situation in study.grid if situation.key != "D0H0")
    one = [flight for flight in flights if flight.situation.key == "D0H0"]
    _home(forecast, log, one[1:], 0.0)
    baseline_s = one[0].situation.nominal_s + FLIGHT_S
    assert forecast.left_s == pytest.approx(elsewhere_s * (2 + 10 * PRIOR_SHARE) + 3 * EACH_S + baseline_s)
    _home(forecast, log, one[:1], 0.0)
    assert forecast.left_s < elsewhere_s * (2 + 10 * PRIOR_SHARE * 0.7) + 3 * EACH_S * 0.7


def test_a_baseline_known_before_tells_how_long_flights_last(study: Any, log: Any) -> None:
    flights = [flight for flight in _flights(study) if flight.situation.key == "D0H0"]
    forecast = Forecast(share=True)
    for flight in flights[1:]:
        forecast.expect(flight, flight.situation.nominal_s)
    before_s = forecast.left_s
    forecast.known(flights[0], replace(log(study, flights[0]), duration_s=15.0), 30.0)
    beside_s = EACH_S - FLIGHT_S
    assert forecast.left_s - beside_s == pytest.approx((before_s - beside_s) / 2)


def test_a_carrier_flown_again_is_flown_but_was_not_expected(study: Any, log: Any) -> None:
    baseline = _flights(study)[0]
    forecast = Forecast(share=True)
    assert not forecast.home(baseline, log(study, baseline), 30.0)
    assert forecast.done_s == 30.0 + FLIGHT_S
