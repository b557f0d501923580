"""When a fault strikes, from stored outcomes alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from builders import GRID, ROSTER, outcome, pool, thrice

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.margin import When, whens
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import score
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.verbs.margin import when_tables, when_values
from scaloft_fi.views.table import Format, render

HUMAN, DARK = "T0O0W0D0H1", "T0O0W0D1H1"


def acting(mutant: str, key: str, *acts_s: float | None, **how: Any) -> list[Outcome]:
    """A flight of each seed, which acts at these times."""
    return [
        replace(one, infected_at_s=at_s, altered=one.altered if at_s is not None else 0)
        for one, at_s in zip(thrice(mutant, key, **how), acts_s, strict=True)
    ]


FLOWN = [
    *pool(HUMAN, DARK),
    *acting("NO-human@3s#waypoint", HUMAN, 30.0, 31.0, 32.0, violated={"SR2": 40.0}),
    *acting("NO-human@3s#waypoint", DARK, 29.0, 33.0, 31.0),
    *acting("NO-human@3s", HUMAN, 20.0, 20.0, 20.0),
    *acting("NO-human@3s#15s", HUMAN, 35.0, 35.0, 35.0, violated={"SR2": 40.0}),
    *acting("NO-human@3s#5s", HUMAN, 25.0, 25.0, 25.0),
    *acting("NO-human@3s#recoil", HUMAN, None, None, None, digest="clean"),
    *acting("NO-human@1s#sight", HUMAN, 9.0, 9.0, 9.0),
    outcome("NO-human@3s#5s", DARK, invalid="the worker died"),
]


def found() -> When:
    (when,) = whens(FLOWN, score(FLOWN, ROSTER, GRID))
    return when


def test_the_phases_of_a_fault_stand_together_times_before_events() -> None:
    when = found()
    assert (when.fault, when.lasts_s) == ("NO-human@3s", 60.0)
    assert [strike.phase for strike in when.strikes] == ["", "#5s", "#15s", "#recoil", "#waypoint"]
    assert [strike.phase for strike in when.told(at_events=True)] == ["#recoil", "#waypoint"]


def test_a_phase_tells_when_it_acts_and_where_it_kills() -> None:
    *_, late, recoil, waypoint = found().strikes
    assert waypoint.acts_s == (29.0, 31.0, 33.0)
    assert (waypoint.kills, waypoint.verdict) == (Ratio(1, 2), Verdict.DETECTED)
    assert (recoil.acts_s, recoil.kills, recoil.verdict) == (None, Ratio(0, 0), Verdict.NOT_TESTED)
    assert (late.acts_s, late.kills) == ((35.0, 35.0, 35.0), Ratio(1, 1))


def test_kills_of_operability_are_asked_for_by_kind() -> None:
    (when,) = whens(FLOWN, score(FLOWN, ROSTER, GRID), Kind.OPERABILITY)
    assert {strike.kills.part for strike in when.strikes} == {0}
    assert when.strikes[-1].kills.whole == 2


def test_times_and_events_have_a_table_each_with_their_own_counts() -> None:
    times, events = when_tables([found()])
    assert times.notes[0] == "Detected at 1 of 3 times; the rail is the baseline's 60 s."
    assert events.notes[0] == "Detected at 1 of 2 events; the rail is the baseline's 60 s."
    assert [row[0] for row in times.rows] == ["#0s", "#5s", "#15s"]
    assert events.rows[0] == ("#recoil", "never", "." * 30, "0/0", "not tested")
    assert events.rows[1] == ("#waypoint", "31.0 (29.0 to 33.0)", "." * 15 + "X" + "." * 14, "1/2", "detected")


def test_every_format_has_every_phase() -> None:
    tables = when_tables([found()])
    for style in Format:
        text = render(tables, style)
        assert all(phase in text.replace("\\", "") for phase in ("#0s", "#5s", "#15s", "#recoil", "#waypoint"))
    last = when_values([found()])["phases"][-1]
    assert (last["phase"], last["acts_median_s"]) == ("#waypoint", 31.0)
    assert last["kills"] == {"part": 1, "whole": 2}


def test_a_fault_flown_at_one_phase_is_left_out() -> None:
    flown = [*pool(HUMAN), *acting("NO-human@1s#sight", HUMAN, 9.0, 9.0, 9.0)]
    assert whens(flown, score(flown, ROSTER, GRID)) == ()
