"""The border `ros1` with a master and nodes of ROS 1, where they can be installed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from processes import alive, soon
from scaloft_ros1.border import Ros1Border, python, unimportable

from scaloft_fi.outside.border import BorderError, Goal, Land, Topic
from scaloft_fi.outside.guard import descendants
from scaloft_fi.stack.messages import Bumper

LACKING = unimportable(("rospy", "rosmaster", "rosgraph_msgs", "geometry_msgs"))
pytestmark = [
    pytest.mark.release,
    pytest.mark.skipif(bool(LACKING), reason=f"the Python of ROS 1 lacks {', '.join(LACKING)}"),
]

TOPICS = (
    Topic("contact", "/contact", Bumper, outward=True),
    Topic("goal", "/goal", Goal, outward=False),
    Topic("land", "/land", Land, outward=False, awaited=False),
)
NODE = """
import sys, rospy
from std_msgs.msg import Bool
from geometry_msgs.msg import PoseStamped
rospy.init_node("node")
goals = rospy.Publisher("/goal", PoseStamped, queue_size=1)
def answer(contact):
    goal = PoseStamped()
    goal.pose.position.x, goal.pose.position.y = float(sys.argv[1]), rospy.get_time()
    goal.pose.position.z = float(contact.data)
    goal.header.stamp = rospy.Time.from_sec(float(sys.argv[2]))
    goals.publish(goal)
rospy.Subscriber("/contact", Bool, answer, queue_size=1)
rospy.spin()
"""


@pytest.fixture
def flight(tmp_path: Path) -> Iterator[Callable[..., Ros1Border]]:
    """A border with a node at its other end, which answers each contact with a goal (x, clock, contact)."""
    borders, nodes = [], []

    def opened(x: float, stamp_s: float = 0.0) -> Ros1Border:
        folder = tmp_path / str(x)
        folder.mkdir()
        border = Ros1Border(TOPICS, folder)
        borders.append(border)
        border.open()
        env = {**os.environ, **border.environment}
        nodes.append(subprocess.Popen([python(), "-c", NODE, str(x), str(stamp_s)], env=env))
        assert soon(lambda: not border.lacking(), within_s=20.0)
        return border

    before = descendants(os.getpid())
    yield opened
    for border in borders:
        border.close()
    for node in nodes:
        node.kill()
        node.wait()
    assert descendants(os.getpid()) - before == set()


def answered(border: Ros1Border, t_s: float, hull: bool = True) -> Goal | None:
    """The goal that answers a contact, a tick after the time was told."""
    border.clock(t_s)
    time.sleep(0.1)
    border.send("contact", t_s, Bumper(t_s, hull=hull, gear=False))
    border.wait("goal", 5.0)
    goal: Goal | None = border.take("goal").sample
    return goal


def test_two_flights_at_once_hear_only_their_own_nodes(flight: Callable[..., Ros1Border]):
    borders = {x: flight(x) for x in (1.0, 2.0)}
    for x, border in borders.items():
        assert answered(border, 7.0 + x, hull=x > 1.5) == Goal((x, 7.0 + x, float(x > 1.5)))


def test_a_message_from_the_future_is_refused(flight: Callable[..., Ros1Border]):
    border = flight(1.0, stamp_s=99.0)
    border.clock(1.0)
    border.send("contact", 1.0, Bumper(1.0, hull=True, gear=False))
    assert not border.wait("goal", 1.0)
    assert border.take("goal").refused == "/goal: stamp_s=99.0 is later than the clock, 1"


def test_the_death_of_the_bridge_is_the_harness(flight: Callable[..., Ros1Border]):
    border = flight(1.0)
    assert border._bridge is not None
    for pid in descendants(os.getpid()):
        if b"bridge" in Path(f"/proc/{pid}/cmdline").read_bytes():
            os.kill(pid, signal.SIGKILL)
    border._bridge.ended(within_s=5.0)
    with pytest.raises(BorderError, match=r"the bridge to ROS 1: bridge\.py was ended by SIGKILL"):
        border.clock(1.0)


def test_a_type_that_is_not_installed_is_the_harness(tmp_path: Path):
    lost = Topic("goal", "/goal", Goal, outward=False, type="lost_msgs/Place", fields={"x": "point.x"})
    border = Ros1Border((lost,), tmp_path)
    with pytest.raises(BorderError, match="No module named 'lost_msgs'"):
        border.open()
    border.close()


def test_nothing_is_left_of_a_flight_that_is_killed(tmp_path: Path):
    program = """
import os, signal, sys
from pathlib import Path
from scaloft_fi.outside.guard import descendants
from scaloft_ros1.border import Ros1Border
border = Ros1Border((), Path(sys.argv[1]))
border.open()
print(*descendants(os.getpid()), flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", program, str(tmp_path)]
    killed = subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=False)
    below = [int(pid) for pid in killed.stdout.split()]
    assert len(below) >= 2
    assert soon(lambda: not any(map(alive, below)), within_s=5.0)
