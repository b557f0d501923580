from __future__ import annotations

SIGNALS = (
    "elapsed_s remaining_s x_m y_m z_m vx_mps speed_mps clearance_m clearance_wall_m clearance_person_m "
    "person_range_m person_sight_m waypoints_left home_m landed light obstacle_pixels waypoint_wall_m told_person "
    "told_range_m limit_mps"
).split()
