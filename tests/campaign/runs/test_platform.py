"""Runs of a campaign whose flights another platform flew: a sample decides whether they count."""

from __future__ import annotations

import io
import os
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.plan.plan import Plan, plan
from scaloft_fi.campaign.progress.progress import Progress
from scaloft_fi.campaign.runs.platform import BASELINES, MUTANTS, sample_of
from scaloft_fi.campaign.runs.run import Report, run
from scaloft_fi.campaign.store.folder import STORE_NAME
from scaloft_fi.campaign.store.held import Held, held_in
from scaloft_fi.campaign.store.platforms import warning_for
from scaloft_fi.campaign.store.selection import Flown
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.campaign.workers.interrupt import Interrupted
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.derive import realise

CONTROL, LATE = "REVERSE-velcmd", "LATE-human@3s"
FLIGHTS = 13

Move = Callable[[str], None]


@pytest.fixture
def move(monkeypatch: pytest.MonkeyPatch) -> Move:
    """Gives this process a platform that differs in the version of numpy."""

    def to(numpy: str) -> None:
        for module in ("runs.platform", "store.platforms", "runs.baseline_pool"):
            monkeypatch.setattr(f"scaloft_fi.campaign.{module}.fingerprint", lambda: {"numpy": numpy})

    to("1")
    return to


def _warning(path: Path) -> str:
    with Store(path, create=False) as store:
        return warning_for(store)


def _held(study: Any) -> Held:
    with Store(study.folder / "c" / STORE_NAME, create=False) as store:
        return held_in(study, store, study.folder / "c")


def _plan(study: Any, seeds: tuple[int, ...] = (0,)) -> Plan:
    return plan(study.grid, seeds, [realise(study.matrix, LATE)], realise(study.matrix, CONTROL))


def _run(study: Any, log: Any, planned: Plan | None = None) -> tuple[Report, str]:
    stream = io.StringIO()
    report = run(study, planned or _plan(study), study.folder / "c", progress=Progress(stream=stream), flyer=log)
    return report, stream.getvalue()


def _otherwise(_flight: Flight, outcome: Outcome) -> Outcome:
    return replace(outcome, digest=f"{outcome.digest}, last bit other")


def test_after_a_change_of_platform_a_sample_is_flown_again_and_where_it_agrees_all_flights_count(
    study: Any, log: Any, move: Move
) -> None:
    first, _ = _run(study, log)
    before = len(log.flown)
    move("2")
    assert "numpy 2 here, 1 there" in _warning(study.folder / "c" / STORE_NAME)
    second, said = _run(study, log)
    again = log.flown[before:]
    assert second.flown == 0
    assert second.outcomes == first.outcomes
    assert len(again) == BASELINES + MUTANTS == len(set(again))
    assert sum(name.startswith("baseline/") for name in again) == BASELINES
    assert "the platform has changed (numpy 2 here, 1 there); 5 stored flights are flown again" in said
    assert "the stored flights count" in said
    assert _warning(study.folder / "c" / STORE_NAME) == ""


def test_a_platform_that_agreed_is_not_asked_again(study: Any, log: Any, move: Move) -> None:
    _run(study, log)
    move("2")
    _run(study, log)
    before = len(log.flown)
    for numpy in ("1", "2"):
        move(numpy)
        assert "platform" not in _run(study, log)[1]
    assert len(log.flown) == before


def test_where_a_digest_differs_the_stored_flights_are_outgrown_with_the_reason_and_flown_again(
    study: Any, log: Any, move: Move
) -> None:
    _run(study, log)
    before = len(log.flown)
    move("2")
    log.change = _otherwise
    report, said = _run(study, log)
    assert report.flown == FLIGHTS
    assert len(log.flown) == before + BASELINES + MUTANTS + FLIGHTS + 1  # one flight of a run is repeated
    assert f"came out with another digest: {FLIGHTS} stored flights of the earlier platform do not count" in said
    assert all(outcome.digest.endswith("last bit other") for outcome in report.outcomes)
    now = _held(study)
    assert len(now.current) == FLIGHTS
    assert now.why == {"flown on a platform with other digests: numpy 2 here, 1 there": FLIGHTS}
    assert now.owed == 0


def test_what_is_outgrown_and_not_asked_for_is_not_flown_again(study: Any, log: Any, move: Move) -> None:
    _run(study, log)
    move("2")
    log.change = _otherwise
    report, _ = _run(study, log, plan(study.grid[:1], (0,), [realise(study.matrix, CONTROL)], None))
    assert report.flown == 3
    assert _held(study).stale == FLIGHTS


def test_there_and_back_again_loses_no_flight_and_doubles_none(study: Any, log: Any, move: Move) -> None:
    _run(study, log)
    for numpy, change in (("2", _otherwise), ("1", lambda _flight, outcome: outcome)) * 2:
        move(numpy)
        log.change = change
        report, _ = _run(study, log)
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
    stored = [Flown(f"k{n}", "baseline" if n % 2 else LATE, "D0H0", n, 1) for n in range(40)]
    one, other = sample_of(stored, "numpy 2"), sample_of(stored[::-1], "numpy 2")
    assert one == other
    assert {flight.seed for flight in one} != {flight.seed for flight in sample_of(stored, "numpy 3")}
    assert sample_of(stored[:1], "numpy 2") == stored[:1]
