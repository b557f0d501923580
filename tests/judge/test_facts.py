from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import campaigns, outcome
from hypothesis import given

from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, pack_track
from scaloft_fi.judge.status import Facts, agreement, facts_of, parting_s

M = "LATE-human@3s"
NAME = f"{M}/T0O0W0D0H0/0"


@given(campaigns())
def test_a_campaign_agrees_with_itself_to_the_bit(outcomes: list[Outcome]) -> None:
    once = list({outcome.name: outcome for outcome in outcomes}.values())
    compared = agreement(once, once[::-1])
    assert sorted(compared.equal) == sorted(outcome.name for outcome in once if not outcome.invalid)
    assert (compared.bits, compared.facts) == ((), {})


@given(campaigns())
def test_other_last_bits_of_every_flight_leave_all_facts(outcomes: list[Outcome]) -> None:
    once = list({outcome.name: outcome for outcome in outcomes}.values())
    other = [replace(outcome, digest=f"{outcome.digest}, other") for outcome in once]
    compared = agreement(once, other)
    assert compared.facts == {}
    assert sorted(compared.bits) == sorted(outcome.name for outcome in once if not outcome.invalid)


def test_a_mutant_that_is_masked_on_one_platform_only_differs_in_more_than_bits() -> None:
    here = [outcome(digest="a"), outcome(M, digest="a")]
    there = [outcome(digest="b"), outcome(M, digest="c")]
    compared = agreement(there, here)
    assert compared.bits == ("baseline/T0O0W0D0H0/0",)
    assert compared.facts == {NAME: (Facts("survived", "landed", ()), Facts("masked", "landed", ()))}
    assert compared.named() == f"{NAME} (masked, landed here, survived, landed there)"


def test_without_a_baseline_on_one_side_the_status_is_not_compared() -> None:
    compared = agreement([outcome(M, digest="c")], [outcome(digest="b"), outcome(M, digest="b")])
    assert compared.bits == (NAME,)


@pytest.mark.parametrize("change", [{"ending": "struck"}, {"violated": True}])
def test_another_ending_or_violation_is_another_fact(change: dict[str, object]) -> None:
    first = outcome(M)
    second = outcome(M, violated={"SR2": 5.0}) if "violated" in change else replace(first, ending="struck")
    assert list(agreement([first], [replace(second, digest="b")]).facts) == [NAME]


def test_a_message_names_three_flights_and_counts_the_rest() -> None:
    flights = [outcome(M, seed=seed, digest="a") for seed in range(5)]
    compared = agreement(flights, [replace(flight, digest="b", ending="struck") for flight in flights])
    assert compared.named().count(M) == 3
    assert compared.named().endswith(" and 2 more")


def test_a_baseline_is_held_or_violated() -> None:
    facts = facts_of([outcome(violated={"SR2": 5.0}), outcome(seed=1)])
    assert [one.status for one in facts.values()] == ["violated", "held"]


def _track(x_m: list[float]) -> bytes:
    times = np.arange(len(x_m)) * 0.05
    zeros = np.zeros(len(x_m))
    return pack_track(dict.fromkeys(TRACK_COLUMNS, zeros) | {"elapsed_s": times, "x_m": np.array(x_m)})


@pytest.mark.parametrize(("apart_m", "expected_s"), [(0.0, None), (0.0005, None), (0.002, 0.4)])
def test_tracks_part_where_the_positions_are_a_millimetre_apart(apart_m: float, expected_s: float | None) -> None:
    first, second = [0.0] * 12, [0.0] * 8 + [apart_m] * 4
    assert parting_s(_track(first), _track(second)) == pytest.approx(expected_s)
