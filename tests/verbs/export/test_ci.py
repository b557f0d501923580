"""The formats that continuous integration reads: JUnit, SARIF, mutation testing, the page of a run."""

from __future__ import annotations

import json
import shlex
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
from builders import CLASSED, outcome, pool
from dossiers import HOSTILE, LINES, dossier, dossiers
from finding import flies, found, known
from hypothesis import given
from junitparser import Error, Failure, JUnitXml, Skipped
from sarif_pydantic import Sarif

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.console import line
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.export.ci import junit, mutation_testing, sarif, summary
from scaloft_fi.verbs.export.dossier import Dossier

HERE, THERE, RED = "T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H1"
CONTROL = "REVERSE-human"


def read_junit(text: str) -> dict[str, dict[str, list[type]]]:
    """Per suite and test case the kinds of its results, as a reader of JUnit files sees them."""
    return {
        suite.name: {case.name: [type(result) for result in case.result] for case in suite}
        for suite in JUnitXml.fromstring(text.encode())
    }


def kinds(mutant: MutantScore) -> list[type]:
    if not mutant.flown:
        return [Error]
    return {Verdict.DETECTED: [], Verdict.NOT_DETECTED: [Failure]}.get(mutant.verdict, [Skipped])


def controls(*flights: Outcome) -> dict[str, list[type]]:
    return read_junit(junit(dossier([*pool(HERE), *flights])))["controls"]


@given(dossiers())
def test_a_detected_mutant_passes_and_every_other_case_carries_the_replay_and_the_next_step(dossier: Dossier) -> None:
    text = junit(dossier)
    suites = read_junit(text)
    for mutant in dossier.score.mutants:
        assert suites[mutant.subject.parameter][mutant.subject.id] == kinds(mutant)
    assert set(suites.get("controls", {})) == {control.subject.id for control in dossier.score.controls}
    flown = {outcome.name for outcome in dossier.outcomes}
    scores = {mutant.subject.id: mutant for mutant in (*dossier.score.mutants, *dossier.score.controls)}
    whole = JUnitXml.fromstring(text.encode())
    for case in (case for suite in whole for case in suite):
        for result in case.result:
            first, *_ = (shlex.split(told.partition(": ")[2]) for told in result.text.splitlines())
            assert first[:2] == ["scaloft-fi", "replay"]
            assert first[2] in flown
            assert first[2].startswith(f"{case.name}/")
            assert line(f"; next: {dossier.next_command(scores[case.name])}") in result.message
    said = (whole.tests, whole.failures, whole.errors, whole.skipped)
    whole.update_statistics()
    assert said == (whole.tests, whole.failures, whole.errors, whole.skipped)


def test_the_flight_to_fly_again_is_the_one_that_says_most() -> None:
    flights = [outcome("LATE-human@3s", HERE, seed, violated={"SR2": 7.0} if seed == 1 else {}) for seed in range(3)]
    ((case,),) = JUnitXml.fromstring(junit(dossier([*pool(HERE), *flights])).encode())
    (skipped,) = case.result
    assert f"scaloft-fi replay LATE-human@3s/{HERE}/1 " in skipped.text


def test_a_find_is_told_beside_a_failure_and_instead_of_seeds() -> None:
    late, no = "LATE-human@3s", "NO-human@100%"
    flights = [*pool(HERE), *(outcome(late, HERE, seed) for seed in range(3)), outcome(no, HERE)]
    text = junit(dossier(flights, known(found(late), found(no))))
    results = {case.name: case.result[0] for suite in JUnitXml.fromstring(text.encode()) for case in suite}
    assert {id_: type(result) for id_, result in results.items()} == {late: Failure, no: Skipped}
    assert all(result.message.endswith(f"; next: {flies(id_)}") for id_, result in results.items())


def test_a_control_that_is_detected_by_operability_alone_passes() -> None:
    assert controls(*(outcome(CONTROL, HERE, seed, violated={"OP1": 9.0}) for seed in range(3))) == {CONTROL: []}


def test_a_control_that_was_flown_once_passes_when_that_flight_is_told_from_its_baseline() -> None:
    assert controls(outcome(CONTROL, HERE, violated={"SR2": 9.0})) == {CONTROL: []}
    assert controls(outcome(CONTROL, HERE, violated={"OP1": 9.0})) == {CONTROL: []}
    assert controls(outcome(CONTROL, HERE)) == {CONTROL: [Skipped]}


def test_a_control_that_shows_nothing_where_it_was_tested_fails() -> None:
    assert controls(*(outcome(CONTROL, HERE, seed) for seed in range(3))) == {CONTROL: [Failure]}


def test_what_xml_cannot_carry_is_spelled_out() -> None:
    flights = [*pool(HERE), *(outcome("LATE-human@\x003s", HERE, seed) for seed in range(3))]
    assert read_junit(junit(dossier(flights)))["human"] == {"LATE-human@\\x003s": [Failure]}


@given(dossiers())
def test_a_reader_of_sarif_finds_each_mutant_that_is_not_detected_on_the_line_of_its_cell(dossier: Dossier) -> None:
    plain = sarif(dossier)
    (run,) = Sarif.model_validate_json(json.dumps(plain, allow_nan=False)).runs
    rules = run.tool.driver.rules or []
    assert sorted({result.rule_id for result in run.results}) == sorted(rule.id for rule in rules)
    mutants = [mutant for mutant in dossier.score.counted if not mutant.detected]
    flown = {outcome.name for outcome in dossier.outcomes}
    for result, raw, mutant in zip(run.results, plain["runs"][0]["results"], mutants, strict=True):
        assert result.partial_fingerprints["mutant/v1"] == mutant.subject.id
        place = result.locations[0].physical_location
        assert place.artifact_location.uri == f"hazop/matrix/{mutant.subject.parameter}.yaml"
        assert place.region.start_line == LINES[mutant.subject.guideword, mutant.subject.parameter]
        rule, steps = rules[result.rule_index], raw["properties"]
        assert rule.id == result.rule_id == f"{mutant.subject.guideword}-{mutant.subject.parameter}"
        assert HOSTILE in rule.short_description.text
        program, verb, name, *campaign = shlex.split(steps["replay"])
        assert (program, verb, campaign) == ("scaloft-fi", "replay", ["--campaign", dossier.campaign])
        assert name in flown
        assert name.startswith(f"{mutant.subject.id}/")
        assert shlex.split(steps["next"])[0] == "scaloft-fi"
        assert shlex.split(steps["seek"]) == ["scaloft-fi", "seek", mutant.subject.id]
        assert all(command in result.message.text for command in (steps["replay"], steps["next"]))
        assert all(command in rule.help.text for command in steps.values())


def test_an_undecided_mutant_is_a_note_and_its_message_tells_the_verdict() -> None:
    flights = [*pool("T0O0W0D0H0"), outcome("LATE-human@3s", violated={"SR2": 7.0})]
    flights += [outcome("NO-human@100%", altered=0)]
    flights += [outcome("MORE-goal@0.6m", seed=seed) for seed in range(3)]
    (run,) = sarif(dossier(flights))["runs"]
    assert [result["level"] for result in run["results"]] == ["warning", "note", "warning"]
    texts = [result["message"]["text"] for result in run["results"]]
    assert texts[0].startswith("NO-human@100% is not tested: it changes no sample in any situation flown.  Fly its ")
    assert texts[1].startswith("LATE-human@3s is undecided: it violates SR2 in 1 of 1 situation")
    assert texts[2].startswith("MORE-goal@0.6m is not detected: nothing seen in 1 situation")


SCHEMA = json.loads((Path(__file__).parents[2] / "support" / "mutation-testing-report-schema-3.8.4.json").read_text())


def mutants(report: dict[str, Any]) -> dict[str, Any]:
    return {mutant["id"]: mutant for file in report["files"].values() for mutant in file["mutants"]}


@given(dossiers())
def test_the_report_of_mutation_testing_fits_its_schema_and_its_readers_compute_our_score(dossier: Dossier) -> None:
    report = mutation_testing(dossier)
    jsonschema.Draft7Validator(SCHEMA).validate(json.loads(json.dumps(report, allow_nan=False)))
    counts = Counter(mutant["status"] for mutant in mutants(report).values())
    killed, survived, uncovered = counts["Killed"], counts["Survived"], counts["NoCoverage"]
    scored = dossier.score
    assert Ratio(killed, killed + survived + uncovered) == scored.mutation_score
    if scored.pooled:
        assert Ratio(killed, killed + survived) == Ratio(scored.mutation_score.part, scored.tested.part)
    found = {m["id"]: (name, m) for name, file in report["files"].items() for m in file["mutants"]}
    tests = {test["id"] for file in report["testFiles"].values() for test in file["tests"]}
    flown = (*scored.mutants, *scored.controls)
    assert sorted(found) == sorted(mutant.subject.id for mutant in flown)
    for mutant in flown:
        name, entry = found[mutant.subject.id]
        assert name == f"hazop/matrix/{mutant.subject.parameter}.yaml"
        assert entry["location"]["start"]["line"] == LINES[mutant.subject.guideword, mutant.subject.parameter]
        assert HOSTILE in entry["description"]
        assert set(entry["killedBy"]) <= set(entry["coveredBy"]) <= tests
        assert not entry["killedBy"] or entry["status"] in ("Killed", "Ignored")
        assert entry["coveredBy"] or entry["status"] not in ("Killed", "Survived")


def test_without_a_pool_every_counted_mutant_is_pending_with_the_reason() -> None:
    flights = [
        outcome(),
        outcome("LATE-human@3s", violated={"SR2": 7.0}),
        outcome("LATE-human@1s"),
        outcome("NO-human@100%"),
    ]
    found = mutants(mutation_testing(dossier(flights)))
    assert {name: mutant["status"] for name, mutant in found.items()} == {
        "LATE-human@3s": "Pending",
        "NO-human@100%": "Pending",
        "LATE-human@1s": "Ignored",
    }
    assert found["LATE-human@3s"]["statusReason"].startswith("undecided: too few baseline flights to tell; 1 of its 1 ")


def test_the_situations_that_test_a_mutant_cover_it_and_those_with_a_kill_kill_it() -> None:
    flights = [*pool(HERE, THERE), *pool("T0O0W0D1H1", red=10, violated={"SR1": 20.0, "SR2": 20.0})]
    for seed in range(3):
        flights += [outcome("LATE-human@3s", key, seed) for key in (HERE, "T0O0W0D1H1")]
        flights += [outcome("LATE-human@3s", THERE, seed, violated={"SR2": 7.0})]
    (found,) = mutants(mutation_testing(dossier(flights))).values()
    assert (found["status"], found["coveredBy"], found["killedBy"]) == ("Killed", [HERE, THERE], [THERE])
    assert found["testsCompleted"] == 3


def test_a_control_is_ignored_as_one() -> None:
    (found,) = mutants(mutation_testing(dossier([*pool(HERE), outcome("REVERSE-human", HERE)]))).values()
    assert found["status"] == "Ignored"
    assert found["statusReason"].startswith("a control, in no ratio: undecided")


def test_the_page_has_the_ratios_the_mutants_by_verdict_and_the_findings_about_the_unmutated_drone() -> None:
    flights = [*pool(HERE), *pool(RED, red=9, violated={"SR1": 20.0, "SR2": 20.0})]
    for seed in range(3):
        flights.append(outcome("LATE-human@3s", HERE, seed, violated={"SR2": 7.0}))
        flights.append(outcome("NO-human@100%", HERE, seed))
        flights.append(outcome("MORE-goal@0.6m", RED, seed))
    page = summary(dossier(flights))
    headings = [line for line in page.splitlines() if line.startswith("### ")]
    assert headings[1:] == [
        *("### 1 detected", "### 1 not detected", "### 1 not tested"),
        "### 1 situations where the unmutated drone violates a safety requirement",
    ]
    detected, not_detected, not_tested, findings = (page.split(heading)[1].split("###")[0] for heading in headings[1:])
    assert "| LATE-human@3s | killed in 1 of 1 situation" in " ".join(detected.split())
    assert "NO-human@100%" in not_detected
    assert "MORE-goal@0.6m" in not_tested
    assert f"| {RED} | SR1 | 9/10 | red |" in " ".join(findings.split())
    assert "| mutation score | 1/3 = 33 % |" in " ".join(page.split())
    assert "| firm | 0/3 = 0 % |" in " ".join(page.split())
    assert "0.02 at most would still be called shown" in page


def test_without_a_pool_no_percentage_is_told_but_what_was_seen_and_what_to_call() -> None:
    page = summary(dossier([outcome(), outcome("LATE-human@3s", violated={"SR2": 7.0})]))
    assert " %" not in page.split("###")[1]
    assert "No score: no situation in which a mutant changes a sample has 10 baseline flights" in page
    assert "1 of its 1 flights violate a safety requirement that the baseline beside them holds" in page
    assert "0 detected" not in page


def test_survivors_of_the_worst_class_stand_first_with_their_class() -> None:
    flights = [*pool(HERE), *(outcome(id_, HERE) for id_ in ("NO-human@100%", "LATE-human@3s", "MORE-goal@0.6m"))]
    page = summary(replace(dossier(flights), roster=CLASSED))
    rows = [line.split("|")[1:3] for line in page.splitlines() if "@" in line]
    assert [[cell.strip() for cell in row] for row in rows] == [
        ["MORE-goal@0.6m", "injury"],
        ["NO-human@100%", "delay"],
        ["LATE-human@3s", ""],
    ]
