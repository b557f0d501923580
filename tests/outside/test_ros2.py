"""The border over ROS 2; with `--release` in processes with the wheels of ROS 2, and without these it says so."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from options import cases
from processes import ROOT, python_with_ros2
from studies import OVER_ROS2, example

from scaloft_fi.errors import InputError
from scaloft_fi.outside.border import Motion, Topic
from scaloft_fi.outside.ros2 import DOMAINS, Ros2Border, take_domain
from scaloft_fi.study import Study

KEY = "T0O0W0D0H1"
LOOPBACK, MULTICAST = "0100007F", "0100FFEF"
LIMIT_S = 1200.0


@pytest.fixture(scope="session")
def python(tmp_path_factory: pytest.TempPathFactory) -> str:
    found, reason = python_with_ros2(tmp_path_factory.mktemp("ros2") / "venv")
    if not found:
        pytest.skip(reason)
    return found


@pytest.fixture(scope="session")
def told(python: str) -> dict[str, Any]:
    script = ROOT / "tests" / "support" / "ros2_border.py"
    done = subprocess.run([python, script], capture_output=True, text=True, timeout=LIMIT_S, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.release
def test_two_borders_are_in_two_domains_and_do_not_hear_each_other(told: dict[str, Any]):
    first, second = told["domains"]
    assert first != second
    assert {first, second} <= set(DOMAINS)
    assert told["alone"] == told["second"]
    assert told["alone"].startswith("nobody subscribes to /odom, /depth, /persons, /charge; nobody publishes /cmd")
    assert told["lacking"] == ""


@pytest.mark.release
def test_a_border_listens_on_loopback_only(told: dict[str, Any]):
    assert LOOPBACK in told["addresses"]
    assert set(told["addresses"]) <= {LOOPBACK, MULTICAST}


@pytest.mark.release
def test_samples_go_out_as_the_usual_messages_with_their_own_stamps(told: dict[str, Any]):
    assert told["stamp"] == [1, 250_000_000]
    assert told["position"] == [1.0, 2.0]
    assert told["ahead_mps"] == 1.0  # it flies along y, and looks along y
    assert told["frames"] == ["map", "base_link", "camera_depth_optical_frame"]
    assert told["depth"] == [None, 1.5, 2.5, 3.5]
    assert dict(zip(told["columns"], told["person"], strict=True)) == {"x": 4.0, "y": 0.0, "z": 0.0, "score": 0.75}
    assert told["mapped"] == 0.5


@pytest.mark.release
def test_an_order_answers_its_tick_and_one_that_came_before_the_clock_does_not(told: dict[str, Any]):
    assert told["order"] == {"came": True, "speed": 0.5, "count": 1, "refused": ""}
    assert told["late"]["came"] is False
    assert told["late"]["speed"] == pytest.approx(0.6)


@pytest.mark.release
def test_nonsense_is_refused_with_a_sentence_and_a_flood_is_bounded(told: dict[str, Any]):
    assert told["nan"]["came"] is False
    assert told["nan"]["refused"] == "/cmd: data.velocity[0]=nan must be finite"
    assert "its stamp, 9 s, is later than the clock" in told["future"]["refused"]
    assert told["flood"]["speed"] == pytest.approx(0.7)
    assert told["flood"]["count"] <= 110


def test_domains_are_held_until_they_are_given_back():
    first, second = take_domain(), take_domain()
    assert first.number != second.number
    first.close()
    again = take_domain()
    assert again.number == first.number
    again.close()
    second.close()


@cases("topic", "sentence")
def test_settings_that_ros_2_cannot_carry_are_refused_without_ros_2(topic: dict[str, Any], sentence: str):
    assert Ros2Border.misfit(Topic("drive", "/cmd", Motion, outward=False, **topic)).startswith(sentence)
    assert bool(Ros2Border.misfit(Topic("drive", "/cmd", Motion, outward=False, **topic))) == bool(sentence)


def test_without_rclpy_a_sentence_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"border=ros2 needs rclpy: source your ROS 2 environment, or pip install"):
        Ros2Border.need()


FLIGHTS = (("baseline", KEY), ("LATE-human", KEY), ("baseline", "T0O0W0D0H0"))
FLY = """
import json, sys
import scaloft_fi
study = scaloft_fi.open(sys.argv[1])
flights = [study.fly(mutant, situation) for mutant, situation in json.loads(sys.argv[2])]
print(json.dumps([[flight.mutant, flight.situation, flight.ending, [*flight.violated]] for flight in flights]))
"""


@pytest.mark.release
@pytest.mark.flight
def test_the_example_over_ros_2_agrees_with_the_same_planner_over_lines(python: str, tmp_path: Path):
    facts = {}
    for border, interpreter in (("ros2", python), ("lines", sys.executable)):
        study = tmp_path / border
        example("outside_planner", study, *(OVER_ROS2 if border == "ros2" else ()))
        flown = subprocess.run(
            [interpreter, "-c", FLY, study, json.dumps(FLIGHTS)],
            cwd=ROOT, capture_output=True, text=True, timeout=LIMIT_S, check=False,
        )  # fmt: skip
        assert flown.returncode == 0, flown.stdout + flown.stderr
        facts[border] = json.loads(flown.stdout)
    assert facts["ros2"] == facts["lines"]
    assert ["LATE-human@3s", KEY, "landed", ["SR2"]] in facts["ros2"]
    assert ["baseline", KEY, "landed", []] in facts["ros2"]
    assert Study.open(tmp_path / "ros2").stack.deterministic is False


@pytest.mark.release
@pytest.mark.flight
def test_a_shell_script_over_the_example_shows_a_late_person(python: str, tmp_path: Path):
    study, own = tmp_path / "study", ROOT / "examples" / "own_tests"
    example("outside_planner", study, *OVER_ROS2)
    for name in ("shell.yaml", "person.sh"):
        shutil.copy(own / name, study / name)
    words = ("shell.yaml", "--mutant", "LATE-human", "--jobs", "2", "--quiet", "--format", "json")
    done = subprocess.run(
        [python, "-m", "scaloft_fi", "suite", *words],
        cwd=study, capture_output=True, text=True, timeout=LIMIT_S, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    (test,) = json.loads(done.stdout)["tests"]
    assert (test["state"], test["shows"]) == ("steady", ["LATE-human@3s"])
