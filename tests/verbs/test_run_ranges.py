"""Campaigns with numbers drawn from a range, from the choice to what is read back from the store."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from ranges import with_range
from refusal import sentence

Call = Callable[..., Result]
WORDS = ("--mutant", "LATE-human", "--quiet")


@pytest.fixture
def ranged(copy: Path) -> Path:
    return with_range(copy, first=True)


def flown(call: Call, study: Path) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = json.loads(call("export", study=study).stdout)
    return rows


def test_drawn_situations_come_back_from_the_store_by_their_keys(call: Call, ranged: Path, tmp_path: Path) -> None:
    chosen = (*WORDS, "--situation", "C?T0O0*D0H1", "--choose", "sobol:6", "--format", "json")
    done = call("run", *chosen, study=ranged)
    assert done.exit_code == 0
    record = json.loads(done.stdout)
    rows = flown(call, ranged)
    keys = list(dict.fromkeys(str(row["situation"]) for row in rows if row["mutant"] == "LATE-human@3s"))
    assert len(keys) == 6
    assert all("=" in key for key in keys)
    parts = [re.fullmatch(r"C(\d)=([0-9.]+)(.*)", key) for key in keys]
    assert parts == sorted(parts, key=lambda part: (part[1], part[3], float(part[2])))
    bins = {(part[1], part[3]) for part in parts}
    assert record["coverage"]["situations"]["part"] == len(bins)
    again = call("score", "--format", "json", study=ranged)
    assert json.loads(again.stdout)["ratios"] == record["ratios"]
    more = call("run", *chosen, study=ranged)
    assert json.loads(more.stdout)["ratios"] == record["ratios"]
    assert len(flown(call, ranged)) == len(rows)  # nothing is flown twice
    kills = json.loads(call("kills", "--format", "json", study=ranged).stdout)
    late = [result for result in kills["results"] if result["mutant"] == "LATE-human@3s"]
    assert {result["situation"] for result in late if result["flown"]} == set(keys)
    for verb in ("status", "coverage", "worksheet", "dispositions"):
        assert call(verb, study=ranged).exit_code == 0
    for style in ("csv", "gsn", "sace", "junit", "sarif", "mutation-testing", "markdown"):
        told = call("export", "--format", style, study=ranged)
        assert told.exit_code == 0, style
    page = tmp_path / "page.html"
    assert call("report", "--output", str(page), study=ranged).exit_code == 0
    assert keys[0] in page.read_text(encoding="utf-8")
    log = json.loads((tmp_path / "campaign" / "mission_log.json").read_text(encoding="utf-8"))
    drawn = {entry["situation"]: entry["parameters"]["C"] for entry in log["generated_situations"]}
    assert all(key.startswith(f"C{key[1]}={number:g}T") for key, number in drawn.items())
    assert log["coverage"]["distinct_situations"]["part"] == len(bins)


def test_the_command_that_decides_names_the_drawn_situations(call: Call, ranged: Path) -> None:
    key = "C2=0.871T0O0W0D0H1"
    done = call("run", *WORDS, "--situation", key, "--baseline-seeds", "2", study=ranged)
    assert f"--situation {key}" in " ".join(done.stdout.split())
    whole = call("run", *WORDS, "--situation", key, "--format", "json", study=ranged)
    assert json.loads(whole.stdout)["pooled"] is True


def test_a_flight_is_stale_when_the_range_no_longer_holds_its_number(call: Call, ranged: Path) -> None:
    call("run", *WORDS, "--situation", "C0=0.45T0O0W0D0H1", "--baseline-seeds", "1", study=ranged)
    path = ranged / "sim" / "situations.yaml"
    path.write_text(path.read_text(encoding="utf-8").replace("from: 0.4", "from: 0.48"), encoding="utf-8")
    told = call("status", study=ranged)
    assert "the situation is not in the grid any more" in " ".join(told.stdout.split())


def test_a_formula_is_held_to_its_caps_at_both_ends_of_the_range(call: Call, ranged: Path) -> None:
    path = ranged / "sim" / "situations.yaml"
    text = path.read_text(encoding="utf-8").replace("speed_mps >= 0.8 * number", "clearance_m < number - 0.15")
    path.write_text(text, encoding="utf-8")
    refused = sentence(call("run", *WORDS, study=ranged))
    assert "realised of C3 compares clearance_m with 1.05 m" in refused  # the middle of the bin: 0.95 m
    assert "situations.yaml:" in refused


def test_a_number_of_another_bin_writes_nothing(call: Call, ranged: Path, tmp_path: Path) -> None:
    refused = call("run", *WORDS, "--situation", "C1=0.871T0O0W0D0H1", study=ranged)
    assert "must have 'C2=0.871', the bin of that number" in sentence(refused)
    assert not (tmp_path / "campaign").exists()


def test_shards_of_a_drawn_choice_merge_into_the_whole(call: Call, ranged: Path, tmp_path: Path) -> None:
    words = (*WORDS, "--situation", "C?T0O0*D0H1", "--choose", "random:3", "--baseline-seeds", "1")
    parts = [str(tmp_path / part) for part in ("one", "two")]
    for number, part in enumerate(parts, start=1):
        done = call("run", *words, "--shard", f"{number}/2", "--campaign", part, study=ranged, campaign=False)
        assert done.exit_code == 0
    assert call("merge", *parts, study=ranged).exit_code == 0
    merged = flown(call, ranged)
    call("run", *words, "--campaign", str(tmp_path / "whole"), study=ranged, campaign=False)
    whole = json.loads(call("export", "--campaign", str(tmp_path / "whole"), study=ranged, campaign=False).stdout)
    control = "REVERSE-velcmd"  # the situation of the one flight of a control may differ
    for rows in (merged, whole):
        rows[:] = [row for row in rows if row["mutant"] != control]
    assert merged == whole
    assert len({row["situation"] for row in merged}) == 3


def test_margins_and_dispositions_take_drawn_situations(call: Call, ranged: Path) -> None:
    key = "C2=0.871T0O0W0D0H1"
    done = call("margin", "LATE-human", "--situation", key, "--quiet", study=ranged)
    assert done.exit_code == 0
    assert key in done.stdout
    path = ranged / "hazop" / "dispositions.yaml"
    entry = "LATE-human: {status: accepted, owner: A. Nyone, reason: harmless, expires: 2999-01-01, situations: [%s]}"
    path.write_text(entry % key, encoding="utf-8")
    assert key in call("dispositions", study=ranged).stdout
    path.write_text(entry % key.replace("C2", "C1"), encoding="utf-8")
    assert "no situation 'C1=0.871T0O0W0D0H1'" in sentence(call("dispositions", study=ranged))
