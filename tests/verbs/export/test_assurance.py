"""The formats of assurance: the argument by the published rules of gsn2x, the log of verification of SACE."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import Any

import yaml
from builders import CLASSED, GRID, outcome, pool
from dossiers import dossier, dossiers
from hypothesis import given

from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.export.assurance import EDGES, gsn, to_json, to_markdown
from scaloft_fi.verbs.export.dossier import Dossier

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


def flown(*keys: str) -> list[Outcome]:
    """One mutant that is detected and one that is not, three seeds in each situation."""
    late = [outcome("LATE-human@3s", key, seed, violated={"SR2": 7.0}) for key in keys for seed in range(3)]
    return [*pool(*keys), *late, *(outcome("NO-human@100%", key, seed) for key in keys for seed in range(3))]


def test_the_claim_says_how_many_are_detected_and_how_many_are_firm() -> None:
    nodes = read_gsn(gsn(dossier(flown("T0O0W0D0H0"))))
    claim = nodes["G3"]["text"]
    assert claim == "The suite detects 1/2 = 50 % of the mutants flown, 0 without any one seed too"
    assert "alpha 0.01" in nodes["C4"]["text"]
    assert "0.02 at most" in nodes["C5"]["text"]
    assert nodes["CG1"]["text"] == "NO-human@100% would not have been revealed"


def test_the_claim_of_coverage_names_the_largest_strength_that_is_whole() -> None:
    def claim(*keys: str) -> str:
        return str(read_gsn(gsn(dossier(flown(*keys))))["G2"]["text"])

    two = claim("T0O0W0D0H0", "T1O1W1D1H1")
    assert two == "2/32 = 6 % of the situations were flown, among them every value of every axis"
    all_of_them = claim(*(key for key, _ in GRID.points))
    assert all_of_them.endswith(", among them every combination of the values of any 5 axes")
    one = claim("T0O0W0D0H0")
    assert ", of the combinations of their values 1-way 5/10 = 50 %, 2-way 10/40 = 25 %, " in one


def test_without_a_pool_the_claim_is_undeveloped_and_has_no_percentage() -> None:
    claim = read_gsn(gsn(dossier([outcome(), outcome("LATE-human@3s", violated={"SR2": 7.0})])))["G3"]
    assert claim["undeveloped"]
    assert "%" not in claim["text"]
    assert "`scaloft-fi run` with the same mutants flies them" in claim["text"]


def test_counter_goals_of_the_worst_class_stand_first_and_name_it() -> None:
    here = "T0O0W0D0H1"
    flights = [*pool(here), *(outcome(id_, here) for id_ in ("NO-human@100%", "LATE-human@3s", "MORE-goal@0.6m"))]
    nodes = read_gsn(gsn(replace(dossier(flights), roster=CLASSED)))
    found = [nodes[f"CG{number}"]["text"] for number in (1, 2, 3)]
    assert [text.split(" ")[0] for text in found] == ["MORE-goal@0.6m", "NO-human@100%", "LATE-human@3s"]
    assert "severity: injury, a person may be hurt" in found[0]
    assert "severity" not in found[2]


HEADINGS = [
    "Test case details",
    "Required results",
    "Sufficiency of coverage (1): safety requirements",
    "Sufficiency of coverage (2): operational domain model",
    "Sufficiency of coverage (3): operating scenarios",
    "Sufficiency of coverage (4): edge cases",
    "Test environment",
    "Representativeness of the test environment",
    "Not claimed",
]


@given(dossiers())
def test_the_log_has_the_headings_of_the_artefact_in_their_order(dossier: Dossier) -> None:
    page = to_markdown(dossier)
    assert [line.removeprefix("### ") for line in page.splitlines() if line.startswith("### ")] == HEADINGS
    assert list(json.loads(json.dumps(to_json(dossier), allow_nan=False))) == HEADINGS


def test_the_edge_cases_are_the_held_flights_with_the_least_robustness() -> None:
    flights = [outcome(situation=f"T0O0W0D0H{i}", seed=seed) for i in range(2) for seed in range(20)]
    flights.append(outcome(seed=99, violated={"SR1": 5.0}))
    rows = to_json(dossier(flights))[HEADINGS[5]]["rows"]
    assert len(rows) == EDGES
    assert all(row["robustness"] == "0.300" and row["seed"] != 99 for row in rows)


def test_a_requirement_is_listed_with_the_mutants_that_it_put_to_the_test() -> None:
    late = [outcome("LATE-human@3s", seed=seed, violated={"SR2": 7.0}) for seed in range(3)]
    table = to_json(dossier([*pool("T0O0W0D0H0"), *late]))[HEADINGS[2]]
    rows = {row["requirement"]: row for row in table["rows"]}
    detected = "mutants detected by it, of those that it put to the test"
    assert (rows["SR2"][detected], rows["SR1"][detected]) == ("1/1 = 100 %", "0/1 = 0 %")
    assert "SR2-literal" not in rows
    assert "1 detected, 0 undecided, 0 not detected, 0 not tested" in table["notes"][1]


def test_a_situation_says_what_the_unmutated_drone_violates_and_which_mutants_are_killed() -> None:
    late = [outcome("LATE-human@3s", seed=seed, violated={"SR2": 7.0}) for seed in range(3)]
    both = {"SR1": 20.0, "SR2": 20.0}
    flights = [*pool("T0O0W0D0H0", red=1, violated=both), *pool("T0O0W0D1H1", red=10, violated=both), *late]
    rows = to_json(dossier(flights))[HEADINGS[4]]["rows"]
    assert [list(row.values()) for row in rows] == [
        ["T0O0W0D0H0", "SR1 in 1 of 10, SR2 in 1 of 10", "", "0/1 = 0 %"],
        ["T0O0W0D1H1", "SR1 in 10 of 10, SR2 in 10 of 10", "", "0/0 = n/a"],
    ]


def test_a_test_case_has_the_seeds_of_the_mutants_and_of_the_unmutated_drone() -> None:
    flights = [*pool("T0O0W0D0H0"), *(outcome("LATE-human@3s", seed=seed) for seed in (0, 1, 2, 5))]
    (row,) = to_json(dossier(flights))[HEADINGS[0]]["rows"]
    assert (row["seeds of the mutants"], row["seeds of the unmutated drone"]) == ("0-2, 5", "0-9")


def test_without_a_pool_there_are_no_verdicts() -> None:
    notes = to_json(dossier([outcome(), outcome("LATE-human@3s")]))[HEADINGS[2]]["notes"]
    assert notes[1].startswith("No verdicts: no situation in which a mutant changes a sample has 10 baseline flights")


def test_a_requirement_that_nothing_put_to_the_test_has_no_robustness() -> None:
    flown = outcome()
    idle = tuple(replace(r, rho=24.0, triggered=0) if r.requirement == "SR2" else r for r in flown.readings)
    rows = {row["requirement"]: row for row in to_json(dossier([replace(flown, readings=idle)]))[HEADINGS[2]]["rows"]}
    assert (rows["SR1"]["least robustness"], rows["SR2"]["least robustness"]) == ("0.300", "n/a")
