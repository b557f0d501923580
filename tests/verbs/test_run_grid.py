"""Runs over further grids and with numbers drawn from a range, from the choice to what the verbs read back."""

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
LIGHT = """
choose: first:2
adds:
  world:
    happenings:
      dust: {kind: dust, active: false, haze_per_m: 0.5}
axes:
  L:
    title: light
    category: environment, light level
    values:
      - {id: 0, title: bright}
      - {id: 1, title: dim, set: {light: 0.2}, realised: always(light <= 0.3)}
      - {id: 2, title: dusty, set: {happenings.dust.active: true}, realised: eventually(haze_per_m > 0.1)}
"""
WORDS = ("--mutant", "LATE-human", "--quiet", "--format", "json")


@pytest.fixture
def study(copy: Path) -> Path:
    (copy / "sim" / "grids" / "light.yaml").write_text(LIGHT)
    return copy


def flown(call: Call, study: Path, *words: str) -> set[str]:
    rows = json.loads(call("export", *words, study=study, campaign=not words).stdout)
    return {row["situation"] for row in rows}


def test_a_run_flies_what_the_grid_chooses_and_the_verbs_that_read_know_the_grid(call: Call, study: Path) -> None:
    done = call("run", "--grid", "light", *WORDS, study=study)
    assert done.exit_code == 0, done.stderr
    assert flown(call, study) == {"L0", "L1"}
    for verb in ("score", "coverage", "status", "kills", "worksheet", "dispositions"):
        told = call(verb, study=study)
        assert told.exit_code == 0, verb
    record = json.loads(call("score", "--format", "json", study=study).stdout)
    assert (record["coverage"]["situations"]["part"], record["coverage"]["situations"]["whole"]) == (2, 3)
    page = call("report", "--output", str(study.parent / "page.html"), study=study)
    assert page.exit_code == 0
    text = (study.parent / "page.html").read_text(encoding="utf-8")
    assert "dim" in text
    assert '"grid":"light"' in text.replace('": "', '":"')
    told = json.loads(call("export", "--format", "mutation-testing", study=study).stdout)
    assert list(told["testFiles"]) == ["sim/grids/light.yaml"]


def test_the_same_command_without_the_grid_goes_on_over_the_grid_of_the_campaign(call: Call, study: Path) -> None:
    call("run", "--grid", "light", *WORDS, study=study)
    assert call("run", *WORDS, "--situation", "L2", study=study).exit_code == 0
    assert flown(call, study) == {"L0", "L1", "L2"}


def test_a_choice_or_a_situation_of_the_user_goes_before_that_of_the_grid(call: Call, study: Path) -> None:
    call("run", "--grid", "light", *WORDS, "--choose", "all", study=study)
    assert flown(call, study) == {"L0", "L1", "L2"}


def test_a_further_grid_has_a_campaign_of_its_own_name(call: Call, study: Path) -> None:
    done = call("run", "--grid", "light", *WORDS, study=study, campaign=False)
    assert done.exit_code == 0, done.stderr
    assert (study / "results" / "campaigns" / "light" / "outcomes.sqlite").is_file()
    assert flown(call, study, "--campaign", "light") == {"L0", "L1"}
    assert call("run", "--grid", "paper", *WORDS, study=study, campaign=False).exit_code == 0
    assert (study / "results" / "campaigns" / "paper" / "outcomes.sqlite").is_file()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--grid", "ligt"), "--grid='ligt' must be the name of a grid of the study; did you mean 'light'?"),
        (("--grid", "paper"), "--grid=paper: campaign"),
        (("--grid", ""), "--grid='' must be the name of a grid of the study; allowed: 'light', 'paper'"),
        (("--situation", "L9"), "no situation 'L9' in keys like 'L0'"),
    ],
)
def test_a_grid_or_situation_that_is_none_is_one_sentence(
    call: Call, study: Path, words: tuple[str, ...], told: str
) -> None:
    call("run", "--grid", "light", *WORDS, study=study)
    assert told in sentence(call("run", *WORDS, *words, study=study))


def test_a_campaign_whose_grid_the_study_lacks_is_one_sentence(call: Call, study: Path) -> None:
    call("run", "--grid", "light", *WORDS, study=study)
    (study / "sim" / "grids" / "light.yaml").rename(study / "sim" / "grids" / "lights.yaml")
    for verb in ("score", "coverage", "run"):
        told = sentence(call(verb, study=study))
        assert "was flown over grid 'light', which the study lacks; did you mean 'lights'?" in told


def test_a_margin_flies_what_the_grid_chooses(call: Call, study: Path) -> None:
    done = call("margin", "LATE-human", "--grid", "light", "--quiet", study=study)
    assert done.exit_code == 0, done.stderr
    assert flown(call, study) == {"L0", "L1"}
    told = sentence(call("margin", "LATE-human", "--when", "--grid", "nope", study=study))
    assert "--grid='nope' must be the name of a grid of the study" in told


def test_baselines_of_another_grid_are_refused(call: Call, study: Path) -> None:
    call("run", "--grid", "light", *WORDS, study=study)
    words = ("--mutant", "LATE-human", "--quiet", "--situation", "T0O0W0D0H1")
    other = ["--baseline-from", str(study.parent / "campaign")]
    told = sentence(call("run", *words, *other, study=study, campaign=False))
    assert "was flown over grid 'light', not over grid 'paper'" in told


def test_a_disposition_may_name_situations_of_any_grid(call: Call, study: Path) -> None:
    path = study / "hazop" / "dispositions.yaml"
    accepted = "NO-human:\n  status: accepted\n  owner: me\n  reason: because\n  expires: 2099-01-31\n"
    path.write_text(f"{accepted}  situations: [T0O0W0D0H0, L1]\n")
    call("run", "--grid", "light", *WORDS, study=study)
    assert call("worksheet", study=study).exit_code == 0
    path.write_text(f"{accepted}  situations: [L7]\n")
    assert "no situation 'L7'" in sentence(call("worksheet", study=study))


LATE = ("--mutant", "LATE-human", "--quiet")


@pytest.fixture
def ranged(copy: Path) -> Path:
    return with_range(copy, first=True)


def rows_of(call: Call, study: Path) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = json.loads(call("export", study=study).stdout)
    return rows


def test_drawn_situations_come_back_from_the_store_by_their_keys(call: Call, ranged: Path, tmp_path: Path) -> None:
    chosen = (*LATE, "--situation", "C?T0O0*D0H1", "--choose", "sobol:6", "--format", "json")
    done = call("run", *chosen, study=ranged)
    assert done.exit_code == 0
    record = json.loads(done.stdout)
    rows = rows_of(call, ranged)
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
    assert len(rows_of(call, ranged)) == len(rows)  # nothing is flown twice
    kills = json.loads(call("kills", "--format", "json", study=ranged).stdout)
    late = [result for result in kills["results"] if result["mutant"] == "LATE-human@3s"]
    assert {result["situation"] for result in late if result["flown"]} == set(keys)
    for verb in ("status", "coverage", "worksheet", "dispositions"):
        assert call(verb, study=ranged).exit_code == 0
    for style in ("csv", "sace", "junit"):
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
    done = call("run", *LATE, "--situation", key, "--baseline-seeds", "2", study=ranged)
    assert f"--situation {key}" in " ".join(done.stdout.split())
    whole = call("run", *LATE, "--situation", key, "--format", "json", study=ranged)
    assert json.loads(whole.stdout)["pooled"] is True


def test_a_flight_is_stale_when_the_range_no_longer_holds_its_number(call: Call, ranged: Path) -> None:
    call("run", *LATE, "--situation", "C0=0.45T0O0W0D0H1", "--baseline-seeds", "1", study=ranged)
    path = ranged / "sim" / "situations.yaml"
    path.write_text(path.read_text(encoding="utf-8").replace("from: 0.4", "from: 0.48"), encoding="utf-8")
    told = call("status", study=ranged)
    assert "the situation is not in the grid any more" in " ".join(told.stdout.split())


def test_a_number_of_another_bin_writes_nothing(call: Call, ranged: Path, tmp_path: Path) -> None:
    refused = call("run", *LATE, "--situation", "C1=0.871T0O0W0D0H1", study=ranged)
    assert "must have 'C2=0.871', the bin of that number" in sentence(refused)
    assert not (tmp_path / "campaign").exists()


def test_shards_of_a_drawn_choice_merge_into_the_whole(call: Call, ranged: Path, tmp_path: Path) -> None:
    words = (*LATE, "--situation", "C?T0O0*D0H1", "--choose", "random:3", "--baseline-seeds", "1")
    parts = [str(tmp_path / part) for part in ("one", "two")]
    for number, part in enumerate(parts, start=1):
        done = call("run", *words, "--shard", f"{number}/2", "--campaign", part, study=ranged, campaign=False)
        assert done.exit_code == 0
    assert call("merge", *parts, study=ranged).exit_code == 0
    merged = rows_of(call, ranged)
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
