"""A simple planner: turns to the next waypoint, flies to it around what it has seen, lands at the end of the route.

It knows nothing of how its messages travel: `over_lines.py` and `over_ros2.py` run it in a process of its own, and
`inside.py` in that of the flight.
"""

import math
from dataclasses import dataclass, field

import numpy as np

REACHED_M, ALIGNED_RAD = 0.15, 0.3
CELL_M, SEEN_M, HALF_HEIGHT_M, LEAST_PIXELS = 0.1, 3.0, 0.25, 3
LOOK_M, HALF_WIDTH_M = 1.0, 0.4
SIDEWAYS_RAD = np.radians(np.stack([np.arange(0, 91, 10), -np.arange(0, 91, 10)], axis=1).ravel())
PERSON_M, PERSON_SCORE = 4.5, 0.5
TURN_RADPS, TURN_GAIN, GAIN = 0.7, 1.5, 1.0


@dataclass
class Planner:
    """Follows a route.

    Attributes:
        route: waypoints (x, y, z) in order, the last one where it lands [m, world].
        altitude_m: height of flight above home [m].
        cruise_mps, slow_mps: speed, and speed after the first person [m/s].
        camera: focal lengths and centre (fx, fy, cx, cy) of the depth image [pixel]; None before the first one.
        landing: whether the end of the route is reached.
    """

    route: list
    altitude_m: float
    cruise_mps: float
    slow_mps: float
    camera: tuple | None = None
    landing: bool = False
    index: int = 0
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    yaw_rad: float = 0.0
    person: bool = False
    airborne: bool = False
    cells: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), dtype=int))

    def odometry(self, position, yaw_rad):
        """Take the pose: position [m, world], heading [rad]."""
        self.position, self.yaw_rad = np.asarray(position, dtype=float), float(yaw_rad)

    def persons(self, seen):
        """Take the persons of a picture: pairs of score and range [m]."""
        self.person = self.person or any(score >= PERSON_SCORE and range_m <= PERSON_M for score, range_m in seen)

    def depth(self, image):
        """Take a depth image (H, W) [m], and remember the cells of the ground plan in which something is."""
        if self.camera is None:
            return
        fx, fy, cx, cy = self.camera
        rows, columns = np.indices(image.shape)
        left, up = -(columns - cx) / fx * image, -(rows - cy) / fy * image
        seen = (image > 0.0) & (image < SEEN_M) & (np.abs(up) < HALF_HEIGHT_M)
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        ahead, left = image[seen], left[seen]
        points = np.stack([cos * ahead - sin * left, sin * ahead + cos * left], axis=1) + self.position[:2]
        cells, pixels = np.unique(np.floor(points / CELL_M).astype(int), axis=0, return_counts=True)
        self.cells = np.unique(np.concatenate([self.cells, cells[pixels >= LEAST_PIXELS]]), axis=0)

    def order(self):
        """The velocity [m/s, world] and the rate of turn [rad/s] for this tick."""
        climb_mps = float(np.clip(GAIN * (self.altitude_m - self.position[2]), -0.5, 0.7))
        hover = np.array([0.0, 0.0, climb_mps])
        self.airborne = self.airborne or self.position[2] > self.altitude_m - 0.1
        if not self.airborne or self.landing:
            return hover, 0.0
        way = np.array(self.route[self.index][:2]) - self.position[:2]
        distance_m = float(np.linalg.norm(way))
        if distance_m < REACHED_M:
            self.landing = self.index == len(self.route) - 1
            self.index += not self.landing
            return hover, 0.0
        wanted_rad = math.atan2(way[1], way[0])
        off_rad = math.remainder(wanted_rad - self.yaw_rad, math.tau)
        turn_radps = float(np.clip(TURN_GAIN * off_rad, -TURN_RADPS, TURN_RADPS))
        heading_rad = self.free(wanted_rad, min(LOOK_M, distance_m))
        if abs(off_rad) > ALIGNED_RAD or heading_rad is None:
            return hover, turn_radps
        speed_mps = min(self.slow_mps if self.person else self.cruise_mps, GAIN * distance_m)
        return hover + speed_mps * np.array([math.cos(heading_rad), math.sin(heading_rad), 0.0]), turn_radps

    def free(self, wanted_rad, look_m):
        """The heading nearest to `wanted_rad` in which nothing is remembered near the way; None without one."""
        seen = (self.cells + 0.5) * CELL_M - self.position[:2]
        near = seen[np.hypot(seen[:, 0], seen[:, 1]) < look_m + HALF_WIDTH_M]
        for heading_rad in wanted_rad + SIDEWAYS_RAD:
            cos, sin = math.cos(heading_rad), math.sin(heading_rad)
            along, aside = near @ (cos, sin), near @ (-sin, cos)
            if not np.any((along > 0.0) & (along < look_m) & (np.abs(aside) < HALF_WIDTH_M)):
                return heading_rad
        return None
