"""The search for a threshold: without physics, what is flown and found; on made-up responses, what is asked."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from options import cases
from paper_flyer import made
from refused import refusal
from running import Runs, asked, quiet

from scaloft_fi.analysis.margin import Margin, Scale, lowest, margin_of, margins
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import PhasedFault, Reaction, Tried
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.margin import WIDENINGS, Search, find, target
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.study import Study
from scaloft_fi.verbs.margin import cell_margins, margin_text, margin_texts

LATE = PhasedFault("LATE-human", "s")
THREE = (0, 1, 2)
THRESHOLDS = {"D0H0": 1e9, "D0H1": 1.3, "D1H0": 2.2, "D1H1": 0.0}
"""From which delay LATE-human is too fast [s]; D1H1 is red without it."""


def delayed(flight: Flight, flown: Outcome) -> Outcome:
    """LATE-human violates SR2 from each situation's threshold on, and infects."""
    if flight.mutant is None or flight.mutant.cell != "LATE-human" or flight.situation.key == "D1H1":
        return flown
    kills = float(flight.mutant.arguments["delay_s"]) >= THRESHOLDS[flight.situation.key]
    kinds = {reading.requirement: reading.kind for reading in flown.readings}
    how = made(flown.subject, flown.situation, flown.seed, kinds, {"SR2": 7.0} if kills else {})
    told = {"readings": how.readings, "violations": how.violations}
    return replace(flown, **told, altered=3, infected_at_s=1.0, digest=flight.name)


@pytest.fixture
def late(log: Any) -> Any:
    log.change = delayed
    return log


def search(study: Any, flyer: Any, *texts: str, seeds: tuple[int, ...] = (0,), **more: Any) -> dict[str, Margin]:
    targets = [target(study.matrix, text, more.get("tolerance")) for text in texts or ("LATE-human",)]
    rounds = [more.get("rounds", 1000)]

    def say() -> Progress:
        rounds[0] -= 1
        if rounds[0] < 0:
            raise RuntimeError("the power failed")
        return quiet()

    options = RunOptions(jobs=1)
    where, folder = more.get("situations", study.grid), study.folder / more.get("folder", "c")
    found = find(study, targets, where, seeds, folder, options, progress=say, flyer=flyer)
    return {margin.situations[0]: margin for margin in found[targets[0].subject]}


def test_each_situation_has_its_own_threshold_between_what_survives_and_what_is_killed(study: Any, late: Any):
    found = search(study, late, seeds=THREE)
    for key in ("D0H1", "D1H0"):
        survives, kills = found[key].survives, found[key].kills
        assert survives < THRESHOLDS[key] <= kills
        assert kills - survives <= 0.1 * kills
    assert margin_text(found["D0H0"]) == "> 40 s"
    assert margin_text(lowest(found.values())) == margin_text(found["D0H1"])


def test_where_the_baseline_is_red_nothing_is_searched_beyond_the_ladder(study: Any, late: Any):
    found = search(study, late)
    assert margin_text(found["D1H1"]) == "?"
    ladder = {f"LATE-human@{rung}s/D1H1/0" for rung in ("0.5", "1", "3", "5")}
    assert {name for name in late.flown if name.startswith("LATE") and "D1H1" in name} == ladder


def test_a_tolerance_in_seconds_is_kept(study: Any, late: Any):
    found = search(study, late, tolerance=0.02)["D0H1"]
    assert found.end - found.survives == pytest.approx(0.02)


def test_the_same_search_again_flies_nothing_and_finds_the_same(study: Any, late: Any):
    first = search(study, late)
    flown = len(late.flown)
    assert search(study, late) == first
    assert len(late.flown) == flown


def test_what_another_verb_has_flown_is_not_flown_again(study: Any, late: Any):
    Runs(study, late)(asked(study, canary=""))
    search(study, late)
    assert late.flown.count("LATE-human@3s/D0H1/0") == 1


def test_a_search_in_one_situation_answers_the_same_whatever_the_campaign_holds_of_others(study: Any, late: Any):
    one = [study.grid.situation("D0H1")]
    alone = search(study, late, situations=one, folder="alone")
    search(study, late, folder="all")
    assert search(study, late, situations=one, folder="all") == alone


def test_a_search_that_dies_goes_on_where_it_stopped(study: Any, late: Any):
    whole = search(study, late)
    flown = sorted(name for name in late.flown if name.startswith("LATE"))
    (study.folder / "c" / STORE_NAME).unlink()
    late.path.unlink()
    with pytest.raises(RuntimeError, match="the power failed"):
        search(study, late, rounds=3)
    before = [name for name in late.flown if name.startswith("LATE")]
    assert 0 < len(before) < len(flown)
    assert search(study, late) == whole
    assert sorted(name for name in late.flown if name.startswith("LATE")) == flown


def test_with_one_seed_a_threshold_is_only_seen_and_found_all_the_same(study: Any, late: Any):
    found = search(study, late, seeds=(0,))["D0H1"]
    assert (found.kills, margin_text(found)[:5]) == (None, "seen ")
    assert found.survives < 1.3 <= found.end
    (seen,) = [entry for entry in found.tried if entry.magnitude == found.seen]
    assert (seen.reaction, seen.violated, seen.flown) == (Reaction.SEEN, (("SR2", 1),), 1)
    assert seen.needed is not None


def test_a_kill_takes_most_of_the_flights(study: Any, late: Any):
    def seeded(flight: Flight, flown: Outcome) -> Outcome:
        """Calm with two seeds of three."""
        calm = flight.seed in (1, 2) and flight.mutant is not None and flight.mutant.cell == "LATE-human"
        quiet = replace(flown, readings=tuple(replace(r, rho=1.0, violated_at_s=None) for r in flown.readings))
        return replace(quiet, violations=(), altered=3, digest=flight.name) if calm else delayed(flight, flown)

    late.change = seeded
    assert margin_text(search(study, late, seeds=THREE)["D0H1"]) == "> 40 s"


def test_the_pool_is_flown_where_a_magnitude_infects_and_nowhere_else(study: Any, log: Any):
    def near(flight: Flight, flown: Outcome) -> Outcome:
        """LATE-human infects where a person is."""
        late = flight.mutant is not None and flight.mutant.cell == "LATE-human" and flight.situation.key.endswith("H0")
        return replace(flown, altered=0, infected_at_s=None) if late else flown

    log.change = near
    search(study, log)
    flown = Counter(name.split("/")[1] for name in set(log.flown) if name.startswith("baseline/"))
    assert flown == {"D0H0": 1, "D0H1": 10, "D1H0": 1, "D1H1": 10}


def test_a_campaign_without_a_pool_is_given_one(study: Any, late: Any):
    rungs = [f"LATE-human@{rung}s" for rung in ("0.5", "1", "3", "5")]
    Runs(study, late)(asked(study, THREE, rungs, canary=""))
    assert sum(name.startswith("baseline/D0H1") for name in set(late.flown)) == 3
    found = search(study, late, seeds=THREE)
    assert sum(name.startswith("baseline/D0H1") for name in set(late.flown)) == 10
    assert found["D0H1"].kills == pytest.approx(1.3, rel=0.1)


def test_more_seeds_than_asked_for_count_and_are_not_flown_again(study: Any, late: Any):
    whole = search(study, late, seeds=THREE)
    flown = len(late.flown)
    assert search(study, late, seeds=(0,)) == whole
    assert len(late.flown) == flown


def test_magnitudes_off_the_ladder_are_in_no_ratio(study: Any, late: Any):
    search(study, late)
    outcomes = Runs(study, late).current()
    scored = score(outcomes, study.roster, study.space)
    only = [outcome for outcome in outcomes if outcome.mutant in (BASELINE, PLACEBO.id, "LATE-human@3s")]
    bare = score(only, study.roster, study.space)
    assert len({outcome.mutant for outcome in outcomes}) > 8
    for name in ("exercised", "infected", "tested", "mutation_score", "operability"):
        assert getattr(scored, name) == getattr(bare, name)


def test_the_matrix_shows_the_margin_from_the_store_alone(study: Any, late: Any):
    found = search(study, late)
    outcomes = Runs(study, late).current()
    scored = score(outcomes, study.roster, study.space)
    told = margin_texts(study.matrix, cell_margins(scored, study.matrix))
    assert told["LATE-human"] == margin_text(lowest(found.values()))
    assert told["REVERSE-human"] == "CONTROL"
    assert told["EARLY-collision"] == "-"
    assert told["MORE-goal"] == "?"
    assert {margin.situations[0]: margin for margin in margins(outcomes, scored, study.matrix)[LATE]} == found


def test_a_phase_has_a_margin_of_its_own(study: Any):
    shifted = target(study.matrix, "UNINTENDED-human@20s#5s")
    assert shifted.id_of(30.0) == "UNINTENDED-human@30s#5s"
    assert shifted.subject == PhasedFault("UNINTENDED-human", "s", 5.0)
    struck = target(study.matrix, "NO-velcmd#sight")
    assert struck.id_of(2.0) == "NO-velcmd@2s#sight"
    assert struck.subject == PhasedFault("NO-velcmd", "s", event="sight")


def test_the_unit_picks_the_fault(study: Any):
    assert target(study.matrix, "NO-depth").subject.unit == "s"
    assert target(study.matrix, "NO-depth@90%").subject.unit == "%"
    assert target(study.matrix, "NO-depth@90%").search.most == 100.0


@cases("text", "says")
def test_a_fault_without_an_order_is_refused_in_a_sentence(study: Any, text: str, says: str):
    assert says in refusal(target, study.matrix, text)


@pytest.mark.flight
@pytest.mark.release
def test_the_margin_of_late_human_in_flight_lies_between_its_rungs(tmp_path: Path):
    """Delays of the detection beyond the time that SR2 allows violate it, delays within the drone's slack do not."""
    study = Study.open(Path(__file__).parents[3])
    goal = target(study.matrix, "LATE-human", tolerance=0.5)
    (situation,) = study.grid.select(["T0O0W0D0H1"])
    found = find(study, [goal], [situation], (0,), tmp_path, progress=quiet)
    (margin,) = found[goal.subject]
    assert margin.end - margin.survives <= 0.5
    assert margin.end <= 3.0


SECONDS = Scale("s", 1, 0.0)
LADDER = (0.5, 1.0, 3.0, 5.0)
SEARCH = Search(SECONDS, LADDER)
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
def test_a_threshold_within_the_ladder_is_bracketed_to_a_tenth(threshold: float):
    found, flown = searched(SEARCH, kills_from(threshold))
    assert found.survives < threshold <= found.kills
    assert found.kills - found.survives <= 0.1 * found.kills * (1 + 1e-9)
    assert flown[: len(LADDER)] == list(LADDER)
    assert not found.again


@given(st.floats(0.05, 40.0), st.floats(1.0, 2.0))
def test_where_a_fault_is_only_seen_the_search_goes_on_as_if_it_were_killed(threshold: float, detected: float):
    def shown(magnitude: float) -> Reaction:
        if magnitude < threshold:
            return Reaction.SURVIVED
        return Reaction.KILLED if magnitude >= detected * threshold else Reaction.SEEN

    found, flown = searched(SEARCH, shown)
    killed, flown_too = searched(SEARCH, kills_from(threshold))
    assert flown == flown_too
    assert (found.survives, found.end) == (killed.survives, killed.kills)
    assert found.kills == min((m for m in flown if shown(m) is Reaction.KILLED), default=None)
    assert margin_text(found).startswith("seen") == (found.seen is not None and found.kills is None)


@given(st.floats(0.01, 40.0), st.floats(0.01, 2.0))
def test_a_tolerance_in_the_faults_own_unit_is_kept_where_the_threshold_is_found(threshold: float, wide: float):
    found, _ = searched(Search(SECONDS, LADDER, tolerance=wide), kills_from(threshold))
    if found.kills is not None and found.survives is not None:
        assert found.survives < threshold <= found.kills
        assert found.kills - found.survives <= max(wide, 1e-5 * found.kills) * (1 + 1e-6)


@given(st.floats(0.02, 1.0, exclude_max=True))
def test_what_gets_worse_as_it_shrinks_is_searched_downwards(threshold: float):
    factor = Search(Scale("x", -1, 1.0), (0.75, 0.5, 0.25), least=0.0)
    found, _ = searched(factor, kills_from(threshold, -1))
    assert found.kills is None or found.kills <= threshold
    assert found.survives is None or found.survives > threshold
    if 0.25 <= threshold < 0.75:
        assert found.survives - found.kills <= 0.1 * (1 - found.kills) * (1 + 1e-9)


SHARE = Search(Scale("%", 1, 0.0), (25.0, 50.0, 60.0), lambda m: 0 <= m <= 100, 0.0, 100.0)
PERIOD = Search(Scale("s", -1), (60.0, 20.0, 10.0))


@pytest.mark.parametrize(
    ("search", "response", "beyond", "said"),
    [
        pytest.param(SEARCH, kills_from(1e9), [10.0, 20.0, 40.0], "> 40 s", id="never"),
        pytest.param(SEARCH, kills_from(0.0), [0.25, 0.125, 0.0625], "<= 0.0625 s", id="always"),
        pytest.param(PERIOD, kills_from(1e9, -1), [120.0, 240.0, 480.0], ">= 480 s", id="no harmless end"),
        pytest.param(SHARE, kills_from(1000.0), [100.0], "> 100 %", id="the end of the operator's range"),
        pytest.param(SEARCH, lambda _m: Reaction.UNTESTED, [], "?", id="nothing can be shown"),
    ],
)
def test_a_fault_without_a_threshold_is_tried_a_little_beyond_the_ladder_and_no_further(
    search: Search, response: Response, beyond: list[float], said: str
):
    found, flown = searched(search, response)
    assert flown == [*search.ladder, *beyond]
    assert len(beyond) <= WIDENINGS
    assert margin_text(found) == said


@given(st.integers(2, 30))
def test_an_operator_that_counts_is_asked_whole_numbers_only(threshold: int):
    def whole(magnitude: float) -> bool:
        return magnitude == int(magnitude) and magnitude >= 2

    frames = Search(Scale("frames", 1, 0.0), (2.0, 5.0), whole, 2.0, 1e3, tolerance=1.0)
    found, flown = searched(frames, kills_from(threshold))
    assert all(map(whole, flown))
    assert found.kills == threshold
    assert found.survives == (threshold - 1 if threshold > 2 else None)


def test_a_kill_only_at_infinity_is_approached_by_doubling():
    found, flown = searched(Search(SECONDS, (0.5, 3.0, float("inf"))), kills_from(11.0))
    assert flown[:5] == [0.5, 3.0, float("inf"), 6.0, 12.0]
    assert found.kills == pytest.approx(11.0, rel=0.1)


@given(st.lists(st.booleans(), min_size=4, max_size=4), st.integers(0, 2**32))
def test_a_response_that_is_not_monotone_is_said_and_its_interval_is_true(rungs: list[bool], salt: int):
    """Between the rungs the response is arbitrary: the interval's ends are still what was flown there."""

    def response(magnitude: float) -> Reaction:
        killed = rungs[LADDER.index(magnitude)] if magnitude in LADDER else hash((magnitude, salt)) % 2 == 0
        return Reaction.KILLED if killed else Reaction.SURVIVED

    found, flown = searched(SEARCH, response)
    survived = [m for m in flown if response(m) is Reaction.SURVIVED]
    assert found.kills == min((m for m in flown if response(m) is Reaction.KILLED), default=None)
    assert found.survives == max((m for m in survived if found.kills is None or m < found.kills), default=None)
    assert found.again == tuple(sorted(m for m in survived if found.kills is not None and m > found.kills))
    assert margin_text(found).endswith("!") == bool(found.again)


def test_what_changes_no_sample_on_the_ladder_may_do_so_beyond_and_else_tells_nothing():
    def late(magnitude: float) -> Reaction:
        return Reaction.KILLED if magnitude >= 9 else Reaction.HARMLESS

    assert searched(SEARCH, late)[0].kills == pytest.approx(9.0, rel=0.1)
    found, flown = searched(SEARCH, lambda _m: Reaction.HARMLESS)
    assert len(flown) == len(LADDER) + WIDENINGS
    assert margin_text(found) == "?"
    assert not found.known


@given(st.floats(0.01, 40.0), st.integers(0, 12))
def test_a_search_that_is_stopped_goes_on_as_if_it_had_not_been(threshold: float, stop: int):
    response = kills_from(threshold)
    whole, flown = searched(SEARCH, response)
    tried = {m: Tried(m, response(m)) for m in flown[:stop]}
    while asked := SEARCH.asks(tried):
        tried |= {m: Tried(m, response(m)) for m in asked}
    assert set(tried) == set(flown)
    assert margin_of(SECONDS, tried.values()) == whole


@given(st.floats(1e-3, 1e3), st.floats(1e-6, 1.0))
def test_magnitudes_are_short_enough_for_an_id(start: float, step: float):
    low = float(f"{start:.6g}")
    high = float(f"{start + step:.6g}")
    for magnitude in Search(Scale("s", 1, 0.0), ())._between(low, high):
        assert float(f"{magnitude:g}") == magnitude
        assert low < magnitude < high
