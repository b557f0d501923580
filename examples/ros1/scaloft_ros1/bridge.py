"""The bridge of the border `ros1`: a master and a node of ROS 1 on one side, JSON lines to the flight on the other.

It is a program of its own for the Python that has rospy, and imports nothing of this package.  Its argument is the
order in JSON: `socket` of the flight, `port` of the master, `topics` with `name`, `type`, `outward`, `depth` and, where
messages come in, the paths of the fields to `read`, and the `services` that it answers, type by name.

It connects to the flight when master and topics are ready, names the topics that have their other end whenever one
more has, and forwards whatever comes.  It ends with the connection.
"""

from __future__ import annotations

import base64
import importlib
import json
import os
import resource
import socket
import sys
import threading
import time
from collections.abc import Iterable, Mapping
from typing import Any

MOST_MEMORY = 4 << 30
"""Address space of this program [bytes]: what others send is bounded by it."""
LOOK_S = 0.02
"""Time between two looks at who is connected [s, wall]."""
ANSWER = "the situation decides where bodies are"


def class_of(kind: str, folder: str = "msg") -> Any:
    """The class of a type of message or service, "nav_msgs/Odometry"."""
    package, _, name = kind.partition("/")
    return getattr(importlib.import_module(f"{package}.{folder}"), name)


def fill(message: Any, fields: Mapping[str, Any]) -> None:
    """Set the fields of a message, nested ones and lists of messages included; bytes come in base 64."""
    kinds = dict(zip(message.__slots__, message._slot_types))  # noqa: B905 - Python 3.8, that of ROS 1, has no `strict`
    for name, value in fields.items():
        held = getattr(message, name)
        if isinstance(value, dict):
            fill(held, value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            kind = class_of(kinds[name].partition("[")[0])
            setattr(message, name, [filled(kind, entry) for entry in value])
        elif isinstance(value, str) and kinds[name] == "uint8[]":
            setattr(message, name, base64.b64decode(value))
        else:
            setattr(message, name, value)


def filled(kind: Any, fields: Mapping[str, Any]) -> Any:
    """A new message with these fields."""
    message = kind()
    fill(message, fields)
    return message


def picked(message: Any, paths: Iterable[str]) -> dict[str, Any]:
    """The fields that stand at these paths, as nested mappings; what is missing is left out."""
    plain: dict[str, Any] = {}
    for path in paths:
        value = message
        for key in path.split("."):
            value = getattr(value, key, None)
        if value is None:
            continue
        *parents, last = path.split(".")
        place = plain
        for parent in parents:
            place = place.setdefault(parent, {})
        place[last] = value
    return plain


class Bridge:
    """Carries messages between the flight and the topics."""

    def __init__(self, order: Mapping[str, Any], rospy: Any) -> None:
        self.rospy = rospy
        self.lock = threading.Lock()
        self.publishers: dict[str, Any] = {}
        self.subscribers: dict[str, Any] = {}
        self.flight = socket.socket(socket.AF_UNIX)
        self.clock = rospy.Publisher("/clock", class_of("rosgraph_msgs/Clock"), queue_size=10, tcp_nodelay=True)
        for topic in order["topics"]:
            name, kind, depth = topic["name"], class_of(topic["type"]), topic["depth"]
            if topic["outward"]:
                self.publishers[name] = rospy.Publisher(name, kind, queue_size=depth, tcp_nodelay=True)
            else:
                self.subscribers[name] = rospy.Subscriber(
                    name, kind, self.come, (name, topic["read"]), queue_size=depth, tcp_nodelay=True
                )
        for name, kind in order["services"].items():
            service = class_of(kind, "srv")
            rospy.Service(name, service, lambda _request, one=service: one._response_class(True, ANSWER))

    def come(self, message: Any, topic: tuple[str, list[str]]) -> None:
        """Forward a message."""
        name, paths = topic
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        line = {"topic": name, "data": picked(message, paths)}
        if stamp is not None:
            line["stamp_s"] = stamp.to_sec()
        self.tell(line)

    def tell(self, line: Mapping[str, Any]) -> None:
        """Tell the flight; without it there is nothing left to do."""
        try:
            text = json.dumps(line, default=repr).encode() + b"\n"
            with self.lock:
                self.flight.sendall(text)
        except OSError:
            os._exit(0)

    def look(self) -> None:
        """Name the topics that have their other end."""
        told: list[str] | None = None
        while True:
            ends = {**self.publishers, **self.subscribers}
            named = sorted(name for name, end in ends.items() if end.get_num_connections())
            if named != told:
                self.tell({"publishes": named})
                told = named
            time.sleep(LOOK_S)

    def run(self, path: str) -> None:
        """Follow the flight until it ends."""
        self.flight.connect(path)
        threading.Thread(target=self.look, daemon=True).start()
        with self.flight.makefile("rb") as lines:
            for text in lines:
                self.send(json.loads(text.decode()))

    def send(self, line: Mapping[str, Any]) -> None:
        """Publish what the flight sends."""
        if "clock" in line:
            self.clock.publish(self.rospy.Time.from_sec(line["clock"]))
            return
        publisher, data = self.publishers[line["topic"]], line["data"]
        message = filled(publisher.data_class, data["fields"])
        if hasattr(message, "header"):
            message.header.stamp = self.rospy.Time.from_sec(data["stamp_s"])
            message.header.frame_id = data["frame"]
        publisher.publish(message)


def main() -> None:
    """Start a master, a node and the topics, then carry messages until the flight ends."""
    order = json.loads(sys.argv[1])
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    importlib.import_module("rosmaster.master").Master(order["port"]).start()
    rospy, rosgraph = map(importlib.import_module, ("rospy", "rosgraph"))
    rospy.init_node("scaloft_fi", disable_signals=True, disable_rosout=True)  # by the wall clock
    rosgraph.Master("/scaloft_fi").setParam("/use_sim_time", True)
    bridge = Bridge(order, rospy)
    bridge.run(order["socket"])
    os._exit(0)


if __name__ == "__main__":
    main()
