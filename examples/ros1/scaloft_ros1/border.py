"""The border `ros1`: the topics of ROS 1, with a master that no other flight has, over this machine's loopback.

rospy runs in a bridge, a process below a guard of its own, with the Python that ROS 1 was installed for.  Simulated
time goes out on `/clock`, last in a tick; the parameter `/use_sim_time` is true.
"""

from __future__ import annotations

import base64
import json
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scaloft_fi import InputError
from scaloft_fi.api import (
    BORDERS,
    Arrival,
    BorderError,
    Codec,
    Command,
    Ends,
    LinesBorder,
    Processes,
    Topic,
    layout_of,
    sample_in,
)
from scaloft_ros1.layouts import LAYOUTS_1

PYTHON = "SCALOFT_ROS1_PYTHON"
"""The environment variable with the Python that has rospy; by default the system's `python3`."""
BRIDGE = Path(__file__).with_name("bridge.py")
DEPTH, MOST_DEPTH = 10, 1000
"""Usual and greatest number of messages that wait for a reader."""
UP_S, CHECK_S = 30.0, 0.02
"""How long the bridge may take to come up, and the time between two looks [s, wall]."""
SERVICES: Mapping[str, str] = {"/gazebo/set_model_state": "gazebo_msgs/SetModelState"}
"""The services that are answered with success, where their types are installed.  They change nothing."""
MISSING = "source your ROS 1 environment, or on Debian apt install python3-rospy python3-rosmaster"


@dataclass(eq=False)
class Ros1Border:
    """A border over topics of ROS 1."""

    topics: Sequence[Topic]
    folder: Path
    _clock_s: float = 0.0
    _ends: Ends = field(default_factory=Ends)
    _held: socket.socket | None = None
    _bridge: Processes | None = None
    _lines: LinesBorder = field(init=False)

    def __post_init__(self) -> None:
        self._layouts = {topic.seam: layout_of(topic, LAYOUTS_1) for topic in self.topics}
        self._lines = LinesBorder(self.topics, self.folder, Codec(self._written, self._read))

    @staticmethod
    def misfit(topic: Topic) -> str:
        """What of a topic's settings ROS 1 cannot carry; "" if all of it."""
        try:
            layout_of(topic, LAYOUTS_1)
        except ValueError as error:
            return str(error)
        for name, value in topic.qos.items():
            if name != "depth":
                return f"qos.{name} is nothing that border=ros1 has; allowed: 'depth'"
            if type(value) is not int or not 1 <= value <= MOST_DEPTH:
                return f"qos.depth={value!r} must be a whole number, 1 to {MOST_DEPTH}"
        return ""

    @staticmethod
    def need() -> None:
        """Look for `rospy` and the master.

        Raises:
            InputError: they are missing.
        """
        lacking = unimportable(("rospy", "rosmaster", "rosgraph_msgs"))
        if lacking:
            raise InputError(f"border=ros1 needs {lacking[0]}, which {python()} lacks: {MISSING}")

    @property
    def environment(self) -> Mapping[str, str]:
        """The master of the flight, loopback as its only network, and where ROS writes."""
        assert self._held is not None
        own = self.folder / "ros"
        return {
            "ROS_MASTER_URI": f"http://127.0.0.1:{self._held.getsockname()[1]}",
            "ROS_IP": "127.0.0.1",
            "ROS_HOSTNAME": "127.0.0.1",
            "ROS_HOME": str(own),
            "ROS_LOG_DIR": str(own / "log"),
        }

    def open(self) -> None:
        """Start a master of the flight's own, and the topics.

        Raises:
            BorderError: ROS 1 or a type of message is missing, or the bridge does not come up.
        """
        (self.folder / "ros" / "log").mkdir(parents=True)
        self._held = held_port()
        self._lines.open()
        run = (python(), str(BRIDGE), json.dumps(self._order()))
        self._bridge = Processes([Command(run)], self.folder, self.environment, self.folder / "ros")
        self._bridge.start()
        due_s = time.monotonic() + UP_S
        while self._lines.lacking() and not self._lines.connected:
            ended = self._bridge.ended(CHECK_S)
            if ended or time.monotonic() > due_s:
                said = self._bridge.last_lines(1)
                raise BorderError(f"ROS 1 does not come up: {ended or f'not within {UP_S:g} s'}; {said}: {MISSING}")

    def _order(self) -> Mapping[str, Any]:
        assert self._held is not None
        lacking = unimportable(sorted({kind.partition("/")[0] for kind in SERVICES.values()}))
        return {
            "socket": str(self.folder / "border"),
            "port": self._held.getsockname()[1],
            "topics": [
                {
                    "name": topic.name,
                    "type": self._layouts[topic.seam].type,
                    "outward": topic.outward,
                    "depth": topic.qos.get("depth", DEPTH),
                    "read": list(self._layouts[topic.seam].read),
                }
                for topic in self.topics
            ],
            "services": {name: kind for name, kind in SERVICES.items() if kind.partition("/")[0] not in lacking},
        }

    def lacking(self) -> str:
        """The awaited topics that nobody subscribes to, or publishes; then a moment for the other side."""
        self._stand()
        named = self._lines.named()
        alone = [topic for topic in self.topics if topic.awaited and topic.name not in named]
        unread = [topic.name for topic in alone if topic.outward]
        unsent = [topic.name for topic in alone if not topic.outward]
        return self._ends.lacking(unread, unsent)

    def send(self, seam: str, t_s: float, sample: Any) -> None:
        """Publish a sample, stamped with its own time where it has one."""
        self._clock_s = t_s
        self._lines.send(seam, t_s, sample)

    def clock(self, t_s: float) -> None:
        """Publish the time.

        Raises:
            BorderError: the bridge has ended.
        """
        self._stand()
        self._lines.clock(t_s)

    def wait(self, seam: str, within_s: float) -> bool:
        """Wait for a message; a refused one is none."""
        return self._lines.wait(seam, within_s)

    def take(self, seam: str) -> Arrival:
        """What came, the newest sample last."""
        return self._lines.take(seam)

    def close(self) -> None:
        """End the bridge, and its master."""
        self._lines.close()
        if self._bridge is not None:
            self._bridge.stop()
        if self._held is not None:
            self._held.close()
            self._held = None

    def _stand(self) -> None:
        assert self._bridge is not None
        if ended := self._bridge.ended():
            raise BorderError(f"the bridge to ROS 1: {ended}; {self._bridge.last_lines()}")

    def _written(self, topic: Topic, sample: Any) -> Any:
        layout = self._layouts[topic.seam]
        assert layout.written is not None
        return {
            "fields": _in_text(layout.written(sample)),
            "frame": topic.frame or layout.frame,
            "stamp_s": getattr(sample, "stamp_s", self._clock_s),
        }

    def _read(self, topic: Topic, data: Any, clock_s: float) -> Any:
        return sample_in(topic, self._layouts[topic.seam], data, clock_s)


def _in_text(value: Any) -> Any:
    """The same with bytes in base 64."""
    if isinstance(value, bytes):
        return base64.b64encode(value).decode("ascii")
    if isinstance(value, Mapping):
        return {name: _in_text(entry) for name, entry in value.items()}
    if isinstance(value, list):
        return [_in_text(entry) for entry in value]
    return value


def python() -> str:
    """The Python that has rospy."""
    return os.environ.get(PYTHON) or shutil.which("python3", path="/usr/bin:/bin") or sys.executable


def unimportable(packages: Sequence[str]) -> list[str]:
    """Which of these packages the Python of ROS 1 cannot find; it imports none of them."""
    program = "import sys; from importlib.util import find_spec\nfor p in sys.argv[1:]: print(p, bool(find_spec(p)))"
    try:
        done = subprocess.run(
            [python(), "-c", program, *packages], capture_output=True, text=True, timeout=UP_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return list(packages)
    found = {line.split()[0] for line in done.stdout.splitlines() if line.endswith(" True")}
    return [package for package in packages if package not in found]


def held_port() -> socket.socket:
    """A socket that holds a free port of loopback; the master alone can listen on it, as it reuses addresses."""
    held = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    held.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    held.bind(("127.0.0.1", 0))
    return held


BORDERS.declare("ros1", Ros1Border)
