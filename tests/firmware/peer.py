"""A stand-in for PX4 or ArduPilot, with the wire formats of pymavlink: it arms when told, and flies what is ordered.

    peer.py px4|ardupilot [arguments of the firmware]

Its throttles tell what it heard: front right 0.5 and the ordered velocity ahead, rear left 0.5 and that to the left,
front left 0.5 and that upwards (each / 10), rear right the angular rate about x that it sensed (/ 10).  Once it sensed
pressure and a magnetic field, or a voltage, the first three tell of that: of PX4 the pressure above 1013.25 [hPa], and
the field's y and z [G], of ArduPilot a hundredth of the voltage [V].
"""

from __future__ import annotations

import json
import select
import socket
import struct
import sys

from pymavlink.dialects.v20 import common as mavlink

HOST = "127.0.0.1"
state = {"armed": False, "mode": 0, "order": (0.0, 0.0, 0.0), "rate": 0.0, "fixes": 0, "told": None}


def hear(parser: mavlink.MAVLink, data: bytes) -> list[mavlink.MAVLink_message]:
    return parser.parse_buffer(data) or []


def take(message: mavlink.MAVLink_message) -> None:
    kind = message.get_type()
    if kind == "COMMAND_LONG" and message.command == mavlink.MAV_CMD_DO_SET_MODE:
        state["mode"] = int(message.param2)
    elif kind == "COMMAND_LONG" and message.command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
        state["armed"] = message.param1 == 1.0
    elif kind == "PARAM_SET" and message.param_id == "SIM_BATT_VOLTAGE":
        state["told"] = (message.param_value / 100.0, 0.0, 0.0)
    elif kind == "SET_POSITION_TARGET_LOCAL_NED":
        assert (message.type_mask, message.coordinate_frame) == (0b100111000111, mavlink.MAV_FRAME_LOCAL_NED)
        state["order"] = (message.vx, -message.vy, -message.vz)


def throttles() -> list[float]:
    if not state["armed"]:
        return [0.0] * 4
    if state["told"] is not None:
        return [*state["told"], state["rate"] / 10.0]
    return [*(0.5 + part / 10.0 for part in state["order"]), state["rate"] / 10.0]


def heartbeat() -> mavlink.MAVLink_message:
    base = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if state["armed"] else 0
    return mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, 12, base, state["mode"], 4, 3)


def px4() -> None:
    sensors, orders, out = socket.socket(), socket.socket(type=socket.SOCK_DGRAM), mavlink.MAVLink(None, 1, 1)
    sensors.connect((HOST, 4560))
    orders.bind((HOST, 14580))
    parsers, frames = {sensors: mavlink.MAVLink(None), orders: mavlink.MAVLink(None)}, 0
    while True:
        for ready in select.select([sensors, orders], [], [])[0]:
            for message in hear(parsers[ready], ready.recv(65536)):
                take(message)
                if message.get_type() == "VISION_POSITION_ESTIMATE":
                    state["fixes"] += 1
                elif message.get_type() == "HIL_SENSOR":
                    state["rate"] = message.xgyro
                    if message.fields_updated & 0b1101111000000 == 0b1101111000000:
                        state["told"] = (message.abs_pressure - 1013.25, message.ymag, message.zmag)
                    frames += 1
                    controls = [*throttles(), *[0.0] * 12]
                    answer = mavlink.MAVLink_hil_actuator_controls_message(message.time_usec, controls, 0, 0)
                    sensors.send(answer.pack(out))
                    if frames % 100 == 0:
                        orders.sendto(heartbeat().pack(out), (HOST, 14540))


def ardupilot() -> None:
    console, frame = socket.socket(), socket.socket(type=socket.SOCK_DGRAM)
    console.bind((HOST, 5760))
    console.listen()
    talk, _ = console.accept()
    talk.setblocking(False)
    parser, out, count = mavlink.MAVLink(None), mavlink.MAVLink(None, 1, 1), 0
    while True:
        pulses = [round(1000 + 1000 * throttle) for throttle in throttles()]
        frame.sendto(struct.pack("<HHI16H", 18458, 480, count, *pulses, *[0] * 12), (HOST, 9002))
        text = frame.recv(65536).decode()
        assert " " not in text
        sensed = json.loads(text)
        state["rate"] = sensed["imu"]["gyro"][0]
        count += 1
        try:
            for message in hear(parser, talk.recv(65536)):
                take(message)
        except BlockingIOError:
            pass
        if count % 100 == 0:
            talk.send(heartbeat().pack(out))


if __name__ == "__main__":
    sys.stdout.write(f"as {sys.argv[1]}\n")
    sys.stdout.flush()
    {"px4": px4, "ardupilot": ardupilot}[sys.argv[1]]()
