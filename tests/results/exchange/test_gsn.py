"""The argument by the published rules of gsn2x, as far as they apply to one module."""

from __future__ import annotations

import re
from typing import Any

import yaml
from builders import outcome
from dossiers import dossier, dossiers
from hypothesis import given

from scaloft_fi.results.exchange.dossier import Dossier
from scaloft_fi.results.exchange.gsn import gsn

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


@given(dossiers())
def test_every_survivor_is_a_counter_goal(dossier: Dossier) -> None:
    nodes = read(gsn(dossier))
    challenges = [node["text"].split(" ")[0] for node in nodes.values() if node.get("challenges") == "G3"]
    assert challenges == [mutant.subject.id for mutant in dossier.survivors]
    assert nodes["G4"].get("undeveloped", False) is bool(dossier.survivors)


def test_the_claim_carries_the_exact_interval() -> None:
    flights = [
        outcome(),
        outcome("LATE-human@3s", violated={"SR2": 7.0}),
        outcome("NO-human@100%", digest="x"),
    ]
    # Clopper and Pearson for 1 of 2
    assert "kills 1/2 = 50 % (exact 95 % interval 1 to 99 %)" in read(gsn(dossier(flights)))["G3"]["text"]
