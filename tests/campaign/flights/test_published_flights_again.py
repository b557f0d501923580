"""A fixed choice of the published flights, flown again: with the kernels of the published flights, bit for bit."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import ModuleType

import pytest
from options import usually
from processes import ROOT, printed

pytest.importorskip("pyarrow.parquet")

NUMBER = 180
FLOWN = {"paper": usually(6, release=NUMBER), "wide": 24}
"""How many flights of each grid are flown again."""
FLAGS = "flags : fpu avx2 avx512f avx512cd avx512bw avx512dq avx512vl"


@pytest.fixture
def reflown(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    monkeypatch.setenv("OPENBLAS_CORETYPE", "")
    monkeypatch.syspath_prepend(ROOT)
    import experiments.reflown as reflown

    return reflown


@pytest.fixture
def published_kernels(reflown: ModuleType) -> ModuleType:
    return sys.modules["experiments.published_kernels"]


def test_the_sample_has_every_mutant_and_control_placebo_and_every_situation(reflown: ModuleType):
    rows = reflown.published()
    some = reflown.sample(rows, NUMBER)
    names = [reflown.name_of(row) for row in some]
    assert len(set(names)) == NUMBER
    assert {row["mutant"] for row in some} == {row["mutant"] for row in rows}
    assert {row["situation"] for row in some} == {row["situation"] for row in rows}
    assert names == [reflown.name_of(row) for row in reflown.sample(rows, len(rows))][:NUMBER]


def test_most_flights_of_the_sample_differ_from_their_baseline(reflown: ModuleType):
    digests = {row["digest"] for row in reflown.sample(reflown.published(), NUMBER)}
    assert len(digests) > 0.8 * NUMBER


def test_shards_have_every_flight_once_and_mutants_with_their_baseline(reflown: ModuleType):
    rows = reflown.published()
    shards = [reflown.shard(rows, number, 3) for number in (1, 2, 3)]
    assert sorted(reflown.name_of(row) for own in shards for row in own) == sorted(map(reflown.name_of, rows))
    for own in shards:
        assert {(row["situation"], row["seed"]) for row in own} == {
            (row["situation"], row["seed"]) for row in own if row["mutant"] == "baseline"
        }


def test_each_column_that_differs_is_told_by_flight(reflown: ModuleType):
    row = {"mutant": "NO-human", "situation": "T0", "seed": 1, "status": "masked", "digest": "a"}
    again = {"NO-human/T0/1": row | {"digest": "b"}}
    assert list(reflown.differences([row], {"NO-human/T0/1": row}, ["status", "digest"])) == []
    assert list(reflown.differences([row], again, ["status"])) == []
    assert list(reflown.differences([row], again, ["status", "digest"])) == [
        "NO-human/T0/1: digest 'a' published, 'b' flown again"
    ]
    assert list(reflown.differences([row], {}, ["status"])) == ["NO-human/T0/1: not flown"]


@pytest.mark.parametrize(("flags", "asked"), [(FLAGS, "SKYLAKEX"), ("flags : fpu avx2 avx512f", ""), ("", "")])
def test_kernels_are_asked_for_only_where_they_can_run(
    published_kernels: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, flags: str, asked: str
):
    monkeypatch.setenv("OPENBLAS_CORETYPE", "")
    cpuinfo = tmp_path / "cpuinfo"
    cpuinfo.write_text(f"processor : 0\n{flags}\n")
    assert published_kernels.choose(cpuinfo) == bool(asked)
    assert os.environ["OPENBLAS_CORETYPE"] == asked


@pytest.mark.flight
@pytest.mark.parametrize("grid", ["paper", pytest.param("wide", marks=pytest.mark.release)])
def test_published_flights_flown_again_are_the_published_ones(grid: str):
    number = FLOWN[grid]
    told = printed("-m", "experiments.reflown", "--grid", grid, "--sample", str(number), "--jobs", "1")
    assert told.endswith(f"{number} flights flown again, 0 differ\n")
