"""The border `ros2`: the topics of ROS 2, in a domain that no other flight has, over the loopback of this machine.

It needs `rclpy`, from the environment that was sourced or from `pip install 'scaloft-fi[ros2]'`.  Simulated time goes
out on `/clock`, last in a tick.

The usual messages of ROS for our ports are nested mappings of their fields, without what only one ROS has, and need no
ROS.  Units and frames are those of REP 103 and REP 105: metres, radians, x forward, y left, z up.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
import os
import socket
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.output import line as inert
from scaloft_fi.output import write_whole
from scaloft_fi.outside.border import (
    BorderError,
    CameraInfo,
    Goal,
    Inbox,
    Land,
    MisfitError,
    Motion,
    Topic,
    TopicsBorder,
    from_plain,
    given,
    picked,
    taken,
    to_plain,
)
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


FIRST_PORT, PORTS_OF_DOMAIN = 7400, 250
"""A domain has the UDP ports from `FIRST_PORT + PORTS_OF_DOMAIN * domain` on (DDSI-RTPS 2.5, section 9.6.2.3)."""
FREE, FIRST_PARTICIPANT = 9, 10
"""Offsets of a port that DDS never uses, and of the first participant's."""
DOMAINS = range(1, 101)
"""Their ports lie below those that Linux hands out.  0 is everybody's default."""


class Domain(NamedTuple):
    """A domain that is held until `close`, or the end of this process."""

    number: int
    held: socket.socket

    def close(self) -> None:
        """Let others have it."""
        self.held.close()


def take_domain() -> Domain | None:
    """A domain that no other flight holds, and in which nobody listens; None without a free one.

    The user's own is left out, and processes begin at different ones.
    """
    begin = os.getpid() % len(DOMAINS)
    for number in (*DOMAINS[begin:], *DOMAINS[:begin]):
        first = FIRST_PORT + PORTS_OF_DOMAIN * number
        if str(number) == os.environ.get("ROS_DOMAIN_ID") or (held := _bound(first + FREE)) is None:
            continue
        used = _bound(first + FIRST_PARTICIPANT)
        if used is not None:
            used.close()
            return Domain(number, held)
        held.close()
    return None


def _bound(port: int) -> socket.socket | None:
    """A socket on a port of loopback; None where somebody has the port there, or on every address."""
    one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        one.bind(("127.0.0.1", port))
    except OSError:
        one.close()
        return None
    return one


LARGEST_MESSAGE = 1 << 20
"""Most bytes of a message that comes in."""
MOST_MESSAGES = 100
"""Most messages that are read in a tick."""
DEPTH = 10
"""Usual number of messages that wait for a reader."""
QOS: Mapping[str, Sequence[str]] = {
    "reliability": ("reliable", "best_effort"),
    "durability": ("volatile", "transient_local"),
    "depth": (),
}
"""Qualities of service that a topic may name, and their values."""
MOST_DEPTH = 1000
CLOCK = "rosgraph_msgs/Clock"
MISSING = "source your ROS 2 environment, or pip install 'scaloft-fi[ros2]'"
PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com"><profiles>
  <transport_descriptors><transport_descriptor>
    <transport_id>loopback</transport_id><type>UDPv4</type>
    <interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>
  </transport_descriptor></transport_descriptors>
  <participant profile_name="flight" is_default_profile="true"><rtps>
    <userTransports><transport_id>loopback</transport_id></userTransports>
    <useBuiltinTransports>false</useBuiltinTransports>
  </rtps></participant>
</profiles></dds>
"""
"""Fast DDS listens on loopback only, and leaves nothing in shared memory."""
OLDER = ("humble", "iron", "jazzy")
"""Distributions of ROS 2 with a Fast DDS before release 3, which has another variable for its profiles."""


@dataclass(eq=False)
class Ros2Border(TopicsBorder):
    """A border over topics of ROS 2."""

    _ends: Ends = field(default_factory=Ends)
    _domain: Domain | None = None
    _context: Any = None
    _node: Any = None
    _executor: Any = None
    _clock: Any = None
    _publishers: dict[str, Any] = field(default_factory=dict)
    _subscriptions: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._layouts = {topic.seam: layout_of(topic, LAYOUTS) for topic in self.topics}

    @staticmethod
    def misfit(topic: Topic) -> str:
        """What of a topic's settings ROS 2 cannot carry; "" if all of it."""
        try:
            layout_of(topic, LAYOUTS)
        except ValueError as error:
            return str(error)
        for name, value in topic.qos.items():
            if name not in QOS:
                return f"qos.{name} is unknown{did_you_mean(name, QOS)}"
            if QOS[name] and value not in QOS[name]:
                return f"qos.{name}={value!r} must be {' or '.join(QOS[name])}"
            if name == "depth" and (type(value) is not int or not 1 <= value <= MOST_DEPTH):
                return f"qos.depth={value!r} must be a whole number, 1 to {MOST_DEPTH}"
        return ""

    @staticmethod
    def need() -> None:
        """Look for `rclpy`, without importing it: it begins threads, and a process with threads cannot be forked.

        Raises:
            InputError: it is missing.
        """
        if importlib.util.find_spec("rclpy") is None:
            raise InputError(f"border=ros2 needs rclpy: {MISSING}")

    @property
    def environment(self) -> Mapping[str, str]:
        """The domain of the flight, and loopback as its only network."""
        assert self._domain is not None
        own = {"ROS_DOMAIN_ID": str(self._domain.number), "ROS_LOG_DIR": str(self.folder / "ros_log")}
        if os.environ.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp") != "rmw_fastrtps_cpp":
            return own | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        own["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SUBNET"  # the profile limits it; LOCALHOST would add other listeners
        fast_dds = "FASTRTPS" if os.environ.get("ROS_DISTRO") in OLDER else "FASTDDS"
        return own | {f"{fast_dds}_DEFAULT_PROFILES_FILE": str(self.folder / "profile.xml")}

    def open(self) -> None:
        """Join a domain of its own and open the topics.

        Raises:
            BorderError: no domain is free, or ROS 2 or a type of message is missing.
        """
        self._domain = take_domain()
        if self._domain is None:
            raise BorderError("all domains of ROS 2 on this machine are in use")
        write_whole(self.folder / "profile.xml", PROFILE.encode())
        os.environ.update(self.environment)
        try:
            import rclpy.signals

            self._context = rclpy.Context()
            silent = rclpy.signals.SignalHandlerOptions.NO
            rclpy.init(context=self._context, domain_id=self._domain.number, signal_handler_options=silent)
            self._node = rclpy.create_node("scaloft_fi", context=self._context, start_parameter_services=False)
            self._executor = rclpy.executors.SingleThreadedExecutor(context=self._context)
            self._executor.add_node(self._node)
            self._open_topics()
        except ImportError as error:
            raise BorderError(f"ROS 2 lacks {inert(str(error))[:200]}: {MISSING}") from error
        except RuntimeError as error:  # of the middleware
            raise BorderError(f"ROS 2: {inert(str(error))[:300]}") from error

    def _open_topics(self) -> None:
        for topic in self.topics:
            type_, qos = message_class(self._layouts[topic.seam].type), _profile(topic)
            if topic.outward:
                self._publishers[topic.seam] = self._node.create_publisher(type_, topic.name, qos)
            else:
                come = partial(self._come, self._inbox[topic.seam], self._layouts[topic.seam], type_)
                one = self._node.create_subscription(type_, topic.name, come, qos, raw=True)
                self._subscriptions[topic.seam] = one
        self._clock = self._node.create_publisher(message_class(CLOCK), "/clock", DEPTH)

    def lacking(self) -> str:
        """The topics that nobody subscribes to, or publishes; then, for a moment, that the other side looks for us."""
        awaited = {topic.seam for topic in self.topics if topic.awaited}
        publishers = [one for seam, one in self._publishers.items() if seam in awaited]
        subscriptions = [one for seam, one in self._subscriptions.items() if seam in awaited]
        unread = [one.topic_name for one in publishers if not one.get_subscription_count()]
        unsent = [one.topic_name for one in subscriptions if not one.get_publisher_count()]
        return self._ends.lacking(unread, unsent)

    def send(self, seam: str, t_s: float, sample: Any) -> None:
        """Publish a sample, stamped with its own time where it has one."""
        topic, layout, publisher = self._outward[seam], self._layouts[seam], self._publishers[seam]
        assert layout.written is not None
        message = publisher.msg_type()
        if hasattr(message, "header"):
            _set_time(message.header.stamp, float(getattr(sample, "stamp_s", t_s)))
            message.header.frame_id = topic.frame or layout.frame
        fill(message, layout.written(sample))
        publisher.publish(message)

    def clock(self, t_s: float) -> None:
        """Publish the time; what came before it answers no more."""
        self._hear(0.0)
        self._begin_tick(t_s)
        message = self._clock.msg_type()
        _set_time(message.clock, t_s)
        self._clock.publish(message)

    def close(self) -> None:
        """Leave the domain."""
        if self._context is not None and self._context.ok():
            if self._executor is not None:
                self._executor.shutdown()
            if self._node is not None:
                self._node.destroy_node()
            self._context.shutdown()
        if self._domain is not None:
            self._domain.close()
            self._domain = None

    def _hear(self, within_s: float) -> bool:
        """Handle what has come: without waiting at most `MOST_MESSAGES` of each topic, without an executor's cost."""
        if within_s:
            self._executor.spin_once(timeout_sec=within_s)
            return True
        for one in self._subscriptions.values():
            for _ in range(MOST_MESSAGES):
                with one.handle:
                    taken_ = one.handle.take_message(one.msg_type, one.raw)
                if taken_ is None:
                    break
                one.callback(taken_[0])
        return True

    def _come(self, box: Inbox, layout: Layout, type_: Any, raw: bytes) -> None:
        """Take a message of an inward topic."""
        from rclpy.serialization import deserialize_message

        box.count += 1
        try:
            if len(raw) > LARGEST_MESSAGE:
                raise MisfitError(f"a message of {len(raw):,} bytes, of which {LARGEST_MESSAGE:,} are allowed")
            message = deserialize_message(raw, type_)
            box.sample = self._sample(box.topic, layout, message)
            box.fresh = True
        except (MisfitError, RuntimeError, TypeError, ValueError) as error:
            box.refuse(str(error))

    def _sample(self, topic: Topic, layout: Layout, message: Any) -> Any:
        stamp_s = _time(message.header.stamp) if hasattr(message, "header") else 0.0
        self._check_stamp(f"its stamp, {stamp_s:g} s,", stamp_s)
        return sample_in(topic, layout, picked(message, layout.read), stamp_s or self.clock_s)


def message_class(name: str) -> Any:
    """The class of a type of message, "nav_msgs/Odometry".

    Raises:
        ImportError: its package is missing, or has no such message.
    """
    package, _, kind = name.partition("/")
    module = importlib.import_module(f"{package}.msg")
    if not hasattr(module, kind):
        raise ImportError(f"the message {kind!r} in {package}.msg")
    return getattr(module, kind)


def fill(message: Any, fields: Mapping[str, Any]) -> None:
    """Set the fields of a message of ROS 2, nested ones and lists of messages included.

    Numbers become of the field's own type.

    Raises:
        AttributeError: the message has no such field.
    """
    for name, value in fields.items():
        held = getattr(message, name)
        if isinstance(value, Mapping):
            fill(held, value)
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            setattr(message, name, [_element(message, name, entry) for entry in value])
        elif isinstance(held, bool | int | float | str):
            setattr(message, name, type(held)(value))
        else:
            setattr(message, name, value)


def _element(message: Any, name: str, fields: Mapping[str, Any]) -> Any:
    kind = message.get_fields_and_field_types()[name].removeprefix("sequence<").partition(">")[0].partition(",")[0]
    one = message_class(kind)()
    fill(one, fields)
    return one


def _set_time(stamp: Any, t_s: float) -> None:
    whole = round(t_s * 1e9)
    stamp.sec, stamp.nanosec = whole // 10**9, whole % 10**9


def _time(stamp: Any) -> float:
    return float(stamp.sec + stamp.nanosec * 1e-9)


def _profile(topic: Topic) -> Any:
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    qos = topic.qos
    return QoSProfile(
        depth=qos.get("depth", DEPTH),
        reliability=ReliabilityPolicy[str(qos.get("reliability", "reliable")).upper()],
        durability=DurabilityPolicy[str(qos.get("durability", "volatile")).upper()],
    )
