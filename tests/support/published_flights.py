"""The published reference flights as outcomes, read from their export."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

import pytest

from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[2]
PUBLISHED = ROOT / "results" / "published" / "reference"
Row = dict[str, object]


@cache
def rows() -> list[dict[str, object]]:
    parquet = pytest.importorskip("pyarrow.parquet")
    return list(parquet.read_table(PUBLISHED / "outcomes.parquet").to_pylist())


@cache
def outcomes() -> list[Outcome]:
    sys.path.append(str(ROOT))
    from experiments.flights import outcomes

    return list(outcomes(Study.open(ROOT), rows()))
