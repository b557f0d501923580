from __future__ import annotations

import json

from builders import outcome
from dossiers import dossier, dossiers
from hypothesis import given

from scaloft_fi.results.exchange.dossier import Dossier
from scaloft_fi.results.exchange.sace import EDGES, to_json, to_markdown

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


def test_a_requirement_is_listed_with_what_it_was_a_test_of() -> None:
    flights = [outcome(), outcome("LATE-human@3s", violated={"SR2": 7.0})]
    rows = {row["requirement"]: row for row in to_json(dossier(flights))[HEADINGS[2]]["rows"]}
    killed = "mutants killed by it, of those it was a test of"
    assert (rows["SR2"][killed], rows["SR1"][killed]) == ("1/1 = 100 %", "0/1 = 0 %")
    assert "SR2-literal" not in rows
