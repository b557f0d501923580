"""The JSON Schemas of `sim/vehicle.yaml` and `sim/sensors.yaml`."""

from __future__ import annotations

from scaloft_fi.sim.sensors.body import ImuConfig
from scaloft_fi.sim.vehicle import LARGEST, SMALLEST
from scaloft_fi.views.documents.build import Schema, listed, mapping, number, numbers
from scaloft_fi.views.documents.declared import Declared
from scaloft_fi.views.documents.docstrings import attributes_of, summary_of
from scaloft_fi.views.documents.probe import probed

SENSOR_KEYS = {
    "width": "columns of the picture [pixel]",
    "height": "rows of the picture [pixel]",
    "fov_deg": "width of the view [deg]",
    "ahead_m": "how far ahead of the vehicle's centre the camera sits [m]",
    "bearing_sigma_deg": "standard deviation of the bearing [deg]",
    "yaw_sigma_deg": "standard deviation of the heading [deg]",
    "cells": "number of cells in series",
}
"""Keys whose settings have another name or unit in the code."""


def vehicle(_: Declared) -> Schema:
    """`sim/vehicle.yaml`."""
    positive = {"least": SMALLEST, "most": LARGEST}
    spin = {"enum": [1, -1], "description": "1 or -1"}
    return mapping(
        "The vehicle: a rigid hull with four rotors.  Body axes: x forward, y left, z up.",
        {
            "mass_kg": number("mass", "kg", 1.5, **positive),
            "inertia_kgm2": numbers("principal moments of inertia x, y, z", 3, "kg m2, body", **positive),
            "hull_m": numbers(
                "edges x, y, z of the hull, a box about the centre", 3, "m, body", (0.47, 0.47, 0.11), **positive
            ),
            "rotors_m": listed(
                "places x, y of the four rotors [m, body]",
                numbers("place of a rotor", 2, "m, body", least=-LARGEST, most=LARGEST),
                least=4,
                most=4,
            ),
            "spins": listed("direction of each rotor's torque about body z", spin, least=4, most=4),
            "moment_m": number("rotor torque per thrust", "m", 0.06, **positive),
            "max_thrust_n": number("greatest thrust of one rotor; four must lift the mass", "N", 10.35, **positive),
            "spin_up_s": number("time constant of a rising thrust", "s", 0.0125, **positive),
            "spin_down_s": number("time constant of a falling thrust", "s", 0.025, **positive),
            "drag_ns_per_m": number("drag force per speed", "N s/m", 0.2, least=0, most=LARGEST),
        },
    )


def sensors(declared: Declared) -> Schema:
    """`sim/sensors.yaml`."""
    needed = {"imu": _sensor(ImuConfig.read, "The inertial sensor, 240 Hz.")}
    optional: dict[str, Schema] = {}
    for name, kind in declared.sensors.items():
        if kind.read is None and kind.required:
            continue  # it has no settings, so no entry
        about = (
            f"The sensor {name}, {20.0 / kind.period_ticks:g} Hz."
            if kind.read
            else f"The sensor {name}; it has no settings."
        )
        schema = _sensor(kind.read, about) if kind.read else mapping(about, {})
        (needed if kind.required else optional)[name] = schema
    return mapping("The sensors: the stack gets data of the simulator only through them.", needed, optional)


def _sensor(read: object, about: str) -> Schema:
    config = getattr(read, "__self__", None)
    told = {**attributes_of(config), **SENSOR_KEYS} if isinstance(config, type) else SENSOR_KEYS
    more = f"  {summary_of(config)}" if isinstance(config, type) else ""
    assert callable(read)
    return probed(read, about + more, told, closed=True)
