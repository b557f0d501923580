"""Runs of a campaign whose flights another platform flew: a sample decides whether they count."""

from __future__ import annotations

import io
import os
import signal
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import pytest

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.plan import Plan, plan
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import BASELINES, MUTANTS, RunOptions, sample_of
from scaloft_fi.campaign.runs.run import Report, run
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Held, current_in, held_in
from scaloft_fi.campaign.store.platforms import Platforms, warning_for
from scaloft_fi.campaign.store.store import FlownFlight, Store
from scaloft_fi.campaign.workers.local import Interrupted
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import flights_of
from scaloft_fi.mutants.catalogue import realise

CONTROL, LATE = "REVERSE-velcmd", "LATE-human@3s"
FLIGHTS = 13

Move = Callable[[str], None]


@pytest.fixture
def move(monkeypatch: pytest.MonkeyPatch) -> Move:
    """Gives this process a platform that differs in the version of numpy."""

    def to(numpy: str) -> None:
        for module in ("runs.gates", "runs.run", "store.platforms"):
            monkeypatch.setattr(f"scaloft_fi.campaign.{module}.fingerprint", lambda: {"numpy": numpy})

    to("1")
    return to


def _warning(study: Any) -> str:
    with Store(study.folder / "c" / STORE_NAME, create=False) as store:
        return warning_for(Platforms(store), current_in(study, store))


def _held(study: Any) -> Held:
    with Store(study.folder / "c" / STORE_NAME, create=False) as store:
        return held_in(study, store, study.folder / "c")


def _plan(study: Any, seeds: tuple[int, ...] = (0,)) -> Plan:
    return plan(study.grid, seeds, [realise(study.matrix, LATE)], realise(study.matrix, CONTROL))


def _run(study: Any, log: Any, planned: Plan | None = None, **options: Any) -> tuple[Report, str]:
    stream, options = io.StringIO(), RunOptions(**options)
    report = run(
        study, planned or _plan(study), study.folder / "c", options, progress=Progress(stream=stream), flyer=log
    )
    return report, stream.getvalue()


def _same(_flight: Flight, outcome: Outcome) -> Outcome:
    return outcome


def _otherwise(_flight: Flight, outcome: Outcome) -> Outcome:
    """Other bits, the same facts."""
    return replace(outcome, digest=f"{outcome.digest}, last bit other")


def _landless(flight: Flight, outcome: Outcome) -> Outcome:
    """Other bits, and other facts in the flights of mutants."""
    changed = _otherwise(flight, outcome)
    return changed if flight.mutant is None else replace(changed, ending="timed_out")


def _statuses(outcomes: Sequence[Outcome]) -> Counter[str]:
    return Counter(flight.status.value for flight in flights_of(outcomes))


def test_after_a_change_of_platform_a_sample_is_flown_again_and_where_it_agrees_all_flights_count(
    study: Any, log: Any, move: Move
) -> None:
    first, _ = _run(study, log)
    before = len(log.flown)
    move("2")
    assert "numpy 2 here, 1 there" in _warning(study)
    second, said = _run(study, log)
    again = log.flown[before:]
    assert second.flown == 0
    assert second.outcomes == first.outcomes
    assert len(again) == BASELINES + MUTANTS == len(set(again))
    assert sum(name.startswith("baseline/") for name in again) == BASELINES
    assert "the platform has changed (numpy 2 here, 1 there); 5 stored flights are flown again" in said
    assert "the stored flights count" in said
    assert _warning(study) == ""


def test_a_platform_that_agreed_is_not_asked_again(study: Any, log: Any, move: Move) -> None:
    _run(study, log)
    move("2")
    _run(study, log)
    before = len(log.flown)
    for numpy in ("1", "2"):
        move(numpy)
        assert "platform" not in _run(study, log)[1]
    assert len(log.flown) == before


def test_where_only_bits_differ_the_stored_flights_count_and_nothing_else_is_flown(
    study: Any, log: Any, move: Move
) -> None:
    first, _ = _run(study, log)
    before = len(log.flown)
    move("2")
    log.change = _otherwise
    second, said = _run(study, log)
    assert (second.flown, second.outcomes, second.mixture) == (0, first.outcomes, "")
    assert len(log.flown) == before + BASELINES + MUTANTS
    assert "the platform has changed (numpy 2 here, 1 there)" in said
    assert "5 of 5 stored flights have other digests on this platform, and all have the same status, ending" in said
    assert _warning(study) == ""
    assert _run(study, log)[1].count("platform") == 0  # the answer is remembered


def test_a_flight_that_is_missing_beside_flights_of_another_platform_has_its_pair_flown_again(
    study: Any, log: Any, move: Move
) -> None:
    first, _ = _run(study, log)
    before = len(log.flown)
    move("2")
    log.change = _otherwise
    late, more = realise(study.matrix, LATE), realise(study.matrix, "MORE-goal@1m")
    report, said = _run(study, log, plan(study.grid[:1], (0, 1), [late, more], None))
    again = log.flown[before + BASELINES + MUTANTS :]
    assert {name for name in again if "/D0H0/0" in name} == {
        *(outcome.name for outcome in first.outcomes if (outcome.situation, outcome.seed) == ("D0H0", 0)),
        f"{more.id}/D0H0/0",
    }
    assert "stored flights of another platform are flown again" in said
    by_pair: dict[tuple[str, int], set[bool]] = {}
    current = _held(study).current
    for outcome in current:
        here = outcome.digest.endswith("last bit other")
        by_pair.setdefault((outcome.situation, outcome.seed), set()).add(here)
    assert by_pair == {(key, 0): {key == "D0H0"} for key in ("D0H0", "D0H1", "D1H0", "D1H1")} | {("D0H0", 1): {True}}
    assert {outcome.name for outcome in first.outcomes} <= {outcome.name for outcome in current}
    assert "flights of one platform and" in _warning(study)
    assert "of another (numpy" in _warning(study)
    assert _statuses(report.outcomes)["not_infected"] == 4  # PLACEBO and LATE equal the baseline of their own platform
    assert report.mixture == ""  # all flights of this request come from one platform


def test_a_mutant_is_never_judged_beside_a_baseline_of_another_platform(study: Any, log: Any, move: Move) -> None:
    """Two platforms take turns; each adds a mutant or a seed, and the statuses stay those of one platform."""
    mutants = [realise(study.matrix, name) for name in (LATE, "MORE-goal@1m", CONTROL)]
    for number, last in enumerate((1, 2, 3, 3)):
        move(str(number % 2))
        log.change = _otherwise if number % 2 else _same
        planned = plan(study.grid[: number + 1], range(number + 1), mutants[:last], None)
        report, _ = _run(study, log, planned)
        for _ in range(2):
            again, _ = _run(study, log, planned)
            assert (again.flown, again.outcomes) == (0, report.outcomes)
    pairs: dict[tuple[str, int], set[bool]] = {}
    for outcome in report.outcomes:
        pairs.setdefault((outcome.situation, outcome.seed), set()).add(outcome.digest.endswith("other"))
    assert all(len(platforms) == 1 for platforms in pairs.values())
    assert len(set(map(tuple, pairs.values()))) == 2
    assert "each mutant is judged beside a baseline of its own platform" in report.mixture
    move("1")
    log.change = _same
    whole = run(study, planned, study.folder / "one", progress=Progress(stream=io.StringIO()), flyer=log)
    assert _statuses(report.outcomes) == _statuses(whole.outcomes)


@pytest.mark.parametrize(("change", "options"), [(_landless, {}), (_otherwise, {"same_platform": True})])
def test_flights_with_other_facts_or_bits_by_the_strict_rule_are_outgrown_with_the_reason_and_flown_again(
    study: Any, log: Any, move: Move, change: Any, options: dict[str, bool]
) -> None:
    _run(study, log)
    before = len(log.flown)
    move("2")
    log.change = change
    report, said = _run(study, log, **options)
    assert report.flown == FLIGHTS
    assert len(log.flown) == before + BASELINES + MUTANTS + FLIGHTS + 1  # one flight of a run is repeated
    assert f"{FLIGHTS} stored flights of the earlier platform do not count" in said
    assert ("in more than bits: " in said) == (change is _landless)
    assert all(outcome.digest.endswith("last bit other") for outcome in report.outcomes)
    now = _held(study)
    assert len(now.current) == FLIGHTS
    assert now.why == {"flown on a platform with other digests: numpy 2 here, 1 there": FLIGHTS}
    assert now.owed == 0
    assert _warning(study) == ""


def test_the_strict_rule_ends_a_campaign_of_two_platforms(study: Any, log: Any, move: Move) -> None:
    _run(study, log)
    move("2")
    log.change = _otherwise
    _run(study, log)
    report, said = _run(study, log, same_platform=True)
    assert report.flown == FLIGHTS
    assert f"{FLIGHTS} flights of another platform (numpy 2 here, 1 there) have other digests: they do not" in said


def test_what_is_outgrown_and_not_asked_for_is_not_flown_again(study: Any, log: Any, move: Move) -> None:
    _run(study, log)
    move("2")
    log.change = _otherwise
    planned = plan(study.grid[:1], (0,), [realise(study.matrix, CONTROL)], None)
    report, _ = _run(study, log, planned, same_platform=True)
    assert report.flown == 3
    assert _held(study).stale == FLIGHTS
    again = {f"{subject}/D0H0/0" for subject in ("baseline", "PLACEBO", CONTROL)}
    assert _held(study).owed == FLIGHTS - len({outcome.name for outcome in report.outcomes} & again)


def test_there_and_back_again_loses_no_flight_and_doubles_none(study: Any, log: Any, move: Move) -> None:
    _run(study, log)
    for numpy, change in (("2", _otherwise), ("1", _same)) * 2:
        move(numpy)
        log.change = change
        report, _ = _run(study, log, same_platform=True)
        assert report.flown == FLIGHTS
    now = _held(study)
    assert len(now.current) == FLIGHTS
    assert sorted(now.why.values()) == [FLIGHTS, FLIGHTS]


def test_flights_that_do_not_count_anyway_are_set_apart_without_a_sample(study: Any, log: Any, move: Move) -> None:
    _run(study, log)
    before = len(log.flown)
    move("2")
    changed = replace(study, inputs={**study.inputs, "sim": "other"})
    report, _ = _run(changed, log)
    assert report.flown == FLIGHTS
    assert len(log.flown) == before + FLIGHTS + 1
    assert _held(study).current == ()


def test_a_sample_that_the_harness_cannot_fly_decides_nothing(study: Any, log: Any, move: Move) -> None:
    _run(study, log)
    move("2")
    log.change = lambda _flight, outcome: replace(outcome, invalid="no memory")
    with pytest.raises(GateError, match=r"no stored flight could be flown again: .*: no memory"):
        _run(study, log)
    log.change = lambda _flight, outcome: outcome
    assert _run(study, log)[0].flown == 0


def test_a_sample_that_is_interrupted_decides_nothing(study: Any, log: Any, move: Move) -> None:
    def interrupt(_flight: Flight, outcome: Outcome) -> Outcome:
        os.kill(os.getppid(), signal.SIGINT)
        return replace(outcome, digest="other")

    _run(study, log)
    move("2")
    log.change = interrupt
    with pytest.raises(Interrupted):
        _run(study, log)
    log.change = lambda _flight, outcome: outcome
    assert _run(study, log)[0].flown == 0


def test_an_empty_store_takes_the_platform_of_its_first_flight(study: Any, log: Any, move: Move) -> None:
    (study.folder / "c").mkdir()
    with Store(study.folder / "c" / STORE_NAME):
        pass
    _run(study, log)
    with Store(study.folder / "c" / STORE_NAME, create=False) as store:
        assert store.meta() == {"numpy": "1"}


def test_the_sample_is_drawn_by_hash_and_not_by_order() -> None:
    stored = [FlownFlight(f"k{n}", "baseline" if n % 2 else LATE, "D0H0", n, 1) for n in range(40)]
    one, other = sample_of(stored, "numpy 2"), sample_of(stored[::-1], "numpy 2")
    assert one == other
    assert {flight.seed for flight in one} != {flight.seed for flight in sample_of(stored, "numpy 3")}
    assert sample_of(stored[:1], "numpy 2") == stored[:1]
