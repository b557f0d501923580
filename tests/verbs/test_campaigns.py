"""Verbs over whole campaigns: `status`, shards, `merge` and `diff`."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from builders import GRID, ROSTER, campaigns, outcome
from hypothesis import given
from printed import STUDY, Call, told_by

from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.platforms import claim
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import Facts
from scaloft_fi.study import Study
from scaloft_fi.verbs.campaigns import Comparison, Difference, compare, comparison_table
from scaloft_fi.verbs.snapshot import snapshot

WORDS = ("--mutant", "LATE-human", "--situation", "T0O0W0D?H?", "--quiet")


def _shards(call: Call, folder: Path) -> list[str]:
    names = [f"{folder}/{k}" for k in (1, 2)]
    for k, name in enumerate(names, 1):
        told_by(call("run", *WORDS, "--shard", f"{k}/2", "--campaign", name, campaign=False))
    return names


def test_two_shards_merged_export_the_bytes_of_the_undivided_run(call: Call, tmp_path: Path):
    call("run", *WORDS)
    names = _shards(call, tmp_path)
    merged = call("merge", *names, "--campaign", f"{tmp_path}/both", campaign=False)
    assert merged.stdout == f"31 flights added to {tmp_path}/both, 0 known already\n"
    both = call("export", "--campaign", f"{tmp_path}/both", campaign=False)
    assert both.stdout == call("export").stdout


def test_diff_prints_what_only_one_of_two_campaigns_has(call: Call, tmp_path: Path):
    first, second = _shards(call, tmp_path)
    result = told_by(call("diff", first, second, campaign=False))
    assert "0 flights are the same bit for bit" in result.replace("\n", " ")
    assert "0 differ" in call("diff", first, first, campaign=False).stdout.replace("\n", " ")


M = "LATE-human@3s"


def _compare(first: list[Outcome], second: list[Outcome]) -> Comparison:
    return compare(("old", "new"), first, second, ROSTER, GRID)


def test_another_status_is_a_difference():
    compared = _compare([outcome(), outcome(M, violated={"SR2": 5.0})], [outcome(), outcome(M)])
    assert compared.same == 1
    first, second = Facts("revealed", "landed", ("SR2",)), Facts("survived", "landed", ())
    assert compared.differences == (Difference(M, "T0O0W0D0H0", 0, first, second),)


def test_another_ending_is_a_difference():
    (difference,) = _compare([outcome()], [replace(outcome(), ending="struck")]).differences
    assert (str(difference.first), str(difference.second)) == ("held, landed", "held, struck")


def test_other_bits_with_the_same_status_are_only_counted():
    compared = _compare([outcome(), outcome(M, digest="a")], [outcome(), outcome(M, digest="b")])
    assert (compared.same, compared.other_bits, compared.differences) == (1, 1, ())


def test_a_flight_that_one_of_them_lacks_is_a_difference():
    (difference,) = _compare([outcome(), outcome(M)], [outcome()]).differences
    assert (difference.mutant, difference.second) == (M, None)


def test_the_table_names_both_campaigns():
    compared = _compare([outcome(), outcome(M, violated={"SR2": 5.0})], [outcome(), outcome(M)])
    table = comparison_table(compared)
    assert table.headers[3:] == ("old", "new")
    assert table.rows == ((M, "T0O0W0D0H0", 0, "revealed SR2, landed", "survived, landed"),)
    assert "1 flights are the same bit for bit" in table.notes[0]


@given(campaigns())
def test_a_campaign_does_not_differ_from_itself(outcomes: list[Outcome]):
    once = list({outcome.name: outcome for outcome in outcomes}.values())
    assert _compare(once, once[::-1]) == Comparison("old", "new", len(once), 0, ())


def test_flights_whose_baseline_is_not_home_wait_for_it_and_are_not_called_invalid(call: Call, tmp_path: Path):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    with closing(sqlite3.connect(tmp_path / "campaign" / STORE_NAME)) as connection:
        connection.execute("DELETE FROM outcomes WHERE mutant = 'baseline' AND situation = 'T0O0W0D0H1'")
        connection.commit()
    statuses = json.loads(call("status", "--format", "json").stdout)["statuses"]
    counted = {row["status"]: row["flights"] for row in statuses if row["subject"] == "mutants"}
    rows = json.loads(call("export").stdout)
    assert counted["waiting"] == sum(row["situation"] == "T0O0W0D0H1" for row in rows) >= 2
    assert "invalid" not in counted
    assert "waiting for their baseline" in call("status").stdout


def test_every_verb_that_shows_a_campaign_of_two_platforms_says_so(call: Call, tmp_path: Path):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    with Store(tmp_path / "campaign" / STORE_NAME) as store:
        assert "platform" not in call("status").stdout
        flights = [flight.key for flight in store.flights() if (flight.situation, flight.seed) == ("T0O0W0D0H1", 0)]
        rows = list(store.rows(flights))
        claim(store, [("T0O0W0D0H1", 0)], {**store.meta(), "machine": "PDP-11"})
        store.put_all(rows)
        whole = len(list(store.flights())) - len(flights)  # without those that were set apart
    mixture = f"{whole - len(rows)} flights of one platform and {len(rows)} of another (machine PDP-11, not "
    said = " ".join(call("status").stdout.split())
    assert mixture in said
    assert f"stale, not counted {len(rows)} " in said
    assert mixture in " ".join(call("score").stderr.split())
    assert mixture in " ".join(call("export", "--format", "sace").stdout.split())
    with snapshot(Study.open(STUDY), f"{tmp_path}/campaign") as now:
        assert now.platform["other platforms"].startswith(mixture)
