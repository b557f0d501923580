"""The planner as a node of ROS 2: over_ros2.py ROUTE ALTITUDE_M CRUISE_MPS SLOW_MPS.

The clock comes last in a tick.  ROS 2 keeps no order between topics, so an answer waits until nothing else has come.
"""

import json
import sys
from contextlib import suppress
from functools import partial

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from planner import Planner
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import Empty

DEPTH = 10


class PlannerNode(Node):
    """Answers each clock with a velocity, and lands at the end of the route."""

    def __init__(self, planner):
        super().__init__("planner")
        self.planner = planner
        self.heard = 0
        self.due = False
        self.velocity = self.create_publisher(Twist, "/cmd_vel", DEPTH)
        self.land = self.create_publisher(Empty, "/land", DEPTH)
        for type_, topic, take in (
            (Odometry, "/odom", self.odometry),
            (CameraInfo, "/camera/info", self.camera),
            (Image, "/camera/depth", self.depth),
            (PointCloud2, "/persons", self.persons),
            (Clock, "/clock", self.clock),
        ):
            self.create_subscription(type_, topic, partial(self.hear, take), DEPTH)

    def hear(self, take, message):
        """Take a message."""
        self.heard += 1
        take(message)

    def odometry(self, message):
        """Take the pose."""
        pose = message.pose.pose
        q = pose.orientation
        yaw_rad = np.arctan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
        self.planner.odometry((pose.position.x, pose.position.y, pose.position.z), yaw_rad)

    def camera(self, message):
        """Take the geometry of the camera."""
        self.planner.camera = message.k[0], message.k[4], message.k[2], message.k[5]

    def depth(self, message):
        """Take a depth image of 32-bit numbers [m]."""
        image = np.frombuffer(message.data, "<f4").reshape(message.height, message.width)
        self.planner.depth(image.astype(float))

    def persons(self, message):
        """Take the persons of a picture: x, y, z [m] and score each."""
        rows = np.frombuffer(message.data, "<f4").reshape(message.width, -1)
        self.planner.persons([(score, np.hypot(x, y)) for x, y, _, score in rows])

    def clock(self, _message):
        """An answer is due."""
        self.due = True

    def answer(self):
        """Order a velocity in the world's frame."""
        self.due = False
        velocity, turn_radps = self.planner.order()
        if self.planner.landing:
            self.land.publish(Empty())
        message = Twist()
        message.linear.x, message.linear.y, message.linear.z = map(float, velocity)
        message.angular.z = float(turn_radps)
        self.velocity.publish(message)


def main(route, *numbers):
    """Run until the flight ends."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        node = PlannerNode(Planner(json.loads(route), *map(float, numbers)))
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        while True:
            heard = node.heard
            executor.spin_once(timeout_sec=0.0 if node.due else None)
            if node.due and node.heard == heard:
                node.answer()


if __name__ == "__main__":
    main(*sys.argv[1:])
