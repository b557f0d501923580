"""What a run with a budget flies: a fair sample, in an order that is always the same."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from itertools import islice
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from running import CONTROL, Runs, same

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.plan import Plan, plan, together
from scaloft_fi.campaign.runs.run import Budget, budget_s, fair_order, interleaved
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import defaults, realise


@pytest.mark.parametrize("text", ["", "10", "0s", "m", "-5m", "10 minutes", "1m1h", "1.5h"])
def test_a_budget_needs_a_time_above_0_with_its_unit(text: str) -> None:
    with pytest.raises(InputError, match="--budget="):
        budget_s(text)


@given(st.integers(0, 99), st.integers(0, 99), st.integers(1, 99))
def test_a_budget_is_the_sum_of_its_parts(hours: int, minutes: int, seconds: int) -> None:
    assert budget_s(f"{hours}h{minutes}m{seconds}s") == 3600 * hours + 60 * minutes + seconds


@given(st.lists(st.integers(1, 12), min_size=1, max_size=6), st.text(max_size=3), st.data())
def test_any_stretch_of_an_interleaved_order_has_its_share_of_every_stratum(
    sizes: list[int], seed: str, data: st.DataObject
) -> None:
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


def test_the_order_has_every_planned_flight_once(study: Any) -> None:
    planned = _whole(study, (0, 1))
    flown = Counter(f.name for batch in _tasks(study, planned) for f in batch.flights if f.mutant)
    assert flown == Counter(flight.name for flight in planned.mutants)


def test_a_situation_begins_with_its_baseline_and_placebo(study: Any) -> None:
    first: dict[str, set[str]] = {}
    for batch in _tasks(study, _whole(study)):
        names = first.setdefault(batch.carrier.situation.key, set())
        if not {"baseline", "PLACEBO"} <= names:
            names.update(flight.subject.id for flight in batch.flights)
    assert all(18 >= len(names) > 2 and {"baseline", "PLACEBO"} <= names for names in first.values())


def test_every_situation_is_drawn_once_before_any_is_drawn_again(study: Any) -> None:
    shared = [batch.carrier.situation.key for batch in _tasks(study, _whole(study)) if batch.shared]
    assert all(len(set(shared[turn : turn + 4])) == 4 for turn in range(0, len(shared), 4))


def test_the_first_turn_flies_every_parameter_in_proportion(study: Any) -> None:
    planned = _whole(study)
    everything = Counter(f.subject.parameter for f in planned.mutants if f.subject.parameter)
    share = 4 * 16 / sum(everything.values())
    first = [batch for batch in _tasks(study, planned) if batch.shared][:4]
    flown = Counter(f.subject.parameter for batch in first for f in batch.flights if f.mutant)
    assert flown.keys() == everything.keys()
    assert all(abs(flown[name] - share * count) <= 4 for name, count in everything.items())


def test_situations_drawn_one_after_the_other_fly_other_groups(study: Any) -> None:
    first = [batch for batch in _tasks(study, _whole(study)) if batch.shared][:4]
    names = [flight.subject.id for batch in first for flight in batch.flights if flight.mutant]
    assert len(names) == len(set(names)) > 4 * 12


def test_each_mutant_has_the_same_chance_over_many_studies(study: Any) -> None:
    planned = plan(study.grid, (0,), defaults(study.matrix)[:40], None)
    tries, first = 300, Counter[str]()
    for number in range(tries):
        other = type(study)(study.folder, {**study.inputs, "sim": str(number)})
        (batch,) = islice((batch for batch in _tasks(other, planned) if batch.shared), 1)
        first.update(f.subject.id for f in batch.flights if f.mutant)
    chance = sum(first.values()) / (40 * tries)
    assert len(first) == 40
    assert all(abs(count / tries - chance) < 5 * (chance * (1 - chance) / tries) ** 0.5 for count in first.values())


def test_what_is_flown_is_left_out_and_the_rest_keeps_its_order(study: Any) -> None:
    planned = _whole(study)
    batches = _tasks(study, planned)
    home = {flight.name for batch in batches[:9] for flight in batch.flights} | {batches[9].flights[1].name}
    left = [flight for flight in (*planned.baselines, *planned.mutants) if flight.name not in home]
    owed = [{f.name for f in batch.flights if f.mutant} - home for batch in batches]
    rest = [{f.name for f in batch.flights if f.mutant} for batch in _tasks(study, planned, left)]
    assert rest == [names for names in owed if names]


def test_when_time_is_up_or_would_be_no_task_is_handed_out() -> None:
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


def test_a_run_whose_time_is_up_is_completed_by_one_without_budget_to_the_same_bytes(
    study: Any, log: Any, fly: Runs
) -> None:
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


def test_a_budget_that_suffices_is_a_whole_run(study: Any, fly: Runs) -> None:
    undisturbed = fly(_some(study), "undisturbed")
    whole = fly(_some(study), "budget", budget_s=3600.0)
    assert whole.left == ()
    assert fly.export(whole.outcomes) == fly.export(undisturbed.outcomes)
