"""The codec of the border `ros1`, and its settings, without ROS."""

from __future__ import annotations

import math
import os
import socket
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from scaloft_ros1 import bridge
from scaloft_ros1.border import PYTHON, Ros1Border, held_port
from scaloft_ros1.layouts import LAYOUTS_1, bounding_boxes, camera_info_1, contacts_state

from scaloft_fi.api import sample_in
from scaloft_fi.errors import InputError
from scaloft_fi.outside.border import CameraInfo, Goal, Land, MisfitError, Topic
from scaloft_fi.outside.ros2 import layout_of
from scaloft_fi.stack.messages import Bumper, Detections, Person
from scaloft_fi.stack.reference.messages import SpeedLimit

SPEED = Topic("speed", "/drone_update_vel", SpeedLimit, outward=False, type="std_msgs/Float32")
GOAL = Topic("goal", "/move_base_simple/goal", Goal, outward=False)


def read(topic: Topic, data: Any, clock_s: float = 2.0) -> Any:
    return sample_in(topic, layout_of(topic, LAYOUTS_1), data, clock_s)


def test_a_box_has_the_class_and_the_score_of_its_person():
    persons = (Person("person", 0.9, 0.1, 3.0), Person("poster", 0.4, 0.0, 5.0))
    boxes = bounding_boxes(Detections(1.0, persons))["bounding_boxes"]
    assert [(box["Class"], box["probability"], box["id"]) for box in boxes] == [("person", 0.9, 0), ("poster", 0.4, 1)]


@pytest.mark.parametrize(("hull", "gear", "states"), [(True, False, 1), (False, True, 0), (False, False, 0)])
def test_a_state_of_contact_is_told_while_the_hull_touches(hull: bool, gear: bool, states: int):
    assert len(contacts_state(Bumper(1.0, hull=hull, gear=gear))["states"]) == states


def test_the_matrices_of_a_camera_have_capital_names():
    fields = camera_info_1(CameraInfo(1.0, 64, 48, 56.0, 56.0, 31.5, 23.5))
    assert fields["K"][2] == 31.5
    assert {"D", "K", "R", "P", "height"} < fields.keys()
    assert not {"d", "k", "r", "p"} & fields.keys()


def test_a_speed_limit_without_a_stamp_has_the_clocks_and_is_euclidean():
    assert read(SPEED, {"data": 0.2}) == SpeedLimit(2.0, 0.2, "euclidean")


def test_an_order_to_land_needs_no_field():
    assert read(Topic("land", "/land_command", Land, outward=False, type="std_msgs/Float32"), {}) == Land(2.0)


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        ({"pose": {"position": {"x": 1.0, "y": math.nan, "z": 0.0}}}, "must be finite"),
        ({"pose": {"position": {"x": 1.0, "y": 2.0}}}, "pose.position.z is missing"),
        (None, "pose.position.x is missing"),
    ],
)
def test_a_goal_that_does_not_fit_is_refused(data: Any, sentence: str):
    with pytest.raises(MisfitError, match=sentence):
        read(GOAL, data)


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"type": "std_msgs/Float23"}, "type='std_msgs/Float23' is no usual message of SpeedLimit; did you mean"),
        ({"qos": {"dept": 3}}, "qos.dept is nothing that border=ros1 has; allowed: 'depth'"),
        ({"qos": {"depth": 0}}, "qos.depth=0 must be a whole number, 1 to 1000"),
        ({"qos": {"depth": 5}}, ""),
    ],
)
def test_settings_that_ros_1_lacks_are_named(changed: dict[str, Any], sentence: str):
    misfit = Ros1Border.misfit(
        Topic("speed", "/v", SpeedLimit, outward=False, **{"type": "std_msgs/Float32", **changed})
    )
    assert misfit.startswith(sentence)
    assert bool(misfit) == bool(sentence)


def test_without_rospy_a_sentence_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    bare = tmp_path / "python"
    bare.write_text(f'#!/bin/sh\nexec {sys.executable} -I -S "$@"\n')
    bare.chmod(0o755)
    monkeypatch.setenv(PYTHON, str(bare))
    with pytest.raises(InputError, match=r"border=ros1 needs rospy, which .* lacks: source your ROS 1 environment, or"):
        Ros1Border.need()


def test_the_border_imports_nothing_of_ros():
    program = "import sys, scaloft_ros1.border\nsys.exit(any(name in sys.modules for name in ('rospy', 'genpy')))"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    assert subprocess.run([sys.executable, "-c", program], env=environment, check=False).returncode == 0


def test_a_held_port_is_free_for_the_master_and_for_no_other_flight():
    first, second = held_port(), held_port()
    port = first.getsockname()[1]
    assert port != second.getsockname()[1]
    with socket.socket() as master:
        master.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        master.bind(("127.0.0.1", port))
        master.listen()
    first.close()
    second.close()


class Inner:
    __slots__ = ("label",)
    _slot_types = ("string",)

    def __init__(self) -> None:
        self.label = ""


class Outer:
    __slots__ = ("data", "entries", "inner", "number")
    _slot_types = ("uint8[]", "own_msgs/Inner[]", "own_msgs/Inner", "float64")

    def __init__(self) -> None:
        self.data, self.entries, self.inner, self.number = b"", [], Inner(), 0.0


def test_the_bridge_fills_nested_fields_lists_and_bytes(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "own_msgs", SimpleNamespace())  # type: ignore[arg-type]
    monkeypatch.setitem(sys.modules, "own_msgs.msg", SimpleNamespace(Inner=Inner))  # type: ignore[arg-type]
    fields = {"data": "AAEC", "entries": [{"label": "a"}, {"label": "b"}], "inner": {"label": "c"}, "number": 1.5}
    message = bridge.filled(Outer, fields)
    assert (message.data, message.number, message.inner.label) == (b"\0\1\2", 1.5, "c")
    assert [entry.label for entry in message.entries] == ["a", "b"]


def test_the_bridge_refuses_a_field_that_the_message_lacks():
    with pytest.raises(AttributeError):
        bridge.filled(Outer, {"nubmer": 1.0})


def test_the_bridge_picks_the_fields_that_are_asked_for():
    message = SimpleNamespace(pose=SimpleNamespace(x=1.0, y=2.0), note="n")
    assert bridge.picked(message, ["pose.x", "pose.w"]) == {"pose": {"x": 1.0}}
