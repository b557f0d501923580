"""The published reference flights as outcomes, read from their export."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from builders import KINDS, subject_of

from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Reading

ROOT = Path(__file__).parents[2]
PUBLISHED = ROOT / "results" / "published" / "reference"
Row = dict[str, object]


@cache
def rows() -> list[dict[str, object]]:
    parquet = pytest.importorskip("pyarrow.parquet")
    return list(parquet.read_table(PUBLISHED / "outcomes.parquet").to_pylist())


def outcome(row: Row) -> Outcome:
    """A flight from its row of the export; robustness and places do not enter the score."""
    named: list[str] = row["violated"]  # type: ignore[assignment]
    at = dict(zip(named, zip(row["violation_times_s"], row["violation_bodies"], strict=True), strict=True))  # type: ignore[call-overload]
    readings = tuple(
        Reading(
            name,
            kind,
            0.0,
            at[name][0] if name in at else None,
            int(name in row["triggered"]),  # type: ignore[operator]
            open=name not in at and name not in row["held"],  # type: ignore[operator]
        )
        for name, kind in KINDS.items()
    )
    return Outcome(
        subject=subject_of(str(row["mutant"])),
        situation=str(row["situation"]),
        seed=row["seed"],  # type: ignore[arg-type]
        ending=str(row["ending"]),
        readings=readings,
        violations=tuple(Violation(n, KINDS[n], t_s, 0.0, 0.0, 0.0, body) for n, (t_s, body) in at.items()),
        carried=row["carried"],  # type: ignore[arg-type]
        altered=row["altered"],  # type: ignore[arg-type]
        duration_s=row["duration_s"],  # type: ignore[arg-type]
        digest=str(row["digest"]),
    )


@cache
def outcomes() -> list[Outcome]:
    return [outcome(row) for row in rows()]
