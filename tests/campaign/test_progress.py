"""The progress of a run: what is shown, how well the rest is foretold, what is said of violations."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import pytest

from scaloft_fi.campaign import progress as live
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.plan import plan
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.catalogue import defaults, realise


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


class Clock:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def _progress(stream: io.StringIO, make: Callable[..., live.Progress] = live.Progress) -> tuple[live.Progress, Clock]:
    clock = Clock()
    progress = make(stream=stream, clock=clock)
    progress.flights = 10
    progress.left_s = lambda: 400.0 - progress.done_s
    return progress, clock


def _advance(progress: live.Progress, flown_s: float, clock: Clock, took_s: float = 0.0) -> None:
    """A flight of this expected time ends, which took so long."""
    clock.now_s += took_s
    progress.done_s += flown_s
    progress.advance()


def test_time_left_and_what_more_would_take_follow_from_the_pace_of_expected_flight_time():
    progress, clock = _progress(io.StringIO())
    assert (progress.time_left_s, progress.wall_s(50.0)) == (None, None)
    clock.now_s += 60.0
    progress.start()  # with the first flight
    _advance(progress, 100.0, clock, 6.0)
    progress.start()
    assert (progress.time_left_s, progress.wall_s(50.0)) == (pytest.approx(18.0), pytest.approx(3.0))
    progress.most_s = lambda: 5.0  # a budget
    assert progress.time_left_s == 5.0


def test_without_a_terminal_there_is_one_line_every_ten_seconds():
    stream = io.StringIO()
    progress, clock = _progress(stream)
    for number in range(8):
        clock.now_s += live.LINE_EVERY_S / 4
        progress.violations = "8 (baseline 3, mutants 5)" if number > 4 else ""
        _advance(progress, 40.0, clock)
    assert stream.getvalue().splitlines() == [
        "4/10 flights  0.4/s  15 s left",
        "8/10 flights  0.4/s  5 s left  violations: 8 (baseline 3, mutants 5)",
    ]


def test_on_a_terminal_the_line_is_live_and_a_warning_stands_above_it(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("NO_COLOR", "1")
    stream = Terminal()
    progress, clock = _progress(stream)
    _advance(progress, 200.0, clock, 1.0)
    progress.line("warning: SR1 violated")
    before, after = stream.getvalue().split("warning: SR1 violated\n")
    assert before.count("\r\x1b[J") == 2  # once to draw, once to make room for the warning
    assert after.startswith("\r\x1b[J[############............] 1/10 flights")


def _lines(progress: live.Progress, clock: Clock, columns: int, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The live screen after a second and a flight."""
    monkeypatch.setenv("COLUMNS", str(columns))
    _advance(progress, 200.0, clock, 1.0)
    return str(progress._stream.getvalue()).rpartition("\x1b[J")[2].split("\n")  # type: ignore[attr-defined]


def test_the_live_screen_has_rate_time_left_simulated_time_violations_and_what_is_detected(
    monkeypatch: pytest.MonkeyPatch,
):
    progress, clock = _progress(
        Terminal(), lambda **words: live.Progress(**words, tally=lambda what: [f"detected: {what}"])
    )
    progress.stored = lambda: ("2 of 3",)
    progress.violations = "8 (baseline 3, mutants 5)"
    progress.simulated_s = 50.0
    clock.now_s += live.TALLY_EVERY_S
    assert _lines(progress, clock, 100, monkeypatch) == [
        "[############............] 1/10 flights  0.1/s  11 s left",
        "5 simulated s a second",
        "violations: 8 (baseline 3, mutants 5)",
        "detected: 2 of 3",
    ]


@pytest.mark.parametrize("columns", [40, 60, 80])
def test_no_line_of_the_live_screen_wraps(columns: int, monkeypatch: pytest.MonkeyPatch):
    progress, clock = _progress(Terminal())
    progress.violations = "2900 (baseline 16, mutants 2868, PLACEBO 16)"
    lines = _lines(progress, clock, columns, monkeypatch)
    assert max(map(len, lines)) < columns
    assert lines[1] == f"violations: {progress.violations}"[: columns - 1]


def test_a_drawing_takes_the_place_of_the_last_one_and_nothing_of_it_is_left_at_the_end(
    monkeypatch: pytest.MonkeyPatch,
):
    stream = Terminal()
    progress, clock = _progress(stream)
    progress.violations = "1 (mutants 1)"
    _lines(progress, clock, 80, monkeypatch)
    _lines(progress, clock, 80, monkeypatch)
    assert "\r\x1b[1A\x1b[J[" in stream.getvalue()
    progress.close()
    assert stream.getvalue().rpartition("\x1b[J")[2] == "2 of 10 flights flown in 2 s, 1.0 a second\n"


def test_the_tally_takes_no_more_than_its_share_of_the_time():
    made: list[float] = []
    progress, clock = _progress(Terminal())

    def tally() -> list[str]:
        made.append(clock.now_s)
        clock.now_s += 1.0
        return ["detected"]

    progress = live.Progress(stream=Terminal(), clock=clock, tally=tally)
    progress.flights, progress.stored = 1000, lambda: ()
    start_s = clock.now_s
    for _ in range(1000):
        _advance(progress, 1.0, clock, 1.0)
    assert len(made) > 1
    assert len(made) - 1 <= live.TALLY_SHARE * (clock.now_s - start_s)


def test_without_a_terminal_nothing_is_tallied():
    clock = Clock()
    progress = live.Progress(stream=io.StringIO(), clock=clock, tally=lambda: 1 / 0)  # type: ignore[arg-type,return-value]
    progress.flights, progress.stored = 10, lambda: ()
    _advance(progress, 1.0, clock, 60.0)


def test_the_end_leaves_a_summary_unless_nothing_was_flown():
    stream = io.StringIO()
    progress, clock = _progress(stream)
    progress.close()
    assert stream.getvalue() == ""
    _advance(progress, 40.0, clock, 4.0)
    progress.close()
    assert stream.getvalue() == "1 of 10 flights flown in 4 s, 0.2 a second\n"


def test_what_is_counted_has_its_own_words():
    stream, clock = io.StringIO(), Clock()
    progress = live.Progress(stream=stream, clock=clock, counts=("runs", "done"))
    progress.flights = 10
    _advance(progress, 40.0, clock, 4.0)
    progress.close()
    assert stream.getvalue() == "1 of 10 runs done in 4 s, 0.2 a second\n"


def test_quiet_shows_nothing_at_all():
    stream = Terminal()
    progress, clock = _progress(stream, live.Silence)
    _advance(progress, 40.0, clock, 60.0)
    progress.line("warning: SR1 violated")
    progress.close()
    assert stream.getvalue() == ""


def test_a_long_time_is_told_in_hours():
    assert live.duration(7260) == "2 h 01 min"


def _reporter(
    study: Any, *, stream: io.StringIO | None = None, share: bool = True, warnings: bool = False
) -> live.Reporter:
    progress = live.Progress(stream=stream or io.StringIO())
    return live.Reporter(study, progress, Path("c/mission_log.json"), share=share, warnings=warnings)


def _flights(study: Any, *mutants: Any) -> list[Flight]:
    return list(plan(study.grid, (0,), mutants or defaults(study.matrix)[:10], None).known)


@pytest.mark.parametrize(("share", "of_a_mutant"), [(True, live.SHARE), (False, 1.0)])
def test_a_mutant_is_expected_to_cost_its_share_of_the_mission(study: Any, *, share: bool, of_a_mutant: float):
    reporter = _reporter(study, share=share)
    reporter.expect(_flights(study))
    missions_s = sum(situation.nominal_s for situation in study.grid)
    assert reporter.left_s == pytest.approx(missions_s * (2 + 10 * of_a_mutant) + 4 * 12 * live.FLIGHT_S)


def test_what_is_flown_is_not_left_and_in_the_end_nothing_is(study: Any, log: Any):
    reporter, flights = _reporter(study), _flights(study)
    reporter.expect(flights)
    whole_s = reporter.left_s
    Random(0).shuffle(flights)
    for flight in flights:
        reporter.arrived(flight, log(study, flight), news=True)
        assert reporter.progress.done_s + reporter.left_s == pytest.approx(whole_s)
    assert reporter.left_s == 0.0
    assert reporter.progress.done == reporter.progress.flights == len(flights)


def test_a_flight_that_is_announced_twice_is_expected_once_and_a_carrier_flown_again_is_not(study: Any, log: Any):
    reporter, (flight, *_) = _reporter(study), _flights(study)
    reporter.expect([flight, flight])
    assert (reporter.left_s, reporter.progress.flights) == (30.0 + live.FLIGHT_S, 1)
    for _ in range(2):
        reporter.arrived(flight, log(study, flight), news=True)
    assert (reporter.progress.done, reporter.left_s) == (1, 0.0)
    assert reporter.progress.done_s == 2 * (30.0 + live.FLIGHT_S)


def _said(study: Any, outcomes: Iterable[tuple[Flight, Outcome]], *, warnings: bool = False, **home: bool) -> list[str]:
    """The lines of a run in which these came home."""
    stream = io.StringIO()
    reporter = _reporter(study, stream=stream, warnings=warnings)
    for flight, outcome in outcomes:
        reporter.arrived(flight, outcome, **({"news": True} | home))
    reporter.close()
    return stream.getvalue().splitlines()


@pytest.fixture
def home(study: Any, log: Any) -> list[tuple[Flight, Outcome]]:
    return [(flight, log(study, flight)) for flight in _flights(study, realise(study.matrix, "LATE-human@3s"))]


def test_operability_counts_and_what_is_only_reported_does_not(study: Any, home: list[tuple[Flight, Outcome]]):
    kinds = (Kind.SAFETY, Kind.OPERABILITY, Kind.REPORTED)
    listed = tuple(Violation(f"R{kind}", kind, 5.0, 0.0, 1.0, 1.6, "") for kind in kinds)
    said = _said(study, [(home[0][0], replace(home[0][1], violations=listed))], warnings=True)
    assert [line.split(" violated")[0] for line in said[:-1]] == ["warning: Rsafety", "warning: Roperability"]
    assert said[-1].startswith("violations: 2 (baseline 2);")


def test_one_line_counts_them_and_says_where_they_are(study: Any, home: list[tuple[Flight, Outcome]]):
    assert _said(study, home) == [
        "violations: 4 (baseline 1, mutants 2, PLACEBO 1); all of them are in c/mission_log.json"
    ]


def test_warnings_tell_each_of_them_the_baselines_too(study: Any, home: list[tuple[Flight, Outcome]]):
    *warnings, last = _said(study, home, warnings=True)
    where = [line.removeprefix("warning: SR2 violated at ").rpartition(" ")[2] for line in warnings]
    assert where == ["baseline/D1H1/0", "PLACEBO/D1H1/0", "LATE-human@3s/D0H1/0", "LATE-human@3s/D1H1/0"]
    assert last.startswith("violations: 4 ")


def test_what_the_store_had_is_neither_told_nor_counted(study: Any, home: list[tuple[Flight, Outcome]]):
    assert _said(study, home, warnings=True, news=False) == []


@pytest.mark.parametrize("warnings", [False, True])
def test_an_invalid_flight_is_always_told_and_is_no_violation(
    study: Any, home: list[tuple[Flight, Outcome]], warnings: bool
):
    flight, outcome = home[0]
    broken = replace(outcome, invalid="no memory", violations=())
    said = _said(study, [(flight, broken)] * 2, warnings=warnings)
    assert said == ["warning: invalid, not counted: baseline/D0H0/0: no memory"] * 2
