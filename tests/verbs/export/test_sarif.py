from __future__ import annotations

import json
import shlex

from builders import outcome, pool
from dossiers import HOSTILE, LINES, dossier, dossiers
from effort import usually
from hypothesis import given, settings
from sarif_pydantic import Sarif

from scaloft_fi.verbs.export.ci import sarif
from scaloft_fi.verbs.export.dossier import Dossier


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_a_reader_of_sarif_finds_each_mutant_that_is_not_detected_on_the_line_of_its_cell(dossier: Dossier) -> None:
    (run,) = Sarif.model_validate_json(json.dumps(sarif(dossier), allow_nan=False)).runs
    rules = run.tool.driver.rules or []
    mutants = [mutant for mutant in dossier.score.counted if not mutant.detected]
    assert [result.partial_fingerprints["mutant/v1"] for result in run.results] == [m.subject.id for m in mutants]
    for result, mutant in zip(run.results, mutants, strict=True):
        place = result.locations[0].physical_location
        assert place.artifact_location.uri == f"hazop/matrix/{mutant.subject.parameter}.yaml"
        assert place.region.start_line == LINES[mutant.subject.guideword, mutant.subject.parameter]
        rule = rules[result.rule_index]
        assert rule.id == result.rule_id == f"{mutant.subject.guideword}-{mutant.subject.parameter}"
        assert HOSTILE in rule.short_description.text


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


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_no_rule_is_without_a_result(dossier: Dossier) -> None:
    (run,) = sarif(dossier)["runs"]
    rules = [rule["id"] for rule in run["tool"]["driver"]["rules"]]
    assert len(rules) == len(set(rules))
    assert set(rules) == {result["ruleId"] for result in run["results"]}


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_every_result_carries_the_replay_and_the_next_step_where_viewers_show_them(dossier: Dossier) -> None:
    (run,) = Sarif.model_validate_json(json.dumps(sarif(dossier), allow_nan=False)).runs
    flown = {outcome.name for outcome in dossier.outcomes}
    for result, raw in zip(run.results, sarif(dossier)["runs"][0]["results"], strict=True):
        mutant, steps = result.partial_fingerprints["mutant/v1"], raw["properties"]
        program, verb, name, *campaign = shlex.split(steps["replay"])
        assert (program, verb) == ("scaloft-fi", "replay")
        assert name in flown
        assert name.startswith(f"{mutant}/")
        assert campaign == ["--campaign", dossier.campaign]
        assert shlex.split(steps["next"])[0] == "scaloft-fi"
        assert shlex.split(steps["seek"]) == ["scaloft-fi", "seek", mutant]
        rule = run.tool.driver.rules[result.rule_index]
        for command in (steps["replay"], steps["next"]):
            assert command in result.message.text
        for command in steps.values():
            assert command in rule.help.text
