"""The plan: what is flown, in which order, and how flights are put together for a worker."""

from __future__ import annotations

import heapq
import random
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.pool import LEAST
from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.plan import LEAST_SHARING, alone, parse_seeds, plan, together
from scaloft_fi.errors import InputError
from scaloft_fi.mutants.mutant import PLACEBO, Mutant


def _mutant(name: str) -> Mutant:
    return Mutant(name, *name.split("-"), "", 0.0, "velcmd", "delay")


def test_the_order_is_baselines_then_placebo_then_the_mutants_as_asked(study: Any) -> None:
    mutants = [_mutant("MORE-goal"), _mutant("LATE-human")]
    planned = plan(study.grid, (0, 1), mutants, None)
    assert [f.name for f in planned.baselines[:3]] == ["baseline/D0H0/0", "baseline/D0H0/1", "baseline/D0H1/0"]
    order = list(dict.fromkeys(f.subject.id for f in planned.mutants))
    assert order == ["PLACEBO", "MORE-goal", "LATE-human"]
    assert len(planned.known) == 4 * 4 * 2


def test_a_control_among_the_mutants_needs_no_canary(study: Any) -> None:
    control = _mutant("REVERSE-velcmd")
    assert plan(study.grid, (0,), [control], control).canary is None


def test_placebo_is_flown_once_even_when_asked_for(study: Any) -> None:
    planned = plan(study.grid, (0,), [PLACEBO], None)
    assert len(planned.mutants) == 4


@given(st.integers(0, 500), st.integers(0, 50))
def test_seeds_are_a_number_or_a_range_with_both_ends(first: int, more: int) -> None:
    assert parse_seeds(f"{first}-{first + more}") == tuple(range(first, first + more + 1))
    assert parse_seeds(f"{more + 1}") == tuple(range(more + 1))


@pytest.mark.parametrize("text", ["0", "-1", "5-4", "a", "", "1,2", "1-", "999999999"])
def test_other_seeds_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="--seeds="):
        parse_seeds(text)


def test_a_pool_fills_up_to_ten_seeds_beside_the_mutants_own(study: Any) -> None:
    planned = plan(study.grid, (3, 4), [_mutant("MORE-goal")], None).with_pool()
    for situation in study.grid:
        seeds = [flight.seed for flight in planned.pool(situation, LEAST)]
        assert seeds == [0, 1, 2, 5, 6, 7, 8, 9]
        assert all(flight.mutant is None for flight in planned.pool(situation, LEAST))
    assert planned.seeds == (3, 4)


def test_a_pool_of_given_seeds_has_those_and_a_plan_without_one_has_none(study: Any) -> None:
    planned = plan(study.grid, (0, 1), [_mutant("MORE-goal")], None)
    (situation, *_) = study.grid
    assert [flight.seed for flight in planned.with_pool(range(5)).pool(situation, LEAST)] == [2, 3, 4]
    assert planned.pool(situation, LEAST) == ()


def test_a_pool_is_flown_where_a_mutant_infects_and_nowhere_else(study: Any, log: Any) -> None:
    planned = plan(study.grid, (0,), [_mutant("LATE-human@3s")], None).with_pool()
    outcomes = [log(study, flight) for flight in planned.known]
    assert [situation.key for situation in planned.infected(outcomes)] == ["D0H1", "D1H1"]
    clean = [outcome for outcome in outcomes if outcome.mutant in ("baseline", "PLACEBO")]
    assert planned.infected(clean) == ()


def test_shards_part_the_flights_and_each_knows_the_seeds_of_the_whole_run(study: Any) -> None:
    planned = plan(study.grid, (0, 1), [_mutant("MORE-goal")], None).with_pool()
    parts = [planned.shard(number, 3) for number in (1, 2, 3)]
    assert sorted(f.name for part in parts for f in part.known) == sorted(f.name for f in planned.known)
    assert all(part.seeds == (0, 1) and part.pool_seeds is None for part in parts)


def _late(number: int) -> Mutant:
    return Mutant(f"LATE-human@{number}s", "LATE", "human", f"{number}s", 0.0, "velcmd", "delay")


def _flights(situation: Any, mutants: int, *, baseline: bool = True, seed: int = 0) -> list[Flight]:
    clean = [Flight(None, situation, seed)] if baseline else []
    return [*clean, *(Flight(_late(n), situation, seed) for n in range(mutants))]


def _nominal_s(flight: Flight) -> float:
    return flight.situation.nominal_s


def test_the_mutants_of_a_situation_and_seed_share_its_baseline(study: Any) -> None:
    flights = [*_flights(study.grid[0], 3), *_flights(study.grid[1], 2), *_flights(study.grid[0], 1, seed=1)]
    batches = together(flights, _nominal_s, 1)
    assert all(batch.shared for batch in batches)
    assert [len(batch.flights) for batch in batches] == [3, 4, 2]
    assert {(batch.carrier.situation.key, batch.carrier.seed) for batch in batches} == {
        ("D0H0", 0),
        ("D0H1", 0),
        ("D0H0", 1),
    }


def test_placebo_is_flown_whole_and_by_itself(study: Any) -> None:
    placebo = Flight(PLACEBO, study.grid[0], 0)
    assert Batch((placebo,)) in together([*_flights(study.grid[0], 3), placebo], _nominal_s, 1)
    with pytest.raises(ValueError, match="PLACEBO is always flown whole"):
        Batch((placebo,), shared=True)


def test_a_known_baseline_is_flown_again_for_its_missing_mutants(study: Any) -> None:
    (batch,) = together(_flights(study.grid[0], 3, baseline=False), _nominal_s, 1)
    assert batch.flights[0] == batch.carrier


def test_a_single_mutant_of_a_known_baseline_is_flown_whole(study: Any) -> None:
    flights = _flights(study.grid[0], 1, baseline=False)
    assert together(flights, _nominal_s, 1) == alone(flights)


def test_a_lone_situation_keeps_every_process_busy(study: Any) -> None:
    batches = together(_flights(study.grid[0], 10 * LEAST_SHARING), _nominal_s, 4)
    assert len(batches) > 4
    assert all(len(batch.flights) > LEAST_SHARING for batch in batches)


def test_tasks_get_smaller_towards_the_end(study: Any) -> None:
    flights = [flight for situation in study.grid for flight in _flights(situation, 8 * LEAST_SHARING)]
    pieces = [batch.carrier.situation.key for batch in together(flights, _nominal_s, 2)]
    assert [pieces.count(situation.key) for situation in sorted(study.grid, key=lambda s: -s.nominal_s)] == [2, 2, 3, 4]


@pytest.mark.parametrize("jobs", [2, 4, 8, 16])
def test_processes_end_at_about_the_same_time_though_nobody_knows_how_long_a_mutant_flies(
    study: Any, jobs: int
) -> None:
    draw = random.Random(0)
    situations = [replace(study.grid[0], key=f"S{number}", nominal_s=40.0 + 5.0 * number) for number in range(16)]
    flights = [flight for situation in situations for flight in _flights(situation, 100)]
    spent_s = {flight.name: draw.expovariate(1.0) * flight.situation.nominal_s for flight in flights if flight.mutant}
    ends_s = [0.0] * jobs
    for batch in together(flights, _nominal_s, jobs):
        took_s = batch.carrier.situation.nominal_s + sum(spent_s[f.name] for f in batch.flights if f.mutant)
        heapq.heapreplace(ends_s, ends_s[0] + took_s)
    assert max(ends_s) < 1.05 * sum(ends_s) / jobs


def test_a_baseline_with_few_mutants_is_not_flown_twice(study: Any) -> None:
    assert len(together(_flights(study.grid[0], 2 * LEAST_SHARING - 1), _nominal_s, 64)) == 1


@pytest.mark.parametrize("jobs", [1, 2, 7, 64])
def test_every_flight_is_in_one_task_and_only_baselines_are_flown_again(study: Any, jobs: int) -> None:
    flights = [f for i, situation in enumerate(study.grid) for f in _flights(situation, 30 * i, baseline=i != 1)]
    planned = [flight for batch in together(flights, _nominal_s, jobs) for flight in batch.flights]
    assert sorted(f.name for f in planned if f.mutant) == sorted(f.name for f in flights if f.mutant)
    assert {f.name for f in planned if not f.mutant} == {f"baseline/{s.key}/0" for s in study.grid}


def test_what_is_home_is_owed_no_longer(study: Any) -> None:
    batch = Batch(tuple(_flights(study.grid[0], 2)), shared=True)
    left = batch.without({"baseline/D0H0/0", "LATE-human@0s/D0H0/0"})
    assert left == Batch((Flight(_late(1), study.grid[0], 0),), shared=True)
    assert left.carrier == batch.carrier
    assert left.without({"LATE-human@1s/D0H0/0"}) is None
