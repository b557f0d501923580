"""The testbed's topics over ROS 1, flown by a mission node of our own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from printed import invoked
from processes import ROOT, marked
from scaloft_ros1.border import unimportable
from studies import mission_study

from scaloft_fi.campaign.flights.fly import judged, wire_of
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.sim.flight import fly
from scaloft_fi.study import Study

EXAMPLE = ROOT / "examples" / "testbed"
LACKING = unimportable(("rospy", "rosmaster", "rosgraph_msgs", "nav_msgs", "gazebo_msgs", "darknet_ros_msgs"))
needs_ros = pytest.mark.skipif(
    bool(LACKING), reason=f"the Python of ROS 1 lacks {', '.join(LACKING)}: run examples/testbed/setup.sh"
)
SHORT = (
    ("route: [corner, end, corner, home]", "route: [corner, home]"),
    ("corner: [0.0, 7.0]", "corner: [0.0, 2.0]"),
    ("start: {near: [-3.0, 8.0], within_m: 0.3}", "start: {near: [0.0, 2.0], within_m: 0.3}"),
)
"""The mission of the tests turns back after 2 m, and meets the person there."""


class Tape:
    """A wire that notes when a sample first held something at a seam: sent, and delivered [s]."""

    def __init__(self, wire: Any) -> None:
        self._wire, self.first = wire, dict[str, float]()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._wire, name)

    def cross(self, seam: str, t_s: float, sample: Any) -> Any:
        delivered = self._wire.cross(seam, t_s, sample)
        if seam == "person" and sample is not None:
            self.first.setdefault("seen", t_s)
        if seam == "speed" and delivered is not None and delivered.limit_mps < 0.25:
            self.first.setdefault("slow", t_s)
        if seam == "landing" and delivered is not None:
            self.first.setdefault("land", t_s)
        return delivered


@pytest.fixture
def flown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[Outcome, dict[str, float]]]:
    def fly_one(subject: str, situation: str, script: Path) -> tuple[Outcome, dict[str, float]]:
        folder = tmp_path / "study"
        mission_study(folder, script)
        world, stack = folder / "sim" / "world.yaml", folder / "sim" / "stack.yaml"
        text = world.read_text()
        for old, new in SHORT:
            assert old in text
            text = text.replace(old, new)
        world.write_text(text)
        stack.write_text(stack.read_text().replace("pace: 2.0", "pace: 4.0"))
        study = Study.open(folder)
        flight = flight_named(study, subject, situation, 0)
        tape = Tape(wire_of(study, flight))
        monkeypatch.setenv("MARK", str(tmp_path))
        log = fly(study.sim, flight.situation, flight.seed, tape)  # type: ignore[arg-type]
        assert marked(str(tmp_path)) == []
        return judged(study, flight, log), tape.first

    return fly_one


@needs_ros
@pytest.mark.release
@pytest.mark.flight
def test_a_mission_over_ros_1_slows_for_the_person_and_lands_at_home(flown: Callable[..., Any]):
    outcome, first = flown("baseline", "H1", EXAMPLE / "own_mission.py")
    assert (outcome.ending, outcome.stack_error, dict(outcome.realised)) == ("landed", "", {"H": True})
    assert [violation.requirement for violation in outcome.violations] == []
    assert 0.0 <= first["slow"] - first["seen"] <= 0.5
    assert first["land"] > first["slow"]


@needs_ros
@pytest.mark.release
@pytest.mark.flight
def test_a_late_person_delays_the_slow_order_by_three_seconds(flown: Callable[..., Any]):
    outcome, first = flown("LATE-human@3s", "H1", EXAMPLE / "own_mission.py")
    assert outcome.altered > 0
    assert 3.0 <= first["slow"] - first["seen"] <= 3.5


@needs_ros
@pytest.mark.release
@pytest.mark.flight
def test_a_false_contact_ends_the_mission_before_it_lands(flown: Callable[..., Any]):
    outcome, first = flown("UNINTENDED-collision@5s", "H0", EXAMPLE / "own_mission.py")
    assert (outcome.ending, outcome.stack_error) == ("timed_out", "")
    assert "OP1" in [violation.requirement for violation in outcome.violations]
    assert "land" not in first


@needs_ros
@pytest.mark.release
@pytest.mark.flight
def test_a_script_that_fails_is_the_drones_with_its_last_words(flown: Callable[..., Any], tmp_path: Path):
    script = tmp_path / "failing.py"
    own = (EXAMPLE / "own_mission.py").read_text()
    script.write_text(
        own.replace("rate.sleep()\n        self.speed", "rate.sleep()\n        sys.exit('no map')\n        self.speed")
    )
    outcome, _ = flown("baseline", "H0", script)
    assert "run_scripts.py ended with code 1" in outcome.stack_error
    assert "no map" in outcome.stack_error


def test_a_script_that_is_not_there_is_named(tmp_path: Path):
    with pytest.raises(InputError, match=r"lost\.py: no such script"):
        mission_study(tmp_path / "study", tmp_path / "lost.py")
    assert not (tmp_path / "study").exists()


def test_the_catalogue_of_the_study_is_current(tmp_path: Path):
    mission_study(tmp_path / "study", EXAMPLE / "own_mission.py")
    result = invoked("mutants", "--check", "--study", str(tmp_path / "study"))
    assert result.exit_code == 0, result.output
