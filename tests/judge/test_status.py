from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest
from builders import campaigns, outcome, seeded
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.judge import status
from scaloft_fi.judge.outcome import BASELINE, TRACK_COLUMNS, Outcome, pack_track

M = "LATE-human@3s"
HELD = outcome()
# struck the bar at 30 s: what it did not violate is open
CUT = outcome(violated={"SR1": 30.0}, struck="bar")


def ruling(flight: Outcome, baseline: Outcome | None = HELD) -> status.Ruling:
    return status.rule(flight, status.counting(baseline))


@pytest.mark.parametrize(
    ("flight", "baseline", "expected"),
    [
        (outcome(M, invalid="worker died"), HELD, "invalid"),
        (outcome(M), None, "invalid"),
        (outcome(M), outcome(invalid="worker died"), "invalid"),
        (outcome(M, carried=0, altered=0), HELD, "not_reached"),
        (outcome(M, altered=0), HELD, "not_infected"),
        (outcome(M, altered=0, violated={"SR1": 1.0}), HELD, "not_infected"),
        (outcome(M, digest="clean"), HELD, "masked"),
        (outcome(M), HELD, "survived"),
        (outcome(M, violated={"SR2": 20.0}), HELD, "revealed"),
        (outcome(M, violated={"SR1": 20.0}, struck="wall"), HELD, "revealed"),
        (outcome(M, violated={"OP1": 60.0}), HELD, "survived"),
        (outcome(M, violated={"SR2-literal": 20.0}), HELD, "survived"),
        # the baseline breaks the same requirement later, at the same moment, earlier; on another body, on the same
        (outcome(M, violated={"SR1": 29.0}, struck="wall"), CUT, "revealed"),
        (outcome(M, violated={"SR1": 29.0}, struck="bar"), CUT, "baseline_red"),
        (outcome(M, violated={"SR1": 31.0}, struck="wall"), CUT, "baseline_red"),
        (outcome(M, violated={"SR2": 9.0}), outcome(violated={"SR2": 10.0}), "baseline_red"),
        (outcome(M, violated={"SR1": 30.0}, struck="bar"), CUT, "baseline_red"),
        (outcome(M, violated={"SR1": 31.0}, struck="bar"), CUT, "baseline_red"),
        # the baseline left it open: up to its end it held, beyond nothing is known
        (outcome(M, violated={"SR2": 30.0}), CUT, "revealed"),
        (outcome(M, violated={"SR2": 30.5}), CUT, "baseline_red"),
        (outcome(M), CUT, "survived"),
        # the baseline held to its end: a later violation is the mutant's own
        (outcome(M, violated={"SR2": 80.0}, duration_s=90.0), HELD, "revealed"),
        # one requirement is the baseline's too, the other is not
        (outcome(M, violated={"SR2": 20.0, "SR1": 25.0}), outcome(violated={"SR2": 10.0}), "revealed"),
        (outcome(M, violated={"SR2": 20.0}), outcome(violated={"SR2": 10.0}), "baseline_red"),
    ],
)
def test_the_first_status_that_fits(flight: Outcome, baseline: Outcome | None, expected: str):
    assert ruling(flight, baseline).status.value == expected


def test_a_spurious_sample_on_a_silent_seam_infects():
    assert ruling(outcome(M, carried=0, altered=3)).status is status.Status.SURVIVED


def test_what_is_revealed_names_its_requirements_earliest_first():
    revealed = ruling(outcome(M, violated={"SR1": 25.0, "SR2": 20.0, "OP1": 50.0}))
    assert revealed.revealed == ("SR2", "SR1")
    assert revealed.operability_revealed == ("OP1",)
    assert revealed.violated == ("SR1", "SR2", "OP1")


def test_a_requirement_that_the_baseline_breaks_too_is_not_revealed():
    revealed = ruling(outcome(M, violated={"SR1": 25.0, "SR2": 20.0}), outcome(violated={"SR2": 10.0}))
    assert (revealed.revealed, revealed.violated) == (("SR1",), ("SR1", "SR2"))


def test_a_flight_that_changes_nothing_still_says_what_it_violates():
    assert ruling(outcome(M, altered=0, violated={"SR2": 20.0}), outcome(violated={"SR2": 20.0})).violated == ("SR2",)


def test_a_baseline_is_held_or_violated_by_its_safety_requirements():
    assert status.baseline_status(HELD) == "held"
    assert status.baseline_status(CUT) == "violated"
    assert status.baseline_status(outcome(violated={"OP1": 60.0, "SR2-literal": 3.0})) == "held"
    assert status.baseline_status(outcome(invalid="x")) == "invalid"


def test_a_mutants_status_is_the_furthest_stage_that_a_flight_reached():
    flights = [outcome(M, altered=0), outcome(M, digest="clean"), outcome(M, invalid="x")]
    assert status.furthest(ruling(flight).status for flight in flights) is status.Status.MASKED
    assert status.furthest([]) is status.Status.INVALID


@given(st.one_of(campaigns(), seeded()))
@settings(deadline=None)
def test_every_flight_is_ruled_as_it_is_beside_its_baseline(flown: list[Outcome]):
    found = status.rulings_of(flown)
    ruled = {
        (mutant.id, situation, one.seed): one
        for mutant, situations in found.mutants.items()
        for situation, flights in situations.items()
        for one in flights
    }
    beside = status.flights_of(flown)
    assert len(ruled) == len(beside) == sum(len(flights) for s in found.mutants.values() for flights in s.values())
    for flight in beside:
        one = ruled[flight.outcome.mutant, flight.outcome.situation, flight.outcome.seed]
        assert one.ruling is flight.ruling
        assert tuple(one.violations) == (() if flight.status is status.Status.INVALID else flight.outcome.violations)
    assert sorted(one.name for one in found.baselines) == sorted(one.name for one in flown if one.mutant == BASELINE)
    assert found.draws == {(one.situation, one.seed) for one in flown if one.mutant != BASELINE and not one.invalid}
    assert found.situations == {one.situation for one in flown}


@given(seeded(), st.randoms())
@settings(deadline=None, max_examples=20)
def test_the_order_of_outcomes_changes_no_ruling(flown: list[Outcome], chance: random.Random):
    shuffled = chance.sample(flown, len(flown))
    one, other = status.rulings_of(flown), status.rulings_of(shuffled)
    assert one.mutants == other.mutants
    for situations in other.mutants.values():
        for flights in situations.values():
            assert [flight.seed for flight in flights] == sorted(flight.seed for flight in flights)


def test_there_are_rulings_where_anything_was_flown():
    assert not status.rulings_of([])
    assert status.rulings_of([outcome()])
    assert status.rulings_of([outcome(M)])


def test_an_invalid_flight_has_no_baseline():
    invalid = outcome(invalid="worker died")
    for flight, baseline in ((outcome(M, invalid="x"), outcome()), (outcome(M), None), (outcome(M), invalid)):
        found = status.flight_of(flight, baseline)
        assert (found.status, found.baseline) == (status.Status.INVALID, None)


@given(campaigns())
def test_every_flight_of_a_mutant_has_one_status_and_what_is_revealed_names_a_requirement(outcomes: list[Outcome]):
    flights = status.flights_of(outcomes)
    assert len(flights) == sum(outcome.mutant != BASELINE for outcome in outcomes)
    for flight in flights:
        assert (flight.status is status.Status.REVEALED) == bool(flight.revealed)
        assert set(flight.revealed) <= {"SR1", "SR2"}
        assert set(flight.operability_revealed) <= {"OP1"}


NAME = f"{M}/T0O0W0D0H0/0"


@given(campaigns())
def test_a_campaign_agrees_with_itself_to_the_bit(outcomes: list[Outcome]):
    once = list({outcome.name: outcome for outcome in outcomes}.values())
    compared = status.agreement(once, once[::-1])
    assert sorted(compared.equal) == sorted(outcome.name for outcome in once if not outcome.invalid)
    assert (compared.bits, compared.facts) == ((), {})


@given(campaigns())
def test_other_last_bits_of_every_flight_leave_all_facts(outcomes: list[Outcome]):
    once = list({outcome.name: outcome for outcome in outcomes}.values())
    other = [replace(outcome, digest=f"{outcome.digest}, other") for outcome in once]
    compared = status.agreement(once, other)
    assert compared.facts == {}
    assert sorted(compared.bits) == sorted(outcome.name for outcome in once if not outcome.invalid)


def test_a_mutant_that_is_masked_on_one_platform_only_differs_in_more_than_bits():
    here = [outcome(digest="a"), outcome(M, digest="a")]
    there = [outcome(digest="b"), outcome(M, digest="c")]
    compared = status.agreement(there, here)
    assert compared.bits == ("baseline/T0O0W0D0H0/0",)
    assert compared.facts == {NAME: (status.Facts("survived", "landed", ()), status.Facts("masked", "landed", ()))}
    assert compared.named() == f"{NAME} (masked, landed here, survived, landed there)"


def test_without_a_baseline_on_one_side_the_status_is_not_compared():
    compared = status.agreement([outcome(M, digest="c")], [outcome(digest="b"), outcome(M, digest="b")])
    assert compared.bits == (NAME,)


@pytest.mark.parametrize("change", [{"ending": "struck"}, {"violated": True}])
def test_another_ending_or_violation_is_another_fact(change: dict[str, object]):
    first = outcome(M)
    second = outcome(M, violated={"SR2": 5.0}) if "violated" in change else replace(first, ending="struck")
    assert list(status.agreement([first], [replace(second, digest="b")]).facts) == [NAME]


def test_a_message_names_three_flights_and_counts_the_rest():
    flights = [outcome(M, seed=seed, digest="a") for seed in range(5)]
    compared = status.agreement(flights, [replace(flight, digest="b", ending="struck") for flight in flights])
    assert compared.named().count(M) == 3
    assert compared.named().endswith(" and 2 more")


def test_a_baseline_is_held_or_violated():
    facts = status.facts_of([outcome(violated={"SR2": 5.0}), outcome(seed=1)])
    assert [one.status for one in facts.values()] == ["violated", "held"]


def _track(x_m: list[float]) -> bytes:
    times = np.arange(len(x_m)) * 0.05
    zeros = np.zeros(len(x_m))
    return pack_track(dict.fromkeys(TRACK_COLUMNS, zeros) | {"elapsed_s": times, "x_m": np.array(x_m)})


@pytest.mark.parametrize(("apart_m", "expected_s"), [(0.0, None), (0.0005, None), (0.002, 0.4)])
def test_tracks_part_where_the_positions_are_a_millimetre_apart(apart_m: float, expected_s: float | None):
    first, second = [0.0] * 12, [0.0] * 8 + [apart_m] * 4
    assert status.parting_s(_track(first), _track(second)) == pytest.approx(expected_s)
