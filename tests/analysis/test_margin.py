"""Margins and times of faults from stored outcomes alone: what a ladder says, when a fault strikes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from builders import GRID, ROSTER, campaigns, outcome, pool, seeded, thrice
from hypothesis import given, settings
from hypothesis import strategies as st
from options import usually

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.margin import Margin, Scale, When, lowest, margin_of, margins, whens
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import PhasedFault, Reaction, Tried
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.verbs.margin import (
    LEGEND,
    MARGIN,
    Margins,
    cell_margins,
    margin_tables,
    margin_text,
    margin_texts,
    when_tables,
)
from scaloft_fi.views.table import Format, render

MATRIX = load_matrix(Path(__file__).parents[2] / "hazop", REFERENCE.by_name)
KEYS = [key for key, _ in GRID.points]
HUMAN = "T0O0W0D0H1"
LATE = PhasedFault("LATE-human", "s")

magnitudes = st.lists(st.integers(1, 100).map(lambda n: n / 10), min_size=1, max_size=6, unique=True)


@given(st.lists(st.tuples(st.floats(0.05, 12.0), magnitudes), min_size=1, max_size=6), st.sampled_from([1, -1]))
def test_the_least_threshold_of_all_situations_is_within_the_interval(
    flown: list[tuple[float, list[float]]], sign: int
):
    scale = Scale("s", sign)

    def margin(threshold: float, tried: list[float]) -> Margin:
        killed = {m: Reaction.KILLED if sign * m >= sign * threshold else Reaction.SURVIVED for m in tried}
        return margin_of(scale, [Tried(m, answer) for m, answer in killed.items()])

    least = lowest(margin(*entry) for entry in flown)
    true = min((threshold for threshold, _ in flown), key=scale.strength)
    assert least.kills is None or scale.strength(true) <= scale.strength(least.kills)
    assert least.survives is None or scale.strength(least.survives) < scale.strength(true)


def flights(*answers: tuple[str, str, dict[str, float]]) -> list[Outcome]:
    """Three outcomes of each (mutant, situation, violated), with the pool they need."""
    made = pool(*dict.fromkeys(key for _, key, _ in answers))
    return [*made, *(flight for mutant, key, violated in answers for flight in thrice(mutant, key, violated=violated))]


def told(outcomes: list[Outcome], kind: Kind = Kind.SAFETY) -> Mapping[str, str]:
    return margin_texts(MATRIX, cell_margins(score(outcomes, ROSTER, GRID), MATRIX, kind))


def found_in(outcomes: list[Outcome]) -> Mapping[PhasedFault, Sequence[Margin]]:
    return margins(outcomes, score(outcomes, ROSTER, GRID), MATRIX)


def test_a_ladder_flown_by_any_verb_has_an_interval():
    flown = flights(("LATE-human@1s", HUMAN, {}), ("LATE-human@3s", HUMAN, {"SR2": 8.0}), ("LATE-human@5s", HUMAN, {}))
    assert told(flown)["LATE-human"] == "1-3 s !"


def test_a_default_alone_bounds_from_one_side():
    assert told(flights(("LATE-human@3s", HUMAN, {})))["LATE-human"] == "> 3 s"
    assert told(flights(("LATE-human@3s", HUMAN, {"SR2": 8.0})))["LATE-human"] == "<= 3 s"


def test_a_situation_without_a_milder_survivor_leaves_the_least_threshold_open_below():
    other = KEYS[0]
    flown = [*flights(("LATE-human@3s", HUMAN, {"SR2": 8.0})), *flights(("LATE-human@1s", other, {}))]
    assert told(flown)["LATE-human"] == "<= 3 s"
    (line,) = [line for line in LEGEND if line.startswith("<= ")]
    assert "in some situation nothing milder survives" in line


def test_two_faults_of_a_cell_each_have_their_own():
    flown = flights(("NO-depth@3s", HUMAN, {}), ("NO-depth@50%", HUMAN, {"SR1": 9.0}))
    assert told(flown)["NO-depth"] == "> 3 s; <= 50 %"


def test_what_one_flight_shows_is_seen_and_never_told_as_a_kill():
    once = [*pool(HUMAN), outcome("LATE-human@1s", HUMAN), outcome("LATE-human@3s", HUMAN, violated={"SR2": 8.0})]
    ((margin,),) = found_in(once).values()
    assert (margin.survives, margin.seen, margin.kills, margin.end) == (1.0, 3.0, None, 3.0)
    assert told(once)["LATE-human"] == margin_text(margin) == "seen 1-3 s"
    (entry,) = [entry for entry in margin.tried if entry.magnitude == 3.0]
    assert (entry.reaction, entry.requirements, entry.needed, entry.anew) == (Reaction.SEEN, ("SR2",), 5, False)
    (table,) = margin_tables(found_in(once), (), 1)
    assert table.rows == ((HUMAN, "seen 1-3 s", "1 s", "3 s", "", "SR2 1/1", "SR2 0.3 / -0.1", "1 3", ""),)
    assert "Seen, decided by 5 seeds: 3 s (`scaloft-fi margin LATE-human@3s --seeds 5`)." in table.notes


def test_a_magnitude_that_other_situations_detect_kills_where_one_flight_shows_it():
    keys = KEYS[1:8:2]
    once = [outcome("LATE-human@3s", key, violated={"SR2": 8.0}) for key in keys]
    assert told([*pool(*keys), *once])["LATE-human"] == "<= 3 s"


def test_a_milder_magnitude_that_is_only_seen_keeps_the_interval_open():
    flown = flights(("LATE-human@1s", HUMAN, {}), ("LATE-human@5s", HUMAN, {"SR2": 8.0}))
    flown.append(outcome("LATE-human@3s", HUMAN, violated={"SR2": 8.0}))
    ((margin,),) = found_in(flown).values()
    assert (margin.survives, margin.seen, margin.kills, margin_text(margin)) == (1.0, 3.0, 5.0, "1-5 s")


def test_some_flights_of_a_detected_mutant_are_no_kill():
    keys = KEYS[:8]
    some = [outcome("LATE-human@3s", k, seed, violated={"SR2": 8.0} if seed else {}) for k in keys for seed in (0, 1)]
    assert score([*pool(*keys), *some], ROSTER, GRID).mutants[0].detected
    assert told([*pool(*keys), *some])["LATE-human"] == "> 3 s"


def test_faults_without_an_order_say_which_of_them_are_detected():
    shown = told(
        flights(
            ("PARTOF-goal@x", HUMAN, {"SR1": 9.0}),
            ("PARTOF-goal@y", HUMAN, {}),
            ("NO-waypoint", HUMAN, {}),
            ("NO-map", HUMAN, {"SR1": 9.0}),
        )
    )
    assert [shown[cell] for cell in ("PARTOF-goal", "NO-waypoint", "NO-map")] == [
        "x detected",
        "not detected",
        "detected",
    ]
    assert told([*pool(HUMAN), outcome("NO-map", HUMAN, violated={"SR1": 9.0})])["NO-map"] == "undecided"


def test_operability_has_margins_of_its_own():
    flown = flights(("LATE-goal@1s", HUMAN, {}), ("LATE-goal@3s", HUMAN, {"OP1": 50.0}))
    assert told(flown)["LATE-goal"] == "> 3 s"
    assert told(flown, Kind.OPERABILITY)["LATE-goal"] == "1-3 s"


def test_what_no_sample_reached_or_no_sample_differed_in_tells_nothing():
    for carried in (0, 100):
        flown = [*pool(HUMAN), *thrice("LATE-human@3s", HUMAN, altered=0, carried=carried)]
        assert told(flown)["LATE-human"] == "?"


def test_a_harmless_magnitude_is_a_survival_beside_one_that_is_killed():
    flown = flights(("LATE-human@3s", HUMAN, {"SR2": 8.0}))
    assert told([*flown, outcome("LATE-human@0.5s", HUMAN, altered=0)])["LATE-human"] == "0.5-3 s"


def test_where_nothing_that_the_cell_puts_at_risk_is_steady_nothing_is_told():
    red = pool(HUMAN, red=10, violated={"SR2": 6.0})
    assert told([*red, *thrice("LATE-human@3s", HUMAN)])["LATE-human"] == "?"
    assert told([*red, *thrice("LATE-depth@0.4s", HUMAN)])["LATE-depth"] == "> 0.4 s"
    assert told([outcome(situation=HUMAN), outcome("LATE-human@3s", HUMAN, violated={"SR2": 8.0})])["LATE-human"] == "?"


@settings(deadline=None, max_examples=usually(25, release=40))
@given(st.one_of(campaigns(), seeded()))
def test_margins_do_not_depend_on_the_order_of_outcomes_and_say_nothing_unknown(outcomes: list[Outcome]):
    assert told(outcomes) == told(outcomes[::-1])
    assert set(told(outcomes)) == {cell.name for cell in MATRIX}
    kills = {(mutant.subject.id, key) for mutant in score(outcomes, ROSTER, GRID).mutants for key in mutant.killing}
    for subject, listed in found_in(outcomes).items():
        for margin in listed:
            answers = {answer: {t.magnitude for t in margin.tried if t.reaction is answer} for answer in Reaction}
            assert (margin.kills in answers[Reaction.KILLED]) == bool(answers[Reaction.KILLED])
            assert margin.seen is None or margin.seen in answers[Reaction.SEEN]
            assert margin.survives not in answers[Reaction.KILLED] | answers[Reaction.SEEN]
            (key,) = margin.situations
            for magnitude in answers[Reaction.KILLED] if not subject.cell.startswith("REVERSE") else ():
                assert (subject.at(f"{magnitude:g}{subject.unit}"), key) in kills
    margin_tables(found_in(outcomes), (), 1)
    json.dumps(MARGIN.record(Margins.of(found_in(outcomes))), allow_nan=False)


def test_the_table_names_ends_requirements_robustness_and_what_was_flown():
    found = found_in(flights(("LATE-human@1s", HUMAN, {}), ("LATE-human@3s", HUMAN, {"SR2": 8.0})))
    (table,) = margin_tables(found, (), 3)
    assert table.rows == ((HUMAN, "1-3 s", "1 s", "", "3 s", "SR2 3/3", "SR2 0.3 / -0.1", "1 3", ""),)
    assert "1-3 s (1 s survives, 3 s is killed)." in table.notes[0]
    (entry,) = MARGIN.record(Margins.of(found))["faults"]
    assert (entry["cell"], entry["survives"], entry["kills"]) == ("LATE-human", 1.0, 3.0)


def test_an_infinite_magnitude_is_a_text_in_json():
    found = found_in(flights(("OTHERTHAN-depth@infs", HUMAN, {"SR1": 8.0})))
    (entry,) = MARGIN.record(Margins.of(found))["faults"]
    assert entry["kills"] == "inf"


@pytest.mark.parametrize("line", LEGEND)
def test_the_legend_fits_a_terminal(line: str):
    assert len(line) <= 120
    assert line.isascii()


DARK = "T0O0W0D1H1"


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


def test_the_phases_of_a_fault_stand_together_times_before_events():
    when = found()
    assert (when.fault, when.lasts_s) == ("NO-human@3s", 60.0)
    assert [strike.phase for strike in when.strikes] == ["", "#5s", "#15s", "#recoil", "#waypoint"]
    assert [strike.phase for strike in when.told(at_events=True)] == ["#recoil", "#waypoint"]


def test_a_phase_tells_when_it_acts_and_where_it_kills():
    *_, late, recoil, waypoint = found().strikes
    assert waypoint.acts_s == (29.0, 31.0, 33.0)
    assert (waypoint.kills, waypoint.verdict) == (Ratio(1, 2), Verdict.DETECTED)
    assert (recoil.acts_s, recoil.kills, recoil.verdict) == (None, Ratio(0, 0), Verdict.NOT_TESTED)
    assert (late.acts_s, late.kills) == ((35.0, 35.0, 35.0), Ratio(1, 1))


def test_kills_of_operability_are_asked_for_by_kind():
    (when,) = whens(FLOWN, score(FLOWN, ROSTER, GRID), Kind.OPERABILITY)
    assert {strike.kills.part for strike in when.strikes} == {0}
    assert when.strikes[-1].kills.whole == 2


def test_times_and_events_have_a_table_each_with_their_own_counts():
    times, events = when_tables([found()])
    assert times.notes[0] == "Detected at 1 of 3 times; the rail is the baseline's 60 s."
    assert events.notes[0] == "Detected at 1 of 2 events; the rail is the baseline's 60 s."
    assert [row[0] for row in times.rows] == ["#0s", "#5s", "#15s"]
    assert events.rows[0] == ("#recoil", "never", "." * 30, "0/0", "not tested")
    assert events.rows[1] == ("#waypoint", "31.0 (29.0 to 33.0)", "." * 15 + "X" + "." * 14, "1/2", "detected")


def test_every_format_has_every_phase():
    tables = when_tables([found()])
    for style in Format:
        text = render(tables, style)
        assert all(phase in text.replace("\\", "") for phase in ("#0s", "#5s", "#15s", "#recoil", "#waypoint"))
    last = MARGIN.record(Margins.when([found()]))["phases"][-1]
    assert (last["phase"], last["acts_median_s"]) == ("#waypoint", 31.0)
    assert last["kills"] == {"part": 1, "whole": 2}


def test_a_fault_flown_at_one_phase_is_left_out():
    flown = [*pool(HUMAN), *acting("NO-human@1s#sight", HUMAN, 9.0, 9.0, 9.0)]
    assert whens(flown, score(flown, ROSTER, GRID)) == ()
