"""The lists of what a study has: nothing is missing, and every formula and example is true."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from printed import STUDY, run
from processes import ROOT, called, install_project
from studies import copied, example, own_simulator

from scaloft_fi.errors import InputError
from scaloft_fi.judge.requirement import bounds_of, check_caps, ranges_of, verdict
from scaloft_fi.judge.stl import Formula
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.sim.log import SIGNALS, TRUTH_NAMES
from scaloft_fi.study import Study
from scaloft_fi.verbs.listing import Listing, acted_on, operator_list, sample_text, seam_list
from scaloft_fi.verbs.signals import BOTH, EXAMPLES, REALISED, TO_ASK, signal_list
from scaloft_fi.verbs.situations import Change, Companion, axis_list


@pytest.fixture(scope="module")
def wide() -> Study:
    return Study.open(STUDY, "wide")


@pytest.fixture(scope="module")
def lists(study: Study) -> dict[str, Listing[Any]]:
    return {
        "signals": signal_list(study),
        "seams": seam_list(study),
        "operators": operator_list(study),
        "axes": axis_list(study.grid),
    }


def test_every_signal_that_a_formula_may_use_is_listed_and_no_other(wide: Study):
    by_use: dict[str, list[str]] = {BOTH: [], REALISED: [], TO_ASK: []}
    for record in signal_list(wide).entries:
        by_use[record.used_in].append(record.name)
    assert by_use[BOTH] == list(wide.signals)
    assert by_use[REALISED] == [name for name in wide.grid.passing_signals if name not in wide.signals]
    assert by_use[TO_ASK] == [name for name in SIGNALS if name not in wide.grid.world().signals]


def test_every_example_of_a_signal_is_a_formula_within_the_caps(wide: Study):
    names = {*wide.signals, *wide.grid.passing_signals, *SIGNALS}
    for record in signal_list(wide).entries:
        check_caps(record.example, wide.caps)
        formula = Formula.parse(record.example, names)
        assert record.name in formula.names, record
        assert verdict(bounds_of(formula, ranges_of(wide.grid.world(), wide.stack.beliefs, names))) is None, record


def test_every_signal_of_the_ground_truth_has_facts_and_a_unit_or_none():
    assert EXAMPLES.keys() >= set(TRUTH_NAMES) - {"clearance_wall_m"}


def test_what_a_consumer_acts_on_follows_from_the_declared_effect(study: Study):
    seams = study.stack.by_name
    assert acted_on(seams["goal"]) == ("reached",)
    assert acted_on(seams["clearing"]) == ("forget",)
    assert acted_on(seams["map"]) == ("points", "inflation")
    assert acted_on(seams["imu"]) == ("stamp_s", "rate", "force")
    assert acted_on(seams["proximity"]) == ("sectors", "watched", "bearings", "trigger_m", "touched")


def test_the_example_of_an_operator_is_what_its_tap_does(lists: dict[str, Listing[Any]]):
    told = {record.name: record.polls for record in lists["operators"].entries}
    assert told.keys() == OPERATORS.keys()
    for name, operator in OPERATORS.items():
        assert [poll.sent for poll in told[name]] == list(map(sample_text, operator.example.before))
        if not callable(operator.example.after):
            assert [poll.arrives for poll in told[name]] == list(map(sample_text, operator.example.after)), name


def test_an_operator_that_is_no_good_is_told_with_its_package_beside_all_others(
    study: Study, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(OPERATORS._entries, "delay", replace(OPERATORS["delay"], make=lambda *_, **__: 5))
    listing = operator_list(study)
    fault = "operator 'delay' must return a tap, and returns 5"
    assert {one.name: one.fault for one in listing.entries} == dict.fromkeys(OPERATORS, "") | {"delay": fault}
    assert listing.notes[-1] == f"Of the package {__name__.partition('.')[0]}: {fault}."
    assert ("fault", fault) in listing.by_name["delay"].sheet()


def test_a_free_axis_tells_its_range_distribution_and_with_what_it_goes():
    records = {record.name: record for record in axis_list(Study.open(STUDY, "search").grid).entries}
    light = records["Li"]
    assert (light.low, light.high, light.distribution) == (0.05, 1.0, "log-uniform")
    assert light.only_with == (Companion("D", ("0", "2")),)
    assert records["Du"].also == (Change("world.happenings.dust.active", True),)


def test_a_pattern_shows_what_it_fits_and_a_miss_names_the_nearest(lists: dict[str, Listing[Any]]):
    chosen = lists["signals"].chosen(["clearance_b*", "mode", "mode"])
    assert tuple(chosen.by_name) == ("clearance_bar_m", "mode")
    with pytest.raises(InputError, match="no seam 'presson'; did you mean 'person'"):
        lists["seams"].chosen(["presson"])
    with pytest.raises(InputError, match="no operator 'zz"):
        lists["operators"].chosen(["zz*"])


VERBS = ("signals", "seams", "operators", "axes")


def listed(capsys: pytest.CaptureFixture[str], verb: str, *words: str | Path) -> dict[str, Any]:
    code, told = run(verb, "--format", "json", *words), capsys.readouterr()
    assert code == 0, told.err
    return {record["name"]: record for record in json.loads(told.out)[verb]}


def test_a_study_whose_stack_sensor_and_operator_come_from_a_package(tmp_path: Path):
    install_project(tmp_path / "site", ROOT / "examples" / "own_stack")
    where = ("--study", str(ROOT / "examples" / "own_stack" / "study"))
    done = called(tmp_path / "site", *((verb, "--format", "json", *where) for verb in VERBS), cwd=tmp_path)
    told: dict[str, dict[str, Any]] = {}
    for verb, (code, printed) in zip(VERBS, done, strict=True):
        assert code == 0, printed
        told[verb] = {record["name"]: record for record in json.loads(printed)[verb]}
    assert told["operators"]["echo"]["package"] == "hopper"
    assert told["operators"]["echo"]["seams"] == ["range"]
    assert told["operators"]["delay"]["package"] == "scaloft-fi"
    assert [field["unit"] for field in told["seams"]["range"]["fields"]] == ["s", "m"]
    assert "belief of the stack hopper" in {record["origin"] for record in told["signals"].values()}


def test_a_study_whose_stages_run_outside(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    folder = tmp_path / "study"
    example("outside_planner", folder)
    seams = listed(capsys, "seams", "--study", folder)
    assert seams["drive"]["edge"] == "/cmd_vel -> our drone"
    assert seams["drive"]["canary"]
    assert "imu" in seams
    assert listed(capsys, "signals", "est_x_m", "--study", folder)["est_x_m"]["origin"] == "belief of the stack outside"
    assert "drive" in listed(capsys, "operators", "delay", "--study", folder)["delay"]["seams"]
    assert listed(capsys, "axes", "H", "--study", folder)["H"]["values"][1]["title"] == "human"


def test_a_study_that_a_command_flies_tells_where_the_record_has_each_signal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folder = tmp_path / "study"
    own_simulator(folder)
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
):
    copied(tmp_path)
    assert listed(capsys, "signals", "--study", tmp_path)["takeoff_charge"]["used_in"] == "neither yet"
    world = tmp_path / "sim" / "world.yaml"
    world.write_text(world.read_text() + "signals: [takeoff_charge]\n")
    assert listed(capsys, "signals", "--study", tmp_path)["takeoff_charge"]["used_in"] == "requirements, axes"
