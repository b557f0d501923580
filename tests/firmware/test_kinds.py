"""The adapters of PX4 and ArduPilot beside a peer that speaks their wire formats, and MAVLink beside pymavlink."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from scaloft_fi.firmware.kind import KINDS, Accelerometer, Firmware, FirmwareConfig, Gyro, Samples, VelocityOrder
from scaloft_fi.firmware.mavlink import News, Talk
from scaloft_fi.outside.border import BorderError
from scaloft_fi.stack.messages import Array, Battery, Fix, MagneticField, Pressure

PEER = Path(__file__).with_name("peer.py")
STILL = Samples(
    Gyro(0.0, np.zeros(3)), Accelerometer(0.0, np.array([0.0, 0.0, 9.81])), None, np.array([0.0, 0.0, 0.0, 1.0]),
    np.zeros(3), 1.65, "takeoff", {"positioning": Fix(0.0, np.zeros(3), 0.0)},
)  # fmt: skip
KINDS_OF_PEERS = ("px4", "ardupilot")


@contextmanager
def booted(kind: str, folder: Path, words: str = "", sensors: tuple[str, ...] = ()) -> Iterator[Firmware]:
    program = folder / "peer"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{PEER}" {words or kind} "$@"\n')
    program.chmod(0o755)
    with closing(KINDS[kind](FirmwareConfig(kind, str(program), "a peer", sensors=sensors), folder, STILL)) as firmware:
        yield firmware


def flown(kind: str, folder: Path) -> list[Array]:
    """Throttles while the drone climbs ahead and to the left, and turns about x."""
    order = VelocityOrder(0.0, np.array([1.0, 2.0, 3.0]), 0.5)
    now = replace(STILL, gyro=Gyro(0.0, np.array([0.25, 0.0, 0.0])), mode="offboard")
    with booted(kind, folder) as firmware:
        return [firmware.step(replace(now, order=order if step % 12 == 0 else None)) for step in range(60)]


@pytest.mark.parametrize("kind", KINDS_OF_PEERS)
def test_a_firmware_is_armed_before_the_flight_and_flies_what_is_ordered(kind: str, tmp_path: Path):
    told = flown(kind, tmp_path)
    assert told[-1] == pytest.approx([0.6, 0.7, 0.8, 0.025], abs=1e-3)
    assert all(np.array_equal(one, two) for one, two in zip(told, flown(kind, tmp_path), strict=True))


@pytest.mark.parametrize("kind", KINDS_OF_PEERS)
def test_a_firmware_that_is_to_stop_is_disarmed(kind: str, tmp_path: Path):
    with booted(kind, tmp_path) as firmware:
        firmware.step(replace(STILL, mode="offboard"))
        assert [firmware.step(replace(STILL, mode="stopped")) for _ in range(3)][-1].tolist() == [0.0] * 4


def test_a_lost_sample_of_the_gyro_reaches_px4_as_none(tmp_path: Path):
    with booted("px4", tmp_path) as firmware:
        turning = replace(STILL, gyro=Gyro(0.0, np.array([5.0, 0.0, 0.0])), mode="offboard")
        assert firmware.step(turning)[3] == pytest.approx(0.5)
        assert firmware.step(replace(STILL, gyro=None, mode="offboard"))[3] == pytest.approx(0.5)


def test_a_lost_sample_of_the_gyro_reaches_ardupilot_as_the_last_that_came(tmp_path: Path):
    with booted("ardupilot", tmp_path) as firmware:
        for gyro in (Gyro(0.0, np.array([5.0, 0.0, 0.0])), None, None):
            throttles = firmware.step(replace(STILL, gyro=gyro, mode="offboard"))
        assert throttles[3] == pytest.approx(0.5, abs=1e-3)


def test_pressure_and_magnetic_field_reach_px4_where_its_sensors_name_them(tmp_path: Path):
    arrived = {"barometer": Pressure(0.0, 1013.75), "magnetometer": MagneticField(0.0, np.array([10.0, 20.0, -30.0]))}
    now = replace(STILL, mode="offboard", arrived=arrived)
    with booted("px4", tmp_path, sensors=("barometer", "magnetometer")) as firmware:
        assert firmware.step(now)[:3] == pytest.approx([0.5, -0.2, 0.3], abs=1e-4)
    with booted("px4", tmp_path) as firmware:
        assert firmware.step(now)[:3] == pytest.approx([0.5] * 3)


def test_the_voltage_of_the_battery_reaches_ardupilot(tmp_path: Path):
    now = replace(STILL, mode="offboard", arrived={"battery": Battery(0.0, 0.9, 15.2, 4)})
    with booted("ardupilot", tmp_path, sensors=("battery",)) as firmware:
        firmware.step(now)
        assert firmware.step(STILL)[0] == pytest.approx(0.152, abs=1e-3)


@pytest.mark.parametrize("kind", KINDS_OF_PEERS)
def test_one_that_does_not_arm_is_the_harnesss_fault_with_its_last_lines(kind: str, tmp_path: Path):
    other = next(one for one in KINDS_OF_PEERS if one != kind)
    said = rf"never was ready for the flight: not armed: .*last lines: as {other}"
    with pytest.raises(BorderError, match=said), booted(kind, tmp_path, other):
        pass


numbers = st.floats(-100.0, 100.0, width=32)


@given(st.tuples(numbers, numbers, numbers), st.floats(-3.0, 3.0, width=32), st.integers(0, 300))
def test_an_order_is_read_by_pymavlink_as_it_was_meant(velocity: tuple[float, ...], yaw_rad: float, said: int):
    talk = Talk()
    for _ in range(said):
        talk.heartbeat()
    (message,) = mavlink.MAVLink(None).parse_buffer(talk.velocity(VelocityOrder(1.5, np.array(velocity), yaw_rad)))
    assert (message.vx, -message.vy, -message.vz, -message.yaw) == (*velocity, yaw_rad)
    assert (message.time_boot_ms, message.get_srcSystem(), message.get_seq()) == (1500, 255, said % 256)


@given(st.binary(max_size=20), st.lists(st.integers(1, 30), max_size=8), st.booleans())
def test_messages_of_pymavlink_are_heard_in_any_pieces_and_among_other_bytes(
    noise: bytes, cuts: list[int], armed: bool
):
    out = mavlink.MAVLink(None, 1, 1)
    base = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0
    heartbeat = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, 12, base, 7, 4, 3).pack(out)
    text = mavlink.MAVLink_statustext_message(4, b"Arming motors").pack(out)
    stream, talk, news = noise.replace(b"\xfd", b"") + heartbeat + text, Talk(), News()
    for cut in cuts:
        for heard in talk.heard(stream[:cut]):
            news.take(*heard)
        stream = stream[cut:]
    for heard in talk.heard(stream):
        news.take(*heard)
    assert (news.armed, news.mode, news.text) == (armed, 7, "Arming motors")
