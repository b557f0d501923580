from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.pool import LEAST
from scaloft_fi.campaign.plan import parse_seeds, plan
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


@pytest.mark.parametrize(("text", "meant"), [("1", (0,)), ("3", (0, 1, 2)), ("4-6", (4, 5, 6)), ("7-7", (7,))])
def test_seeds_are_a_number_or_a_range(text: str, meant: tuple[int, ...]) -> None:
    assert parse_seeds(text) == meant


@pytest.mark.parametrize("text", ["0", "-1", "5-4", "a", "", "1,2", "1-", "999999999"])
def test_other_seeds_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="--seeds="):
        parse_seeds(text)


@given(st.integers(0, 500), st.integers(0, 50))
def test_a_range_of_seeds_has_both_ends(first: int, more: int) -> None:
    meant = parse_seeds(f"{first}-{first + more}")
    assert (meant[0], meant[-1], len(meant)) == (first, first + more, more + 1)


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
