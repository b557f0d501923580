"""Sensors of the body: inertial sensor 240 Hz, positioning 20 Hz, battery, touch sensor; barometer, magnetometer."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError
from scaloft_fi.marks import Bounds, Count, NotNegative, Share
from scaloft_fi.sim.build import GRAVITY_MPS2
from scaloft_fi.sim.sensors.sensor import OWN_LATENCY, SENSORS, FlightSetting, Latency, Moment, SensorKind
from scaloft_fi.stack.declaration import STEP_S, TICK_S
from scaloft_fi.stack.kernel import jit
from scaloft_fi.stack.messages import EARTH_FIELD_UT, Battery, Bumper, Fix, Imu, MagneticField, Pressure, standard_hpa
from scaloft_fi.streams import Array, Table, generator


class BumperSensor:
    """Reports contacts of hull and landing gear."""

    def __init__(self, config: None, flight: FlightSetting) -> None:
        pass

    def measure(self, moment: Moment) -> Bumper:
        """Whether hull and landing gear had a contact since the last reading."""
        hull = gear = False
        for contact in moment.contacts:
            gear |= contact.gear
            hull |= not contact.gear
        return Bumper(moment.now_s, hull, gear)


SENSORS.declare("bumper", SensorKind(BumperSensor, Bumper, required=True))


@dataclass(frozen=True)
class PositioningConfig:
    """Errors of the positioning system.

    Attributes:
        sigma_m: standard deviation per axis [m].
        yaw_sigma_deg: standard deviation of the heading [deg].
        latency_s: from measurement to delivery [s].
    """

    sigma_m: NotNegative
    yaw_sigma_deg: NotNegative
    latency_s: Latency


class Positioning:
    """Measures position and heading."""

    def __init__(self, config: PositioningConfig, flight: FlightSetting) -> None:
        self._config, self._yaw_sigma_rad = config, math.radians(config.yaw_sigma_deg)
        self._noise = Table(4, *flight.stream, "fix")

    def measure(self, moment: Moment) -> Fix:
        """The fix of this tick."""
        *noise, yaw_noise = self._noise.row(moment.tick).tolist()
        *place, x, y, z, w = moment.state[:7].tolist()
        yaw_rad = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        drift_m, sigma_m = moment.around.drift_m.tolist(), self._config.sigma_m
        position = [p + d + sigma_m * n for p, d, n in zip(place, drift_m, noise, strict=True)]
        return Fix(moment.stamps.fix_s, np.array(position), yaw_rad + self._yaw_sigma_rad * yaw_noise)


SENSORS.declare("positioning", SensorKind(Positioning, Fix, PositioningConfig, latency_s=OWN_LATENCY, required=True))


@dataclass(frozen=True)
class BarometerConfig:
    """Errors of the barometer.

    Attributes:
        sigma_hpa: standard deviation [hPa].
        bias_hpa: standard deviation of the bias, drawn once per flight [hPa].
    """

    sigma_hpa: NotNegative
    bias_hpa: NotNegative


class Barometer:
    """Measures the pressure of the standard atmosphere; the world's height 0 is at sea level."""

    def __init__(self, config: BarometerConfig, flight: FlightSetting) -> None:
        self._sigma_hpa, self._noise = config.sigma_hpa, Table(1, *flight.stream, "barometer")
        self._bias_hpa = config.bias_hpa * float(generator(*flight.stream, "barometer bias").standard_normal())

    def measure(self, moment: Moment) -> Pressure:
        """The sample of this tick."""
        noise_hpa = self._bias_hpa + self._sigma_hpa * float(self._noise.row(moment.tick)[0])
        return Pressure(moment.now_s, standard_hpa(float(moment.state[2])) + noise_hpa)


SENSORS.declare("barometer", SensorKind(Barometer, Pressure, BarometerConfig))


@dataclass(frozen=True)
class MagnetometerConfig:
    """Errors of the magnetometer.

    Attributes:
        sigma_ut: standard deviation per axis [uT].
        bias_ut: standard deviation of the bias per axis, drawn once per flight [uT].
    """

    sigma_ut: NotNegative
    bias_ut: NotNegative


class Magnetometer:
    """Measures the earth's field; neither iron nor currents bend it."""

    def __init__(self, config: MagnetometerConfig, flight: FlightSetting) -> None:
        self._sigma_ut, self._noise = config.sigma_ut, Table(3, *flight.stream, "magnetometer")
        self._bias_ut = config.bias_ut * generator(*flight.stream, "magnetometer bias").standard_normal(3)

    def measure(self, moment: Moment) -> MagneticField:
        """The sample of this tick."""
        x, y, z, w = moment.state[3:7]
        there = np.array(EARTH_FIELD_UT)
        about = np.array([x, y, z])
        turned = there - 2.0 * w * np.cross(about, there) + 2.0 * np.cross(about, np.cross(about, there))
        return MagneticField(moment.now_s, turned + self._bias_ut + self._sigma_ut * self._noise.row(moment.tick))


SENSORS.declare("magnetometer", SensorKind(Magnetometer, MagneticField, MagnetometerConfig))


PERIOD_TICKS = 20
"""Ticks from one telemetry message to the next: 1 Hz."""


@dataclass(frozen=True)
class BatteryConfig:
    """Settings of the battery.

    Attributes:
        cells: number of cells in series.
        capacity_ah: charge of a full pack [A h].
        charge: state of charge at take-off, 0..1.
        full_cell_v, empty_cell_v: open-circuit voltage of a full and of an empty cell [V]; linear in between.
        resistance_ohm: resistance of the whole pack [ohm].
        hover_w_per_n15: power of a rotor per thrust^1.5 [W/N^1.5].
        idle_w: power of all other consumers [W].
    """

    cells: Count
    capacity_ah: Annotated[float, Bounds(least=1e-3)]
    charge: Share
    full_cell_v: float
    empty_cell_v: Annotated[float, Bounds(least=1e-3)]
    resistance_ohm: NotNegative
    hover_w_per_n15: NotNegative
    idle_w: NotNegative

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a full cell whose voltage is not above that of an empty one."""
        if self.full_cell_v <= self.empty_cell_v:
            yield item.need("full_cell_v").error(f"> {self.empty_cell_v:g}")


class BatteryGauge:
    """Tracks the charge and sends telemetry."""

    def __init__(self, config: BatteryConfig, flight: FlightSetting) -> None:
        self._config = config
        self._charge = config.charge

    def drain(self, thrusts: Array, seconds: float) -> float:
        """Drain the pack by the power for `thrusts` (4,) [N] over `seconds` [s]; returns the terminal voltage [V]."""
        config = self._config
        rest_v = config.cells * (config.empty_cell_v + (config.full_cell_v - config.empty_cell_v) * self._charge)
        work: float = sum(n * math.sqrt(n) for n in thrusts.tolist())
        power_w = config.idle_w + config.hover_w_per_n15 * work
        current_a = power_w / rest_v
        self._charge = max(0.0, self._charge - current_a * seconds / (3600.0 * config.capacity_ah))
        return rest_v - current_a * config.resistance_ohm

    def measure(self, moment: Moment) -> Battery | None:
        """Drain the pack at every tick; returns a telemetry message once per second, else None."""
        voltage_v = self.drain(moment.thrusts, TICK_S)
        if moment.tick % PERIOD_TICKS:
            return None
        return Battery(moment.now_s, self._charge, voltage_v, self._config.cells)


SENSORS.declare("battery", SensorKind(BatteryGauge, Battery, BatteryConfig, required=True))


NUMBERS = 21


@dataclass(frozen=True)
class ImuConfig:
    """Errors of the inertial sensor; the biases are drawn once per flight.

    Attributes:
        rate_sigma_radps, rate_bias_radps: white noise per sample, standard deviation of the bias [rad/s].
        force_sigma_mps2, force_bias_mps2: white noise per sample, standard deviation of the bias [m/s2].
    """

    rate_sigma_radps: NotNegative
    rate_bias_radps: NotNegative
    force_sigma_mps2: NotNegative
    force_bias_mps2: NotNegative


class ImuSensor:
    """Measures angular rate and specific force; the acceleration is the change of velocity over the last step.

    Attributes:
        noise: noise of each sample.
        numbers: (21,) arguments of `inertial`, see `parts_of`.
    """

    def __init__(self, config: ImuConfig, *stream: object) -> None:
        self.noise = Table(6, *stream, "imu")
        bias = np.repeat(np.array([config.rate_bias_radps, config.force_bias_mps2], np.float64), 3)
        bias *= generator(*stream, "imu bias").standard_normal(6)
        sigma = np.repeat(np.array([config.rate_sigma_radps, config.force_sigma_mps2], np.float64), 3)
        self.numbers = np.zeros(NUMBERS)
        self._before, self._errors, _ = parts_of(self.numbers)
        self._errors[:] = bias, sigma
        self._measured = False

    def begin(self, state: Array) -> None:
        """Before the first sample, set the velocity one step earlier to that of `state` (13,)."""
        if not self._measured:
            self._measured = True
            self._before[:] = state[7:10]

    def measure(self, step: int, state: Array) -> Imu:
        """The sample of physics step `step` from the vehicle's true `state` (13,)."""
        self.begin(state)
        reading = np.empty((2, 3))
        inertial(state, self._before, self.noise.row(step), self._errors, reading)
        return Imu(step * STEP_S, reading[0], reading[1])


@jit
def parts_of(numbers: Array) -> tuple[Array, Array, Array]:
    """Velocity one step earlier (3,), errors (2, 6), reading (2, 3) as views of `numbers` (21,); see `inertial`."""
    return numbers[:3], numbers[3:15].reshape((2, 6)), numbers[15:NUMBERS].reshape((2, 3))


@jit
def inertial(state: Array, before: Array, noise: Array, errors: Array, reading: Array) -> None:
    """Write the `reading` of the sensor, and copy the velocity of `state` into `before` (3,).

    Args:
        state: (13,) state of the vehicle.
        before: (3,) velocity one step earlier [m/s, world].
        noise: (6,) standard normal numbers.
        errors: (2, 6) bias and standard deviation of rate x, y, z and force x, y, z.
        reading: (2, 3) receives body rate [rad/s] and specific force [m/s2].
    """
    x, y, z, w = state[3], state[4], state[5], state[6]
    r = np.empty((3, 3))
    r[0, 0], r[0, 1], r[0, 2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)
    r[1, 0], r[1, 1], r[1, 2] = 2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)
    r[2, 0], r[2, 1], r[2, 2] = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)
    for i in range(3):
        turn, push = 0.0, 0.0
        for k in range(3):
            felt = (state[7 + k] - before[k]) / STEP_S + (GRAVITY_MPS2 if k == 2 else 0.0)
            turn += r[k, i] * state[10 + k]
            push += r[k, i] * felt
        reading[0, i] = turn + errors[0, i] + errors[1, i] * noise[i]
        reading[1, i] = push + errors[0, 3 + i] + errors[1, 3 + i] * noise[3 + i]
    for k in range(3):
        before[k] = state[7 + k]
