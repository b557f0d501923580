"""The beliefs of the reference stack, as the flight log records them."""

from __future__ import annotations

from scaloft_fi.stack.belief import Belief, Mark

MODES = ("takeoff", "offboard", "hold", "land", "level", "stopped")
"""Modes of flight control; the belief `mode` is a place in this list."""
NOBODY_M = 100.0
"""The belief `told_range_m` while no person counts as reported."""

BELIEFS = (
    Belief(
        "told_person",
        "",
        "1 while the stack counts a person as reported",
        0.0,
        Mark("person", "a person is reported", first=True),
    ),
    Belief("told_range_m", "m", "range of that person; 100 without one", NOBODY_M, most=NOBODY_M),
    Belief("limit_mps", "m/s", "speed limit in force"),
    Belief(
        "collision_flag",
        "",
        "1 while the stack's own collision flag is up",
        0.0,
        Mark("recoil", "the collision flag is raised", colour="#b45309"),
    ),
    Belief("target_index", "", "place in the route of the waypoint flown to"),
    Belief("map_points", "", "occupied cells the planner knows of"),
    Belief("cmd_vx_mps", "m/s", "ordered velocity, world"),
    Belief("cmd_vy_mps", "m/s", "ordered velocity, world"),
    Belief("cmd_vz_mps", "m/s", "ordered velocity, world"),
    Belief("cmd_yaw_rad", "rad", "ordered heading, world"),
    Belief("est_x_m", "m", "estimated position, world"),
    Belief("est_y_m", "m", "estimated position, world"),
    Belief("est_z_m", "m", "estimated position, world"),
    Belief("est_vx_mps", "m/s", "estimated velocity, world"),
    Belief("est_vy_mps", "m/s", "estimated velocity, world"),
    Belief("est_vz_mps", "m/s", "estimated velocity, world"),
    Belief(
        "mode",
        "",
        "what flight control does, by number",
        mark=Mark("mode", "flight control: {}", values=MODES, colour=""),
    ),
)
