"""Margins in the page: their ends are those of the export, measured against a requirement, ladders in order."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from counting import clean_of, exported
from papers import campaign, evidence_of, flight
from reading import embedded

from scaloft_fi.report.bounds import bounds_of
from scaloft_fi.report.evidence import Evidence
from scaloft_fi.report.page import page
from scaloft_fi.report.severity import by_severity
from scaloft_fi.results.outcome import Subject
from scaloft_fi.results.requirement import Kind, Requirement
from scaloft_fi.study import Study

SEARCHED = "T0O0W0D0H1"


@pytest.fixture(scope="module")
def found(study: Study) -> tuple[Evidence, dict[str, Any]]:
    """Seed 1, where 1 s survives and 3 s kills, and a search in one situation that flew 2 s there."""
    outcomes = campaign(study, ("LATE-human@3s", "LATE-human@1s", "MORE-goal@0.6m"), range(1, 2))
    between = replace(
        flight(study, "LATE-human@3s", SEARCHED, 1), subject=Subject("LATE-human@2s", "LATE", "human", "2s")
    )
    evidence = evidence_of(study, (*outcomes, between))
    return evidence, embedded(page(evidence, 1), "figures")


def test_the_ends_of_a_margin_and_the_robustness_there_are_those_of_the_export(
    found: tuple[Evidence, dict[str, Any]],
) -> None:
    evidence, told = found
    (entry,) = told["thresholds"]
    rows = [row for row in exported(evidence) if row["mutant"].startswith("LATE-human")]
    clean = clean_of(exported(evidence))
    expected = {}
    for key in {row["situation"] for row in rows}:
        here = {float(row["mutant"].split("@")[1][:-1]): row for row in rows if row["situation"] == key}
        killed = sorted(m for m, row in here.items() if row["status"] == "killed")
        tested = [
            m
            for m, row in here.items()
            if row["infected_at_s"] is not None and m not in killed and "SR2" not in clean[key, 1]["violated"]
        ]
        kills = killed[0] if killed else None
        milder = [m for m in tested if kills is None or m < kills]
        survives = max(milder, default=None)
        if killed or tested:
            rho = [None if end is None else here[end]["rho_SR2"] for end in (survives, kills)]
            expected[key] = (survives, kills, rho, sorted(here))
    said = {one["key"]: (one["survives"], one["kills"], one["rho"]["SR2"], one["flown"]) for one in entry["situations"]}
    assert said == expected
    assert said[SEARCHED][:2] == (1.0, 2.0)
    assert (entry["fault"], entry["unit"], entry["worse"], entry["against"]) == ("LATE-human", "s", 1, ["SR2"])
    assert entry["least"] == told["margins"]["LATE-human"] == "1-2 s"
    assert entry["situations_flown"] == 32
    assert all(one["counts"] for one in entry["situations"])


def test_a_magnitude_flown_where_a_search_asked_for_it_is_no_rung_of_the_ladder(
    found: tuple[Evidence, dict[str, Any]],
) -> None:
    (ladder,) = found[1]["ladders"]
    assert [rung["magnitude"] for rung in ladder["rungs"]] == ["1s", "3s"]
    late = [mutant["id"] for mutant in found[1]["mutants"] if mutant["cell"] == "LATE-human"]
    assert late == ["LATE-human@1s", "LATE-human@2s", "LATE-human@3s"]
    assert [mutant["id"] for mutant in found[1]["mutants"] if mutant["searched"]] == ["LATE-human@2s"]


def test_a_kill_that_no_score_counts_is_marked(study: Study) -> None:
    outcomes = campaign(study, ("MORE-goal@0.6m", "MORE-goal@0.3m"), range(1))
    (entry,) = embedded(page(evidence_of(study, outcomes), 1), "figures")["thresholds"]
    assert {one["key"]: one["kills"] for one in entry["situations"] if not one["counts"]} == {"T1O1W1D1H0": 0.3}


def test_magnitudes_are_in_order_and_forms_without_one_stay_as_they_are(study: Study) -> None:
    order = by_severity(study.matrix, study.roster)
    ids = [mutant.id for mutant in study.catalogue]
    cells = [id_.split("@")[0].split("#")[0] for id_ in sorted(ids, key=order)]
    assert cells == [id_.split("@")[0].split("#")[0] for id_ in ids]
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
        "always(2 * a > 3)",
        "always(a + b > 3)",
        "always(abs(a) > 3)",
        "always(a > 0 and b > 0 implies c > 0)",
        "always(trigger implies a > 0 and b > 0)",
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
    text = "always(((trigger implies (a / 2 <= 3 and b >= -1)) and low))"
    (entry,) = bounds_of([Requirement("R", Kind.SAFETY, text, trigger="t > 0", definitions=(("low", "c < 5"),))])
    assert json.loads(json.dumps([tuple(bound.values()) for bound in entry["demands"]])) == [
        ["a", "<=", 6.0, None, True],
        ["b", ">=", -1.0, None, True],
        ["c", "<", 5.0, None, False],
    ]
