#!/usr/bin/env python3
"""A flight control of 50 lines: it holds the tilt, the turn rate and the throttle that it is told, by gyro and gravity.

It speaks the lines of `scaloft_fi/firmware/lines.py` over UDP, and reads no clock but the one in them.
"""

import json
import math
import socket

TILT_P, RATE_P, TURN_P = 6.0, 0.08, 0.4
"""Gains of tilt [1/s], of the rates of roll and pitch, and of the turn rate [throttle s/rad]."""
LEAN_ON = 0.002
"""Share of the accelerometer in the estimated tilt, each step."""
SIGNS = ((-1, -1, -1), (1, 1, -1), (1, -1, 1), (-1, 1, 1))
"""What roll, pitch and turn do to front right, rear left, front left, rear right."""


class Autopilot:
    """The tilt that it believes in [rad], and its last order."""

    def __init__(self):
        self.roll = self.pitch = 0.0
        self.then = None
        self.rate = [0.0, 0.0, 0.0]
        self.order = {"roll_rad": 0.0, "pitch_rad": 0.0, "turn_radps": 0.0, "throttle": 0.0}

    def step(self, line):
        """The throttles for what is sensed and ordered."""
        dt = 0.0 if self.then is None else line["t_s"] - self.then
        self.then = line["t_s"]
        self.order = line["order"] or self.order
        if line["gyro"]:
            self.rate = line["gyro"]
            self.roll += self.rate[0] * dt
            self.pitch += self.rate[1] * dt
        if line["accelerometer"]:
            x, y, z = line["accelerometer"]
            if z > 1.0:
                self.roll += LEAN_ON * (math.atan2(y, z) - self.roll)
                self.pitch += LEAN_ON * (math.atan2(-x, z) - self.pitch)
        if not line["armed"]:
            return [0.0] * 4
        roll = RATE_P * (TILT_P * (self.order["roll_rad"] - self.roll) - self.rate[0])
        pitch = RATE_P * (TILT_P * (self.order["pitch_rad"] - self.pitch) - self.rate[1])
        turn = TURN_P * (self.order["turn_radps"] - self.rate[2])
        base = self.order["throttle"]
        return [min(1.0, max(0.0, base + r * roll + p * pitch + t * turn)) for r, p, t in SIGNS]


def main():
    """Answer each line."""
    autopilot, link = Autopilot(), socket.socket(type=socket.SOCK_DGRAM)
    link.bind(("127.0.0.1", 7001))
    while True:
        throttles = autopilot.step(json.loads(link.recv(65536)))
        link.sendto(json.dumps({"throttles": throttles}).encode(), ("127.0.0.1", 7002))


if __name__ == "__main__":
    main()
