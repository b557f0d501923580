"""An archive's columns hold an outcome whole, and a file that somebody crafted is refused in one sentence."""

from __future__ import annotations

import io
from array import array
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pyarrow
import pyarrow.parquet
import pytest
from builders import AXES, GRID, KINDS, ROSTER, campaigns, outcome
from hypothesis import given

from scaloft_fi.campaign.store.archive import Trajectories, read_outcomes
from scaloft_fi.campaign.store.record import MOST_FLIGHTS
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, track_values
from scaloft_fi.judge.requirement import measured_rho
from scaloft_fi.verbs.export.archive import outcome_file, track_file

PATH = Path("archive/outcomes.parquet")
STUDY: Any = SimpleNamespace(
    roster=ROSTER, space=GRID, requirements=[SimpleNamespace(name=name, kind=kind) for name, kind in KINDS.items()]
)
Change = Callable[[pyarrow.Table], pyarrow.Table]


def read(content: bytes) -> list[Outcome]:
    return list(read_outcomes(PATH, content, tuple(KINDS.items()), AXES))


def flown(one: Outcome) -> Outcome:
    """The outcome as a flight has it: an invalid one has no readings, and only measured robustness is kept."""
    if one.invalid:
        return replace(one, readings=(), violations=(), realised=())
    order = list(KINDS)
    return replace(
        one,
        readings=tuple(replace(r, rho=r.rho if measured_rho(r) is not None else 0.0) for r in one.readings),
        violations=tuple(sorted(one.violations, key=lambda violation: order.index(violation.requirement))),
    )


@given(campaigns())
def test_every_outcome_comes_back_as_it_was(outcomes: list[Outcome]) -> None:
    once = {one.name: flown(one) for one in outcomes}
    assert {one.name: one for one in read(outcome_file(tuple(once.values()), STUDY))} == once


def test_what_export_leaves_out_comes_back_too() -> None:
    one = outcome("LATE-human@3s", violated={"SR1": 5.0, "SR2": 4.0}, struck="wall")
    one = replace(
        one,
        stack_error="ZeroDivisionError",
        perceived_digest="seen",
        readings=tuple(replace(reading, triggered=3) for reading in one.readings),
        violations=tuple(replace(v, x=v.t_s, y=-v.t_s, z=0.5) for v in one.violations),
    )
    assert read(outcome_file([one], STUDY)) == [flown(one)]


def changed(change: Change) -> bytes:
    table = pyarrow.parquet.read_table(io.BytesIO(outcome_file([outcome(), outcome(seed=1)], STUDY)))
    file = io.BytesIO()
    pyarrow.parquet.write_table(change(table), file)
    return file.getvalue()


def put(name: str, values: list[Any], kind: Any = None) -> Change:
    def change(table: pyarrow.Table) -> pyarrow.Table:
        column = pyarrow.array(values, kind or table.schema.field(name).type)
        return table.set_column(table.column_names.index(name), name, column)

    return change


NAN = float("nan")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda table: table.drop_columns(["episodes"]), "column 'episodes' must be list<int64>"),
        (put("seed", ["0", "1"], pyarrow.string()), "column 'seed' must be int64, and is string"),
        (put("seed", [0, 2**40]), "column seed must be a whole number from 0 to"),
        (put("seed", [0, None]), "column seed must be a whole number"),
        (put("mutant", ["baseline", "a\nb"]), "column mutant must be a text of at most"),
        (put("digest", ["", None]), "column digest must be a text"),
        (put("duration_s", [1.0, NAN]), "column duration_s must be a finite number"),
        (put("rho_SR1", [None, float("inf")]), "column rho_SR1 must be a finite number or NULL"),
        (put("held", [[], None]), "column held must be a list"),
        (put("violated", [[], ["SR9"]]), "must be as long as violated"),
        (put("episodes", [[], []]), "column episodes must be as long as triggered"),
    ],
)
def test_what_no_store_holds_is_refused(change: Change, said: str) -> None:
    with pytest.raises(InputError) as refused:
        read(changed(change))
    assert str(refused.value).startswith(f"{PATH}: ")
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_requirement_that_the_archive_does_not_name_is_refused() -> None:
    names = {"violated": ["SR9"], "violation_times_s": [1.0], "violation_bodies": [""]}
    places = {f"violation_{axis}": [0.0] for axis in "xyz"}

    def change(table: pyarrow.Table) -> pyarrow.Table:
        for name, values in (names | places).items():
            table = put(name, [[], values])(table)
        return table

    with pytest.raises(InputError, match="column violated must be names of SR1, SR2"):
        read(changed(change))


@pytest.mark.parametrize("content", [b"", b"PAR1", b"PAR1" + bytes(100) + b"PAR1", changed(lambda table: table)[:-9]])
def test_a_damaged_file_is_refused(content: bytes) -> None:
    with pytest.raises(InputError, match="holds no flights of an archive") as refused:
        read(content)
    assert "\n" not in str(refused.value)


def test_a_file_that_grows_in_memory_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(MOST_FLIGHTS, "2")
    assert len(read(changed(lambda table: table))) == 2
    bomb = changed(put("stack_error", ["x" * 200_000] * 2))  # one value in the file, two in memory
    assert len(bomb) < 20_000
    with pytest.raises(InputError, match="more rows than the limit for 2 flights"):
        read(bomb)
    monkeypatch.setenv(MOST_FLIGHTS, "1")
    with pytest.raises(InputError, match="SCALOFT_MOST_FLIGHTS raises the limit"):
        read(changed(put("seed", [4, 5])))


def test_without_pyarrow_the_remedy_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    content = changed(put("seed", [6, 7]))
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(InputError, match=r"needs pyarrow: pip install 'scaloft-fi\[parquet\]'"):
        read(content)


WIDTH = len(TRACK_COLUMNS)


def test_a_trajectory_comes_back_by_the_digest_of_its_flight() -> None:
    tracks = {"a": array("f", map(float, range(2 * WIDTH))), "b": array("f", [0.5] * WIDTH), "c": array("f")}
    kept = Trajectories(PATH, track_file(tracks))
    assert {digest: track_values(kept.of(digest)) for digest in tracks} == tracks
    assert kept.of("d") == b""
    assert Trajectories(PATH, track_file({})).of("a") == b""


def test_trajectories_of_unequal_columns_are_refused() -> None:
    table = pyarrow.parquet.read_table(io.BytesIO(track_file({"a": array("f", [0.5] * WIDTH)})))
    file = io.BytesIO()
    pyarrow.parquet.write_table(put("x_m", [[1.0, 2.0]])(table), file)
    with pytest.raises(InputError, match="of equal length"):
        Trajectories(PATH, file.getvalue())
