"""Kills and eligible flights counted from the rows of `export`, in code that shares nothing with `results/`."""

from __future__ import annotations

import json
from collections import defaultdict
from typing import Any

from scaloft_fi.report.evidence import Evidence
from scaloft_fi.results.telling.export import export_rows, to_json

Row = dict[str, Any]
SAFETY = {"SR1", "SR2"}


def exported(evidence: Evidence) -> list[Row]:
    """The rows of `export --format json`."""
    study = evidence.study
    found: list[Row] = json.loads(to_json(export_rows(evidence.outcomes, study.roster, study.space)))
    return found


def clean_of(rows: list[Row]) -> dict[tuple[str, int], Row]:
    """The baseline of each situation and seed."""
    return {(row["situation"], row["seed"]): row for row in rows if row["mutant"] == "baseline"}


def eligible(row: Row, clean: dict[tuple[str, int], Row]) -> bool:
    """Infected, and the baseline held a safety requirement to its end."""
    base = clean[row["situation"], row["seed"]]
    held = base["ending"] != "struck" and not set(base["violated"]) >= SAFETY
    return row["status"] != "invalid" and row["infected_at_s"] is not None and held


def counts_of(rows: list[Row]) -> dict[str, dict[str, list[int]]]:
    """By mutant and situation: killed, eligible and flown flights."""
    clean = clean_of(rows)
    found: dict[str, dict[str, list[int]]] = defaultdict(lambda: defaultdict(lambda: [0, 0, 0]))
    for row in rows:
        if row["mutant"] in ("baseline", "PLACEBO"):
            continue
        counts = found[row["mutant"]][row["situation"]]
        counts[0] += row["status"] == "killed" and eligible(row, clean)
        counts[1] += eligible(row, clean)
        counts[2] += row["status"] != "invalid"
    return found
