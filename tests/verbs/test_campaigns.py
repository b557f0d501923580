"""Verbs over whole campaigns: `status`, shards and `merge`."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from pathlib import Path

from printed import STUDY, Call, told_by

from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.platforms import claim
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.study import Study
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


def test_first_screen_kills_and_status_say_the_same_next_step(call: Call, tmp_path: Path):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    with snapshot(Study.open(STUDY), f"{tmp_path}/campaign") as now:
        step = now.next_step
    for words in (("score",), ("score", "--all"), ("kills",), ("status",)):
        said = " ".join(call(*words).stdout.replace("\\\n", "\n").split())
        assert f"What next {step}" in said or f"What next: {step}" in said


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
