"""Published flights as outcomes, read from an export in Parquet: all that a score and its reasons need."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pyarrow.parquet

from scaloft_fi.judge.outcome import Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.mutants.derive import realise
from scaloft_fi.study import Study

Row = Mapping[str, Any]


def rows_of(path: Path) -> list[Row]:
    """The rows of an export."""
    return list(pyarrow.parquet.read_table(path).to_pylist())


def outcomes(study: Study, rows: Iterable[Row]) -> list[Outcome]:
    """The flights of the rows; places of violations and trajectories are not in them."""
    kinds = {requirement.name: requirement.kind for requirement in study.requirements}
    subjects: dict[str, Subject] = {}
    return [_outcome(row, kinds, _subject(study, str(row["mutant"]), subjects)) for row in rows]


def _subject(study: Study, mutant: str, known: dict[str, Subject]) -> Subject:
    if mutant not in known:
        plain = mutant in ("baseline", "PLACEBO")
        known[mutant] = Subject(mutant) if plain else Subject.of(realise(study.matrix, mutant))
    return known[mutant]


def _outcome(row: Row, kinds: Mapping[str, Kind], subject: Subject) -> Outcome:
    struck = dict(
        zip(row["violated"], zip(row["violation_times_s"], row["violation_bodies"], strict=True), strict=True)
    )
    readings = tuple(
        Reading(
            name,
            kind,
            row[f"rho_{name}"] or 0.0,  # none where the flight did not put the requirement to the test
            struck[name][0] if name in struck else None,
            int(name in row["triggered"]),
            open=name not in struck and name not in row["held"],
        )
        for name, kind in kinds.items()
    )
    return Outcome(
        subject=subject,
        situation=row["situation"],
        seed=row["seed"],
        ending=row["ending"],
        readings=readings,
        violations=tuple(
            Violation(name, kinds[name], t_s, 0.0, 0.0, 0.0, body) for name, (t_s, body) in struck.items()
        ),
        carried=row["carried"],
        altered=row["altered"],
        infected_at_s=row["infected_at_s"],
        duration_s=row["duration_s"],
        digest=row["digest"],
    )
