"""The plan: what is flown, in which order, and how flights are put together for a worker.

What a run with a budget flies: a fair sample, in an order that is always the same.
"""

from __future__ import annotations

import heapq
import random
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from running import CONTROL, Runs, same

from scaloft_fi.analysis.detection import LEAST
from scaloft_fi.campaign.flights.fly import Batch, Flight
from scaloft_fi.campaign.plan import LEAST_SHARING, Plan, alone, parse_seeds, plan, together
from scaloft_fi.campaign.runs.run import Budget, budget_s, fair_order, interleaved
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import defaults, realise
from scaloft_fi.mutants.mutant import PLACEBO, Mutant


def _mutant(name: str) -> Mutant:
    return Mutant(name, *name.split("-"), "", 0.0, "velcmd", "delay")


def test_the_order_is_baselines_then_placebo_then_the_mutants_as_asked(study: Any):
    mutants = [_mutant("MORE-goal"), _mutant("LATE-human")]
    planned = plan(study.grid, (0, 1), mutants, None)
    assert [f.name for f in planned.baselines[:3]] == ["baseline/D0H0/0", "baseline/D0H0/1", "baseline/D0H1/0"]
    order = list(dict.fromkeys(f.subject.id for f in planned.mutants))
    assert order == ["PLACEBO", "MORE-goal", "LATE-human"]
    assert len(planned.known) == 4 * 4 * 2


def test_a_control_among_the_mutants_needs_no_canary(study: Any):
    control = _mutant("REVERSE-velcmd")
    assert plan(study.grid, (0,), [control], control).canary is None


def test_placebo_is_flown_once_even_when_asked_for(study: Any):
    planned = plan(study.grid, (0,), [PLACEBO], None)
    assert len(planned.mutants) == 4


@given(st.integers(0, 500), st.integers(0, 50))
def test_seeds_are_a_number_or_a_range_with_both_ends(first: int, more: int):
    assert parse_seeds(f"{first}-{first + more}") == tuple(range(first, first + more + 1))
    assert parse_seeds(f"{more + 1}") == tuple(range(more + 1))


@pytest.mark.parametrize("text", ["0", "-1", "5-4", "a", "", "1,2", "1-", "999999999"])
def test_other_seeds_are_refused(text: str):
    with pytest.raises(InputError, match="--seeds="):
        parse_seeds(text)


def test_a_pool_fills_up_to_ten_seeds_beside_the_mutants_own(study: Any):
    planned = plan(study.grid, (3, 4), [_mutant("MORE-goal")], None).with_pool()
    for situation in study.grid:
        seeds = [flight.seed for flight in planned.pool(situation, LEAST)]
        assert seeds == [0, 1, 2, 5, 6, 7, 8, 9]
        assert all(flight.mutant is None for flight in planned.pool(situation, LEAST))
    assert planned.seeds == (3, 4)


def test_a_pool_of_given_seeds_has_those_and_a_plan_without_one_has_none(study: Any):
    planned = plan(study.grid, (0, 1), [_mutant("MORE-goal")], None)
    (situation, *_) = study.grid
    assert [flight.seed for flight in planned.with_pool(range(5)).pool(situation, LEAST)] == [2, 3, 4]
    assert planned.pool(situation, LEAST) == ()


def test_a_pool_is_flown_where_a_mutant_infects_and_nowhere_else(study: Any, log: Any):
    planned = plan(study.grid, (0,), [_mutant("LATE-human@3s")], None).with_pool()
    outcomes = [log(study, flight) for flight in planned.known]
    assert [situation.key for situation in planned.infected(outcomes)] == ["D0H1", "D1H1"]
    clean = [outcome for outcome in outcomes if outcome.mutant in ("baseline", "PLACEBO")]
    assert planned.infected(clean) == ()


def test_shards_part_the_flights_and_each_knows_the_seeds_of_the_whole_run(study: Any):
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


def test_the_mutants_of_a_situation_and_seed_share_its_baseline(study: Any):
    flights = [*_flights(study.grid[0], 3), *_flights(study.grid[1], 2), *_flights(study.grid[0], 1, seed=1)]
    batches = together(flights, _nominal_s, 1)
    assert all(batch.shared for batch in batches)
    assert [len(batch.flights) for batch in batches] == [3, 4, 2]
    assert {(batch.carrier.situation.key, batch.carrier.seed) for batch in batches} == {
        ("D0H0", 0),
        ("D0H1", 0),
        ("D0H0", 1),
    }


def test_placebo_is_flown_whole_and_by_itself(study: Any):
    placebo = Flight(PLACEBO, study.grid[0], 0)
    assert Batch((placebo,)) in together([*_flights(study.grid[0], 3), placebo], _nominal_s, 1)
    with pytest.raises(ValueError, match="PLACEBO is always flown whole"):
        Batch((placebo,), shared=True)


def test_a_known_baseline_is_flown_again_for_its_missing_mutants(study: Any):
    (batch,) = together(_flights(study.grid[0], 3, baseline=False), _nominal_s, 1)
    assert batch.flights[0] == batch.carrier


def test_a_single_mutant_of_a_known_baseline_is_flown_whole(study: Any):
    flights = _flights(study.grid[0], 1, baseline=False)
    assert together(flights, _nominal_s, 1) == alone(flights)


def test_a_lone_situation_keeps_every_process_busy(study: Any):
    batches = together(_flights(study.grid[0], 10 * LEAST_SHARING), _nominal_s, 4)
    assert len(batches) > 4
    assert all(len(batch.flights) > LEAST_SHARING for batch in batches)


def test_tasks_get_smaller_towards_the_end(study: Any):
    flights = [flight for situation in study.grid for flight in _flights(situation, 8 * LEAST_SHARING)]
    pieces = [batch.carrier.situation.key for batch in together(flights, _nominal_s, 2)]
    assert [pieces.count(situation.key) for situation in sorted(study.grid, key=lambda s: -s.nominal_s)] == [2, 2, 3, 4]


@pytest.mark.parametrize("jobs", [2, 4, 8, 16])
def test_processes_end_at_about_the_same_time_though_nobody_knows_how_long_a_mutant_flies(study: Any, jobs: int):
    draw = random.Random(0)
    situations = [replace(study.grid[0], key=f"S{number}", nominal_s=40.0 + 5.0 * number) for number in range(16)]
    flights = [flight for situation in situations for flight in _flights(situation, 100)]
    spent_s = {flight.name: draw.expovariate(1.0) * flight.situation.nominal_s for flight in flights if flight.mutant}
    ends_s = [0.0] * jobs
    for batch in together(flights, _nominal_s, jobs):
        took_s = batch.carrier.situation.nominal_s + sum(spent_s[f.name] for f in batch.flights if f.mutant)
        heapq.heapreplace(ends_s, ends_s[0] + took_s)
    assert max(ends_s) < 1.05 * sum(ends_s) / jobs


def test_a_baseline_with_few_mutants_is_not_flown_twice(study: Any):
    assert len(together(_flights(study.grid[0], 2 * LEAST_SHARING - 1), _nominal_s, 64)) == 1


@pytest.mark.parametrize("jobs", [1, 2, 7, 64])
def test_every_flight_is_in_one_task_and_only_baselines_are_flown_again(study: Any, jobs: int):
    flights = [f for i, situation in enumerate(study.grid) for f in _flights(situation, 30 * i, baseline=i != 1)]
    planned = [flight for batch in together(flights, _nominal_s, jobs) for flight in batch.flights]
    assert sorted(f.name for f in planned if f.mutant) == sorted(f.name for f in flights if f.mutant)
    assert {f.name for f in planned if not f.mutant} == {f"baseline/{s.key}/0" for s in study.grid}


def test_what_is_home_is_owed_no_longer(study: Any):
    batch = Batch(tuple(_flights(study.grid[0], 2)), shared=True)
    left = batch.without({"baseline/D0H0/0", "LATE-human@0s/D0H0/0"})
    assert left == Batch((Flight(_late(1), study.grid[0], 0),), shared=True)
    assert left.carrier == batch.carrier
    assert left.without({"LATE-human@1s/D0H0/0"}) is None


@pytest.mark.parametrize("text", ["", "10", "0s", "m", "-5m", "10 minutes", "1m1h", "1.5h"])
def test_a_budget_needs_a_time_above_0_with_its_unit(text: str):
    with pytest.raises(InputError, match="--budget="):
        budget_s(text)


@given(st.integers(0, 99), st.integers(0, 99), st.integers(1, 99))
def test_a_budget_is_the_sum_of_its_parts(hours: int, minutes: int, seconds: int):
    assert budget_s(f"{hours}h{minutes}m{seconds}s") == 3600 * hours + 60 * minutes + seconds


@given(st.lists(st.integers(1, 12), min_size=1, max_size=6), st.text(max_size=3), st.data())
def test_any_stretch_of_an_interleaved_order_has_its_share_of_every_stratum(
    sizes: list[int], seed: str, data: st.DataObject
):
    items = [(stratum, member) for stratum, size in enumerate(sizes) for member in range(size)]
    order = interleaved(items, lambda item: item[0], str, [seed])
    assert sorted(order) == items
    assert order == interleaved(items[::-1], lambda item: item[0], str, [seed])
    length = data.draw(st.integers(0, len(items)))
    for stratum, size in enumerate(sizes):
        flown = sum(item[0] == stratum for item in order[:length])
        assert abs(flown - size * length / len(items)) < 1 + len(sizes) * size / len(items)


def _whole(study: Any, seeds: Sequence[int] = (0,)) -> Plan:
    return plan(study.grid, seeds, defaults(study.matrix), None)


def _tasks(study: Any, planned: Plan, left: Sequence[Flight] | None = None) -> list[Batch]:
    def arrange(flights: Sequence[Flight]) -> list[Batch]:
        return together(flights, lambda flight: flight.situation.nominal_s, 1)

    everything = (*planned.baselines, *planned.mutants)
    return list(fair_order(study, planned, arrange, everything if left is None else left))


def test_the_order_has_every_planned_flight_once(study: Any):
    planned = _whole(study, (0, 1))
    flown = Counter(f.name for batch in _tasks(study, planned) for f in batch.flights if f.mutant)
    assert flown == Counter(flight.name for flight in planned.mutants)


def test_a_situation_begins_with_its_baseline_and_placebo(study: Any):
    first: dict[str, set[str]] = {}
    for batch in _tasks(study, _whole(study)):
        names = first.setdefault(batch.carrier.situation.key, set())
        if not {"baseline", "PLACEBO"} <= names:
            names.update(flight.subject.id for flight in batch.flights)
    assert all(18 >= len(names) > 2 and {"baseline", "PLACEBO"} <= names for names in first.values())


def test_every_situation_is_drawn_once_before_any_is_drawn_again(study: Any):
    shared = [batch.carrier.situation.key for batch in _tasks(study, _whole(study)) if batch.shared]
    assert all(len(set(shared[turn : turn + 4])) == 4 for turn in range(0, len(shared), 4))


def test_the_first_turn_flies_every_parameter_in_proportion(study: Any):
    planned = _whole(study)
    everything = Counter(f.subject.parameter for f in planned.mutants if f.subject.parameter)
    share = 4 * 16 / sum(everything.values())
    first = [batch for batch in _tasks(study, planned) if batch.shared][:4]
    flown = Counter(f.subject.parameter for batch in first for f in batch.flights if f.mutant)
    assert flown.keys() == everything.keys()
    assert all(abs(flown[name] - share * count) <= 4 for name, count in everything.items())


def test_situations_drawn_one_after_the_other_fly_other_groups(study: Any):
    first = [batch for batch in _tasks(study, _whole(study)) if batch.shared][:4]
    names = [flight.subject.id for batch in first for flight in batch.flights if flight.mutant]
    assert len(names) == len(set(names)) > 4 * 12


def test_each_mutant_has_the_same_chance_over_many_studies(study: Any):
    planned = plan(study.grid, (0,), defaults(study.matrix)[:40], None)
    tries, first = 300, Counter[str]()
    for number in range(tries):
        other = type(study)(study.folder, {**study.inputs, "sim": str(number)})
        (batch,) = islice((batch for batch in _tasks(other, planned) if batch.shared), 1)
        first.update(f.subject.id for f in batch.flights if f.mutant)
    chance = sum(first.values()) / (40 * tries)
    assert len(first) == 40
    assert all(abs(count / tries - chance) < 5 * (chance * (1 - chance) / tries) ** 0.5 for count in first.values())


def test_what_is_flown_is_left_out_and_the_rest_keeps_its_order(study: Any):
    planned = _whole(study)
    batches = _tasks(study, planned)
    home = {flight.name for batch in batches[:9] for flight in batch.flights} | {batches[9].flights[1].name}
    left = [flight for flight in (*planned.baselines, *planned.mutants) if flight.name not in home]
    owed = [{f.name for f in batch.flights if f.mutant} - home for batch in batches]
    rest = [{f.name for f in batch.flights if f.mutant} for batch in _tasks(study, planned, left)]
    assert rest == [names for names in owed if names]


def test_when_time_is_up_or_would_be_no_task_is_handed_out():
    now_s, handed = [0.0], []
    budget = Budget(10.0, clock=lambda: now_s[0])
    for batch in budget.while_it_lasts([Batch(())] * 9):
        handed.append(batch)
        now_s[0] += 4.0
    assert len(handed) == 3
    batches, budget = [Batch(()), Batch((), shared=True), Batch(())], Budget(10.0, clock=lambda: 0.0)
    assert list(budget.while_it_lasts(batches, lambda batch: 11.0 if batch.shared else 9.0)) == batches[:1]
    assert Budget(None).left_s == float("inf")


def _some(study: Any) -> Plan:
    return plan(study.grid, (0,), defaults(study.matrix)[:40], realise(study.matrix, CONTROL))


def test_a_run_whose_time_is_up_is_completed_by_one_without_budget_to_the_same_bytes(study: Any, log: Any, fly: Runs):
    undisturbed = fly(_some(study), "undisturbed")

    def slow(_flight: Flight, outcome: Outcome) -> Outcome:
        time.sleep(0.05)
        return outcome

    log.change = slow
    part = fly(_some(study), "budget", jobs=2, budget_s=2.0)
    assert part.left
    assert part.flown
    log.change = same
    rest = fly(_some(study), "budget")
    assert (rest.left, rest.flown) == ((), len(_some(study).known) + 1 - part.flown)
    assert fly.export(rest.outcomes) == fly.export(undisturbed.outcomes)


def test_a_budget_that_suffices_is_a_whole_run(study: Any, fly: Runs):
    undisturbed = fly(_some(study), "undisturbed")
    whole = fly(_some(study), "budget", budget_s=3600.0)
    assert whole.left == ()
    assert fly.export(whole.outcomes) == fly.export(undisturbed.outcomes)
