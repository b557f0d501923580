"""The scenario of a flight: the world of the situation, the mission, and the times derived from them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from scaloft_fi.sim.mine import WallPoint
from scaloft_fi.sim.sensors import SensorsConfig
from scaloft_fi.sim.sensors.camera import look
from scaloft_fi.sim.situation import Situation
from scaloft_fi.sim.vehicle import Vehicle
from scaloft_fi.sim.world import ROLES, Point, World

TIME_LIMIT_S, TIME_LIMIT_FACTOR = 20.0, 1.5
"""A flight may last 20 s + 1.5 x the nominal mission time (definition of OP1)."""

NEAR_HOME_M = 0.5
"""A waypoint closer to home than this counts as home [m]."""
SIGHTED_PIXELS = 25
"""A person with at least this number of pixels is in view."""
LOOK_EVERY_S = 0.2


class Leg(NamedTuple):
    """A piece of the nominal flight at constant speed.  start, end: position (3,) [m, world] and heading [rad]."""

    duration_s: float
    start: tuple[float, float, float, float]
    end: tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Scenario:
    """World, vehicle, sensors and nominal flight of a situation.

    Attributes:
        situation: the point of the grid.
        world: mine, bodies, mission, light.
        vehicle: the vehicle.
        sensors: settings of the sensors.
    """

    situation: Situation
    world: World
    vehicle: Vehicle
    sensors: SensorsConfig

    @property
    def key(self) -> str:
        """Key of the situation."""
        return self.situation.key

    @cached_property
    def home(self) -> Point:
        """Start and end of the mission, on the floor [m, world]."""
        return (*self.world.mission.home, self.world.floor_m)

    @property
    def route(self) -> tuple[Point, ...]:
        """The waypoints of the mission in order; it lands at the last one [m, world]."""
        return self.world.route

    @property
    def persons(self) -> tuple[str, ...]:
        """Names of the persons that are present."""
        return self.world.bodies_with(lambda role: role.is_person)

    @cached_property
    def labels(self) -> Mapping[str, str]:
        """Class label of each body that the person detector finds, by the body's name."""
        bodies = self.world.bodies
        return {name: ROLES[bodies[name].role].label for name in self.world.bodies_with(lambda role: role.label)}

    @property
    def start(self) -> Point:
        """Centre of the vehicle when it stands at home [m, world]."""
        x, y, floor_m = self.home
        return x, y, floor_m + self.vehicle.half_height_m

    @cached_property
    def first_leg(self) -> tuple[Point, Point]:
        """Start and end of the first leg that leads away from home [m, world]."""
        x0, y0 = self.world.mission.home
        end = next((p for p in self.route if math.hypot(p[0] - x0, p[1] - y0) > NEAR_HOME_M), self.route[0])
        return (x0, y0, end[2]), end

    @cached_property
    def wall_right(self) -> WallPoint | None:
        """The point on the wall right of the first leg that is nearest to the leg's middle; None without a wall."""
        (x0, y0, z), (x1, y1, _) = self.first_leg
        return self.world.mine.wall_towards(((x0 + x1) / 2, (y0 + y1) / 2, z), (y1 - y0, x0 - x1))

    @cached_property
    def nominal_s(self) -> float:
        """Nominal mission time [s]: climb, turns, legs at cruise speed (slow speed with a person present), landing."""
        mission = self.world.mission
        return sum(leg.duration_s for leg in self._legs(mission.slow_mps if self.persons else mission.cruise_mps))

    @cached_property
    def t_max_s(self) -> float:
        """Time limit of a flight [s]."""
        return TIME_LIMIT_S + TIME_LIMIT_FACTOR * self.nominal_s

    @cached_property
    def sighting_s(self) -> float | None:
        """Time at which the nominal flight first has a person in view [s]; None if it never has."""
        around = self.world.surroundings()
        scene, persons = around.scene, [around.scene.names.index(name) for name in self.persons]
        begun_s = 0.0
        for leg in self._legs(self.world.mission.cruise_mps) if persons else ():
            for k in range(math.ceil(leg.duration_s / LOOK_EVERY_S)):
                share = k * LOOK_EVERY_S / leg.duration_s
                x, y, z, yaw = ((1.0 - share) * a + share * b for a, b in zip(leg.start, leg.end, strict=True))
                around.update(begun_s + k * LOOK_EVERY_S, x, y)
                attitude = np.array([0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)])
                view = look(scene, self.sensors.depth.camera, np.array([x, y, z]), attitude)
                if any(np.count_nonzero(view.segments == person) >= SIGHTED_PIXELS for person in persons):
                    return begun_s + k * LOOK_EVERY_S
            begun_s += leg.duration_s
        return None

    def _legs(self, speed_mps: float) -> Iterator[Leg]:
        """The nominal flight: climb; for each waypoint turn on the spot and fly straight; descend where it ends."""
        mission = self.world.mission
        nominal = mission.nominal
        x, y, floor_m = self.home
        z, yaw = mission.altitude_m, mission.yaw_rad
        yield Leg((z - floor_m) / nominal.climb_mps, (x, y, floor_m, yaw), (x, y, z, yaw))
        yield Leg(nominal.dwell_s, (x, y, z, yaw), (x, y, z, yaw))
        for to_x, to_y, to_z in self.route:
            level_m = math.hypot(to_x - x, to_y - y)
            if level_m > 0:
                heading = math.atan2(to_y - y, to_x - x)
                turned = yaw + math.remainder(heading - yaw, 2.0 * math.pi)
                yield Leg(abs(turned - yaw) / math.radians(nominal.turn_degps), (x, y, z, yaw), (x, y, z, turned))
                yaw = turned
            distance_m = math.hypot(level_m, to_z - z) if to_z != z else level_m
            if distance_m > 0:
                yield Leg(distance_m / speed_mps, (x, y, z, yaw), (to_x, to_y, to_z, yaw))
                x, y, z = to_x, to_y, to_z
        yield Leg((z - floor_m) / nominal.sink_mps, (x, y, z, yaw), (x, y, floor_m, yaw))
