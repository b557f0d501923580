"""Every figure of the page, and its head, equals what a script of one's own makes of `export`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import combinations, pairwise
from typing import Any

import pytest
from options import as_recorded
from pages import SAFETY, Count, counts_of, embedded, exported, states_of, unpacked
from papers import BAR, MUTANTS, SHAKY, campaign, evidence_of

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import Score, score
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study
from scaloft_fi.verbs.first_screen import answers, selected
from scaloft_fi.verbs.report.analyses import Evidence
from scaloft_fi.verbs.report.page import head, page
from scaloft_fi.verbs.snapshot import Stale

VERDICTS = {
    "LATE-human@1s": "detected",
    "LATE-human@3s": "detected",
    "MORE-goal@0.6m": "not_detected",
    "NO-depth@3s": "not_tested",
    "LESS-goal@0.05m": "undecided",
    "REVERSE-velcmd": "detected",
}
Figures = Callable[[Evidence], dict[str, Any]]
DEFAULTS = set(VERDICTS) - {"LATE-human@1s", "REVERSE-velcmd"}


@pytest.fixture(scope="module")
def rows(evidence: Evidence) -> list[dict[str, Any]]:
    return exported(evidence)


@pytest.fixture(scope="module")
def counted(rows: list[dict[str, Any]]) -> dict[str, dict[str, Count]]:
    return counts_of(rows)


def sign(count: Count, verdict: str) -> tuple[str, list[str]]:
    """What the kill matrix shows of a mutant in a situation, and by which requirements."""
    stopped = [
        rung for rung in ("not_reached", "not_infected", "masked") if count.statuses and count.statuses <= {rung}
    ]
    seen = [name for name in count.tests if count.violated[name]]
    if not count.flown:
        return "not_flown", []
    if verdict == "detected" and count.most:
        return "kill", count.most
    if stopped:
        return stopped[0], []
    if seen:
        return "seen", seen
    return ("tested" if count.tests else "no_test"), []


def test_the_head_answers_four_questions_as_the_score_does(told: dict[str, Any], evidence: Evidence):
    study = evidence.study
    expected = answers(score(evidence.outcomes, study.roster, study.space), study, "paper")
    assert told["answers"] == [answer._asdict() for answer in expected]
    assert [answer["name"] for answer in told["answers"]] == ["Shown", "Not shown", "How sure", "What next"]
    assert told["answers"][0]["text"].startswith("1 of 4 faults")
    assert "`scaloft-fi " in told["answers"][3]["text"]
    assert [line["name"] for line in told["besides"]] == ["Situations"]


def test_alpha_is_spent_as_the_campaign_spent_it(evidence: Evidence, quick: Figures):
    grown = frozenset(VERDICTS)
    looks = quick(replace(evidence, spending=Spending(0.04, grown)))
    assert {m["decided_at"]["alpha"] for m in looks["mutants"] if m["tests"]} == {0.01}


def test_results_and_kill_rates_are_those_of_the_export(told: dict[str, Any], counted: dict[str, dict[str, Count]]):
    keys = [situation["key"] for situation in told["situations"]]
    assert {mutant["id"]: mutant["verdict"] for mutant in told["mutants"]} == VERDICTS
    shown = set()
    for mutant in told["mutants"]:
        counts = counted[mutant["id"]]
        for key, (number, flown, _, violated, by) in zip(keys, mutant["results"], strict=True):
            assert (told["signs"][number], by) == sign(counts[key], mutant["verdict"])
            assert (flown, violated) == (counts[key].flown, {n: k for n, k in counts[key].violated.items() if k})
            shown.add(told["signs"][number])
        kills = sum(bool(count.most) for count in counts.values()) if mutant["verdict"] == "detected" else 0
        assert mutant["kill_rate"] == {"part": kills, "whole": sum(bool(count.tests) for count in counts.values())}
        assert mutant["kill_rate_flown"] == {"part": kills, "whole": sum(count.flown > 0 for count in counts.values())}
        assert (mutant["counts"], mutant["control"]) == (mutant["id"] in DEFAULTS, mutant["id"] == "REVERSE-velcmd")
    assert shown == set(told["signs"]) - {"not_flown"}


def test_a_situation_not_flown_has_no_result(study: Study, quick: Figures):
    outcomes = [o for o in campaign(study, MUTANTS[:1]) if o.mutant != MUTANTS[0] or o.situation.endswith("H1")]
    (mutant,) = quick(evidence_of(study, outcomes))["mutants"]
    assert sum(result is None for result in mutant["results"]) == 16


def test_a_kill_opens_a_flight_that_has_it(told: dict[str, Any], rows: list[dict[str, Any]]):
    flights = {(row["mutant"], row["situation"], row["seed"]): row for row in rows}
    opened = {}
    for mutant in told["mutants"]:
        for situation, (number, _, seed, _, by) in zip(told["situations"], mutant["results"], strict=True):
            flight = flights[mutant["id"], situation["key"], seed]
            if by:
                assert by[0] in flight["violated"]
                assert flight["status"] == "revealed"
            opened[mutant["id"], told["signs"][number]] = seed
    # one second late, the seed 0 does not show it
    assert opened["LATE-human@1s", "kill"] == 1
    assert opened["LATE-human@3s", "kill"] == 0
    assert opened["LESS-goal@0.05m", "seen"] == 1


def test_every_kill_names_a_flight_that_has_it(told: dict[str, Any], rows: list[dict[str, Any]]):
    flights = {(row["mutant"], row["situation"], row["seed"]): row for row in rows}
    pool = [row for row in rows if row["mutant"] == "baseline"]
    for mutant in told["mutants"]:
        killed = {(kill["situation"], kill["requirement"]) for kill in mutant["kills"] if kill["requirement"] in SAFETY}
        shown = zip(told["situations"], mutant["results"], strict=True)
        signs = {(s["key"], name) for s, result in shown if told["signs"][result[0]] == "kill" for name in result[4]}
        assert killed == signs
        for kill in mutant["kills"]:
            flight = flights[mutant["id"], kill["situation"], kill["seed"]]
            place = flight["violated"].index(kill["requirement"])
            assert kill["t_s"] == flight["violation_times_s"][place]
            assert kill["struck"] == flight["violation_bodies"][place]
            beside = [row for row in pool if row["situation"] == kill["situation"]]
            violated = sum(kill["requirement"] in row["violated"] for row in beside)
            assert kill["baseline"] == {"part": violated, "whole": len(beside)}
            own = [row for key, row in flights.items() if key[:2] == (mutant["id"], kill["situation"])]
            violated = sum(kill["requirement"] in row["violated"] for row in own)
            assert kill["flights"] == {"part": violated, "whole": len(own)}


def test_a_detection_is_as_sure_as_its_p_is_small(told: dict[str, Any]):
    assert told["certainty"] == [0.01, 0.001, 0.00001]
    steps = {}
    for mutant in told["mutants"]:
        p = min((test["p"] for test in mutant["tests"] if test["requirement"] in SAFETY), default=1)
        steps[mutant["id"]] = mutant["certainty"]
        assert mutant["certainty"] == (sum(p <= step for step in told["certainty"]) if p <= 0.01 else 0)
    assert steps["LATE-human@3s"] == 3
    assert steps["MORE-goal@0.6m"] == 0


def test_a_situation_is_named_by_the_values_that_are_not_benign(told: dict[str, Any]):
    names = {situation["key"]: (situation["name"], situation["aliases"]) for situation in told["situations"]}
    assert names["T0O0W0D0H0"] == ("every value benign", [])
    assert names["T1O1W1D1H0"] == ("corner, obstacle, near wall, dark", ["32"])


def test_the_ratios_are_those_of_the_export(told: dict[str, Any], counted: dict[str, dict[str, Count]]):
    defaults = [counted[mutant].values() for mutant in DEFAULTS]
    ratios = {ratio["name"]: (ratio["part"], ratio["whole"]) for ratio in told["ratios"]}
    assert ratios == {
        "exercised": (4, sum(cell["status"] == "credible" for cell in told["cells"])),
        "infected": (sum(any(count.infected for count in counts) for counts in defaults), 4),
        "tested": (sum(any(count.tests for count in counts) for counts in defaults), 4),
        "mutation_score": (1, 4),
        "firm": (1, 4),
        "operability": (1, 4),
    }
    assert all(ratio["population"] and "interval" not in ratio for ratio in told["ratios"])


def test_what_a_verdict_rests_on_is_counted_in_steady_pairs(
    told: dict[str, Any], rows: list[dict[str, Any]], counted: dict[str, dict[str, Count]]
):
    states = states_of(rows)
    for mutant in told["mutants"]:
        counts = counted[mutant["id"]]
        tests = {test["requirement"]: test for test in mutant["tests"]}
        for name in (*SAFETY, "OP1"):
            keys = {key for key, count in counts.items() if count.infected and states[key, name] == "steady"}
            pool = [row for row in rows if row["mutant"] == "baseline" and row["situation"] in keys]
            assert (name in tests) == bool(keys)
            if not keys:
                continue
            assert tests[name]["kills"]["whole"] == len(keys)
            flights = sum(counts[key].violated[name] for key in keys), sum(counts[key].flown for key in keys)
            assert tuple(tests[name]["flights"].values()) == flights
            judged = sum(name in (*row["held"], *row["violated"]) for row in pool)
            assert tuple(tests[name]["baseline"].values()) == (sum(name in row["violated"] for row in pool), judged)
            detected = name in mutant["by"]
            assert (tests[name]["p"] <= 0.01) == detected
            assert not tests[name]["kills"]["part"] or detected


def test_a_control_names_what_shows_it(told: dict[str, Any], study: Study, quick: Figures):
    shows = {mutant["id"]: mutant["shows"] for mutant in told["mutants"]}
    assert shows.pop("REVERSE-velcmd") == ["SR1"]
    assert not any(shows.values())
    assert told["gates"]["controls"] == {"part": 1, "whole": 1}
    few = quick(evidence_of(study, campaign(study, ("LATE-human@3s", "REVERSE-velcmd"), range(1), range(1))))
    late, control = few["mutants"]
    assert (few["pooled"], control["by"], control["shows"]) == (False, [], ["SR1"])
    # without a pool nothing is told but what was seen
    assert {few["signs"][result[0]] for result in control["results"]} == {"seen"}
    assert {few["signs"][result[0]] for result in late["results"]} == {"seen", "no_test", "not_infected"}
    assert few["ratios"][3].items() >= {"name": "mutation_score", "part": 0, "whole": 0}.items()


def test_the_line_below_the_matrix_counts_default_mutants(told: dict[str, Any], counted: dict[str, dict[str, Count]]):
    for situation, counts in zip(told["situations"], told["by_situation"], strict=True):
        here = {mutant: counted[mutant][situation["key"]] for mutant in DEFAULTS}
        assert counts == {
            "killed": len(here["LATE-human@3s"].most),
            "tested": sum(bool(count.tests) for count in here.values()),
            "flown": 4,
        }


def test_pairs_and_coverage_are_those_of_the_export(told: dict[str, Any], rows: list[dict[str, Any]]):
    states = states_of(rows)
    assert {(pair["situation"], pair["requirement"]): pair["state"] for pair in told["pairs"]} == states
    assert set(states.values()) == {"steady", "red", "unsteady", "open", "vacuous"}
    red = {row["situation"] for row in rows if row["mutant"] == "baseline" and row["status"] == "violated"}
    assert {first["situation"] for first in told["firsts"]} == red
    steady = {key for (key, name), state in states.items() if state == "steady" and name in SAFETY}
    assert told["gates"]["steady_situations"] == {"part": len(steady), "whole": 32}
    assert told["gates"]["invalid_flights"] == sum(row["status"] == "invalid" for row in rows)
    assert told["coverage"]["situations"] == {"part": 32, "whole": 32}
    assert told["coverage"]["t_way"]["2"].items() >= {"part": 40, "whole": 40}.items()
    assert (told["flights"], told["seeds"]) == (len(rows), [0, 1, 2])


def test_every_flight_tells_what_its_row_of_the_export_tells(
    text: str, told: dict[str, Any], rows: list[dict[str, Any]]
):
    quanta = [entry["quantum"] for entry in told["columns"]]
    flights = {
        (flight["mutant"], key, flight["seed"]): flight
        for key, pack in embedded(text, "flights").items()
        for flight in unpacked(pack, quanta)
    }
    names = [requirement["name"] for requirement in told["requirements"]]
    for row in rows:
        if row["mutant"] == "PLACEBO":
            continue
        flight = flights.pop((row["mutant"], row["situation"], row["seed"]))
        assert {key: flight[key] for key in ("status", "ending", "struck", "infected_at_s", "duration_s")} == {
            key: row[key] for key in ("status", "ending", "struck", "infected_at_s", "duration_s")
        }
        readings = dict(zip(names, flight["readings"], strict=True))
        assert [name for name, reading in readings.items() if reading and reading[2] == "violated"] == row["violated"]
        assert [(f"rho_{name}", reading and reading[0]) for name, reading in readings.items()] == [
            (column, row[column]) for column in row if column.startswith("rho_")
        ]
    assert not flights


def test_neighbouring_columns_differ_in_one_axis(told: dict[str, Any]):
    levels = [situation["levels"] for situation in told["situations"]]
    for one, next_ in pairwise(levels):
        assert sum(a != b for a, b in zip(one, next_, strict=True)) == 1


def test_the_smallest_suite_and_the_minimal_mutants_are_those_of_brute_force(study: Study):
    evidence = evidence_of(study, campaign(study, ("LATE-human@3s", "NO-human@100%", "NO-depth@3s", "MORE-goal@0.6m")))
    told = embedded(page(evidence, 1), "figures")
    kills = {m: {key for key, count in c.items() if count.most} for m, c in counts_of(exported(evidence)).items()}
    kills = {mutant: keys for mutant, keys in kills.items() if keys}
    assert len(kills) == 2
    keys = [situation["key"] for situation in told["situations"]]
    least = next(
        size for size in range(4) for chosen in combinations(keys, size) if all(set(chosen) & k for k in kills.values())
    )
    assert len(told["suite"]["situations"]) == least
    minimal = {m for m, k in kills.items() if not any(other < k for other in kills.values())}
    assert {m for node in told["subsumption"]["nodes"] if node["minimal"] for m in node["mutants"]} == minimal


def test_a_ladder_has_a_rung_for_each_magnitude_flown(told: dict[str, Any]):
    (ladder,) = told["ladders"]
    assert ladder["cell"] == "LATE-human"
    assert [(rung["magnitude"], rung["default"]) for rung in ladder["rungs"]] == [("1s", False), ("3s", True)]


def test_the_gates_hold_over_flights_that_nothing_is_wrong_with(told: dict[str, Any]):
    assert told["gates"]["failed"] == ""


def test_gates_that_fail_are_told(evidence: Evidence, quick: Figures):
    failing = replace(evidence, stale=Stale(invalid=("no score is valid: gate failed: PLACEBO differs",)))
    assert "PLACEBO differs" in quick(failing)["gates"]["failed"]


def test_a_requirement_that_was_never_put_to_the_test_has_no_least_robustness(evidence: Evidence, quick: Figures):
    def idle(outcome: Outcome) -> Outcome:
        readings = [replace(r, rho=24.0, triggered=0) if r.requirement == "OP1" else r for r in outcome.readings]
        return replace(outcome, readings=tuple(readings))

    outcomes = tuple(map(idle, evidence.outcomes))
    told = {t["requirement"]: t["least_rho"] for t in quick(replace(evidence, outcomes=outcomes))["tallies"]}
    assert told["OP1"] is None
    assert told["SR2"] is not None


def test_what_the_head_says_the_drone_fails_and_nobody_claims_is_as_recorded(evidence: Evidence, study: Study):
    def scored(outcomes: Iterable[Outcome]) -> Score:
        return score(outcomes, study.roster, study.space)

    paper, every = scored(evidence.outcomes), Ratio(32, 32)
    clean = [o for o in campaign(study, ("NO-depth@3s",)) if o.situation in ("T0O0W1D0H0", "T0O0W0D0H1")]
    # SR1 is red at the bar, unsteady where three of ten strike a wall; SR2 is red in the dark with a person
    assert {paper.pool.states[key, "SR1"].value for key in (BAR, SHAKY)} == {"red", "unsteady"}
    heads = {
        "a campaign of 32 situations": head(paper, every, 0),
        "a break around the grid": head(paper, every, 1),
        "situations were chosen, and few of the grid flown": head(
            paper, Ratio(3, 32), 0, selected(replace(paper, selected=("T0O0W0D0H1",)), study)
        ),
        "nothing fails": head(scored(clean), every, 0),
        "without a pool": head(scored(campaign(study, ("LATE-human@3s",), range(1), range(1))), every, 0),
        "tests of one's own": head(replace(paper, of_tests=True), every, 0),
    }
    as_recorded(
        __file__,
        {
            name: "\n".join([*map(told.get, ("answer", "sure", "claim")), "", *told["fails"], "", *told["claims"]])
            for name, told in heads.items()
        },
    )
