"""What does a border cost a tick?  A process that answers each clock at once, in lock step, beside no simulator.

    python benchmarks/border.py [--border lines|ros2] [--ticks N]

A tick sends odometry, a depth image of 64 x 48 pixels, and the clock, and waits for a velocity.  So the time is that of
the border and of the other side's reading; the aim is a median of at most 1.5 ms.  `ros2` needs rclpy.
"""

from __future__ import annotations

from checkout import ROOT  # first: it sets the path and the threads

# isort: split

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from scaloft_fi.outside.exchange import Command, Exchange, OutsideConfig, SeamConfig
from scaloft_fi.stack.declaration import TICK_S, PlainWire
from scaloft_fi.stack.messages import DepthFrame
from scaloft_fi.stack.reference.messages import PoseEstimate

SIZE = (48, 64)
WARM = 100
"""First ticks, which are not counted."""


def echo_lines() -> None:
    """Answer over the border `lines`."""
    from scaloft_fi.outside.client import connect

    border = connect(publishes=["/cmd_vel"])
    for message in border:
        if "clock" in message:
            border.send("/cmd_vel", {"velocity": [0.0, 0.0, 0.0], "turn_radps": 0.0})


def echo_ros2() -> None:
    """Answer as a node of ROS 2."""
    import rclpy
    from geometry_msgs.msg import Twist
    from nav_msgs.msg import Odometry
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import Image

    rclpy.init()
    node = rclpy.create_node("echo")
    orders = node.create_publisher(Twist, "/cmd_vel", 10)
    node.create_subscription(Odometry, "/odom", lambda _: None, 10)
    node.create_subscription(Image, "/depth", lambda _: None, 10)
    node.create_subscription(Clock, "/clock", lambda _: orders.publish(Twist()), 10)
    rclpy.spin(node)


ECHOES = {"lines": echo_lines, "ros2": echo_ros2}


def ticks_ms(border: str, ticks: int) -> Any:
    """The wall time of each tick, (ticks,) [ms]."""
    config = OutsideConfig(
        border=border,
        below="flight_control",
        processes=(Command(("{python}", str(Path(__file__).resolve()), "--echo", border)),),
        seams={
            "pose": SeamConfig("/odom", "odometry"),
            "depth": SeamConfig("/depth", "depth"),
            "drive": SeamConfig("/cmd_vel", "velocity", frame="world"),
        },
        inside=None,
        answer="drive",
        answer_s=2.0,
    )
    random = np.random.default_rng(0)
    took_ms = []
    exchange = Exchange.begin(config, PlainWire(), ROOT, {})
    try:
        for number in range(WARM + ticks):
            now_s = number * TICK_S
            pose = PoseEstimate(now_s, random.random(3), random.random(3), 0.5, np.array([0.0, 0.0, 0.0, 1.0]))
            offered = {"odometry": pose, "depth": DepthFrame(now_s, 5.0 * random.random(SIZE))}
            begin_s = time.perf_counter()
            taken = exchange.tick(now_s, offered)
            took_ms.append(1e3 * (time.perf_counter() - begin_s))
            assert taken["velocity"] is not None, f"no answer at {now_s:g} s"
    finally:
        exchange.close()
    return np.array(took_ms[WARM:])


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, and print the median and two quantiles."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--border", choices=list(ECHOES), default="lines")
    parser.add_argument("--ticks", type=int, default=2000)
    parser.add_argument("--echo", choices=list(ECHOES), help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.echo:
        ECHOES[options.echo]()
        return
    took_ms = ticks_ms(options.border, options.ticks)
    median, most, worst = np.quantile(took_ms, [0.5, 0.95, 0.99])
    sys.stdout.write(
        f"{options.border}: {options.ticks} ticks, median {median:.2f} ms, 95 % {most:.2f}, 99 % {worst:.2f}\n"
    )


if __name__ == "__main__":
    main()
