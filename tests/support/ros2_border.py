"""Opens a border of ROS 2 beside a node that talks to it, and prints as JSON what came of it."""

import contextlib
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import BatteryState, Image, PointCloud2

from scaloft_fi.outside.border import Motion, Topic
from scaloft_fi.outside.ros2 import MOST_MESSAGES, Ros2Border
from scaloft_fi.stack.messages import Battery, DepthFrame, Detections, Person
from scaloft_fi.stack.reference.messages import PoseEstimate

TURNED = (0.0, 0.0, np.sin(np.pi / 4), np.cos(np.pi / 4))
TOPICS = (
    Topic("pose", "/odom", PoseEstimate, outward=True),
    Topic("depth", "/depth", DepthFrame, outward=True, qos={"reliability": "best_effort", "depth": 1}),
    Topic("person", "/persons", Detections, outward=True),
    Topic(
        "charge", "/charge", Battery, outward=True, type="sensor_msgs/msg/BatteryState", fields={"voltage": "charge"}
    ),
    Topic("drive", "/cmd", Motion, outward=False, type="geometry_msgs/msg/TwistStamped"),
)
WITHIN_S = 5.0


class Node:
    """The other side."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("other", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.got = {}
        for type_, name in ((Odometry, "/odom"), (PointCloud2, "/persons"), (BatteryState, "/charge")):
            self.node.create_subscription(type_, name, lambda message, name=name: self.got.update({name: message}), 10)
        self.node.create_subscription(
            Image, "/depth", lambda message: self.got.update({"/depth": message}), rclpy.qos.qos_profile_sensor_data
        )
        self.orders = self.node.create_publisher(TwistStamped, "/cmd", 10)

    def order(self, speed_mps: float, stamp_s: float = 0.0, count: int = 1) -> None:
        message = TwistStamped()
        message.header.stamp.sec = int(stamp_s)
        message.twist.linear.x = speed_mps
        for _ in range(count):
            self.orders.publish(message)

    def hear(self) -> None:
        due_s = time.monotonic() + WITHIN_S
        while len(self.got) < 4 and time.monotonic() < due_s:
            self.executor.spin_once(timeout_sec=0.1)

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.shutdown()


def taken(border: Ros2Border) -> dict[str, object]:
    came = border.wait("drive", 0.5)
    arrival = border.take("drive")
    speed = None if arrival.sample is None else float(arrival.sample.velocity[0])
    return {"came": came, "speed": speed, "count": arrival.count, "refused": arrival.refused}


def ports_of_this_process() -> list[str]:
    """The addresses of the UDP sockets of this process, in hexadecimal as Linux has them."""
    inodes = set()
    for path in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):  # it has been closed
            inodes.add(str(path.readlink()).removeprefix("socket:[").rstrip("]"))
    lines = Path("/proc/self/net/udp").read_text().splitlines()[1:]
    return [line.split()[1].partition(":")[0] for line in lines if line.split()[9] in inodes]


def main() -> dict[str, object]:
    folder = Path(tempfile.mkdtemp())
    (folder / "second").mkdir()
    border, second = Ros2Border(TOPICS, folder), Ros2Border(TOPICS, folder / "second")
    border.open()
    second.open()
    domains = [int(one.environment["ROS_DOMAIN_ID"]) for one in (border, second)]
    told = {"domains": domains, "alone": border.lacking()}
    node = Node(domains[0])
    due_s = time.monotonic() + WITHIN_S
    while border.lacking() and time.monotonic() < due_s:
        time.sleep(0.02)
    told |= {"lacking": border.lacking(), "second": second.lacking(), "addresses": ports_of_this_process()}
    border.send("pose", 1.0, PoseEstimate(1.25, np.array([1.0, 2.0, 3.0]), np.array([0.0, 1.0, 0.0]), 1.57, TURNED))
    border.send("depth", 1.0, DepthFrame(1.0, np.array([[0.0, 1.5], [2.5, 3.5]])))
    border.send("person", 1.0, Detections(1.0, (Person("person", 0.75, 0.0, 4.0),)))
    border.send("charge", 1.0, Battery(1.0, 0.5, 15.0, 4))
    border.clock(1.0)
    node.hear()
    pose, depth, persons = node.got["/odom"], node.got["/depth"], node.got["/persons"]
    told |= {
        "stamp": [pose.header.stamp.sec, pose.header.stamp.nanosec],
        "position": [pose.pose.pose.position.x, pose.pose.pose.position.y],
        "ahead_mps": round(pose.twist.twist.linear.x, 6),
        "frames": [pose.header.frame_id, pose.child_frame_id, depth.header.frame_id],
        "depth": [None if np.isnan(one) else float(one) for one in np.frombuffer(depth.data, "<f4")],
        "person": np.frombuffer(persons.data, "<f4").tolist(),
        "columns": [one.name for one in persons.fields],
        "mapped": node.got["/charge"].voltage,
    }
    node.order(0.5)
    told["order"] = taken(border)
    node.order(0.6)
    time.sleep(0.3)
    border.clock(1.05)
    told["late"] = {"came": border.wait("drive", 0.05), "speed": float(border.take("drive").sample.velocity[0])}
    node.order(float("nan"))
    told["nan"] = taken(border)
    node.order(0.5, stamp_s=9.0)
    told["future"] = taken(border)
    node.order(0.7, count=5 * MOST_MESSAGES)
    time.sleep(0.3)
    told["flood"] = taken(border)
    node.close()
    border.close()
    border.close()
    second.close()
    return told


if __name__ == "__main__":
    sys.stdout.write(json.dumps(main()))
    sys.stdout.flush()
    os._exit(0)  # the middleware may take its time
