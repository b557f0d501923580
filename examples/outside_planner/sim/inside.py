"""A stack named `planner_inside`: the same planner, in the process of the flight, over seams of the same names.

It shows what the way over the border costs, and that the border changes no verdict.
"""

import json
from dataclasses import replace

from planner import Planner

from scaloft_fi.outside.border import Land, Motion
from scaloft_fi.outside.stack import OUTSIDE, DeclaredWire, VelocityStack, seams_of, shaped, words_of
from scaloft_fi.sim.stacks import declare_stack


class Round:
    """What `Exchange` is to stages outside: one round over the seams at each tick."""

    complaint = ""

    def __init__(self, config, wire, words):
        self.wire, self.seams = wire, {seam.carries: name for name, seam in config.seams.items()}
        speeds = (float(words[name]) for name in ("altitude_m", "cruise_mps", "slow_mps"))
        self.planner = Planner(json.loads(words["route"]), *speeds)

    def tick(self, now_s, offered):
        """Hand what is offered to the planner, and return its orders."""
        came = {
            port: self.wire.cross(name, now_s, offered[port]) for port, name in self.seams.items() if port in offered
        }
        planner, pose = self.planner, came["odometry"]
        if pose is not None:
            planner.odometry(pose.position, pose.yaw_rad)
        if came["camera_info"] is not None:
            info = came["camera_info"]
            planner.camera = info.fx, info.fy, info.cx, info.cy
        if came["depth"] is not None:
            planner.depth(came["depth"].depth)
        if came["detections"] is not None:
            planner.persons([(person.score, person.range_m) for person in came["detections"].persons])
        order = Motion(*planner.order())
        land = Land(now_s) if planner.landing else None
        cross = self.wire.cross
        return {"velocity": cross(self.seams["velocity"], now_s, order), "land": cross(self.seams["land"], now_s, land)}

    def close(self):
        """Nothing was started."""


def make(task, wire):
    """The stack of one flight."""
    declared = DeclaredWire(wire, [seam.name for seam in seams_of(task.settings)])
    return VelocityStack(task, declared, Round(task.settings, declared, words_of(task)))


declare_stack(
    replace(
        OUTSIDE,
        name="planner_inside",
        make=make,
        rehearse=None,
        shape=lambda settings: replace(
            shaped(settings), name="planner_inside", make=make, rehearse=None, forks=True, deterministic=True
        ),
    )
)
