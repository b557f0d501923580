"""The sensors: the stack gets data of the simulator only through them."""

from scaloft_fi.sim.sensors.suite import Sensors, SensorsConfig, read_sensors

__all__ = ["Sensors", "SensorsConfig", "read_sensors"]
