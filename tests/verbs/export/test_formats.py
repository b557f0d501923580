"""The formats that other tools read: laws that hold of every campaign, and what is recorded of some in a file."""

from __future__ import annotations

import json
import re
import shlex
from collections import Counter
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import jsonschema
import yaml
from builders import CLASSED, GRID, outcome, pool
from dossiers import HOSTILE, LINES, dossier, dossiers
from finding import found, known
from hypothesis import given
from junitparser import Error, Failure, JUnitXml, Skipped
from said import as_recorded
from sarif_pydantic import Sarif

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.console import line
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.export.assurance import gsn, to_json, to_markdown
from scaloft_fi.verbs.export.ci import junit, mutation_testing, sarif
from scaloft_fi.verbs.export.dossier import FORMATS, Dossier

HERE, THERE, RED = "T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H1"
LATE, MORE, NO, CONTROL = "LATE-human@3s", "MORE-goal@0.6m", "NO-human@100%", "REVERSE-human"
BOTH = {"SR1": 20.0, "SR2": 20.0}
LAST = date(2027, 1, 31)
ACCEPTED = [Disposition(id_, "A. Owner", "the goal is far from any wall", LAST) for id_ in (MORE, LATE, NO)]


def flown(id_: str, *keys: str, seeds: int = 3, **how: Any) -> list[Outcome]:
    return [outcome(id_, key, seed, **how) for key in keys or (HERE,) for seed in range(seeds)]


def made(*flights: Outcome, pooled: tuple[str, ...] = (HERE,), **how: Any) -> Dossier:
    """A dossier of a study whose texts are short."""
    told = replace(dossier([*pool(*pooled), *flights]), campaign="mine", **how)
    short = {"deviation": "what differs", "effect": "why it matters"}
    cells = {key: replace(cell, **short) for key, cell in told.matrix.cells.items()}
    requirements = tuple(replace(one, title="in words") for one in told.requirements)
    return replace(told, matrix=replace(told.matrix, cells=cells), requirements=requirements)


IDLE = outcome()
IDLE = replace(
    IDLE, readings=tuple(replace(r, rho=24.0, triggered=0) if r.requirement == "SR2" else r for r in IDLE.readings)
)
THREE = (*flown(LATE, violated={"SR2": 7.0}, seeds=10), *flown(MORE, seeds=10), outcome(NO, altered=0))
FIND = (*flown(LATE), *flown(NO))
ALL = ("gsn", "junit", "markdown", "mutation-testing", "sace", "sarif")
CASES = {
    "one is detected, one accepted, one not tested": (made(*THREE, dispositions=tuple(ACCEPTED), today=LAST), ALL),
    "the day after": (
        made(*THREE, dispositions=(ACCEPTED[0],), today=date(2027, 2, 1)),
        ("gsn", "junit", "markdown", "sace", "sarif"),
    ),
    "every survivor is accepted": (made(*flown(MORE, seeds=10), dispositions=(ACCEPTED[0],), today=LAST), ("gsn",)),
    "a survivor with a find, and one without": (
        made(*FIND, finds=known(found(LATE))),
        ("junit", "markdown", "mutation-testing", "sarif"),
    ),
    "without a pool": (
        made(outcome(), outcome(LATE, violated={"SR2": 7.0}), outcome("LATE-human@1s"), outcome(NO), pooled=()),
        ALL,
    ),
    "the second of three flights says most": (
        made(*(outcome(LATE, HERE, seed, violated={"SR2": 7.0} if seed == 1 else {}) for seed in range(3))),
        ("junit", "sarif"),
    ),
    "a control that operability detects": (made(*flown(CONTROL, violated={"OP1": 9.0})), ("junit",)),
    "a control flown once shows itself": (made(outcome(CONTROL, violated={"SR2": 9.0})), ("junit",)),
    "a control flown once shows itself by operability": (made(outcome(CONTROL, violated={"OP1": 9.0})), ("junit",)),
    "a control flown once shows nothing": (made(outcome(CONTROL)), ("junit", "mutation-testing")),
    "a control that was tested shows nothing": (made(*flown(CONTROL)), ("junit",)),
    "killed in one of two situations that test it, and flown in a red one": (
        made(
            *(one for id_ in (LATE, NO, MORE) for one in flown(id_, RED)),
            *(*flown(LATE, THERE, violated={"SR2": 7.0}), *flown(LATE), *flown(NO), outcome(NO, seed=5)),
            *pool(RED, red=9, violated=BOTH),
            pooled=(HERE, THERE),
        ),
        ("markdown", "mutation-testing", "sace"),
    ),
    "classes of severity": (made(*map(outcome, (NO, LATE, MORE)), roster=CLASSED), ("gsn", "markdown", "sarif")),
    "all situations": (made(outcome(LATE), pooled=tuple(key for key, _ in GRID.points)), ("gsn",)),
    "two opposite situations": (made(outcome(LATE), pooled=(HERE, "T1O1W1D1H1")), ("gsn",)),
    "many flights of the unmutated drone, one of which violates": (
        made(*flown("baseline", HERE, THERE, seeds=20), outcome(seed=99, violated={"SR1": 5.0}), pooled=()),
        ("sace",),
    ),
    "a requirement that nothing puts to the test": (made(IDLE, pooled=()), ("sace",)),
    "an id that XML cannot carry": (made(*flown("LATE-human@\x003s")), ("junit",)),
}


def test_what_a_format_says_is_as_recorded() -> None:
    cases = ((name, case, style) for name, (case, styles) in CASES.items() for style in styles)
    as_recorded(__file__, {f"{name}: {style}": FORMATS[style].content(case).decode() for name, case, style in cases})


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


SCHEMA = json.loads((Path(__file__).parents[2] / "support" / "mutation-testing-report-schema-3.8.4.json").read_text())


@given(dossiers())
def test_the_report_of_mutation_testing_fits_its_schema_and_its_readers_compute_our_score(dossier: Dossier) -> None:
    report = mutation_testing(dossier)
    jsonschema.Draft7Validator(SCHEMA).validate(json.loads(json.dumps(report, allow_nan=False)))
    found = {m["id"]: (name, m) for name, file in report["files"].items() for m in file["mutants"]}
    counts = Counter(mutant["status"] for _, mutant in found.values())
    killed, survived, uncovered = counts["Killed"], counts["Survived"], counts["NoCoverage"]
    scored = dossier.score
    assert Ratio(killed, killed + survived + uncovered) == scored.mutation_score
    if scored.pooled:
        assert Ratio(killed, killed + survived) == Ratio(scored.mutation_score.part, scored.tested.part)
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


PREFIX = re.compile(r"(CG|CSn|Sn|G|S|C|A|J)\d+")
SUPPORTERS = {"G": {"G", "S", "Sn"}, "S": {"G", "S", "Sn"}, "CG": {"CG", "CSn", "S"}}
"""By which kinds of nodes a node may be supported."""


def read_gsn(text: str) -> dict[str, Any]:
    found = yaml.safe_load(text)
    assert set(found.pop("module")) == {"name", "brief"}
    return dict(found)


def kind(name: str) -> str:
    match = PREFIX.fullmatch(name)
    assert match, name
    return match[1]


@given(dossiers())
def test_every_node_has_a_kind_and_a_text_and_hangs_on_one_root_or_challenges_it(dossier: Dossier) -> None:
    nodes = read_gsn(gsn(dossier))
    referred = set[str]()
    for name, node in nodes.items():
        assert node["text"]
        supporters, context = node.get("supportedBy", []), node.get("inContextOf", [])
        assert len({*supporters, *context}) == len(supporters) + len(context)
        assert name not in supporters
        assert {*supporters, *context, *([node["challenges"]] if "challenges" in node else [])} <= nodes.keys()
        assert all(kind(other) in SUPPORTERS[kind(name)] for other in supporters)
        assert all(kind(other) in {"C", "A", "J"} for other in context)
        if kind(name) in {"G", "S", "CG"}:
            assert node.get("undeveloped", False) is not bool(supporters)
        referred |= {*supporters, *context}
    assert {name for name, node in nodes.items() if name not in referred and "challenges" not in node} == {"G1"}
    challenges = [node["text"].split(" ")[0] for node in nodes.values() if node.get("challenges") == "G3"]
    assert challenges == [mutant.subject.id for mutant in dossier.score.counted if not mutant.detected]
    assert nodes["G4"].get("undeveloped", False) is bool(challenges or not dossier.score.pooled)


@given(dossiers())
def test_the_log_has_the_same_headings_as_a_page_and_as_json(dossier: Dossier) -> None:
    page = to_markdown(dossier)
    headings = [line.removeprefix("### ") for line in page.splitlines() if line.startswith("### ")]
    assert list(json.loads(json.dumps(to_json(dossier), allow_nan=False))) == headings
