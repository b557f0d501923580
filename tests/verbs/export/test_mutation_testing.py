from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import jsonschema
from builders import outcome, pool
from dossiers import HOSTILE, LINES, dossier, dossiers
from effort import usually
from hypothesis import given, settings

from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.verbs.export.ci import mutation_testing
from scaloft_fi.verbs.export.dossier import Dossier

SCHEMA = json.loads((Path(__file__).parents[2] / "support" / "mutation-testing-report-schema-3.8.4.json").read_text())
HERE, THERE = "T0O0W0D0H0", "T0O0W0D0H1"


def mutants(report: dict[str, Any]) -> dict[str, Any]:
    return {mutant["id"]: mutant for file in report["files"].values() for mutant in file["mutants"]}


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_the_report_is_valid_against_the_published_schema(dossier: Dossier) -> None:
    jsonschema.Draft7Validator(SCHEMA).validate(json.loads(json.dumps(mutation_testing(dossier), allow_nan=False)))


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_the_scores_that_its_readers_compute_are_the_mutation_score_and_the_same_of_mutants_tested(
    dossier: Dossier,
) -> None:
    counts = Counter(mutant["status"] for mutant in mutants(mutation_testing(dossier)).values())
    killed, survived, uncovered = counts["Killed"], counts["Survived"], counts["NoCoverage"]
    scored = dossier.score
    assert Ratio(killed, killed + survived + uncovered) == scored.mutation_score
    if scored.pooled:
        assert Ratio(killed, killed + survived) == Ratio(scored.mutation_score.part, scored.tested.part)


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


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_every_mutant_and_control_stands_once_on_the_line_of_its_cell(dossier: Dossier) -> None:
    report = mutation_testing(dossier)
    found = {m["id"]: (name, m) for name, file in report["files"].items() for m in file["mutants"]}
    flown = (*dossier.score.mutants, *dossier.score.controls)
    assert sorted(found) == sorted(mutant.subject.id for mutant in flown)
    for mutant in flown:
        name, entry = found[mutant.subject.id]
        assert name == f"hazop/matrix/{mutant.subject.parameter}.yaml"
        assert entry["location"]["start"]["line"] == LINES[mutant.subject.guideword, mutant.subject.parameter]
        assert HOSTILE in entry["description"]


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_a_test_kills_only_what_it_covers_and_every_test_named_exists(dossier: Dossier) -> None:
    report = mutation_testing(dossier)
    tests = {test["id"] for file in report["testFiles"].values() for test in file["tests"]}
    for mutant in mutants(report).values():
        assert set(mutant["killedBy"]) <= set(mutant["coveredBy"]) <= tests
        assert not mutant["killedBy"] or mutant["status"] in ("Killed", "Ignored")
        assert mutant["coveredBy"] or mutant["status"] not in ("Killed", "Survived")
