"""What an operator may know of a flight: numbers of the study, never the state of the flight."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Facts:
    """Facts of the situation, the vehicle and the sensors.  The defaults serve examples and tests.

    Attributes:
        duration_s: nominal mission time of the situation [s].
        sighting_s: when the nominal flight first sees a person [s]; None when it sees none.
        home_x_m, home_y_m: where the mission starts and ends [m, world].
        cruise_mps, slow_mps: cruise speed, and the speed after a person was seen [m/s].
        bearing_rad: direction of the first leg, along the wall on its right where there is one, from x [rad, world].
        wall_m: point of the wall on the right of the first leg, nearest to its middle [m, world]; None without a wall.
        inward: unit normal of the wall there, into the open space; zero without a wall.
        half_width_m: half of the hull's width [m].
        view_rad: width of the camera's view [rad].
        gyro_sigma_radps, accel_sigma_mps2: white noise of the inertial sensor per sample [rad/s, m/s2]; by default a
            Bosch BMI088 at 120 Hz bandwidth (data sheet: 0.014 deg/s/sqrt(Hz), 175 ug/sqrt(Hz)).
        settings: of the stack, as in `sim/stack.yaml`, for the stack's own operators.
    """

    duration_s: float = 60.0
    sighting_s: float | None = None
    home_x_m: float = 0.0
    home_y_m: float = 0.0
    cruise_mps: float = 0.5
    slow_mps: float = 0.2
    bearing_rad: float = math.pi / 2
    wall_m: tuple[float, float] | None = (1.5, 3.5)
    inward: tuple[float, float] = (-1.0, 0.0)
    half_width_m: float = 0.235
    view_rad: float = math.radians(59.0)
    gyro_sigma_radps: float = 0.0027
    accel_sigma_mps2: float = 0.019
    settings: Mapping[str, Any] = field(default_factory=dict, hash=False)
