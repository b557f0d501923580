"""The observer computes the truth signals of the flight log from the ground truth of the simulator.

The stack under test gets none of these signals.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from scaloft_fi.sim.build import BodyIds, blocked, nearest
from scaloft_fi.sim.contact import Clearances, Contact
from scaloft_fi.sim.happenings import Surroundings
from scaloft_fi.sim.load import Scenario
from scaloft_fi.sim.log import CLEARANCE_CAP_M, FAR_M, NEVER_S, SIGNALS, TOUCH_M, truth_signals
from scaloft_fi.sim.mesh import View
from scaloft_fi.sim.sensors.camera import pixels_of
from scaloft_fi.sim.vehicle import STATE_SIZE, Array, Vehicle
from scaloft_fi.sim.world import GROUND, WALL

PASS_M = 0.5
"""A waypoint counts as passed, and home as near, within this horizontal distance [m]."""
LANDING_MPS, LANDING_TILT_COS = 0.7, math.cos(math.radians(10.0))
"""A landing has a lower sink rate and a smaller tilt than these."""
AIRBORNE_M = 0.3
"""A touchdown counts only after the vehicle's centre has been this high above the floor [m]."""
SIGHT_M = 6.0
"""The line of sight to a person is tested within this range [m]."""
BODY_SHARES = (0.1, 0.5, 0.9)
"""A person is in sight if the line to the nearest point, or to a point at one of these heights on the axis, is free."""


class Observer:
    """Watches one flight.

    Attributes:
        names: names of the values of `sample`, in order.
        struck: name of the first body struck, excused contacts apart; "" before that.
        struck_at_s: time of that contact [s]; NaN before that.
        landed: whether the vehicle has touched down.
        room_m: lower bound of the distance from the hull to any surface at the last sample [m].
    """

    def __init__(
        self, client: int, ids: BodyIds, body: int, vehicle: Vehicle, scenario: Scenario, around: Surroundings
    ) -> None:
        world = scenario.world
        declared = tuple(signal.name for signal in truth_signals(world.surfaces, world.signals))
        self.names = (*declared, *around.names)
        self.struck = ""
        self.struck_at_s = NEVER_S
        self.landed = False
        self._clearances = Clearances(client, ids, body, vehicle, world)
        self._scenario, self._scene, self._surfaces, self._around = scenario, around.scene, world.surfaces, around
        self.room_m = 0.0
        self._range_m = scenario.sensors.depth.max_m
        owners = {name: number for number, name in enumerate(self._scene.names)}
        self._persons: list[tuple[str, int, list[Array]]] = []
        for name in scenario.persons:
            vertices = world.bodies[name].mesh.vertices
            low, high = vertices.min(axis=0), vertices.max(axis=0)
            x, y, _ = 0.5 * (low + high)
            axis = [np.array([x, y, low[2] + share * (high[2] - low[2])]) for share in BODY_SHARES]
            self._persons.append((name, owners[name], axis))
        obstacles = world.bodies_with(lambda role: role.is_obstacle)
        self._obstacles = np.array([name in obstacles for name in self._scene.names])
        self._any_obstacle = bool(self._obstacles.any())
        home = scenario.world.mission.home
        self._route = scenario.route
        self._waypoints = tuple((x, y) for x, y, _ in self._route if (x, y) != home)
        self._home = scenario.home
        self._passed = 0
        self._measures = [SIGNALS[name].measure(scenario) for name in world.signals]
        self._airborne = False
        self._top_square = 0.0
        self._touched: set[str] = set()
        self._foot = np.empty(3)
        self._before: Sequence[float] = (0.0,) * STATE_SIZE

    def step(self, t_s: float, state: Sequence[float], contacts: Iterable[Contact]) -> None:
        """Observe one physics step (240 Hz).

        Args:
            t_s: time at the end of the step [s].
            state: the 13 numbers of the vehicle's state at the end of the step; the observer keeps the reference.
            contacts: contacts during the step.
        """
        vx, vy, vz = state[7:10]
        square = vx * vx + vy * vy + vz * vz
        if square > self._top_square:
            self._top_square = square
        for contact in contacts:
            if contact.struck == GROUND and self._excused(state[0], state[1]):
                self.landed |= self._airborne
            else:
                self._touched.add(contact.struck)
                if not self.struck:
                    self.struck, self.struck_at_s = contact.struck, t_s
        # The motion before the contacts of the next step stop the vehicle.
        self._before = state

    def pass_by(self, top_square: float, state: Sequence[float]) -> None:
        """Observe the steps of a tick in which the vehicle can touch nothing.

        Args:
            top_square: greatest square of the speed after a step [m2/s2].
            state: the 13 numbers of the vehicle's state after the last step; the observer keeps the reference.
        """
        self._top_square = max(self._top_square, top_square)
        self._before = state

    def _excused(self, x: float, y: float) -> bool:
        """Whether contact with the ground at (x, y) is excused: near home, or in a landing."""
        if math.hypot(x - self._home[0], y - self._home[1]) <= PASS_M:
            return True
        qx, qy, sink_mps = self._before[3], self._before[4], -self._before[9]
        return sink_mps < LANDING_MPS and 1.0 - 2.0 * (qx * qx + qy * qy) > LANDING_TILT_COS

    def sample(self, t_s: float, state: Array, view: View | None) -> list[float]:
        """The truth signals at `t_s`, in the order of `names`; resets the maxima and minima since the last sample.

        Args:
            t_s: time [s].
            state: (13,) state of the vehicle.
            view: view of the depth camera; None before the first picture.
        """
        scenario = self._scenario
        x, y, z, qx, qy, qz, qw, vx, vy, vz = state[:10].tolist()
        self._airborne |= z - self._home[2] > AIRBORNE_M
        home_m = math.hypot(x - self._home[0], y - self._home[1])
        excused = self._excused(x, y)
        self._clearances.look((x, y, z, qx, qy, qz, qw), self._around.shifts)
        gaps_m, touched = self._clearances.gaps_m, self._touched
        clearances = {
            name: CLEARANCE_CAP_M
            if gaps_m.get(name, math.inf) >= CLEARANCE_CAP_M and name not in touched
            else self._clearance(name, excused)
            for name in self._surfaces
        }
        person_range_m, person_sight_m = self._person(state)
        clearance_m = self.room_m = min(clearances.values())
        if excused:
            self.room_m = min(clearance_m, self._clearances.gaps_m[GROUND])
        self._pass_waypoints(x, y)
        obstacle_pixels = 0.0
        if view is not None and self._any_obstacle:
            obstacle_pixels = float(pixels_of(view.segments, view.depth, self._obstacles, self._range_m))
        near_waypoint = False
        for wx, wy in self._waypoints:
            if abs(x - wx) <= PASS_M and math.hypot(x - wx, y - wy) <= PASS_M:
                near_waypoint = True
                break
        row = [
            t_s,
            scenario.t_max_s - t_s,
            *(x, y, z, vx, vy, vz, qx, qy, qz, qw),
            math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz)),
            math.sqrt(max(self._top_square, vx * vx + vy * vy + vz * vz)),
            clearance_m,
            person_range_m,
            person_sight_m,
            float(len(self._route) - self._passed),
            home_m,
            float(self.landed),
            self._around.light,
            obstacle_pixels,
            clearances[WALL] if near_waypoint else FAR_M,
            *clearances.values(),
            *[measure(state) for measure in self._measures],
            *self._around.row(),
        ]
        self._top_square = 0.0
        self._touched.clear()
        return row

    def _clearance(self, name: str, excused: bool) -> float:
        """Distance from the hull to a surface [m], at most 1; negative after a contact since the last sample.

        Ground whose contact is excused counts as 1 m away, or every landing would end at clearance 0.
        """
        if name == GROUND and excused:
            return CLEARANCE_CAP_M if name not in self._touched else TOUCH_M
        clearance_m = self._clearances.measure(name)
        if name in self._touched:
            return min(clearance_m, TOUCH_M)
        # Bullet's margins may overlap slightly without a contact; only a contact counts.
        return max(clearance_m, -TOUCH_M)

    def _person(self, state: Array) -> tuple[float, float]:
        """Range of the nearest person's surface, and of the nearest person in sight [m]."""
        scene, centre, foot = self._scene, state[:3], self._foot
        range_m, sight_m = FAR_M, FAR_M
        for name, owner, axis in self._persons:
            distance_m = nearest(scene.vertices, scene.faces, scene.owner, owner, centre, foot)
            range_m = min(range_m, distance_m)
            if distance_m >= min(SIGHT_M, sight_m):
                continue
            by_m = self._around.shifts.get(name)
            points = axis if by_m is None else [point + by_m for point in axis]
            for point in (foot, *points):
                if not blocked(scene.vertices, scene.faces, scene.owner, owner, centre, point):
                    sight_m = distance_m
                    break
        return range_m, sight_m

    def _pass_waypoints(self, x: float, y: float) -> None:
        while self._airborne and self._passed < len(self._route):
            wx, wy, _ = self._route[self._passed]
            if math.hypot(x - wx, y - wy) > PASS_M:
                return
            self._passed += 1
