"""Campaigns flown in parts and joined."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from scaloft_fi.campaign.plan.plan import Plan, plan
from scaloft_fi.campaign.progress.progress import Silence
from scaloft_fi.campaign.runs.merge import merge
from scaloft_fi.campaign.runs.options import RunOptions
from scaloft_fi.campaign.runs.run import run
from scaloft_fi.campaign.store.folder import LOG_NAME, STORE_NAME
from scaloft_fi.campaign.store.held import held_in
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import GateError, InputError
from scaloft_fi.mutants.derive import realise
from scaloft_fi.views.flights.export import export_rows, to_json

CONTROL, LATE = "REVERSE-velcmd", "LATE-human@3s"


def _plan(study: Any) -> Plan:
    return plan(study.grid, (0, 1), [realise(study.matrix, LATE)], realise(study.matrix, CONTROL))


def _run(study: Any, log: Any, planned: Plan, name: str, *, shard: bool = False) -> Path:
    folder: Path = study.folder / name
    run(study, planned, folder, RunOptions(part=shard), progress=Silence(stream=io.StringIO()), flyer=log)
    return folder


def _export(study: Any, folder: Path) -> str:
    with Store(folder / STORE_NAME, create=False) as store:
        return to_json(export_rows(held_in(study, store, folder).current, study.roster, study.space))


@pytest.mark.parametrize("shards", [2, 3, 8])
def test_shards_merged_in_any_order_are_the_undivided_run(study: Any, log: Any, shards: int) -> None:
    whole = _run(study, log, _plan(study), "whole")
    parts = [_run(study, log, _plan(study).shard(k + 1, shards), f"part{k}", shard=True) for k in range(shards)]
    merged = merge(study, study.folder / "merged", parts[::-1])
    assert _export(study, study.folder / "merged") == _export(study, whole)
    assert (study.folder / "merged" / LOG_NAME).read_text() == (whole / LOG_NAME).read_text()
    assert merged.added == 3 * 8 + 1


def test_the_shards_of_a_plan_are_the_plan(study: Any) -> None:
    planned = _plan(study)
    shards = [planned.shard(k, 3) for k in (1, 2, 3)]
    assert sorted(f.name for shard in shards for f in shard.mutants) == sorted(f.name for f in planned.mutants)
    assert sorted(f.name for shard in shards for f in shard.baselines) == sorted(f.name for f in planned.baselines)


def test_the_undivided_command_flies_nothing_after_the_merge(study: Any, log: Any) -> None:
    parts = [_run(study, log, _plan(study).shard(k, 2), f"part{k}", shard=True) for k in (1, 2)]
    merge(study, study.folder / "merged", parts)
    flown = len(log.flown)
    _run(study, log, _plan(study), "merged")
    assert len(log.flown) == flown


def test_merging_twice_adds_nothing(study: Any, log: Any) -> None:
    whole = _run(study, log, _plan(study), "whole")
    merge(study, study.folder / "merged", [whole])
    again = merge(study, study.folder / "merged", [whole])
    assert (again.added, again.known, again.warnings) == (0, 25, ())


def test_a_flight_that_came_out_in_two_ways_stops_the_merge(study: Any, log: Any) -> None:
    first = _run(study, log, _plan(study), "first")
    log.change = lambda _flight, outcome: replace(outcome, digest=f"other {outcome.digest}")
    second = _run(study, log, _plan(study), "second")
    before = _export(study, first)
    with pytest.raises(GateError, match=r"/\d in .*second is not the flight in .*first: digest other"):
        merge(study, first, [second])
    assert _export(study, first) == before


def test_on_another_platform_other_bits_are_said_and_the_first_stays(study: Any, log: Any) -> None:
    first = _run(study, log, _plan(study), "first")
    log.change = lambda _flight, outcome: replace(outcome, digest=f"other {outcome.digest}")
    second = _run(study, log, _plan(study), "second")
    with Store(second / STORE_NAME) as store:
        store._connection.execute("UPDATE meta SET value = 'PDP-11' WHERE name = 'machine'")
    before = _export(study, first)
    merged = merge(study, first, [second])
    assert "another platform: machine" in merged.warnings[0]
    assert _export(study, first) == before


def test_a_source_without_a_campaign_stops_the_merge_before_anything_is_made(study: Any) -> None:
    with pytest.raises(InputError, match="no campaign was flown here"):
        merge(study, study.folder / "merged", [study.folder / "nothing"])
    assert not (study.folder / "merged").exists()


def test_what_was_planned_and_not_flown_is_owed(study: Any, log: Any) -> None:
    folder = _run(study, log, _plan(study), "c")
    with Store(folder / STORE_NAME) as store:
        assert held_in(study, store, folder).owed == 0
        store._connection.execute("DELETE FROM outcomes WHERE mutant = ?", (LATE,))
        assert held_in(study, store, folder).owed == 8
