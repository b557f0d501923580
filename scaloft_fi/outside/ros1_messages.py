"""The usual messages of ROS 1 for our ports, where they differ from those that ROS 1 and ROS 2 have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from scaloft_fi.outside.ports import CameraInfo, Land
from scaloft_fi.outside.ros_messages import BODY, LAYOUTS, Fields, Layout, camera_info
from scaloft_fi.stack.messages import Bumper, Detections
from scaloft_fi.stack.reference.messages import SpeedLimit


def camera_info_1(info: CameraInfo) -> Fields:
    """`sensor_msgs/CameraInfo`, whose matrices have capital names in ROS 1."""
    return {name.upper() if len(name) == 1 else name: value for name, value in camera_info(info).items()}


def bounding_boxes(detections: Detections) -> Fields:
    """`darknet_ros_msgs/BoundingBoxes`: class and score of each person; our detector has no corners in pixels."""
    return {
        "bounding_boxes": [
            {"Class": one.label, "probability": float(one.score), "id": place}
            for place, one in enumerate(detections.persons)
        ]
    }


def contacts_state(bumper: Bumper) -> Fields:
    """`gazebo_msgs/ContactsState`: one state while the hull touches something, else none."""
    return {"states": [{"info": "hull", "collision1_name": "hull"}] if bumper.hull else []}


def _with(message: type, *more: Layout) -> tuple[Layout, ...]:
    return (*LAYOUTS[message], *more)


LAYOUTS_1: Mapping[type, tuple[Layout, ...]] = MappingProxyType(
    {
        **LAYOUTS,
        CameraInfo: tuple(replace(one, written=camera_info_1) for one in LAYOUTS[CameraInfo]),
        Detections: _with(Detections, Layout("darknet_ros_msgs/BoundingBoxes", bounding_boxes, BODY)),
        Bumper: _with(Bumper, Layout("gazebo_msgs/ContactsState", contacts_state, BODY)),
        SpeedLimit: _with(SpeedLimit, replace(LAYOUTS[SpeedLimit][0], type="std_msgs/Float32")),
        Land: _with(Land, Layout("std_msgs/Float32")),
    }
)
"""The usual messages of each port, the first one where a topic names none."""
