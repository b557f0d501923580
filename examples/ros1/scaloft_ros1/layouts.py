"""The usual messages of ROS 1 for our ports, where they differ from those of ROS 2."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from scaloft_fi.api import LAYOUTS, CameraInfo, Land, Layout, SpeedLimit
from scaloft_fi.api import messages as ours

BODY = "base_link"


def camera_info_1(info: CameraInfo) -> Mapping[str, Any]:
    """`sensor_msgs/CameraInfo`, whose matrices have capital names in ROS 1."""
    return {name.upper() if len(name) == 1 else name: value for name, value in _of_ros_2(info).items()}


def _of_ros_2(info: CameraInfo) -> Mapping[str, Any]:
    written = LAYOUTS[CameraInfo][0].written
    assert written is not None
    return written(info)


def bounding_boxes(detections: ours.Detections) -> Mapping[str, Any]:
    """`darknet_ros_msgs/BoundingBoxes`: class and score of each person; our detector has no corners in pixels."""
    return {
        "bounding_boxes": [
            {"Class": one.label, "probability": float(one.score), "id": place}
            for place, one in enumerate(detections.persons)
        ]
    }


def contacts_state(bumper: ours.Bumper) -> Mapping[str, Any]:
    """`gazebo_msgs/ContactsState`: one state while the hull touches something, else none."""
    return {"states": [{"info": "hull", "collision1_name": "hull"}] if bumper.hull else []}


def _with(message: type, *more: Layout) -> tuple[Layout, ...]:
    return (*LAYOUTS[message], *more)


LAYOUTS_1: Mapping[type, tuple[Layout, ...]] = MappingProxyType(
    {
        **LAYOUTS,
        CameraInfo: tuple(replace(one, written=camera_info_1) for one in LAYOUTS[CameraInfo]),
        ours.Detections: _with(ours.Detections, Layout("darknet_ros_msgs/BoundingBoxes", bounding_boxes, BODY)),
        ours.Bumper: _with(ours.Bumper, Layout("gazebo_msgs/ContactsState", contacts_state, BODY)),
        SpeedLimit: _with(SpeedLimit, replace(LAYOUTS[SpeedLimit][0], type="std_msgs/Float32")),
        Land: _with(Land, Layout("std_msgs/Float32")),
    }
)
"""The usual messages of each port, the first one where a topic names none."""
