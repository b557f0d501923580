"""`run` without physics: the whole one, a choice, a budget, looks, a pool of baselines, further grids, coverage."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest
from builders import with_range
from options import cases
from pages import embedded
from paper_flyer import Paper
from printed import STUDY, Call, sentence, told_by
from studies import GRIDS, edit_in

from scaloft_fi.campaign.store.held import remembered
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.hazop.matrix import CellStatus
from scaloft_fi.sim.load import Scenario, SimConfig
from scaloft_fi.study import Study


def test_a_run_prints_four_answers_and_its_mutant_and_the_rest_under_all(call: Call):
    result = call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?")
    assert result.exit_code == 0, result.output
    for name in ("Shown", "Not shown", "How sure", "What next", "Situations", "More"):
        assert f"\n{name}  " in f"\n{result.stdout}"
    assert "\nLATE-human@3s  undecided  " in result.stdout
    assert "Unmutated drone" not in result.stdout
    whole = call("score", "--all").stdout
    assert [told in whole for told in ("Unmutated drone  ", "Undecided: 1\n", "Where the faults stopped")] == [True] * 3
    assert "violations: 2 (mutants 2); all of them are in " in result.stderr
    assert "warning" not in result.stderr


def test_warnings_tell_each_violation_of_however_many_mutants(call: Call):
    for words in (("--mutant", "LATE-human"), ("--seeds", "1-1")):
        said = call("run", "--situation", "T0O0W0D0H1", "--warnings", *words).stderr.splitlines()
        (counted,) = (line for line in said if line.startswith("violations: "))
        warnings = [line for line in said if line.startswith("warning: ") and " violated at " in line]
        beyond = [line for line in said if "as the run did not ask for them" in line]
        assert len(beyond) == (words[0] == "--seeds"), "seed 0 of LATE-human is no part of the second run"
        assert any(line.startswith("warning: SR2 violated at 8.00 s") for line in warnings)
        assert counted.startswith(f"violations: {len(warnings)} (mutants {len(warnings)}); ")


def test_quiet_says_nothing_but_the_tables(call: Call):
    assert call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet").stderr == ""


def test_without_mutant_every_cells_default_and_every_control_flies(call: Call):
    assert call("run", "--situation", "T0O0W0D0H1", "--quiet").exit_code == 0
    flown = {row["mutant"] for row in json.loads(call("export").stdout)}
    matrix = Study.open(STUDY).matrix
    assert len(flown) == 2 + sum(cell.status is not CellStatus.NOT_MEANINGFUL for cell in matrix)


def test_the_same_command_in_any_number_of_jobs_exports_the_same_bytes(call: Call, tmp_path: Path):
    exports = []
    for name, jobs in (("one", "1"), ("two", "2"), ("two", "1")):
        words = ("--campaign", str(tmp_path / name / "c"))
        told_by(call("run", "--mutant", "LATE-human*", "--jobs", jobs, "--quiet", *words, campaign=False))
        exports.append(call("export", *words, campaign=False).stdout)
    assert exports[0] == exports[1] == exports[2]


def test_a_control_that_shows_nothing_is_a_gate_and_prints_no_score(call: Call, paper: Paper):
    paper.tame = True
    result = call("run", "--mutant", "LATE-human", "--quiet")
    assert (result.exit_code, result.stdout) == (4, "")
    assert "a control shows nothing" in result.stderr


def test_a_bare_campaign_name_is_a_folder_of_the_study(call: Call, copy: Path):
    words = ("--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet", "--campaign", "mine")
    assert call("run", *words, study=copy, campaign=False).exit_code == 0
    assert (copy / "results" / "campaigns" / "mine" / "outcomes.sqlite").is_file()


def test_an_edited_number_flies_again_and_an_edited_comment_does_not(call: Call, copy: Path):
    words = ("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0")
    assert "3 of 3 flights flown" in call(*words, study=copy).stderr
    edit_in(copy / "sim" / "world.yaml", "light: 0.9", "light: 0.9 # bright")
    assert "flown" not in call(*words, study=copy).stderr
    edit_in(copy / "sim" / "world.yaml", "light: 0.9", "light: 0.8")
    assert "3 of 3 flights flown" in call(*words, study=copy).stderr
    status = call("status", study=copy).stdout.splitlines()
    assert "sim/ changed  3" in [" ".join(line.split()).replace("changed ", "changed  ") for line in status]
    told = json.loads(call("status", "--format", "json", study=copy).stdout)
    assert told["reasons"] == [{"why": "sim/ changed", "flights": 3}]


def test_chosen_situations_are_flown_and_the_choice_is_kept(call: Call, tmp_path: Path):
    done = told_by(
        call("run", "--mutant", "LATE-human", "--choose", "2-way", "--choose-seed", "1", "--quiet", "--format", "json")
    )
    covered = json.loads(done)["coverage"]
    assert (covered["situations"]["part"], covered["draws"] - covered["pool"]) == (6, 6)
    assert covered["t_way"]["2"]["part"] == 40
    with Store(tmp_path / "campaign" / "outcomes.sqlite", create=False) as store:
        assert [(one.text, one.seed) for one in remembered(store)] == [("2-way", 1)]


def test_a_run_whose_time_is_up_names_what_it_left(call: Call, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("scaloft_fi.campaign.runs.run.Budget.left_s", 0.0)
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--budget", "1h", "--quiet")
    left = json.loads(told_by(call(*words, "--format", "json")))["unflown"]
    assert {"by": "parameter", "name": "human", "planned": 2, "flown": 0, "not_flown": 2} in left
    assert "6 of 6 planned flights were not flown" in call(*words).stdout
    assert "planned, not flown" in call("status").stdout


def test_the_declared_share_of_invalid_flights_is_an_option(call: Call, paper: Paper):
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    assert call(*words, "--max-invalid", "0").exit_code == 0
    assert call(*words, "--max-invalid", "2").exit_code == 2


def test_sequential_looks_fly_on_what_is_undecided_and_print_how_it_went(call: Call):
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    first, *_ = json.loads(told_by(call("run", *words, "--sequential", "--format", "json")))["looks"]
    assert (first["seeds"], first["mutants"], first["flights"]) == (1, 1, 2)
    assert "Looks" in call("run", *words, "--sequential").stdout


def test_a_pool_of_ten_is_flown_by_default_where_the_mutant_infects(call: Call):
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    found = json.loads(call("run", *words, "--format", "json").stdout)
    seeds = {key: set() for key in ("T0O0W0D0H0", "T0O0W0D0H1")}
    for row in json.loads(call("export").stdout):
        if row["mutant"] == "baseline":
            seeds[row["situation"]].add(row["seed"])
    assert seeds == {"T0O0W0D0H0": {0}, "T0O0W0D0H1": set(range(10))}
    assert found["pooled"]
    assert found["coverage"]["pool"] == 9


def test_without_a_pool_the_score_has_counts_and_the_command_that_decides(call: Call):
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    text = call("run", *words, "--baseline-seeds", "1").stdout
    assert "not known: there is no baseline pool. 1 of 1 fault violated a safety requirement" in " ".join(text.split())
    assert "`scaloft-fi run " in text
    assert json.loads(call("score", "--format", "json").stdout)["ratios"]["mutation_score"] == {"part": 0, "whole": 0}


def test_fail_under_without_a_pool_is_refused(call: Call, tmp_path: Path):
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet", "--baseline-seeds", "5")
    assert "--fail-under=0.5 needs a baseline pool of at least 10 seeds" in sentence(
        call(*words, "--fail-under", "0.5")
    )
    assert not (tmp_path / "campaign").exists()
    assert call(*words).exit_code == 0
    assert "--fail-under=0.5 needs a baseline pool: campaign" in sentence(call("score", "--fail-under", "0.5"))


def test_a_campaign_that_grows_spends_its_alpha_by_looks(call: Call):
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet", "--format", "json")
    (late,) = json.loads(call(*words, "--seeds", "3").stdout)["mutants"]
    assert (late["verdict"], late["decided_at"]["alpha"]) == ("detected", 0.01)
    (late,) = json.loads(call(*words, "--seeds", "5").stdout)["mutants"]
    assert (late["verdict"], late["decided_at"]["alpha"]) == ("detected", 0.0025)
    (late,) = json.loads(call("score", "--format", "json").stdout)["mutants"]
    assert (late["verdict"], late["decided_at"]["seeds"]) == ("detected", 5)


def test_another_campaigns_baselines_decide_and_are_only_read(call: Call, tmp_path: Path):
    where = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    lender = str(tmp_path / "lender" / "c")
    call("run", *where, "--baseline-seeds", "50", "--campaign", lender, campaign=False)
    before = call("export", "--campaign", lender, campaign=False).stdout
    lone = call("run", *where, "--seeds", "3", "--baseline-seeds", "3").stdout
    lent = call("run", *where, "--seeds", "3", "--baseline-from", lender).stdout
    assert "there is no baseline pool" in lone
    assert "1 of 1 fault by safety requirements" in lent
    assert "  detected  " in call("score", "--baseline-from", lender).stdout
    assert call("export", "--campaign", lender, campaign=False).stdout == before


def test_a_lender_that_does_not_fit_is_onesentence(call: Call, tmp_path: Path, copy: Path):
    lender = str(tmp_path / "lender" / "c")
    words = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H0", "--quiet", "--baseline-from", lender)
    assert "no campaign was flown here" in sentence(call(*words))
    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H1", "--quiet", "--campaign", lender, campaign=False)
    assert "has no baseline of T0O0W0D0H0" in sentence(call(*words))
    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet", "--campaign", lender, campaign=False)
    edit_in(copy / "sim" / "world.yaml", "light: 0.9", "light: 0.8")
    assert "baseline/T0O0W0D0H0/0 was flown with other data or code" in sentence(call(*words, study=copy))
    assert not (tmp_path / "campaign").exists()


def test_a_lender_from_another_platform_is_onesentence(call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    lender = str(tmp_path / "lender" / "c")
    where = ("--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet")
    call("run", *where, "--campaign", lender, campaign=False)
    monkeypatch.setattr("scaloft_fi.campaign.store.platforms.fingerprint", lambda: {"machine": "PDP-11"})
    assert "was flown on another platform" in sentence(call("run", *where, "--baseline-from", lender))


WORDS = ("--mutant", "LATE-human", "--quiet", "--format", "json")


@pytest.fixture
def study(copy: Path) -> Path:
    shutil.copy(GRIDS / "light.yaml", copy / "sim" / "grids")
    return copy


def flown(call: Call, study: Path, *words: str) -> set[str]:
    rows = json.loads(call("export", *words, study=study, campaign=not words).stdout)
    return {row["situation"] for row in rows}


def test_a_run_flies_what_the_grid_chooses_and_the_verbs_that_read_know_the_grid(call: Call, study: Path):
    told_by(call("run", "--grid", "light", *WORDS, study=study))
    assert flown(call, study) == {"L0", "L1"}
    for verb in ("score", "coverage", "status", "kills", "worksheet", "dispositions"):
        told_by(call(verb, study=study))
    record = json.loads(call("score", "--format", "json", study=study).stdout)
    assert (record["coverage"]["situations"]["part"], record["coverage"]["situations"]["whole"]) == (2, 3)
    page = call("report", "--output", str(study.parent / "page.html"), study=study)
    assert page.exit_code == 0
    figures = embedded((study.parent / "page.html").read_text(encoding="utf-8"), "figures")
    assert '"dim"' in (text := json.dumps(figures, separators=(",", ":")))
    assert '"grid":"light"' in text
    told = json.loads(call("export", "--format", "mutation-testing", study=study).stdout)
    assert list(told["testFiles"]) == ["sim/grids/light.yaml"]


def test_the_same_command_without_the_grid_goes_on_over_the_grid_of_the_campaign(call: Call, study: Path):
    call("run", "--grid", "light", *WORDS, study=study)
    assert call("run", *WORDS, "--situation", "L2", study=study).exit_code == 0
    assert flown(call, study) == {"L0", "L1", "L2"}


def test_a_choice_or_a_situation_of_the_user_goes_before_that_of_the_grid(call: Call, study: Path):
    call("run", "--grid", "light", *WORDS, "--choose", "all", study=study)
    assert flown(call, study) == {"L0", "L1", "L2"}


def test_a_further_grid_has_a_campaign_of_its_own_name(call: Call, study: Path):
    told_by(call("run", "--grid", "light", *WORDS, study=study, campaign=False))
    assert (study / "results" / "campaigns" / "light" / "outcomes.sqlite").is_file()
    assert flown(call, study, "--campaign", "light") == {"L0", "L1"}
    assert call("run", "--grid", "paper", *WORDS, study=study, campaign=False).exit_code == 0
    assert (study / "results" / "campaigns" / "paper" / "outcomes.sqlite").is_file()


@cases("words", "told")
def test_a_grid_or_situation_that_is_none_is_one_sentence(call: Call, study: Path, words: tuple[str, ...], told: str):
    call("run", "--grid", "light", *WORDS, study=study)
    assert told in sentence(call("run", *WORDS, *words, study=study))


def test_a_campaign_whose_grid_the_study_lacks_is_one_sentence(call: Call, study: Path):
    call("run", "--grid", "light", *WORDS, study=study)
    (study / "sim" / "grids" / "light.yaml").rename(study / "sim" / "grids" / "lights.yaml")
    for verb in ("score", "coverage", "run"):
        told = sentence(call(verb, study=study))
        assert "was flown over grid 'light', which the study lacks; did you mean 'lights'?" in told


def test_a_margin_flies_what_the_grid_chooses(call: Call, study: Path):
    told_by(call("margin", "LATE-human", "--grid", "light", "--quiet", study=study))
    assert flown(call, study) == {"L0", "L1"}
    told = sentence(call("margin", "LATE-human", "--when", "--grid", "nope", study=study))
    assert "--grid='nope' must be the name of a grid of the study" in told


def test_baselines_of_another_grid_are_refused(call: Call, study: Path):
    call("run", "--grid", "light", *WORDS, study=study)
    words = ("--mutant", "LATE-human", "--quiet", "--situation", "T0O0W0D0H1")
    other = ["--baseline-from", str(study.parent / "campaign")]
    told = sentence(call("run", *words, *other, study=study, campaign=False))
    assert "was flown over grid 'light', not over grid 'paper'" in told


def test_a_disposition_may_name_situations_of_any_grid(call: Call, study: Path):
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
    return json.loads(call("export", study=study).stdout)


def test_drawn_situations_come_back_from_the_store_by_their_keys(call: Call, ranged: Path, tmp_path: Path):
    chosen = (*LATE, "--situation", "C?T0O0*D0H1", "--choose", "sobol:6", "--format", "json")
    record = json.loads(told_by(call("run", *chosen, study=ranged)))
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
        told_by(call("export", "--format", style, study=ranged))
    page = tmp_path / "page.html"
    assert call("report", "--output", str(page), study=ranged).exit_code == 0
    assert keys[0] in page.read_text(encoding="utf-8")
    log = json.loads((tmp_path / "campaign" / "mission_log.json").read_text(encoding="utf-8"))
    drawn = {entry["situation"]: entry["parameters"]["C"] for entry in log["generated_situations"]}
    assert all(key.startswith(f"C{key[1]}={number:g}T") for key, number in drawn.items())
    assert log["coverage"]["distinct_situations"]["part"] == len(bins)


def test_the_command_that_decides_names_the_drawn_situations(call: Call, ranged: Path):
    key = "C2=0.871T0O0W0D0H1"
    done = call("run", *LATE, "--situation", key, "--baseline-seeds", "2", study=ranged)
    assert f"--situation {key}" in " ".join(done.stdout.split())
    whole = call("run", *LATE, "--situation", key, "--format", "json", study=ranged)
    assert json.loads(whole.stdout)["pooled"] is True


def test_a_flight_is_stale_when_the_range_no_longer_holds_its_number(call: Call, ranged: Path):
    call("run", *LATE, "--situation", "C0=0.45T0O0W0D0H1", "--baseline-seeds", "1", study=ranged)
    edit_in(ranged / "sim" / "situations.yaml", "from: 0.4", "from: 0.48")
    told = call("status", study=ranged)
    assert "the situation is not in the grid any more" in " ".join(told.stdout.split())


def test_a_number_of_another_bin_writes_nothing(call: Call, ranged: Path, tmp_path: Path):
    refused = call("run", *LATE, "--situation", "C1=0.871T0O0W0D0H1", study=ranged)
    assert "must have 'C2=0.871', the bin of that number" in sentence(refused)
    assert not (tmp_path / "campaign").exists()


def test_shards_of_a_drawn_choice_merge_into_the_whole(call: Call, ranged: Path, tmp_path: Path):
    words = (*LATE, "--situation", "C?T0O0*D0H1", "--choose", "random:3", "--baseline-seeds", "1")
    parts = [str(tmp_path / part) for part in ("one", "two")]
    for number, part in enumerate(parts, start=1):
        told_by(call("run", *words, "--shard", f"{number}/2", "--campaign", part, study=ranged, campaign=False))
    assert call("merge", *parts, study=ranged).exit_code == 0
    merged = rows_of(call, ranged)
    call("run", *words, "--campaign", str(tmp_path / "whole"), study=ranged, campaign=False)
    whole = json.loads(call("export", "--campaign", str(tmp_path / "whole"), study=ranged, campaign=False).stdout)
    control = "REVERSE-velcmd"  # the situation of the one flight of a control may differ
    for rows in (merged, whole):
        rows[:] = [row for row in rows if row["mutant"] != control]
    assert merged == whole
    assert len({row["situation"] for row in merged}) == 3


def test_margins_and_dispositions_take_drawn_situations(call: Call, ranged: Path):
    key = "C2=0.871T0O0W0D0H1"
    done = told_by(call("margin", "LATE-human", "--situation", key, "--quiet", study=ranged))
    assert key in done
    path = ranged / "hazop" / "dispositions.yaml"
    entry = "LATE-human: {status: accepted, owner: A. Nyone, reason: harmless, expires: 2999-01-01, situations: [%s]}"
    path.write_text(entry % key, encoding="utf-8")
    assert key in call("dispositions", study=ranged).stdout
    path.write_text(entry % key.replace("C2", "C1"), encoding="utf-8")
    assert "no situation 'C1=0.871T0O0W0D0H1'" in sentence(call("dispositions", study=ranged))


def chosen(call: Call, *words: str) -> None:
    assert call("run", "--mutant", "LATE-human", "--quiet", *words).exit_code == 0


def test_json_counts_what_was_chosen_and_flown(call: Call):
    chosen(call, "--choose", "draws:40")
    chosen(call, "--choose", "first:1", "--seeds", "9-9")
    said = json.loads(call("coverage", "--format", "json").stdout)
    draws, first = said["choices"]
    assert (draws["choose"], draws["pool"], len(draws["draws"])) == ("draws:40", 32, 40)
    assert (first["choose"], first["draws"]) == ("first:1", [{"situation": "T0O0W0D0H0", "seed": 9}])
    cases = {tuple(draw.values()) for draw in [*draws["draws"], *first["draws"]]}
    assert said["coverage"]["draws"] - said["coverage"]["pool"] == len(cases)
    assert said["coverage"]["situations"] == {"part": len({key for key, _ in cases}), "whole": 32}


def test_coverage_and_score_say_the_same(call: Call):
    chosen(call, "--choose", "random:7")
    scored = json.loads(call("score", "--format", "json").stdout)["coverage"]
    said = json.loads(call("coverage", "--format", "json").stdout)["coverage"]
    assert scored == said


@pytest.fixture
def large(copy: Path) -> Path:
    """Ten axes of three values: 59,049 situations, of which the constraint leaves 52,488."""
    axes = "".join(
        f"\n  A{letter}: {{title: axis {letter}, category: c, values: [{{id: 0, title: benign}}, "
        "{id: 1, title: one, realised: always(light <= 1)}, {id: 2, title: two, realised: always(light <= 1)}]}"
        for letter in "abcdefghij"
    )
    constraints = "\nconstraints:\n  - exclude: {Aa: 0, Ab: 2}\n    reason: they do not go together\n"
    (copy / "sim" / "situations.yaml").write_text(f"axes:{axes}\n{constraints}", encoding="utf-8")
    return copy


@pytest.mark.release
@pytest.mark.parametrize("how", ["2-way", "random:50"])
def test_a_large_grid_is_sampled_and_scored_without_making_every_world(
    call: Call, large: Path, monkeypatch: pytest.MonkeyPatch, how: str
):
    made: list[str] = []
    begin = SimConfig.scenario

    def scenario(self: SimConfig, situation) -> Scenario:
        made.append(situation.key)
        return begin(self, situation)

    monkeypatch.setattr(SimConfig, "scenario", scenario)
    assert len(Study.open(large).grid) == 52_488
    done = call("run", "--mutant", "LATE-human", "--choose", how, "--quiet", "--format", "json", study=large)
    covered = json.loads(done.stdout)["coverage"]
    assert len(set(made)) == covered["situations"]["part"]
    assert covered["situations"]["whole"] == 52_488
    # the pair that no situation has is none of the 405; of the 3-way combinations it takes 8 x 3
    assert (covered["t_way"]["2"]["whole"], covered["t_way"]["3"]["whole"]) == (404, 3240 - 24)
    if how == "2-way":
        assert covered["t_way"]["2"]["part"] == 404
        assert covered["situations"]["part"] <= 18
        assert covered["t_way"]["5"]["whole"] == 61_236 - 56 * 27


def test_a_situation_that_a_large_grid_lacks_is_refused_fast(call: Call, large: Path):
    refused = call("run", "--situation", "Aa0Ab2Ac0Ad0Ae0Af0Ag0Ah0Ai0Aj0", study=large)
    assert "is excluded by" in refused.stderr
    assert "they do not go together" in refused.stderr
