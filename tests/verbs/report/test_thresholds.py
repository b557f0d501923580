"""Margins, limits and dispositions in the page: those of the export, of the formulas, of the study, and no clock."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import date
from typing import Any

import pytest
from counting import counts_of, exported
from papers import SEEDS, campaign, evidence_of, flight
from reading import embedded

from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, Subject
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import Evidence, accepted, bounds_of, by_ladder, limits, thresholds
from scaloft_fi.verbs.report.page import page

SEARCHED = "T0O0W0D0H1"


@pytest.fixture(scope="module")
def found(study: Study) -> tuple[Evidence, dict[str, Any]]:
    """A ladder of 0.5, 1 and 3 s, of which the mildest survives, and a search in one situation that flew 2 s there."""
    outcomes = campaign(study, ("LATE-human@3s", "LATE-human@1s", "MORE-goal@0.6m"))
    milder = [_as(o, "0.5s") for o in campaign(study, ("MORE-goal@0.6m",)) if o.mutant == "MORE-goal@0.6m"]
    between = [_as(flight(study, "LATE-human@3s", SEARCHED, seed), "2s") for seed in SEEDS]
    evidence = evidence_of(study, (*outcomes, *milder, *between))
    return evidence, embedded(page(evidence, 1), "figures")


def _as(outcome: Outcome, magnitude: str) -> Outcome:
    return replace(outcome, subject=Subject(f"LATE-human@{magnitude}", "LATE", "human", magnitude))


def test_the_ends_of_a_margin_and_the_robustness_there_are_those_of_the_export(
    found: tuple[Evidence, dict[str, Any]],
) -> None:
    evidence, told = found
    (entry,) = told["thresholds"]
    rows = [row for row in exported(evidence) if row["mutant"].startswith("LATE-human")]
    counted = counts_of(exported(evidence))
    expected = {}
    for key in {row["situation"] for row in rows}:
        here = {m: counted[f"LATE-human@{m}s"][key] for m in ("0.5", "1", "2", "3")}
        flown = {float(m): count for m, count in here.items() if count.flown}
        kills = min((m for m, count in flown.items() if count.most), default=None)
        # its cell puts SR2 at risk, so where SR1 alone is steady nothing is told of it
        survived = [m for m, count in flown.items() if "SR2" in count.tests and not count.most]
        harmless = [m for m, count in flown.items() if not count.infected and "not_infected" in count.statuses]
        survives = max((m for m in (*survived, *harmless) if kills is None or m < kills), default=None)
        if kills is not None or survived:
            rho = [None if end is None else _least(rows, key, end) for end in (survives, kills)]
            expected[key] = (survives, kills, rho, sorted(flown))
    said = {one["key"]: (one["survives"], one["kills"], one["rho"]["SR2"], one["flown"]) for one in entry["situations"]}
    assert said == expected
    assert said[SEARCHED][:2] == (0.5, 1.0)
    assert (entry["fault"], entry["unit"], entry["worse"], entry["against"]) == ("LATE-human", "s", 1, ["SR2"])
    assert entry["least"] == told["margins"]["LATE-human"] == "0.5-1 s"
    assert entry["situations_flown"] == 32
    assert {one["seen"] for one in entry["situations"]} == {None}


def _least(rows: list[dict[str, Any]], key: str, magnitude: float) -> float:
    """The least robustness against SR2."""
    name = f"LATE-human@{magnitude:g}s"
    return min(row["rho_SR2"] for row in rows if row["mutant"] == name and row["situation"] == key)


def test_a_magnitude_flown_where_a_search_asked_for_it_is_no_rung_of_the_ladder(
    found: tuple[Evidence, dict[str, Any]],
) -> None:
    (ladder,) = found[1]["ladders"]
    assert [rung["magnitude"] for rung in ladder["rungs"]] == ["0.5s", "1s", "3s"]
    late = [mutant["id"] for mutant in found[1]["mutants"] if mutant["cell"] == "LATE-human"]
    assert late == ["LATE-human@0.5s", "LATE-human@1s", "LATE-human@2s", "LATE-human@3s"]
    assert [mutant["id"] for mutant in found[1]["mutants"] if mutant["searched"]] == ["LATE-human@2s"]


def test_what_is_seen_without_a_verdict_is_no_kill(study: Study) -> None:
    outcomes = campaign(study, ("LATE-human@3s", "LATE-human@1s"), range(1))
    few = [o for o in outcomes if o.mutant != "LATE-human@3s" or o.situation in (SEARCHED, "T0O1W0D0H1")]
    scored = score(few, study.roster, study.space)
    (entry,) = thresholds(few, scored, study.matrix, study.requirements)
    ends = {one["key"]: (one["survives"], one["seen"], one["kills"]) for one in entry["situations"] if one["seen"]}
    assert ends == dict.fromkeys((SEARCHED, "T0O1W0D0H1"), (1.0, 3.0, None))
    assert entry["least"] == "seen 1-3 s"


def test_the_page_has_each_fault_that_was_flown_at_several_phases(study: Study) -> None:
    mutants = ("NO-velcmd@1s", "NO-velcmd@1s#5s", "NO-velcmd@1s#sight", "LATE-human@3s")
    told = embedded(page(evidence_of(study, campaign(study, mutants, range(1))), 1), "figures")
    (when,) = told["whens"]
    assert when["fault"] == "NO-velcmd@1s"
    assert [(strike["phase"], strike["at_event"]) for strike in when["strikes"]] == [
        ("", False),
        ("#5s", False),
        ("#sight", True),
    ]


def test_magnitudes_are_in_order_and_forms_without_one_stay_as_they_are(study: Study) -> None:
    order = by_ladder(study.matrix, study.roster)
    ids = [mutant.id for mutant in study.catalogue]
    cells = [id_.split("@")[0].split("#")[0] for id_ in sorted(ids, key=order)]
    assert cells == [id_.split("@")[0].split("#")[0] for id_ in ids]
    phases = ["", "#5s", "#15s", "#mode", "#sight"]
    assert sorted({f"NO-velcmd@1s{phase}" for phase in phases}, key=order) == [f"NO-velcmd@1s{p}" for p in phases]
    late = [f"LATE-human@{text}" for text in ("0.5s", "0.688s", "1s", "1.06s", "3s", "5s", "12s")]
    assert sorted(set(late), key=order) == late


def test_the_reference_studys_limits_are_told_in_the_units_of_their_signals(study: Study) -> None:
    told = {entry["name"]: entry for entry in bounds_of(study.requirements)}

    def short(bounds: list[dict[str, Any]]) -> list[tuple[Any, ...]]:
        return [tuple(bound.values()) for bound in bounds]

    assert short(told["SR1"]["demands"]) == [("clearance_m", ">", 0.0, None, False)]
    assert short(told["SR2"]["demands"]) == [
        ("speed_mps", "<=", 0.25, None, True),
        ("clearance_person_m", ">", 0.0, None, False),
    ]
    assert short(told["SR2"]["when"]) == [
        ("elapsed_s", ">=", 2.0, None, False),
        ("person_sight_m", "<=", 3.0, 2.0, False),
    ]
    # its trigger is one of two things: no conjunction
    assert told["OP1"]["demands"] == told["OP1"]["when"] == []


@pytest.mark.parametrize(
    "text",
    [
        "always(a > 0 or b > 0)",
        "always(not (a > 0))",
        "always(a + b > 3)",
        "always(abs(a) > 3)",
        "always(a > 0 and b > 0 implies c > 0)",
        "always(once[0:2](a > 0))",
        "always(historically[1:2](a > 0))",
        "always(historically[0:2](historically[0:2](a > 0)))",
        "always(a > b)",
    ],
)
def test_what_is_more_than_a_conjunction_of_bounds_is_not_taken_apart(text: str) -> None:
    (entry,) = bounds_of([Requirement("R", Kind.SAFETY, text, trigger="t > 0")])
    assert entry == {"name": "R", "demands": [], "when": []}


def test_brackets_negative_bounds_and_definitions() -> None:
    text = "always(((trigger implies (a / 2 <= 3 and -1 <= b)) and low))"
    (entry,) = bounds_of([Requirement("R", Kind.SAFETY, text, trigger="t > 0", definitions=(("low", "c < 5"),))])
    assert json.loads(json.dumps([tuple(bound.values()) for bound in entry["demands"]])) == [
        ["a", "<=", 6.0, None, True],
        ["b", ">=", -1.0, None, True],
        ["c", "<", 5.0, None, False],
    ]


def test_the_reference_study_limits_clearance_speed_and_the_distance_at_which_that_counts(study: Study) -> None:
    found = {
        (limit["requirement"], limit["signal"], limit["sense"], limit["bound"], limit["role"])
        for limit in limits(study.requirements, TRACK_COLUMNS)
    }
    assert ("SR1", "clearance_m", ">", 0.0, "demands") in found
    assert ("SR2", "speed_mps", "<=", 0.25, "demands") in found
    assert ("SR2", "person_sight_m", "<=", 3.0, "when") in found


@pytest.mark.parametrize(
    ("text", "bound"),
    [("always(speed_mps / 0.5 <= 3)", 1.5), ("always(speed_mps>=-2.5)", -2.5), ("always(x_m > 1)", None)],
)
def test_a_limit_is_in_the_unit_of_its_signal(text: str, bound: float | None) -> None:
    found = limits([Requirement("R", Kind.SAFETY, text)], ("speed_mps",))
    assert [limit["bound"] for limit in found] == ([] if bound is None else [bound])


def test_a_survivor_is_told_with_its_disposition_and_the_situations_that_it_does_not_name(evidence: Evidence) -> None:
    study, more, day = evidence.study, "MORE-goal@0.6m", date(2027, 1, 31)
    scored = score(evidence.outcomes, study.roster, study.space)
    known = (Disposition(more, "A. Engineer", "there is 1 m of room", day, (SEARCHED,)),)
    tests = [key for key, count in counts_of(exported(evidence))[more].items() if count.tests]
    for today, state in ((None, "uncovered"), (day, "uncovered"), (date(2027, 2, 1), "expired")):
        told = accepted(scored, study.roster, known, today)
        assert told["today"] == (today and today.isoformat())
        found = {entry["mutant"]: entry for entry in told["judged"]}
        assert found["LESS-goal@0.05m"].keys() == {"mutant", "state", "surviving"}
        assert (found["LESS-goal@0.05m"]["state"], sorted(found[more]["surviving"])) == ("open", sorted(tests))
        said = [found[more][name] for name in ("state", "owner", "reason", "until", "situations")]
        assert said == [state, "A. Engineer", "there is 1 m of room", "2027-01-31", [SEARCHED]]
        assert sorted(found[more]["unnamed"]) == sorted(set(tests) - {SEARCHED})
