"""`scaloft-fi signals`, `seams`, `operators`, `axes` on studies with plugins, stages outside and a command."""

from __future__ import annotations

import json
import shutil
import sys
from importlib import util
from pathlib import Path
from typing import Any

import pytest
from plugins import ROOT, call, install_project

from scaloft_fi.cli import main

VERBS = ("signals", "seams", "operators", "axes")


def listed(capsys: pytest.CaptureFixture[str], verb: str, *words: str | Path) -> dict[str, Any]:
    with pytest.raises(SystemExit) as left:
        main([verb, "--format", "json", *map(str, words)])
    told = capsys.readouterr()
    assert left.value.code == 0, told.err
    return {record["name"]: record for record in json.loads(told.out)[verb]}


def script(path: Path) -> Any:
    """A script of the examples as a module."""
    spec = util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module


def test_a_study_whose_stack_sensor_and_operator_come_from_a_package(tmp_path: Path) -> None:
    site = tmp_path / "site"
    install_project(site, ROOT / "examples" / "own_stack")
    study = ROOT / "examples" / "own_stack" / "study"
    told: dict[str, dict[str, Any]] = {}
    for verb in VERBS:
        done = call(site, "-m", "scaloft_fi", verb, "--format", "json", "--study", study, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        told[verb] = {record["name"]: record for record in json.loads(done.stdout)[verb]}
    assert told["operators"]["echo"]["package"] == "hopper"
    assert told["operators"]["echo"]["seams"] == ["range"]
    assert told["operators"]["delay"]["package"] == "scaloft-fi"
    assert [field["unit"] for field in told["seams"]["range"]["fields"]] == ["s", "m"]
    assert "belief of the stack hopper" in {record["origin"] for record in told["signals"].values()}


def test_a_study_whose_stages_run_outside(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "study"
    script(ROOT / "examples" / "outside_planner" / "make_study.py").make_study(folder, source=ROOT)
    seams = listed(capsys, "seams", "--study", folder)
    assert seams["drive"]["edge"] == "/cmd_vel -> our drone"
    assert seams["drive"]["canary"]
    assert "imu" in seams
    assert listed(capsys, "signals", "est_x_m", "--study", folder)["est_x_m"]["origin"] == "belief of the stack outside"
    assert "drive" in listed(capsys, "operators", "delay", "--study", folder)["delay"]["seams"]
    assert listed(capsys, "axes", "H", "--study", folder)["H"]["values"][1]["title"] == "human"


def test_a_study_that_a_command_flies_tells_where_the_record_has_each_signal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "study"
    script(ROOT / "examples" / "own_simulator" / "copy_study.py").copy_study(folder, ROOT)
    record = folder / "sim" / "record.yaml"
    record.write_text(record.read_text() + "  pitch_deg: {column: pitch}\n")
    signals = listed(capsys, "signals", "--study", folder)
    assert signals["x_m"]["recorded"] == "column east"
    assert signals["home_m"]["recorded"] == "follows from others"
    assert signals["vx_mps"]["recorded"] == "not in the record"
    assert (signals["pitch_deg"]["origin"], signals["pitch_deg"]["unit"]) == ("sim/record.yaml", "deg")
    assert listed(capsys, "seams", "--study", folder)["person"]["carried"].startswith("the command")
    assert listed(capsys, "axes", "--study", folder)


def test_an_optional_signal_that_the_world_lists_is_a_signal_like_any_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(ROOT / name, tmp_path / name)
    assert listed(capsys, "signals", "--study", tmp_path)["takeoff_charge"]["used_in"] == "neither yet"
    world = tmp_path / "sim" / "world.yaml"
    world.write_text(world.read_text() + "signals: [takeoff_charge]\n")
    assert listed(capsys, "signals", "--study", tmp_path)["takeoff_charge"]["used_in"] == "requirements, axes"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("signals", "persn_sight_m"), "no signal 'persn_sight_m'; did you mean 'person_sight_m'?"),
        (("axes", "X"), "no axis 'X'"),
        (("axes", "--grid", "wild"), "must be the name of a grid of the study; did you mean 'wide'?"),
    ],
)
def test_a_miss_is_one_sentence_and_exit_2(
    words: tuple[str, ...], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        main([*words, "--study", str(ROOT)])
    assert left.value.code == 2
    assert sentence in capsys.readouterr().err
