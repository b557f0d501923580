"""The search for a threshold on responses that are made up: what is asked, and what is concluded."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.margin import Margin, Scale, margin_of
from scaloft_fi.analysis.survivor import Reaction, Tried
from scaloft_fi.campaign.runs.margin import WIDENINGS, Search
from scaloft_fi.verbs.margin import margin_text

SECONDS = Scale("s", 1, 0.0)
LADDER = (0.5, 1.0, 3.0, 5.0)
LATE = Search(SECONDS, LADDER)
Response = Callable[[float], Reaction]


def searched(search: Search, response: Response) -> tuple[Margin, list[float]]:
    """The margin that a search ends at, and what it flew."""
    tried: dict[float, Tried] = {}
    flown: list[float] = []
    while asked := search.asks(tried):
        assert not set(asked) & set(tried), "a magnitude is flown once"
        flown += asked
        tried |= {m: Tried(m, response(m)) for m in asked}
        assert len(flown) < 60, "a search ends"
    return margin_of(search.scale, tried.values()), flown


def kills_from(threshold: float, sign: int = 1) -> Response:
    return lambda magnitude: Reaction.KILLED if sign * magnitude >= sign * threshold else Reaction.SURVIVED


@given(st.floats(0.5, 5.0, exclude_min=True))
def test_a_threshold_within_the_ladder_is_bracketed_to_a_tenth(threshold: float) -> None:
    found, flown = searched(LATE, kills_from(threshold))
    assert found.kills is not None
    assert found.survives is not None
    assert found.survives < threshold <= found.kills
    assert found.kills - found.survives <= 0.1 * found.kills * (1 + 1e-9)
    assert flown[: len(LADDER)] == list(LADDER)
    assert not found.again


@given(st.floats(0.05, 40.0), st.floats(1.0, 2.0))
def test_where_a_fault_is_only_seen_the_search_goes_on_as_if_it_were_killed(threshold: float, detected: float) -> None:
    def shown(magnitude: float) -> Reaction:
        if magnitude < threshold:
            return Reaction.SURVIVED
        return Reaction.KILLED if magnitude >= detected * threshold else Reaction.SEEN

    found, flown = searched(LATE, shown)
    killed, flown_too = searched(LATE, kills_from(threshold))
    assert flown == flown_too
    assert (found.survives, found.end) == (killed.survives, killed.kills)
    assert found.kills == min((m for m in flown if shown(m) is Reaction.KILLED), default=None)
    assert margin_text(found).startswith("seen") == (found.seen is not None and found.kills is None)


@given(st.floats(0.01, 40.0), st.floats(0.01, 2.0))
def test_a_tolerance_in_the_faults_own_unit_is_kept_where_the_threshold_is_found(threshold: float, wide: float) -> None:
    found, _ = searched(Search(SECONDS, LADDER, tolerance=wide), kills_from(threshold))
    if found.kills is not None and found.survives is not None:
        assert found.survives < threshold <= found.kills
        assert found.kills - found.survives <= max(wide, 1e-5 * found.kills) * (1 + 1e-6)


@given(st.floats(0.02, 1.0, exclude_max=True))
def test_what_gets_worse_as_it_shrinks_is_searched_downwards(threshold: float) -> None:
    factor = Search(Scale("x", -1, 1.0), (0.75, 0.5, 0.25), least=0.0)
    found, _ = searched(factor, kills_from(threshold, -1))
    assert found.kills is None or found.kills <= threshold
    assert found.survives is None or found.survives > threshold
    if 0.25 <= threshold < 0.75:
        assert found.kills is not None
        assert found.survives is not None
        assert found.survives - found.kills <= 0.1 * (1 - found.kills) * (1 + 1e-9)


def test_a_fault_that_never_kills_is_tried_a_little_beyond_the_ladder_and_no_further() -> None:
    found, flown = searched(LATE, kills_from(1e9))
    assert flown == [*LADDER, 10.0, 20.0, 40.0]
    assert len(flown) == len(LADDER) + WIDENINGS
    assert margin_text(found) == "> 40 s"


def test_a_fault_that_always_kills_is_tried_a_little_below_the_ladder_and_no_further() -> None:
    found, flown = searched(LATE, kills_from(0.0))
    assert flown == [*LADDER, 0.25, 0.125, 0.0625]
    assert margin_text(found) == "<= 0.0625 s"


def test_a_period_without_a_harmless_end_is_doubled() -> None:
    found, flown = searched(Search(Scale("s", -1), (60.0, 20.0, 10.0)), kills_from(1e9, -1))
    assert flown == [60.0, 20.0, 10.0, 120.0, 240.0, 480.0]
    assert margin_text(found) == ">= 480 s"


def test_the_operators_range_ends_the_search() -> None:
    share = Search(Scale("%", 1, 0.0), (25.0, 50.0, 60.0), lambda m: 0 <= m <= 100, 0.0, 100.0)
    found, flown = searched(share, kills_from(1000.0))
    assert flown == [25.0, 50.0, 60.0, 100.0]
    assert margin_text(found) == "> 100 %"


@given(st.integers(2, 30))
def test_an_operator_that_counts_is_asked_whole_numbers_only(threshold: int) -> None:
    def whole(magnitude: float) -> bool:
        return magnitude == int(magnitude) and magnitude >= 2

    frames = Search(Scale("frames", 1, 0.0), (2.0, 5.0), whole, 2.0, 1e3, tolerance=1.0)
    found, flown = searched(frames, kills_from(threshold))
    assert all(map(whole, flown))
    assert found.kills == threshold
    assert found.survives == (threshold - 1 if threshold > 2 else None)


def test_a_kill_only_at_infinity_is_approached_by_doubling() -> None:
    found, flown = searched(Search(SECONDS, (0.5, 3.0, float("inf"))), kills_from(11.0))
    assert flown[:5] == [0.5, 3.0, float("inf"), 6.0, 12.0]
    assert found.kills == pytest.approx(11.0, rel=0.1)


@given(st.lists(st.booleans(), min_size=4, max_size=4), st.integers(0, 2**32))
def test_a_response_that_is_not_monotone_is_said_and_its_interval_is_true(rungs: list[bool], salt: int) -> None:
    """Between the rungs the response is arbitrary: the interval's ends are still what was flown there."""

    def response(magnitude: float) -> Reaction:
        killed = rungs[LADDER.index(magnitude)] if magnitude in LADDER else hash((magnitude, salt)) % 2 == 0
        return Reaction.KILLED if killed else Reaction.SURVIVED

    found, flown = searched(LATE, response)
    survived = [m for m in flown if response(m) is Reaction.SURVIVED]
    assert found.kills == min((m for m in flown if response(m) is Reaction.KILLED), default=None)
    assert found.survives == max((m for m in survived if found.kills is None or m < found.kills), default=None)
    assert found.again == tuple(sorted(m for m in survived if found.kills is not None and m > found.kills))
    assert margin_text(found).endswith("!") == bool(found.again)


def test_where_nothing_can_be_shown_only_the_ladder_is_flown() -> None:
    found, flown = searched(LATE, lambda _m: Reaction.UNTESTED)
    assert flown == list(LADDER)
    assert margin_text(found) == "?"


def test_what_changes_no_sample_on_the_ladder_may_do_so_beyond_and_else_tells_nothing() -> None:
    def late(magnitude: float) -> Reaction:
        return Reaction.KILLED if magnitude >= 9 else Reaction.HARMLESS

    assert searched(LATE, late)[0].kills == pytest.approx(9.0, rel=0.1)
    found, flown = searched(LATE, lambda _m: Reaction.HARMLESS)
    assert len(flown) == len(LADDER) + WIDENINGS
    assert margin_text(found) == "?"
    assert not found.known


@given(st.floats(0.01, 40.0), st.integers(0, 12))
def test_a_search_that_is_stopped_goes_on_as_if_it_had_not_been(threshold: float, stop: int) -> None:
    response = kills_from(threshold)
    whole, flown = searched(LATE, response)
    tried = {m: Tried(m, response(m)) for m in flown[:stop]}
    while asked := LATE.asks(tried):
        tried |= {m: Tried(m, response(m)) for m in asked}
    assert set(tried) == set(flown)
    assert margin_of(SECONDS, tried.values()) == whole


@given(st.floats(1e-3, 1e3), st.floats(1e-6, 1.0))
def test_magnitudes_are_short_enough_for_an_id(start: float, step: float) -> None:
    low = float(f"{start:.6g}")
    high = float(f"{start + step:.6g}")
    for magnitude in Search(Scale("s", 1, 0.0), ())._between(low, high):
        assert float(f"{magnitude:g}") == magnitude
        assert low < magnitude < high
