from __future__ import annotations

import json

from dossiers import HOSTILE, LINES, dossiers
from hypothesis import given
from sarif_pydantic import Sarif

from scaloft_fi.results.exchange.dossier import Dossier
from scaloft_fi.results.exchange.sarif import sarif


@given(dossiers())
def test_a_reader_of_sarif_finds_each_survivor_on_the_line_of_its_cell(dossier: Dossier) -> None:
    (run,) = Sarif.model_validate_json(json.dumps(sarif(dossier), allow_nan=False)).runs
    rules = run.tool.driver.rules or []
    assert [result.partial_fingerprints["mutant/v1"] for result in run.results] == [
        mutant.subject.id for mutant in dossier.survivors
    ]
    for result, mutant in zip(run.results, dossier.survivors, strict=True):
        place = result.locations[0].physical_location
        assert place.artifact_location.uri == f"hazop/matrix/{mutant.subject.parameter}.yaml"
        assert place.region.start_line == LINES[mutant.subject.guideword, mutant.subject.parameter]
        rule = rules[result.rule_index]
        assert rule.id == result.rule_id == f"{mutant.subject.guideword}-{mutant.subject.parameter}"
        assert HOSTILE in rule.short_description.text


@given(dossiers())
def test_no_rule_is_without_a_result(dossier: Dossier) -> None:
    (run,) = sarif(dossier)["runs"]
    rules = [rule["id"] for rule in run["tool"]["driver"]["rules"]]
    assert len(rules) == len(set(rules))
    assert set(rules) == {result["ruleId"] for result in run["results"]}
