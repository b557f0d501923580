from __future__ import annotations

import json
from pathlib import Path

import jsonschema
from dossiers import HOSTILE, LINES, dossiers
from hypothesis import given

from scaloft_fi.results.exchange.dossier import Dossier
from scaloft_fi.results.exchange.mutation_testing import mutation_testing
from scaloft_fi.results.scoring.ratio import Ratio

SCHEMA = json.loads((Path(__file__).parent / "mutation-testing-report-schema-3.8.4.json").read_text())


@given(dossiers())
def test_the_report_is_valid_against_the_published_schema(dossier: Dossier) -> None:
    jsonschema.Draft7Validator(SCHEMA).validate(json.loads(json.dumps(mutation_testing(dossier), allow_nan=False)))


@given(dossiers())
def test_the_score_that_its_readers_compute_of_covered_code_is_the_mutation_score(dossier: Dossier) -> None:
    mutants = [mutant for file in mutation_testing(dossier)["files"].values() for mutant in file["mutants"]]
    killed, survived = (sum(m["status"] == status for m in mutants) for status in ("Killed", "Survived"))
    assert Ratio(killed, killed + survived) == dossier.score.mutation_score


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


@given(dossiers())
def test_a_test_kills_only_what_it_covers_and_every_test_named_exists(dossier: Dossier) -> None:
    report = mutation_testing(dossier)
    tests = {test["id"] for file in report["testFiles"].values() for test in file["tests"]}
    for file in report["files"].values():
        for mutant in file["mutants"]:
            assert set(mutant["killedBy"]) <= set(mutant["coveredBy"]) <= tests
            assert mutant["killedBy"] or mutant["status"] != "Killed"
