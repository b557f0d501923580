from __future__ import annotations

from dataclasses import replace

from builders import CLASSED, outcome, pool
from dossiers import dossier

from scaloft_fi.verbs.export.ci import summary

HERE, RED = "T0O0W0D0H0", "T0O0W0D1H1"


def test_the_page_has_the_ratios_the_mutants_by_verdict_and_the_findings_about_the_unmutated_drone() -> None:
    flights = [*pool(HERE), *pool(RED, red=9, violated={"SR1": 20.0, "SR2": 20.0})]
    for seed in range(3):
        flights.append(outcome("LATE-human@3s", HERE, seed, violated={"SR2": 7.0}))
        flights.append(outcome("NO-human@100%", HERE, seed))
        flights.append(outcome("MORE-goal@0.6m", RED, seed))
    page = summary(dossier(flights))
    headings = [line for line in page.splitlines() if line.startswith("### ")]
    assert headings[1:] == [
        *("### 1 detected", "### 1 not detected", "### 1 not tested"),
        "### 1 situations where the unmutated drone violates a safety requirement",
    ]
    detected, not_detected, not_tested, findings = (page.split(heading)[1].split("###")[0] for heading in headings[1:])
    assert "| LATE-human@3s | killed in 1 of 1 situation" in " ".join(detected.split())
    assert "NO-human@100%" in not_detected
    assert "MORE-goal@0.6m" in not_tested
    assert f"| {RED} | SR1 | 9/10 | red |" in " ".join(findings.split())
    assert "| mutation score | 1/3 = 33 % |" in " ".join(page.split())
    assert "| firm | 0/3 = 0 % |" in " ".join(page.split())
    assert "0.02 at most would still be called shown" in page


def test_without_a_pool_no_percentage_is_told_but_what_was_seen_and_what_to_call() -> None:
    page = summary(dossier([outcome(), outcome("LATE-human@3s", violated={"SR2": 7.0})]))
    assert " %" not in page.split("###")[1]
    assert "No score: no situation in which a mutant changes a sample has 10 baseline flights" in page
    assert "1 of its 1 flights violate a safety requirement that the baseline beside them holds" in page
    assert "0 detected" not in page


def test_survivors_of_the_worst_class_stand_first_with_their_class() -> None:
    flights = [*pool(HERE), *(outcome(id_, HERE) for id_ in ("NO-human@100%", "LATE-human@3s", "MORE-goal@0.6m"))]
    page = summary(replace(dossier(flights), roster=CLASSED))
    rows = [line.split("|")[1:3] for line in page.splitlines() if "@" in line]
    assert [[cell.strip() for cell in row] for row in rows] == [
        ["MORE-goal@0.6m", "injury"],
        ["NO-human@100%", "delay"],
        ["LATE-human@3s", ""],
    ]
