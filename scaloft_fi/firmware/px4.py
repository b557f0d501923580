"""PX4's SITL over `simulator_mavlink`: HIL_SENSOR moves its time, its own EKF2 estimates from the position fix.

The program is the client of port 4560; orders go to port 14580.  Frames are north, east, down in the study's x, -y, -z.
Its start script runs commands of the program beside it, `px4-*`, in the shell; they are no part of the flight.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from scaloft_fi.firmware.kind import (
    ACCELEROMETER,
    BAROMETER,
    GYRO,
    MAGNETOMETER,
    POSITION,
    VELOCITY,
    FirmwareConfig,
    Samples,
    VelocityOrder,
)
from scaloft_fi.firmware.mavlink import ARM, SENSORS, SET_MODE, VISION, News, Talk
from scaloft_fi.firmware.program import Datagram, FirmwareError, Program
from scaloft_fi.stack.declaration import STEP_HZ, STEPS_PER_TICK, Seam
from scaloft_fi.stack.messages import Array

SENSED, ORDERS, TOLD = 4560, 14580, 14540
"""Ports: sensors and motors; orders to it; what it tells a ground station."""
BOOT_S, ARMED_S = 12.0, 16.0
"""Its filter uses the position; it is armed [s from power on]."""
OFFBOARD = 6
FIELDS, MAGNETIC_FIELDS, PRESSURE_FIELDS = 0b111111, 0b111000000, 0b1101000000000
"""What is new in a frame: acceleration and angular rate; magnetic field; pressure and temperature."""
GAUSS_PER_UT = 0.01
DITHER = 0.01
"""A sensor that repeats itself is taken for dead: what shakes accelerometer [m/s2] and gyro [rad/s] during the boot."""
SCRIPT = "start.sh"
PARAMETERS = {
    "MAV_SYS_ID": 1, "MAV_TYPE": 2, "MAV_PROTO_VER": 2,
    **{f"CAL_{sensor}{number}_ID": device for number, device in enumerate((1310988, 1310996, 1311004))
       for sensor in ("ACC", "GYRO")}, "SENS_BOARD_X_OFF": 0.000001,
    "SYS_HAS_MAG": 0, "SYS_HAS_BARO": 0, "SYS_HAS_GPS": 0, "SENS_IMU_MODE": 1, "IMU_INTEG_RATE": 250,
    "IMU_GYRO_RATEMAX": 800, "EKF2_MULTI_IMU": 0, "EKF2_EV_CTRL": 11, "EKF2_HGT_REF": 3, "EKF2_EV_DELAY": 0,
    "EKF2_GPS_CTRL": 0, "EKF2_BARO_CTRL": 0, "EKF2_MAG_TYPE": 5,
    "COM_RC_IN_MODE": 4, "NAV_RCL_ACT": 0, "NAV_DLL_ACT": 0, "COM_RCL_EXCEPT": 7, "COM_CPU_MAX": -1,
    "COM_DISARM_PRFLT": -1, "CBRK_SUPPLY_CHK": 894281, "SDLOG_MODE": -1, "CA_AIRFRAME": 0, "CA_ROTOR_COUNT": 4,
    **{f"PWM_MAIN_FUNC{number}": 100 + number for number in range(1, 5)},
}  # fmt: skip
"""Parameters of every study's PX4, before the study's own, which have its rotors: only an inertial sensor, position and
heading from outside, no remote control."""
FUSED: Mapping[str, Mapping[str, float]] = {
    "barometer": {"SYS_HAS_BARO": 1, "EKF2_BARO_CTRL": 1, "EKF2_HGT_REF": 0, "EKF2_BARO_NOISE": 0.2},
    "magnetometer": {
        "SYS_HAS_MAG": 1,
        "CAL_MAG0_ID": 197388,
        "CAL_MAG0_PRIO": 50,
        "EKF2_MAG_TYPE": 1,
        "EKF2_EV_CTRL": 3,
    },
}
"""What they are where a study's PX4 gets these sensors: height from the barometer, heading from the magnetometer.

With its own 3.5 m for the barometer's noise, of which ours has 0.1 m, it does not learn within a flight the bias of the
accelerometer, which it has not met while it booted, and climbs at 0.13 m/s where it is ordered to hold its height.
"""
MODULES = (
    "dataman start -r", f"simulator_mavlink start -c {SENSED}", "load_mon start", "rc_update start",
    "manual_control start", "sensors start", "commander start", "ekf2 start", "pwm_out_sim start -m sim",
    "control_allocator start", "mc_rate_control start", "mc_att_control start", "mc_hover_thrust_estimator start",
    "flight_mode_manager start", "mc_pos_control start", "land_detector start multicopter", "navigator start",
    f"mavlink start -x -u {ORDERS} -r 4000000 -m onboard -o {TOLD}", "mavlink boot_complete",
)  # fmt: skip
"""What its start script starts, in order."""


class Px4:
    """PX4 under way, for `FirmwareKind` and `Firmware`."""

    seams = (GYRO, ACCELEROMETER, POSITION, VELOCITY)
    further: Mapping[str, Seam] = {"barometer": BAROMETER, "magnetometer": MAGNETOMETER}

    def __init__(self, config: FirmwareConfig, study: Path, still: Samples) -> None:
        program, *more = config.run(study)
        own = [text.decode("utf-8", "replace") for text in config.content(study).values()]
        settings = dict(PARAMETERS)
        for sensor in config.sensors:
            settings |= FUSED[sensor]
        lines = [f"param set {name} {value}" for name, value in settings.items()]
        self._sensors = frozenset(config.sensors)
        script = "\n".join((". px4-alias.sh", "param select parameters.bson", *lines, *own, *MODULES, ""))
        # the number is in the names of files outside the folder of the flight, so no two flights have the same
        instance = os.getpid()
        elsewhere = [Path(f"/tmp/px4-sock-{instance}"), Path(f"/tmp/px4_lock-{instance}")]
        self._steps, self._talk, self._news = 0, Talk(), News()
        run = (program, "-d", "-i", str(instance), *more, "-s", SCRIPT)
        self._program = Program.start(run, {SCRIPT: script.encode(), "etc/empty": b""}, study, elsewhere)
        with self._program.booting("PX4"):
            yaw_rad = 2.0 * math.atan2(still.attitude[2], still.attitude[3])
            self._orders = VelocityOrder(0.0, np.zeros(3), yaw_rad)
            while self._now_s < ARMED_S:
                arrived = still.arrived if self._steps % STEPS_PER_TICK == 0 else {}
                self._advance(replace(still, arrived=arrived), self._boot_orders())
            if not self._news.armed:
                raise FirmwareError(f"not armed: {self._news.text or 'it says nothing'}{self._program.said()}")

    @property
    def _now_s(self) -> float:
        return self._steps / STEP_HZ

    def _boot_orders(self) -> bytes:
        if self._now_s < BOOT_S - 4.0:
            return b""
        orders = b""
        if self._steps % round(STEP_HZ) == 0:
            orders += self._talk.heartbeat()
            if self._now_s >= BOOT_S and not self._news.armed:
                orders += self._talk.command(SET_MODE, 1.0, OFFBOARD) + self._talk.command(ARM, 1.0)
        if self._steps % STEPS_PER_TICK == 0:
            orders += self._talk.velocity(self._orders)
        return orders

    def step(self, samples: Samples) -> Array:
        """Move on by one physics step."""
        orders = self._talk.heartbeat() if self._steps % round(STEP_HZ) == 0 else b""
        if isinstance(samples.order, VelocityOrder):
            orders += self._talk.velocity(samples.order)
        if not samples.armed:
            orders += self._talk.command(ARM, 0.0, 21196.0)
        return self._advance(samples, orders)

    def close(self) -> None:
        """End the program."""
        self._program.close()

    def _advance(self, samples: Samples, orders: bytes) -> Array:
        time_us = round(self._now_s * 1e6) + 1
        datagrams = [Datagram(ORDERS, orders)] if orders else []
        sensed = b""
        if samples.gyro is not None and samples.accelerometer is not None:
            rate, force = samples.gyro.rate.tolist(), samples.accelerometer.force.tolist()
            still = self._now_s < ARMED_S
            shaken = DITHER * (-1.0) ** self._steps * (1.0 + 0.1 * (self._steps % 7)) if still else 0.0
            numbers = (force[0] + shaken, -force[1] + shaken, -force[2] + shaken, rate[0] + shaken,
                       -rate[1] + shaken, -rate[2] + shaken)  # fmt: skip
            field, pressure_hpa, fields = (0.0, 0.0, 0.0), 1013.25, FIELDS
            if "magnetometer" in self._sensors and (magnetic := samples.arrived.get("magnetometer")) is not None:
                x, y, z = (GAUSS_PER_UT * magnetic.field + 0.1 * shaken).tolist()
                field, fields = (x, -y, -z), fields | MAGNETIC_FIELDS
            if "barometer" in self._sensors and (pressure := samples.arrived.get("barometer")) is not None:
                pressure_hpa, fields = pressure.pressure_hpa + shaken, fields | PRESSURE_FIELDS
            rest = (*field, pressure_hpa, 0.0, 0.0, 20.0)
            sensed += self._talk.said(SENSORS, time_us, *numbers, *rest, fields, 0)
        fix = samples.fix
        if fix is not None:
            x, y, z = fix.position.tolist()
            spread = [0.0] * 21
            sensed += self._talk.said(VISION, time_us, x, -y, -z, 0.0, 0.0, -fix.yaw_rad, *spread, 0)
        self._steps += 1
        datagrams.append(Datagram(SENSED, sensed))
        for answer in self._program.step(round(self._steps * 1e9 / STEP_HZ), datagrams):
            if answer.port in (SENSED, ORDERS, TOLD):
                for number, payload in self._talk.heard(answer.data):
                    self._news.take(number, payload)
        return self._news.throttles
