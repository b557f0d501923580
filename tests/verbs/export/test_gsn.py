"""The argument by the published rules of gsn2x, as far as they apply to one module."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import yaml
from builders import CLASSED, GRID, outcome, pool
from dossiers import dossier, dossiers
from effort import usually
from hypothesis import given, settings

from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.export.assurance import gsn
from scaloft_fi.verbs.export.dossier import Dossier

PREFIX = re.compile(r"(CG|CSn|Sn|G|S|C|A|J)\d+")
SUPPORTERS = {"G": {"G", "S", "Sn"}, "S": {"G", "S", "Sn"}, "CG": {"CG", "CSn", "S"}}
"""By which kinds of nodes a node may be supported."""


def read(text: str) -> dict[str, Any]:
    found = yaml.safe_load(text)
    assert set(found.pop("module")) == {"name", "brief"}
    return dict(found)


def kind(name: str) -> str:
    match = PREFIX.fullmatch(name)
    assert match, name
    return match[1]


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_every_node_is_of_a_known_kind_has_a_text_and_refers_to_nodes_that_exist(dossier: Dossier) -> None:
    nodes = read(gsn(dossier))
    for name, node in nodes.items():
        assert node["text"]
        supporters, context = node.get("supportedBy", []), node.get("inContextOf", [])
        assert len({*supporters, *context}) == len(supporters) + len(context)
        assert name not in supporters
        assert {*supporters, *context, *([node["challenges"]] if "challenges" in node else [])} <= nodes.keys()
        assert all(kind(other) in SUPPORTERS[kind(name)] for other in supporters)
        assert all(kind(other) in {"C", "A", "J"} for other in context)


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_there_is_one_root_and_everything_hangs_on_it_or_challenges_it(dossier: Dossier) -> None:
    nodes = read(gsn(dossier))
    referred = {
        other for node in nodes.values() for key in ("supportedBy", "inContextOf") for other in node.get(key, [])
    }
    assert {name for name, node in nodes.items() if name not in referred and "challenges" not in node} == {"G1"}
    for name, node in nodes.items():
        if kind(name) in {"G", "S", "CG"}:
            assert node.get("undeveloped", False) is not bool(node.get("supportedBy"))


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_every_mutant_flown_that_is_not_detected_is_a_counter_goal(dossier: Dossier) -> None:
    nodes = read(gsn(dossier))
    challenges = [node["text"].split(" ")[0] for node in nodes.values() if node.get("challenges") == "G3"]
    assert challenges == [mutant.subject.id for mutant in dossier.score.counted if not mutant.detected]
    assert nodes["G4"].get("undeveloped", False) is bool(challenges or not dossier.score.pooled)


def flown(*keys: str) -> list[Outcome]:
    """One mutant that is detected and one that is not, three seeds in each situation."""
    late = [outcome("LATE-human@3s", key, seed, violated={"SR2": 7.0}) for key in keys for seed in range(3)]
    return [*pool(*keys), *late, *(outcome("NO-human@100%", key, seed) for key in keys for seed in range(3))]


def test_the_claim_says_how_many_are_detected_and_how_many_are_firm() -> None:
    nodes = read(gsn(dossier(flown("T0O0W0D0H0"))))
    claim = nodes["G3"]["text"]
    assert claim == "The suite detects 1/2 = 50 % of the mutants flown, 0 without any one seed too"
    assert "alpha 0.01" in nodes["C4"]["text"]
    assert "0.02 at most" in nodes["C5"]["text"]
    assert nodes["CG1"]["text"] == "NO-human@100% would not have been revealed"


def test_the_claim_of_coverage_names_the_largest_strength_that_is_whole() -> None:
    def claim(*keys: str) -> str:
        return str(read(gsn(dossier(flown(*keys))))["G2"]["text"])

    two = claim("T0O0W0D0H0", "T1O1W1D1H1")
    assert two == "2/32 = 6 % of the situations were flown, among them every value of every axis"
    all_of_them = claim(*(key for key, _ in GRID.points))
    assert all_of_them.endswith(", among them every combination of the values of any 5 axes")
    one = claim("T0O0W0D0H0")
    assert ", of the combinations of their values 1-way 5/10 = 50 %, 2-way 10/40 = 25 %, " in one


def test_without_a_pool_the_claim_is_undeveloped_and_has_no_percentage() -> None:
    claim = read(gsn(dossier([outcome(), outcome("LATE-human@3s", violated={"SR2": 7.0})])))["G3"]
    assert claim["undeveloped"]
    assert "%" not in claim["text"]
    assert "`scaloft-fi run` with the same mutants flies them" in claim["text"]


def test_counter_goals_of_the_worst_class_stand_first_and_name_it() -> None:
    here = "T0O0W0D0H1"
    flights = [*pool(here), *(outcome(id_, here) for id_ in ("NO-human@100%", "LATE-human@3s", "MORE-goal@0.6m"))]
    nodes = read(gsn(replace(dossier(flights), roster=CLASSED)))
    found = [nodes[f"CG{number}"]["text"] for number in (1, 2, 3)]
    assert [text.split(" ")[0] for text in found] == ["MORE-goal@0.6m", "NO-human@100%", "LATE-human@3s"]
    assert "severity: injury, a person may be hurt" in found[0]
    assert "severity" not in found[2]
