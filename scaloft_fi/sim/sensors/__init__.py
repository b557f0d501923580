"""The sensors: the only way from the simulator to the stack."""

from scaloft_fi.sim.sensors.suite import Sensors, SensorsConfig, read_sensors

__all__ = ["Sensors", "SensorsConfig", "read_sensors"]
