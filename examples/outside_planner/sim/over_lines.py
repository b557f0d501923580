"""The planner in a process of its own, over the border `lines`: over_lines.py ROUTE ALTITUDE_M CRUISE_MPS SLOW_MPS."""

import base64
import json
import sys

import numpy as np
from planner import Planner

from scaloft_fi.outside.client import connect


def main(route, *numbers):
    """Answer each clock with a velocity, and land at the end of the route."""
    planner = Planner(json.loads(route), *map(float, numbers))
    border = connect(publishes=["/cmd_vel", "/land"])
    for message in border:
        topic, data = message.get("topic"), message.get("data")
        if topic == "/odom":
            planner.odometry(data["position"], data["yaw_rad"])
        elif topic == "/camera/info":
            planner.camera = data["fx"], data["fy"], data["cx"], data["cy"]
        elif topic == "/camera/depth":
            image = data["depth"]
            flat = np.frombuffer(base64.b64decode(image["data"]), "<f8")
            planner.depth(flat.reshape(image["height"], image["width"]))
        elif topic == "/persons":
            planner.persons([(person["score"], person["range_m"]) for person in data["persons"]])
        elif "clock" in message:
            velocity, turn_radps = planner.order()
            if planner.landing:
                border.send("/land", {"stamp_s": message["clock"]})
            border.send("/cmd_vel", {"velocity": velocity.tolist(), "turn_radps": turn_radps})


if __name__ == "__main__":
    main(*sys.argv[1:])
