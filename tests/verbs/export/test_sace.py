from __future__ import annotations

import json
from dataclasses import replace

from builders import outcome, pool
from dossiers import dossier, dossiers
from effort import usually
from hypothesis import given, settings

from scaloft_fi.verbs.export.assurance import EDGES, to_json, to_markdown
from scaloft_fi.verbs.export.dossier import Dossier

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


@settings(deadline=None, max_examples=usually(25, release=50))
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
