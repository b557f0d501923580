"""Campaigns of a stack that does not repeat its bits: nothing is shared, nothing is compared by digest."""

from __future__ import annotations

import io
import secrets
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from scaloft_fi.campaign.flight import Batch, Flight
from scaloft_fi.campaign.plan import Plan, plan
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.merge import merge
from scaloft_fi.campaign.runs.run import Report, opened, run
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import PLACEBO_ID, Outcome, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import Status, flights_of
from scaloft_fi.mutants.catalogue import realise

SEEDS = tuple(range(10))


@pytest.fixture
def noisy(study: Any) -> Any:
    return replace(study, stack=replace(study.stack, deterministic=False))


def _bits(_flight: Flight, outcome: Outcome) -> Outcome:
    """No flight repeats its bits."""
    return replace(outcome, digest=secrets.token_hex(32))


def _violating_placebo(flight: Flight, outcome: Outcome) -> Outcome:
    """PLACEBO violates SR2 wherever the baseline does not."""
    if flight.subject.id != PLACEBO_ID or outcome.violations:
        return _bits(flight, outcome)
    violation = Violation("SR2", Kind.SAFETY, 7.0, 0.1, 1.0, 1.6, "")
    readings = tuple(
        replace(reading, rho=-1.0, violated_at_s=7.0) if reading.requirement == "SR2" else reading
        for reading in outcome.readings
    )
    return replace(_bits(flight, outcome), violations=(violation,), readings=readings)


def _plan(study: Any) -> Plan:
    return plan(
        study.grid, (0, 1, 2), [realise(study.matrix, "LATE-human@3s")], realise(study.matrix, "REVERSE-velcmd")
    )


def _run(study: Any, log: Any, folder: str = "c", planned: Plan | None = None) -> Report:
    progress, flights = Progress(stream=io.StringIO()), (planned or _plan(study)).with_pool(SEEDS)
    return run(study, flights, study.folder / folder, RunOptions(), progress=progress, flyer=log)


def test_flights_of_other_bits_pass_the_gates_and_placebo_is_held_against_the_pool(noisy: Any, log: Any) -> None:
    log.change = _bits
    report = _run(noisy, log)
    assert len({outcome.digest for outcome in report.outcomes}) == len(report.outcomes)
    assert any(outcome.mutant == PLACEBO_ID for outcome in report.outcomes)


def test_the_same_flights_of_a_deterministic_stack_fail_them(study: Any, log: Any) -> None:
    log.change = _bits
    with pytest.raises(GateError, match="PLACEBO differs from the baseline"):
        _run(study, log)


def test_a_placebo_that_the_scores_test_detects_fails_the_gate_with_its_p(noisy: Any, log: Any) -> None:
    log.change = _violating_placebo
    with pytest.raises(GateError, match=r"PLACEBO, which does nothing, is detected by the score's test \(SR2 p = "):
        _run(noisy, log)


def test_no_flight_shares_a_baseline(noisy: Any, log: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    batches: list[Batch] = []

    def noted(flights: Sequence[Flight]) -> list[Batch]:
        batches.extend(made := [Batch((flight,)) for flight in flights])
        return made

    monkeypatch.setattr("scaloft_fi.campaign.runs.run.alone", noted)
    monkeypatch.setattr("scaloft_fi.campaign.runs.run.together", None)  # calling it would raise
    with opened(
        noisy, noisy.folder / "c", RunOptions(), progress=Progress(stream=io.StringIO()), flyer=log, first=()
    ) as campaign:
        campaign.fly(_plan(noisy).known)
    assert len(batches) == len(_plan(noisy).known)
    assert not any(batch.shared for batch in batches)


def test_a_mutant_is_infected_where_taps_altered_samples_whatever_its_bits(noisy: Any, log: Any) -> None:
    log.change = _bits
    report = _run(noisy, log)
    for flight in flights_of(report.outcomes):
        if flight.outcome.mutant == PLACEBO_ID:
            assert flight.status is Status.NOT_INFECTED
        elif flight.outcome.altered:
            assert flight.status.infected
            assert flight.status is not Status.MASKED


def test_a_flight_that_never_came_up_is_no_kill_and_one_whose_stack_died_is_the_drones(noisy: Any, log: Any) -> None:
    def change(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.name.startswith("LATE-human@3s/D0H1/0"):
            raise RuntimeError("the stages outside never came up: planner ended with code 1")
        if flight.name.startswith("LATE-human@3s/D0H1/1"):
            return replace(_bits(flight, outcome), stack_error="companion at 3.000 s: planner was ended by SIGKILL")
        return _bits(flight, outcome)

    log.change = change
    by_name = {f.outcome.name: f for f in flights_of(_run(noisy, log).outcomes)}
    assert by_name["LATE-human@3s/D0H1/0"].status is Status.INVALID
    assert "never came up" in by_name["LATE-human@3s/D0H1/0"].outcome.invalid
    assert by_name["LATE-human@3s/D0H1/1"].status is Status.REVEALED


def test_merged_campaigns_may_hold_the_same_flight_with_other_bits_and_the_first_stays(noisy: Any, log: Any) -> None:
    log.change = _bits
    first, second = (_run(noisy, log, name) for name in ("first", "second"))
    assert first.outcomes != second.outcomes
    merged = merge(noisy, noisy.folder / "first", [noisy.folder / "second"])
    assert merged.added == 0
    assert merged.known > 0


def test_after_a_change_of_platform_no_flight_is_flown_again_to_compare(
    noisy: Any, log: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def platform(numpy: str) -> None:
        for module in ("runs.gates", "runs.run", "store.platforms"):
            monkeypatch.setattr(f"scaloft_fi.campaign.{module}.fingerprint", lambda: {"numpy": numpy})

    log.change = _bits
    platform("1")
    _run(noisy, log)
    before = len(log.flown)
    platform("2")
    assert _run(noisy, log).flown == 0
    assert len(log.flown) == before
