"""Pairs, tests and violations counted from the rows of `export`, in code that shares nothing with `results/`."""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any

import recomputation

from scaloft_fi.verbs.export.dossier import export_rows, to_json
from scaloft_fi.verbs.report.analyses import Evidence

Row = dict[str, Any]
SAFETY = ("SR1", "SR2")
CLEAN = ("baseline", "PLACEBO")


def exported(evidence: Evidence) -> list[Row]:
    """The rows of `export --format json`."""
    study = evidence.study
    found: list[Row] = json.loads(to_json(export_rows(evidence.outcomes, study.roster, study.space)))
    return found


def states_of(rows: list[Row]) -> dict[tuple[str, str], str]:
    """The state of each pair of situation and requirement."""
    pool = [row | {"counts": row["status"] != "invalid"} for row in rows if row["mutant"] == "baseline"]
    found = recomputation.pairs(pool, {**dict.fromkeys(SAFETY, "safety"), "OP1": "operability"})
    return {(pair["situation"], pair["requirement"]): pair["state"] for pair in found}


@dataclass
class Count:
    """A mutant in a situation: flights that count, whether any is infected, flights that violate each requirement."""

    flown: int = 0
    infected: bool = False
    violated: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    statuses: set[str] = field(default_factory=set)
    tests: tuple[str, ...] = ()

    @property
    def most(self) -> list[str]:
        """The safety requirements that test the mutant here and that most flights violate."""
        return [name for name in self.tests if self.violated[name] > self.flown / 2]


def counts_of(rows: list[Row]) -> dict[str, dict[str, Count]]:
    """By mutant and situation."""
    states = states_of(rows)
    found: dict[str, dict[str, Count]] = defaultdict(lambda: defaultdict(Count))
    for row in rows:
        if row["mutant"] in CLEAN:
            continue
        count = found[row["mutant"]][row["situation"]]
        if row["status"] == "invalid":
            continue
        count.flown += 1
        count.infected |= row["infected_at_s"] is not None
        count.statuses.add(row["status"])
        for name in row["violated"]:
            count.violated[name] += 1
    for by_situation in found.values():
        for key, count in by_situation.items():
            count.tests = tuple(name for name in SAFETY if count.infected and states.get((key, name)) == "steady")
    return found
