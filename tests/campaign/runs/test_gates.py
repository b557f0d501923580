"""What an unmutated drone must do before a score is believed: its stack lives, and it takes off."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.plan import Plan, plan
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RISE_M, RunOptions, check_gates
from scaloft_fi.campaign.runs.run import run
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, pack_track
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.sim import observer

ERROR = "autopilot at 0.000 s: RuntimeError: no bus"


def _plan(study: Any) -> Plan:
    return plan(study.grid, (0,), [realise(study.matrix, "LATE-human@3s")], realise(study.matrix, "REVERSE-velcmd"))


def _run(study: Any, log: Any, *, part: bool = False) -> None:
    progress = Progress(stream=io.StringIO())
    run(study, _plan(study), study.folder / "c", RunOptions(part=part), progress=progress, flyer=log)


def _change(names: str, **changes: Any) -> Callable[[Flight, Outcome], Outcome]:
    """Another outcome of the flights whose name begins so."""
    return lambda flight, outcome: replace(outcome, **changes) if flight.name.startswith(names) else outcome


def _track(*heights: float) -> bytes:
    signals = {name: [0.0] * 5 * len(heights) for name in TRACK_COLUMNS}
    return pack_track(signals | {"z_m": [z for z in heights for _ in range(5)]})


GROUNDED = {"ending": "timed_out", "track": _track(0.06, 0.06, 0.2, 0.06)}
FLOWN = {"ending": "timed_out", "track": _track(0.06, 1.6, 1.6)}
SENTENCE = "the drone never leaves the ground without any fault: baseline/D0H1/0"


def test_a_stack_that_raises_in_a_baseline_fails_the_gate_with_flight_and_error(study: Any, log: Any) -> None:
    log.change = _change("baseline/D0H1", stack_error=ERROR)
    with pytest.raises(GateError) as caught:
        _run(study, log)
    assert str(caught.value) == f"gate failed: the stack raises without any fault: baseline/D0H1/0 ({ERROR})"


def test_a_stack_that_raises_under_a_fault_is_no_gates_business(study: Any, log: Any) -> None:
    log.change = _change("LATE-human", stack_error=ERROR)
    _run(study, log)


def test_a_baseline_that_never_rises_fails_the_gate_by_name(study: Any, log: Any) -> None:
    log.change = _change("baseline/D0H1", **GROUNDED)
    with pytest.raises(GateError) as caught:
        _run(study, log)
    assert str(caught.value) == f"gate failed: {SENTENCE}"


def test_the_gate_holds_when_nothing_is_left_to_fly_and_in_a_part_of_a_run(study: Any, log: Any) -> None:
    log.change = _change("baseline/D0H1", **GROUNDED)
    for part in (False, True):
        with pytest.raises(GateError, match=SENTENCE):
            _run(study, log, part=part)
    assert len(log.flown) == 14  # each once, and one again


def test_a_mutant_may_stay_on_the_ground_and_a_baseline_may_fly_to_its_time_limit(study: Any, log: Any) -> None:
    def change(flight: Flight, outcome: Outcome) -> Outcome:
        how = GROUNDED if flight.name.startswith("LATE-human") else FLOWN if flight.mutant is None else {}
        return replace(outcome, **how)

    log.change = change
    _run(study, log)


def test_a_baseline_without_a_track_is_believed_to_have_flown(study: Any, log: Any) -> None:
    log.change = _change("baseline", ending="timed_out", track=b"")
    _run(study, log)


def test_outcomes_that_come_with_their_tracks_are_judged_without_a_store(study: Any, log: Any) -> None:
    clean = [replace(log(study, flight), **GROUNDED) for flight in _plan(study).baselines[:1]]
    with pytest.raises(GateError, match="the drone never leaves the ground without any fault: baseline/D0H0/0"):
        check_gates(clean, study.roster, canary=None, whole_grid=False)


def test_the_ground_is_left_at_the_height_from_which_a_touch_down_counts() -> None:
    assert RISE_M == observer.AIRBORNE_M
