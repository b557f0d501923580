"""Runs over a further grid, from the choice of situations to the verbs that read the campaign."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
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
    assert "dim" in (study.parent / "page.html").read_text(encoding="utf-8")


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


def test_a_choice_of_the_grid_that_is_none_is_named_with_its_place(call: Call, study: Path) -> None:
    path = study / "sim" / "grids" / "light.yaml"
    path.write_text(LIGHT.replace("first:2", "frist:2"))
    told = sentence(call("run", "--grid", "light", *WORDS, study=study))
    assert told.startswith(f"error: {path}:2: choose='frist:2' must be ")


def test_the_page_of_a_campaign_knows_its_grid_for_the_commands(call: Call, study: Path) -> None:
    call("run", "--grid", "light", *WORDS, "--baseline-seeds", "1", study=study)
    page = study.parent / "page.html"
    assert call("report", "--output", str(page), study=study).exit_code == 0
    assert '"grid":"light"' in page.read_text(encoding="utf-8").replace('": "', '":"')


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


def test_a_format_of_another_tool_names_the_file_of_the_grid(call: Call, study: Path) -> None:
    call("run", "--grid", "light", *WORDS, study=study)
    told = json.loads(call("export", "--format", "mutation-testing", study=study).stdout)
    assert list(told["testFiles"]) == ["sim/grids/light.yaml"]
