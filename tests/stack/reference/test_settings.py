"""The bounds of the reference stack's settings."""

from __future__ import annotations

import pytest
import yaml
from refused import refusal
from studies import build

from scaloft_fi.marks import LARGEST
from scaloft_fi.stack.reference.stack import ReferenceConfig
from tests.stack.conftest import STACK

SETTINGS = {key: one for key, one in yaml.safe_load(STACK.read_text()).items() if key != "name"}
NUMBERS = [
    (part, key) for part, entries in SETTINGS.items() for key in entries if key not in ("label", "law", "rotors")
]


def changed(part: str, key: str, value: object) -> str:
    return refusal(build, ReferenceConfig, SETTINGS | {part: SETTINGS[part] | {key: value}})


@pytest.mark.parametrize(
    ("part", "key", "value", "allowed"),
    [
        ("battery", "low_charge", 15, ">= 0 and <= 1"),
        ("battery", "critical_charge", 7, ">= 0 and <= 1"),
        ("speed_limit", "min_score", 50, ">= 0 and <= 1"),
        ("speed_limit", "max_range_m", -4.5, ">= 1e-06"),
        ("planner", "elevation_limit_deg", 120, ">= 0 and <= 90"),
        ("recoil", "timeout_s", -3, ">= 0"),
    ],
)
def test_a_setting_out_of_range_is_refused_with_what_is_allowed(part: str, key: str, value: float, allowed: str):
    assert f"{key}={value} must be {allowed}" in changed(part, key, value)


@pytest.mark.parametrize(("part", "key"), NUMBERS, ids=lambda one: one)
def test_every_number_has_bounds_of_its_own(part: str, key: str):
    told = SETTINGS[part][key]
    value = [-LARGEST, *told[1:]] if isinstance(told, list) else -LARGEST
    assert f"{key}{'[0]' if isinstance(told, list) else ''}=-1000000000.0 " in changed(part, key, value)


def test_flight_control_has_four_rotors_that_turn_one_way_or_the_other():
    assert "rotors=[...] must be a list of 4 values" in changed("control", "rotors", SETTINGS["control"]["rotors"][:3])
    assert "spins[3]=0 must be 1 or -1" in changed("control", "spins", [1, 1, -1, 0])
