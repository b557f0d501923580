"""The usual messages of ROS for our ports, as nested mappings of their fields, without what only one ROS has.

Units and frames are those of REP 103 and REP 105: metres, radians, x forward, y left, z up.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from scaloft_fi.errors import did_you_mean
from scaloft_fi.outside.border import CameraInfo, Goal, Land, Motion, Topic, from_plain, given, taken, to_plain
from scaloft_fi.stack.messages import Battery, Bumper, DepthFrame, Detections, Imu
from scaloft_fi.stack.reference.messages import PoseEstimate, SpeedLimit

Fields = Mapping[str, Any]
BODY, OPTICAL, WORLD = "base_link", "camera_depth_optical_frame", "map"
FLOAT32 = 7
"""`PointField.FLOAT32`."""
POINT = ("x", "y", "z", "score")
"""The numbers of a person in a `PointCloud2`."""


@dataclass(frozen=True)
class Layout:
    """How the samples of a port stand in one type of message.

    Attributes:
        type: package and name, such as "nav_msgs/Odometry".
        written: (sample) -> fields of a message that goes out; None where messages come in.
        frame: usual frame id of messages that go out.
        read: fields of a message that comes in, to those of the sample.
        also: plain values of the sample that such a message does not have.
    """

    type: str
    written: Callable[[Any], Fields] | None = None
    frame: str = ""
    read: Mapping[str, str] = field(default_factory=dict)
    also: Fields = field(default_factory=dict)


def _xyz(values: Iterable[float]) -> Fields:
    return dict(zip("xyz", map(float, values), strict=True))


def odometry(pose: PoseEstimate) -> Fields:
    """`nav_msgs/Odometry`: pose in the world, velocity in the body."""
    x, y, z, w = map(float, pose.attitude)
    body = _turned(-np.array([x, y, z]), w, np.asarray(pose.velocity, dtype=float))
    return {
        "child_frame_id": BODY,
        "pose": {"pose": {"position": _xyz(pose.position), "orientation": {"x": x, "y": y, "z": z, "w": w}}},
        "twist": {"twist": {"linear": _xyz(body)}},
    }


def _turned(axis: Any, w: float, vector: Any) -> Any:
    """A vector (3,) turned by the unit quaternion with the vector part `axis` (3,) and the scalar part `w`."""
    across = 2.0 * np.cross(axis, vector)
    return vector + w * across + np.cross(axis, across)


def pose_stamped(pose: PoseEstimate) -> Fields:
    """`geometry_msgs/PoseStamped`."""
    return {"pose": odometry(pose)["pose"]["pose"]}


def image(frame: DepthFrame) -> Fields:
    """`sensor_msgs/Image` of encoding 32FC1 [m]; NaN where the sensor saw nothing, as REP 118 has it."""
    depth = np.where(frame.depth > 0.0, frame.depth, np.nan).astype("<f4")
    height, width = depth.shape
    return {
        "height": height,
        "width": width,
        "encoding": "32FC1",
        "is_bigendian": 0,
        "step": 4 * width,
        "data": depth.tobytes(),
    }


def camera_info(info: CameraInfo) -> Fields:
    """`sensor_msgs/CameraInfo` of a pinhole camera without distortion."""
    fx, fy, cx, cy = info.fx, info.fy, info.cx, info.cy
    return {
        "height": info.height,
        "width": info.width,
        "distortion_model": "plumb_bob",
        "d": [0.0] * 5,
        "k": [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    }


def imu(sample: Imu) -> Fields:
    """`sensor_msgs/Imu` without an orientation, which a first covariance of -1 says."""
    return {
        "orientation_covariance": [-1.0] + [0.0] * 8,
        "angular_velocity": _xyz(sample.rate),
        "linear_acceleration": _xyz(sample.force),
    }


def point_cloud(detections: Detections) -> Fields:
    """`sensor_msgs/PointCloud2`: for each person x ahead, y left, z [m, body] and score."""
    rows = [
        (one.range_m * math.cos(one.bearing_rad), one.range_m * math.sin(one.bearing_rad), 0.0, one.score)
        for one in detections.persons
    ]
    points = np.array(rows, dtype="<f4").reshape(-1, len(POINT))
    return {
        "height": 1,
        "width": len(rows),
        "fields": [
            {"name": name, "offset": 4 * place, "datatype": FLOAT32, "count": 1} for place, name in enumerate(POINT)
        ],
        "is_bigendian": False,
        "point_step": 4 * len(POINT),
        "row_step": 4 * len(POINT) * len(rows),
        "data": points.tobytes(),
        "is_dense": True,
    }


def detections_3d(detections: Detections) -> Fields:
    """`vision_msgs/Detection3DArray`, whose places are [m, body]."""
    return {
        "detections": [
            {
                "results": [
                    {"hypothesis": {"class_id": one.label, "score": float(one.score)}, "pose": {"pose": _place(one)}}
                ],
                "bbox": {"center": _place(one)},
            }
            for one in detections.persons
        ]
    }


def _place(one: Any) -> Fields:
    ahead_m, left_m = one.range_m * math.cos(one.bearing_rad), one.range_m * math.sin(one.bearing_rad)
    return {"position": _xyz((ahead_m, left_m, 0.0))}


def battery(sample: Battery) -> Fields:
    """`sensor_msgs/BatteryState`; the voltage of single cells is unknown, which NaN says."""
    return {
        "voltage": float(sample.voltage_v),
        "percentage": float(sample.charge),
        "cell_voltage": [math.nan] * sample.cells,
        "present": True,
    }


def hull(sample: Bumper) -> Fields:
    """`std_msgs/Bool`: whether the hull touches something."""
    return {"data": bool(sample.hull)}


def _of(parent: str, sample: str, axes: str = "xyz") -> Mapping[str, str]:
    return {f"{parent}.{axis}": f"{sample}.{axis}" for axis in axes}


TWIST = {**_of("linear", "velocity"), "angular.z": "turn_radps"}

LAYOUTS: Mapping[type, tuple[Layout, ...]] = MappingProxyType(
    {
        PoseEstimate: (
            Layout("nav_msgs/Odometry", odometry, WORLD),
            Layout("geometry_msgs/PoseStamped", pose_stamped, WORLD),
        ),
        DepthFrame: (Layout("sensor_msgs/Image", image, OPTICAL),),
        CameraInfo: (Layout("sensor_msgs/CameraInfo", camera_info, OPTICAL),),
        Imu: (Layout("sensor_msgs/Imu", imu, BODY),),
        Detections: (
            Layout("sensor_msgs/PointCloud2", point_cloud, BODY),
            Layout("vision_msgs/Detection3DArray", detections_3d, BODY),
        ),
        Battery: (Layout("sensor_msgs/BatteryState", battery, BODY),),
        Bumper: (Layout("std_msgs/Bool", hull),),
        Motion: (
            Layout("geometry_msgs/Twist", read=TWIST),
            Layout("geometry_msgs/TwistStamped", read={f"twist.{theirs}": ours for theirs, ours in TWIST.items()}),
        ),
        Goal: (
            Layout("geometry_msgs/PoseStamped", read=_of("pose.position", "point")),
            Layout("geometry_msgs/PointStamped", read=_of("point", "point")),
        ),
        SpeedLimit: (Layout("std_msgs/Float64", read={"data": "limit_mps"}, also={"norm": "euclidean"}),),
        Land: (Layout("std_msgs/Empty"),),
    }
)
"""The usual messages of each port, the first one where a topic names none."""


def plain_type(name: str) -> str:
    """The type of a message without the folder that ROS 2 puts in its middle.

    >>> plain_type("nav_msgs/msg/Odometry"), plain_type("nav_msgs/Odometry")
    ('nav_msgs/Odometry', 'nav_msgs/Odometry')
    """
    return name.replace("/msg/", "/", 1)


def layout_of(topic: Topic, layouts: Mapping[type, tuple[Layout, ...]]) -> Layout:
    """The layout of a topic: its own fields where it has some, else the usual one of its type.

    Args:
        topic: the topic.
        layouts: the usual ones of each port.

    Raises:
        ValueError: there is no usual one; the message says which there are.
    """
    usual = layouts.get(topic.message, ())
    if topic.fields:
        name = plain_type(topic.type) if topic.type else usual[0].type if usual else ""
        if not name:
            raise ValueError(f"type='' is missing: {topic.message.__name__} has no usual message")
        if not topic.outward:
            return Layout(name, read=topic.fields, also=usual[0].also if usual else {})
        return Layout(name, lambda sample: given(to_plain(sample), topic.fields), WORLD)
    if not topic.type and usual:
        return usual[0]
    known = {one.type: one for one in usual}
    name = plain_type(topic.type)
    if name not in known:
        hint = did_you_mean(name, known)
        raise ValueError(f"type={topic.type!r} is no usual message of {topic.message.__name__}{hint}; map its `fields`")
    return known[name]


def sample_in(topic: Topic, layout: Layout, message: Any, stamp_s: float) -> Any:
    """The sample that a message stands for.

    Args:
        topic: the topic.
        layout: its layout.
        message: the fields that the layout reads, as nested mappings.
        stamp_s: the stamp [s] of a sample that has none of its own.

    Raises:
        MisfitError: it does not fit.
    """
    plain = {**layout.also, **(taken(message, layout.read) if layout.read else {})}
    if "stamp_s" in topic.message.__annotations__:
        plain.setdefault("stamp_s", stamp_s)
    return from_plain(topic.message, plain)


SETTLE_S = 0.2
"""Time from when this side knows its other ends until they know it as well [s, wall]."""


@dataclass
class Ends:
    """Whether the topics of a border have their other ends, and know it.  met_s: since when they have them [s]."""

    met_s: float | None = None

    def lacking(self, unread: Sequence[str], unsent: Sequence[str]) -> str:
        """What `Border.lacking` says of the topics that nobody subscribes to, and of those that nobody publishes."""
        said = [f"nobody subscribes to {', '.join(unread)}"] * bool(unread)
        said += [f"nobody publishes {', '.join(unsent)}"] * bool(unsent)
        now_s = time.monotonic()
        if said:
            self.met_s = None
        elif self.met_s is None:
            self.met_s = now_s
        settled = self.met_s is not None and now_s - self.met_s >= SETTLE_S
        return "; ".join(said) or ("" if settled else "a moment for the other side")
