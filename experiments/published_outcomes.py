"""Published flights as outcomes, read from an export in Parquet or from an archive's: all that a score needs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pyarrow.parquet

from scaloft_fi.campaign.store.archive import Rows
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

Row = Mapping[str, Any]


def rows_of(path: Path) -> list[Row]:
    """The rows of a file."""
    return list(pyarrow.parquet.read_table(path).to_pylist())


def outcomes(study: Study, rows: Iterable[Row]) -> list[Outcome]:
    """The flights of the rows, without trajectories; an export has no places of violations either."""
    read = Rows({requirement.name: requirement.kind for requirement in study.requirements}, study.space.axes)
    return [read({**_lacking(row), **row}) for row in rows]


def _lacking(row: Row) -> Row:
    """What an export does not have of a flight that counts."""
    places = dict.fromkeys(("violation_x", "violation_y", "violation_z"), [0.0] * len(row["violated"]))
    texts = dict.fromkeys(("invalid", "ended_by", "stack_error", "perceived_digest"), "")
    return {**places, **texts, "episodes": [1] * len(row["triggered"])}
