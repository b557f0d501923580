"""The record of a flight as a simulator of ROS 2 would leave it: a folder of rosbag2, written without ROS.

Positions are in `nav_msgs/Odometry`, every other number in `std_msgs/Float64` on a topic of its own; `/clock` has the
simulated time, and the simulator ran at four times real time.
"""

from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from scaloft_fi.sim.log import FlightLog

STORE = get_typestore(Stores.ROS2_HUMBLE)
BEGAN_NS, FACTOR = 1_700_000_000_000_000_000, 0.25
"""Wall time of the start, and wall seconds for each simulated one."""


def _message(name, **fields):
    return STORE.types[name](**fields)


def _numbers(name, names, values):
    return _message(name, **dict(zip(names, map(float, values), strict=True)))


def write_bag(path: Path, log: FlightLog, topics: dict[str, str]) -> None:
    """Write the folder.  topics: name of the topic by signal, positions excepted."""
    still = np.zeros(36)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        ticks = writer.add_connection("/clock", "rosgraph_msgs/msg/Clock", typestore=STORE)
        odometry = writer.add_connection("/odom", "nav_msgs/msg/Odometry", typestore=STORE)
        others = {
            signal: writer.add_connection(f"/{topic}", "std_msgs/msg/Float64", typestore=STORE)
            for signal, topic in topics.items()
            if signal not in ("x_m", "y_m", "z_m")
        }
        for i, t_s in enumerate(log.signals["elapsed_s"].tolist()):
            wall_ns, ns = BEGAN_NS + round(t_s * FACTOR * 1e9), round(t_s * 1e9)
            now = _message("builtin_interfaces/msg/Time", sec=ns // 10**9, nanosec=ns % 10**9)
            place = [log.signals[name][i] for name in ("x_m", "y_m", "z_m")]
            turned = [log.signals[name][i] for name in ("qx", "qy", "qz", "qw")]
            zero = _numbers("geometry_msgs/msg/Vector3", "xyz", (0, 0, 0))
            pose = _message(
                "geometry_msgs/msg/Pose",
                position=_numbers("geometry_msgs/msg/Point", "xyz", place),
                orientation=_numbers("geometry_msgs/msg/Quaternion", "xyzw", turned),
            )
            message = _message(
                "nav_msgs/msg/Odometry",
                header=_message("std_msgs/msg/Header", stamp=now, frame_id="world"),
                child_frame_id="base_link",
                pose=_message("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=still),
                twist=_message(
                    "geometry_msgs/msg/TwistWithCovariance",
                    twist=_message("geometry_msgs/msg/Twist", linear=zero, angular=zero),
                    covariance=still,
                ),
            )
            numbers = [
                (connection, _message("std_msgs/msg/Float64", data=float(log.signals[signal][i])))
                for signal, connection in others.items()
            ]
            clock = _message("rosgraph_msgs/msg/Clock", clock=now)
            for to, each in ((ticks, clock), (odometry, message), *numbers):
                writer.write(to, wall_ns, STORE.serialize_cdr(each, to.msgtype))
