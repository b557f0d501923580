from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.outside.border import BORDERS
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "outside_planner" / "study"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copytree(EXAMPLE, tmp_path / "study")
    for name in ("world", "vehicle", "sensors", "situations"):
        shutil.copy(ROOT / "sim" / f"{name}.yaml", tmp_path / "study" / "sim")
    return tmp_path / "study"


def test_seams_and_beliefs_follow_from_the_settings(folder: Path) -> None:
    stack = Study.open(folder).stack
    assert [seam.name for seam in stack.seams] == [
        "pose", "camera", "depth", "person", "drive", "land", "imu", "fix", "thrust",
    ]  # fmt: skip
    assert stack.by_name["person"].edge == "our drone -> /persons"
    assert stack.by_name["drive"].edge == "/cmd_vel -> our drone"
    assert stack.by_name["drive"].unit("velocity") == "m/s"
    assert stack.canaries == ("drive", "pose")
    assert (stack.deterministic, stack.forks) == (True, False)
    assert "est_x_m" in stack.belief_names


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("border: lines", "border: line", "border='line' is not known; did you mean 'lines'?"),
        ("carries: odometry", "carries: odometer", "carries='odometer' is not known; did you mean 'odometry'?"),
        ("carries: velocity", "carries: goal", "carries='goal' must be taken by flight_control"),
        ("carries: land", "carries: velocity", "'velocity' is carried by drive and land; one is allowed"),
        ("answer: drive ", "version: x ", "needs `answer`, the seam that answers each tick, or `pace`, such as 1.0"),
        ("  pose: {topic", "  imu: {topic", "stack.seams.imu: is the name of a seam of our drone"),
    ],
)  # fmt: skip
def test_settings_that_do_not_fit_are_refused_with_their_place(folder: Path, old: str, new: str, sentence: str) -> None:
    path = folder / "sim" / "stack.yaml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError) as refused:
        _ = Study.open(folder).stack
    assert sentence in str(refused.value)
    assert str(refused.value).startswith(f"{path}:")


def test_a_border_of_a_package_that_is_not_installed_is_told_with_the_command_that_installs_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(BORDERS._entries, "ros1", raising=False)  # tests of the package add it
    path = folder / "sim" / "stack.yaml"
    path.write_text(path.read_text().replace("border: lines", "border: ros1"))
    with pytest.raises(InputError, match=r"border='ros1' is of a package .*: pip install \./examples/ros1") as refused:
        _ = Study.open(folder).stack
    assert str(refused.value).startswith(f"{path}:")


def test_settings_of_the_part_below_are_checked_before_a_flight(folder: Path) -> None:
    path = folder / "sim" / "stack.yaml"
    path.write_text(path.read_text().replace("mass_kg: 1.5", "mass_kg: -1.5"))
    with pytest.raises(InputError, match=r"mass_kg=-1.5 must be >= 1e-06"):
        Study.open(folder).check()


def test_another_program_in_the_study_means_other_flights(folder: Path) -> None:
    (folder / "sim" / "planner.py").write_text("a = 1\n")
    before = Study.open(folder).inputs
    (folder / "sim" / "planner.py").write_text("a = 2\n")
    after = Study.open(folder).inputs
    assert before["sim"] != after["sim"]
    assert before["code"] == after["code"]
