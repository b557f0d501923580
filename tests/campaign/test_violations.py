"""What is said of violations while flights are flown."""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.plan import plan
from scaloft_fi.campaign.progress import Progress, Reporter, Violations
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.catalogue import realise


def _flights(study: Any) -> list[Flight]:
    planned = plan(study.grid, (0,), [realise(study.matrix, "LATE-human@3s")], None)
    return [*planned.baselines, *planned.mutants]


def _said(study: Any, outcomes: Iterable[tuple[Flight, Outcome]], *, warnings: bool = False, **home: bool) -> list[str]:
    """The lines of a run in which these came home."""
    stream = io.StringIO()
    reporter = Reporter(study, Progress(stream=stream), Path("c/mission_log.json"), share=True, warnings=warnings)
    for flight, outcome in outcomes:
        reporter.arrived(flight, outcome, **({"news": True} | home))
    reporter.close()
    return stream.getvalue().splitlines()


@pytest.fixture
def home(study: Any, log: Any) -> list[tuple[Flight, Outcome]]:
    return [(flight, log(study, flight)) for flight in _flights(study)]


def test_violations_are_counted_by_what_was_flown(home: list[tuple[Flight, Outcome]]) -> None:
    violations = Violations()
    assert str(violations) == ""
    for _, outcome in home:
        violations.add(outcome)
    assert str(violations) == "4 (baseline 1, mutants 2, PLACEBO 1)"


def test_operability_counts_and_what_is_only_reported_does_not(home: list[tuple[Flight, Outcome]]) -> None:
    kinds = (Kind.SAFETY, Kind.OPERABILITY, Kind.REPORTED)
    listed = tuple(Violation(f"R{kind}", kind, 5.0, 0.0, 1.0, 1.6, "") for kind in kinds)
    violations = Violations()
    assert len(violations.add(replace(home[0][1], violations=listed))) == 2
    assert str(violations) == "2 (baseline 2)"


def test_one_line_counts_them_and_says_where_they_are(study: Any, home: list[tuple[Flight, Outcome]]) -> None:
    assert _said(study, home) == [
        "violations: 4 (baseline 1, mutants 2, PLACEBO 1); all of them are in c/mission_log.json"
    ]


def test_warnings_tell_each_of_them_the_baselines_too(study: Any, home: list[tuple[Flight, Outcome]]) -> None:
    *warnings, last = _said(study, home, warnings=True)
    where = [line.removeprefix("warning: SR2 violated at ").rpartition(" ")[2] for line in warnings]
    assert where == ["baseline/D1H1/0", "PLACEBO/D1H1/0", "LATE-human@3s/D0H1/0", "LATE-human@3s/D1H1/0"]
    assert last.startswith("violations: 4 ")


def test_what_the_store_had_is_neither_told_nor_counted(study: Any, home: list[tuple[Flight, Outcome]]) -> None:
    assert _said(study, home, warnings=True, news=False) == []


@pytest.mark.parametrize("warnings", [False, True])
def test_an_invalid_flight_is_always_told_and_is_no_violation(
    study: Any, home: list[tuple[Flight, Outcome]], warnings: bool
) -> None:
    flight, outcome = home[0]
    broken = replace(outcome, invalid="no memory", violations=())
    said = _said(study, [(flight, broken)] * 2, warnings=warnings)
    assert said == ["warning: invalid, not counted: baseline/D0H0/0: no memory"] * 2
