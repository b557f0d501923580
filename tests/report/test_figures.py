"""Every figure of the page equals what a script of one's own makes of `export`."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from itertools import combinations, pairwise
from typing import Any

import pytest
from counting import counts_of, exported
from papers import track
from reading import embedded, unpacked

from scaloft_fi.report.evidence import Evidence
from scaloft_fi.report.figures import figures
from scaloft_fi.report.page import page

DEFAULTS = {"LATE-human@3s", "MORE-goal@0.6m", "NO-depth@3s", "LESS-goal@0.05m"}
CONTROLS = {"REVERSE-velcmd"}


@pytest.fixture(scope="module")
def told(text: str) -> dict[str, Any]:
    found: dict[str, Any] = embedded(text, "figures")
    return found


@pytest.fixture(scope="module")
def rows(evidence: Evidence) -> list[dict[str, Any]]:
    return exported(evidence)


def test_results_and_kill_rates_are_those_of_the_export(told: dict[str, Any], rows: list[dict[str, Any]]) -> None:
    counted = counts_of(rows)
    keys = [situation["key"] for situation in told["situations"]]
    assert {mutant["id"] for mutant in told["mutants"]} == set(counted)
    for mutant in told["mutants"]:
        counts = counted[mutant["id"]]
        assert [result[1:4] for result in mutant["results"]] == [counts[key] for key in keys]
        assert mutant["kill_rate"]["part"] == sum(k > 0 for k, _, _ in counts.values())
        assert mutant["kill_rate"]["whole"] == sum(e > 0 for _, e, _ in counts.values())
        assert mutant["kill_rate_flown"]["whole"] == sum(f > 0 for _, _, f in counts.values())
        assert (mutant["counts"], mutant["control"]) == (mutant["id"] in DEFAULTS, mutant["id"] in CONTROLS)


def test_the_ratios_are_those_of_the_export(told: dict[str, Any], rows: list[dict[str, Any]]) -> None:
    counted = {mutant: counts for mutant, counts in counts_of(rows).items() if mutant in DEFAULTS}
    infected = {row["mutant"] for row in rows if row["infected_at_s"] is not None}
    killed = sum(any(k for k, _, _ in counts.values()) for counts in counted.values())
    eligible = sum(any(e for _, e, _ in counts.values()) for counts in counted.values())
    ratios = {ratio["name"]: (ratio["part"], ratio["whole"]) for ratio in told["ratios"]}
    credible = sum(cell["status"] == "credible" for cell in told["cells"])
    assert ratios["exercised"] == (len(counted), credible)
    assert ratios["infected"] == (len(infected & DEFAULTS), len(counted))
    assert ratios["mutation_score"] == (killed, eligible)
    assert ratios["strict_score"] == (killed, len(counted))
    assert ratios["decided_score"] == (0, 0)  # one seed decides nothing
    assert all(ratio["population"] and (ratio["interval"] is None) == (not ratio["whole"]) for ratio in told["ratios"])


def test_the_line_below_the_matrix_counts_default_mutants(told: dict[str, Any], rows: list[dict[str, Any]]) -> None:
    counted = counts_of(rows)
    for situation, counts in zip(told["situations"], told["by_situation"], strict=True):
        here = [counted[mutant][situation["key"]] for mutant in DEFAULTS]
        assert (counts["killed"], counts["eligible"]) == (
            sum(k > 0 for k, _, _ in here),
            sum(e > 0 for _, e, _ in here),
        )


def test_baseline_findings_and_coverage_are_those_of_the_export(
    told: dict[str, Any], rows: list[dict[str, Any]]
) -> None:
    red: dict[str, int] = defaultdict(int)
    for row in rows:
        red[row["situation"]] += row["mutant"] == "baseline" and row["status"] == "violated"
    assert {finding["situation"]: finding["red"] for finding in told["baseline"]} == red
    assert told["gates"]["green_situations"] == {"part": sum(count == 0 for count in red.values()), "whole": 32}
    assert told["gates"]["invalid_flights"] == sum(row["status"] == "invalid" for row in rows)
    assert told["coverage"]["situations"] == {"part": 32, "whole": 32}
    assert told["coverage"]["t_way"]["2"].items() >= {"part": 40, "whole": 40}.items()
    assert (told["flights"], told["seeds"]) == (len(rows), [0, 1])


def test_every_flight_tells_what_its_row_of_the_export_tells(
    text: str, told: dict[str, Any], rows: list[dict[str, Any]]
) -> None:
    quanta = [entry["quantum"] for entry in told["columns"]]
    flights = {
        (flight["mutant"], key, flight["seed"]): flight
        for key, pack in embedded(text, "flights").items()
        for flight in unpacked(pack, quanta)
    }
    names = [requirement["name"] for requirement in told["requirements"]]
    for row in rows:
        if row["mutant"] == "PLACEBO":
            continue
        flight = flights.pop((row["mutant"], row["situation"], row["seed"]))
        assert {key: flight[key] for key in ("status", "ending", "struck", "infected_at_s", "duration_s")} == {
            key: row[key] for key in ("status", "ending", "struck", "infected_at_s", "duration_s")
        }
        readings = dict(zip(names, flight["readings"], strict=True))
        assert [name for name, reading in readings.items() if reading and reading[2] == "violated"] == row["violated"]
        assert {f"rho_{name}": reading and reading[0] for name, reading in readings.items()}.items() <= row.items()
    assert not flights


def test_neighbouring_columns_differ_in_one_axis(told: dict[str, Any]) -> None:
    levels = [situation["levels"] for situation in told["situations"]]
    for one, next_ in pairwise(levels):
        assert sum(a != b for a, b in zip(one, next_, strict=True)) == 1


def test_the_smallest_suite_and_the_minimal_mutants_are_those_of_brute_force(
    told: dict[str, Any], rows: list[dict[str, Any]]
) -> None:
    kills = {
        mutant: {key for key, (killed, _, _) in counts.items() if killed}
        for mutant, counts in counts_of(rows).items()
        if mutant in DEFAULTS
    }
    kills = {mutant: keys for mutant, keys in kills.items() if keys}
    keys = [situation["key"] for situation in told["situations"]]
    least = next(
        size for size in range(4) for chosen in combinations(keys, size) if all(set(chosen) & k for k in kills.values())
    )
    assert len(told["suite"]["situations"]) == least
    minimal = {m for m, k in kills.items() if not any(other < k for other in kills.values())}
    assert {m for node in told["subsumption"]["nodes"] if node["minimal"] for m in node["mutants"]} == minimal


def test_a_ladder_has_a_rung_for_each_magnitude_flown(told: dict[str, Any]) -> None:
    (ladder,) = told["ladders"]
    assert ladder["cell"] == "LATE-human"
    assert [(rung["magnitude"], rung["default"]) for rung in ladder["rungs"]] == [("1s", False), ("3s", True)]


def test_the_gates_hold_over_flights_that_nothing_is_wrong_with(told: dict[str, Any]) -> None:
    assert told["gates"]["failed"] == ""


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"stack_error": "autopilot at 0.000 s: no bus"}, "raises without any fault: baseline/{} (autopilot at 0.000"),
        ({"ending": "timed_out", "track": track(1.0, 0.0, 0.0, climb_m=0.1)}, "never leaves the ground without any"),
    ],
)
def test_a_baseline_that_raises_or_stands_fails_the_gates_of_the_page(
    evidence: Evidence, change: dict[str, Any], said: str
) -> None:
    first = next(outcome for outcome in evidence.outcomes if outcome.mutant == "baseline")
    outcomes = tuple(replace(o, **change) if o is first else o for o in evidence.outcomes)
    failed = figures(replace(evidence, outcomes=outcomes))["gates"]["failed"]
    assert said.format(f"{first.situation}/{first.seed}") in failed
    assert first.name in failed


def test_gates_that_fail_are_told(evidence: Evidence) -> None:
    outcomes = tuple(replace(o, digest="other") if o.mutant == "PLACEBO" else o for o in evidence.outcomes)
    told = embedded(page(replace(evidence, outcomes=outcomes)), "figures")
    assert "PLACEBO differs" in told["gates"]["failed"]
