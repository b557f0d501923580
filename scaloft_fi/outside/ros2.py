"""The border `ros2`: the topics of ROS 2, in a domain that no other flight has, over the loopback of this machine.

It needs `rclpy`, from the environment that was sourced or from `pip install 'scaloft-fi[ros2]'`.  Simulated time goes
out on `/clock`, last in a tick.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import socket
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

from scaloft_fi.console import line as inert
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.output import write_whole
from scaloft_fi.outside.border import BorderError, Inbox, MisfitError, Topic, TopicsBorder, picked
from scaloft_fi.outside.ros_messages import LAYOUTS, Ends, Layout, layout_of, sample_in

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
            import rclpy
            from rclpy.signals import SignalHandlerOptions

            self._context = rclpy.Context()
            rclpy.init(
                context=self._context, domain_id=self._domain.number, signal_handler_options=SignalHandlerOptions.NO
            )
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
