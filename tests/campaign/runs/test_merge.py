"""Campaigns flown in parts and joined."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from running import LATE, Runs, asked

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.plan import Plan
from scaloft_fi.campaign.runs.merge import merge
from scaloft_fi.campaign.store.archive import LOG_NAME, STORE_NAME
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.campaign.store.platforms import Platforms
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import GateError, InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import facts_of


def _plan(study: Any) -> Plan:
    return asked(study, (0, 1))


def _run(fly: Runs, planned: Plan, name: str, *, shard: bool = False) -> Path:
    fly(planned, name, part=shard)
    return fly.folder(name)


def _export(fly: Runs, folder: Path) -> str:
    return fly.export(fly.current(folder.name))


@pytest.mark.parametrize("shards", [2, 3, 8])
def test_shards_merged_in_any_order_are_the_undivided_run(study: Any, fly: Runs, shards: int):
    whole = _run(fly, _plan(study), "whole")
    parts = [_run(fly, _plan(study).shard(k + 1, shards), f"part{k}", shard=True) for k in range(shards)]
    merged = merge(study, study.folder / "merged", parts[::-1])
    assert _export(fly, study.folder / "merged") == _export(fly, whole)
    assert (study.folder / "merged" / LOG_NAME).read_text() == (whole / LOG_NAME).read_text()
    assert merged.added == 3 * 8 + 1


def test_the_undivided_command_flies_nothing_after_the_merge(study: Any, log: Any, fly: Runs):
    parts = [_run(fly, _plan(study).shard(k, 2), f"part{k}", shard=True) for k in (1, 2)]
    merge(study, study.folder / "merged", parts)
    flown = len(log.flown)
    _run(fly, _plan(study), "merged")
    assert len(log.flown) == flown


def test_merging_twice_adds_nothing(study: Any, fly: Runs):
    whole = _run(fly, _plan(study), "whole")
    merge(study, study.folder / "merged", [whole])
    again = merge(study, study.folder / "merged", [whole])
    assert (again.added, again.known, again.warnings) == (0, 25, ())


def test_a_flight_that_came_out_in_two_ways_stops_the_merge(study: Any, log: Any, fly: Runs):
    first = _run(fly, _plan(study), "first")
    log.change = lambda _flight, outcome: replace(outcome, digest=f"other {outcome.digest}")
    second = _run(fly, _plan(study), "second")
    before = _export(fly, first)
    with pytest.raises(GateError, match=r"/\d in .*second is not the flight in .*first: digest other"):
        merge(study, first, [second])
    assert _export(fly, first) == before


def _elsewhere(folder: Path) -> Path:
    """The same campaign, flown on another platform."""
    with Store(folder / STORE_NAME) as store:
        store._connection.execute("UPDATE meta SET value = 'PDP-11' WHERE name = 'machine'")
    return folder


def _other_bits(_flight: Flight, outcome: Outcome) -> Outcome:
    return replace(outcome, digest=f"other {outcome.digest}")


def test_on_another_platform_other_bits_are_said_and_the_first_stays(study: Any, log: Any, fly: Runs):
    first = _run(fly, _plan(study), "first")
    log.change = _other_bits
    second = _elsewhere(_run(fly, _plan(study), "second"))
    before = _export(fly, first)
    merged = merge(study, first, [second])
    (warning,) = merged.warnings
    assert "another platform than " in warning
    assert "here, PDP-11 there)" in warning
    assert "of 25 flights in both 0 have equal digests, and 25 differ in bits only" in warning
    assert _export(fly, first) == before
    with pytest.raises(GateError, match=r"--same-platform allows equal digests only: other digests: .*; nothing was"):
        merge(study, first, [second], same_platform=True)


@pytest.mark.parametrize("strict", [False, True])
def test_equal_digests_on_another_platform_join(study: Any, fly: Runs, strict: bool):
    planned = _plan(study)
    first = _run(fly, planned.shard(1, 2), "first", shard=True)
    second = _elsewhere(_run(fly, planned, "second"))
    merged = merge(study, first, [second], same_platform=strict)
    assert "0 differ in bits only" in merged.warnings[0]
    assert merged.added > 0


def test_a_flight_with_other_facts_on_another_platform_is_named_and_stops_the_merge(study: Any, log: Any, fly: Runs):
    first = _run(fly, _plan(study), "first")
    log.change = lambda flight, outcome: replace(
        _other_bits(flight, outcome), ending="struck" if flight.name == f"{LATE}/D0H1/1" else outcome.ending
    )
    second = _elsewhere(_run(fly, _plan(study), "second"))
    before = _export(fly, first)
    with pytest.raises(GateError, match=rf"1 of the flights .*{LATE}/D0H1/1 \(revealed SR2, landed here, "):
        merge(study, first, [second])
    assert _export(fly, first) == before


def test_parts_of_two_platforms_join_and_every_mutant_keeps_a_baseline_of_its_own_platform(
    study: Any, log: Any, fly: Runs
):
    whole = _run(fly, _plan(study), "whole")
    first = _run(fly, _plan(study).shard(1, 2), "first", shard=True)
    log.change = _other_bits
    second = _elsewhere(_run(fly, _plan(study), "second"))
    third = _elsewhere(_run(fly, _plan(study).shard(2, 2), "third", shard=True))
    folder = study.folder / "merged"
    with pytest.raises(GateError, match="no flight in both to compare"):
        merge(study, folder, [first, third], same_platform=True)
    said = merge(study, folder, [first, third]).warnings
    assert any("no flight is in both, so nothing could be compared" in warning for warning in said)
    for parts in ([first, second], [first, third], [first, third, second]):
        folder = study.folder / f"merged {len(parts)} {parts[-1].name}"
        merge(study, folder, parts)
        with Store(folder / STORE_NAME, create=False) as store:
            current = current_in(study, store)
            mixture = Platforms(store).mixture(current)
        here = {(o.situation, o.seed, o.digest.startswith("other")) for o in current}
        assert len(here) == len({(situation, seed) for situation, seed, _ in here}) == 8
        assert len({other for _, _, other in here}) == 2
        assert "each mutant is judged beside a baseline of its own platform" in mixture
        alone = fly.current("whole")
        asked = {o.name for o in current} & {o.name for o in alone}
        assert len(asked) >= 24
        assert {n: f for n, f in facts_of(current).items() if n in asked} == {
            n: f for n, f in facts_of(alone).items() if n in asked
        }
    before = _export(fly, whole)
    merge(study, whole, [folder])  # what a source notes of its situations and seeds does not hold here
    assert _export(fly, whole) == before


def test_mutants_that_only_the_second_platform_flew_beside_a_baseline_of_the_first_are_left_out(
    study: Any, log: Any, fly: Runs
):
    first = _run(fly, asked(study, names=()), "first")
    log.change = _other_bits
    second = _elsewhere(_run(fly, asked(study, canary=""), "second"))
    merged = merge(study, first, [second])
    assert merged.added == 0
    assert any("4 flights of " in warning and "are left out, because" in warning for warning in merged.warnings)


def test_a_source_without_a_campaign_stops_the_merge_before_anything_is_made(study: Any):
    with pytest.raises(InputError, match="no campaign was flown here"):
        merge(study, study.folder / "merged", [study.folder / "nothing"])
    assert not (study.folder / "merged").exists()
