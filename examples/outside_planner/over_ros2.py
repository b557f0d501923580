"""The planner as a ROS 2 node: over_ros2.py ROUTE ALTITUDE_M CRUISE_MPS SLOW_MPS; it answers each odometry."""

import json
import math
import sys

import numpy as np
import rclpy
from geometry_msgs.msg import PoseArray, Twist
from nav_msgs.msg import Odometry
from planner import Planner
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Empty
