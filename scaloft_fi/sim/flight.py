"""One flight: simulate the vehicle, its sensors and the stack under test in a situation until the flight ends.

Physics, inertial sensor and flight control run at 240 Hz; the other sensors, the companion and the log run at 20 Hz.
Steppers make the physics steps: in the physics server, or compiled where no contact is possible.  Both compute the same
bits; they may differ on a processor that fuses multiplication and addition, or with another version of the server, and
then the server makes every step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import TypeVar

import numpy as np

from scaloft_fi.aside import foreign
from scaloft_fi.errors import InputError, ScaloftError
from scaloft_fi.mutants.operator import TapError
from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.sim import vehicle
from scaloft_fi.sim.build import build, physics_server, place, set_up
from scaloft_fi.sim.contact import Feeler
from scaloft_fi.sim.events import Lookout, events_of
from scaloft_fi.sim.load import Scenario, SimConfig
from scaloft_fi.sim.log import SIGNALS, Ending, FlightLog, Recorder
from scaloft_fi.sim.observer import Observer
from scaloft_fi.sim.sensors import Sensors, body
from scaloft_fi.sim.sensors.body import ImuSensor, inertial
from scaloft_fi.sim.situation import Situation
from scaloft_fi.sim.vehicle import Airframe, Array, Vehicle, actuate, free_step
from scaloft_fi.stack import Declaration, Stack, Task, Wire
from scaloft_fi.stack.declaration import (
    STEP_HZ,
    STEP_S,
    STEPS_PER_TICK,
    TICK_HZ,
    TICK_S,
    ConfigError,
    FastPath,
    Kernel,
    Numbers,
)
from scaloft_fi.stack.kernel import jit, with_globals
from scaloft_fi.stack.messages import DepthCamera, SensorFrames

R = TypeVar("R")


STEPS = 240
"""Number of steps that are compared: one second."""
BLOCK = Vehicle(
    1.3, (0.011, 0.017, 0.023), (0.4, 0.3, 0.1), ((0.0, 0.0),) * 4, (1, 1, 1, 1),
    moment_m=0.01, max_thrust_n=8.0, spin_up_s=0.05, spin_down_s=0.05, drag_ns_per_m=0.0,
)  # fmt: skip
"""The body of the test; no two of its moments of inertia are equal."""


@cache
def agrees() -> bool:
    """Whether a block that tumbles under changing forces has the same state, to the bit, in both."""
    pushes = np.random.default_rng(0).normal(0.0, (9.0, 9.0, 9.0, 0.3, 0.3, 0.3), (STEPS, 6))
    with physics_server() as client:
        set_up(client)
        airframe = Airframe(client, BLOCK, (0.1, -0.2, 5.0), 0.3)
        state, inverse = airframe.state.copy(), airframe.inverse_attitude().copy()
        for step in range(STEPS):
            airframe.pushed[:] = pushes[step]
            airframe.step(lambda _step: None, step, 1)
            free_step(state, inverse, pushes[step], airframe.inertia)
            if state.tobytes() != airframe.state.tobytes():
                return False
        return inverse.tobytes() == airframe.inverse_attitude().tobytes()


Loop = Callable[[Array, int, int, int, Array, Array, Array, Array, Numbers], float]
Advance = Callable[[int, int], float]
"""Makes physics steps, each with inertial sensor, flight control and rotors: called with the number of the first step,
and how many; returns the greatest square of the speed after a step [m2/s2]."""


class CompiledStepper:
    """Makes steps without contact outside the physics server; the server then gets the last state.

    Args:
        fast_path: fast path of the stack.
        sensor: the inertial sensor.
        airframe: the vehicle.
    """

    def __init__(self, fast_path: FastPath, sensor: ImuSensor, airframe: Airframe) -> None:
        self._fast_path, self._sensor, self._airframe = fast_path, sensor, airframe
        self._loop = loop_with(fast_path.kernel)
        self._numbers: Numbers = ()

    def begin(self) -> None:
        """Prepare the stack for `advance`; any exception here is a failure of the stack before the first step."""
        self._numbers = self._fast_path.begin()

    def advance(self, first: int, count: int) -> float:
        """Make the steps; valid only where the vehicle can touch nothing and no wire listens on the skipped seams."""
        sensor, airframe, numbers, top_square = self._sensor, self._airframe, self._numbers, 0.0
        sensor.begin(airframe.state)
        inverse, last = airframe.inverse_attitude(), first + count
        while first < last:
            noise, row = sensor.noise.place(first)
            steps = min(last - first, len(noise) - row)
            square = self._loop(
                noise, row, first, steps, sensor.numbers, airframe.numbers, inverse, airframe.inertia, numbers
            )
            top_square = max(top_square, square)
            first += steps
        airframe.update_server()
        self._fast_path.end()
        return top_square


@cache
def loop_with(kernel: Kernel) -> Loop:
    """Compile `_loop` with the kernel of the stack."""
    return jit(with_globals(_loop, kernel=kernel))


def _loop(
    noise: Array, row: int, first: int, count: int,
    sensor: Array, airframe: Array, inverse: Array, inertia: Array, numbers: Numbers,
) -> float:  # fmt: skip
    """Make `count` steps, beginning with number `first`; returns the greatest square of the speed [m2/s2].

    Args:
        noise: (N, 6) noise of the inertial samples.
        row: row of `noise` for the first sample.
        sensor: (21,) numbers of the inertial sensor.
        airframe: (46,) numbers of the vehicle.
        inverse, inertia: (4,), (5,) arguments of `free_step`.
        numbers: numbers of the stack's kernel.
    """
    before, errors, reading = body.parts_of(sensor)
    state, thrusts, pushed, lag, effect = vehicle.parts_of(airframe)
    top_square = 0.0
    for i in range(count):
        step = first + i
        inertial(state, before, noise[row + i], errors, reading)
        order = kernel(step / STEP_HZ, step * STEP_S, reading[0], reading[1], numbers)  # type: ignore[name-defined] # noqa: F821 - `loop_with` gives it
        actuate(thrusts, order, lag, effect, state, pushed)
        top_square = max(top_square, free_step(state, inverse, pushed, inertia))
    return top_square


NO_THRUST = np.zeros(4)


class StackError(ScaloftError):
    """A stack breaks its declaration, so the flight cannot continue."""


HARNESS = (TapError, StackError, MemoryError)
"""Exceptions that are faults of the harness, never of the drone."""


def fly(
    config: SimConfig, situation: Situation, seed: int, wire: Wire, declared: Declaration | None = None
) -> FlightLog:
    """Fly once; a pure function of its arguments.  A wire serves one flight only.

    Args:
        config: simulation part of the study.
        situation: the situation of the flight.
        seed: seed of the noise.
        wire: carries the samples between the stages.
        declared: the stack; by default the one that the study names.

    Raises:
        InputError: the study names an unknown stack, or the settings of the stack do not fit.
        TapError: a fault could not be injected.
        StackError: the beliefs of the stack differ from its declaration.
        SignalError: a signal of the study is not what it declares.
    """
    scenario = config.scenario(situation)
    with physics_server() as client:
        flight = FlightLoop(client, config, scenario, seed, wire, declared)
        try:
            while flight.tick():
                flight.advance()
            return flight.log()
        finally:
            flight.close()


def task_of(config: SimConfig, declared: Declaration, scenario: Scenario) -> Task:
    """What the stack has to do in a scenario.

    Raises:
        InputError: the settings of the stack do not fit.
    """
    mission, camera = scenario.world.mission, scenario.sensors.depth.camera
    return Task(
        settings=config.stack.settings(declared),
        camera=DepthCamera(camera.rays, camera.ahead_m),
        home=scenario.start,
        yaw_rad=mission.yaw_rad,
        route=scenario.route,
        altitude_m=mission.altitude_m,
        cruise_mps=mission.cruise_mps,
        slow_mps=mission.slow_mps,
        folder=str(config.stack.document.path.absolute().parents[1]),
        situation=scenario.key,
        sensors=tuple(scenario.sensors.by_name),
        throttle_exponent=scenario.vehicle.throttle_exponent,
    )


def make_stack(config: SimConfig, declared: Declaration, scenario: Scenario, wire: Wire) -> Stack:
    """Build the stack, ready for take-off.

    Raises:
        InputError: the settings of the stack do not fit.
    """
    task = task_of(config, declared, scenario)
    try:
        return declared.make(task, wire)
    except ConfigError as error:
        raise InputError(f"{config.stack.place_of(error.path)}: {error}") from error


class FlightLoop:
    """A flight under way.

    Attributes:
        stack, sensors, airframe: the system under test, its sensors, the vehicle.
        ticks: number of completed ticks.

    An exception of the stack under test is a fact about the drone: when its companion fails, the autopilot flies on
    with its own fail-safes; when the autopilot fails, the rotors stop.
    """

    def __init__(
        self,
        client: int,
        config: SimConfig,
        scenario: Scenario,
        seed: int,
        wire: Wire,
        declared: Declaration | None = None,
    ) -> None:
        vehicle = scenario.vehicle
        self._ids = ids = build(client, scenario.world)
        self._around = around = scenario.world.surroundings()
        self._declared = declared or config.stack.declaration
        self.stack: Stack = make_stack(config, self._declared, scenario, wire)
        self.sensors = Sensors(scenario.sensors, around, scenario.labels, scenario.key, seed)
        self._client, self._scenario, self._wire = client, scenario, wire
        self.airframe = Airframe(client, vehicle, scenario.start, scenario.world.mission.yaw_rad)
        self._observer = Observer(client, ids, self.airframe.number, vehicle, scenario, around)
        self._feeler = Feeler(client, self.airframe.number, vehicle, ids.name_of, around.top_wind_mps)
        self._lookout = Lookout.of(wire, scenario.world, self._observer.names, self._declared.beliefs)
        self._truth, self._beliefs = Recorder(self._observer.names), Recorder(self._declared.belief_names)
        self._compiled: CompiledStepper | None = None
        if self.stack.fast_path is not None:
            self._compiled = CompiledStepper(self.stack.fast_path, self.sensors.inertial, self.airframe)
        self.ticks = self._steps = 0
        self._companion_alive = self._autopilot_alive = True
        self._stack_error = ""

    def tick(self) -> bool:
        """Record a sample; unless the flight is over, run sensors and companion.  Returns whether it continues."""
        now_s, around = self.ticks / TICK_HZ, self._around
        around.update(now_s, *self.airframe.truth[:2])
        if around.shifts:
            place(self._client, self._ids, around.shifts)
        if around.top_wind_mps:
            self.airframe.blow(around.wind_mps)
        truth = self._observer.sample(now_s, self.airframe.state, self.sensors.view)
        self._truth.add(truth)
        self._feeler.look(self.airframe.truth, self._observer.room_m - around.top_body_mps * TICK_S)
        believed = self._believed(now_s)
        self._beliefs.add(believed)
        if self._ending(now_s) is not None:
            return False
        if self._lookout:
            self._lookout.look(now_s, truth, believed.tolist())
        self._think(now_s, self._sense(now_s))
        self.ticks += 1
        return True

    def _believed(self, now_s: float) -> Array:
        """The stack's beliefs.

        Raises:
            StackError: `beliefs` raised, or returned another number of values than declared.
        """
        name, due = self._declared.name, len(self._declared.beliefs)
        try:
            values = np.asarray(self.stack.beliefs(now_s), dtype=np.float64)
        except foreign() as error:
            raise StackError(f"stack {name!r}: beliefs: {type(error).__name__}: {error}") from error
        if values.shape != (due,):
            raise StackError(f"stack {name!r} declares {due} beliefs, but `beliefs` returns shape {values.shape}")
        return values

    def advance(self) -> None:
        """Make the physics steps up to the next sample."""
        if not self._feeler.out_of_reach:
            for _ in range(STEPS_PER_TICK):
                self.step()
            return
        top_square = self._stepper()(self._steps, STEPS_PER_TICK)
        self._steps += STEPS_PER_TICK
        self._observer.pass_by(top_square, self.airframe.truth)

    def step(self) -> None:
        """Let the server make one physics step, and find its contacts."""
        if self._around.top_body_mps:
            self._around.move(self._steps * STEP_S)
            place(self._client, self._ids, self._around.shifts)
        self._served(self._steps, 1)
        self._steps += 1
        airframe = self.airframe
        touched = self._feeler.feel(airframe.truth, airframe.state)
        if touched:
            self.sensors.feel(touched)
        self._observer.step(self._steps * STEP_S, airframe.truth, touched)

    def _served(self, first: int, count: int) -> float:
        """Let the server make steps; contacts are allowed."""
        return self.airframe.step(self._drive, first, count)

    def _stepper(self) -> Advance:
        """The stepper for a tick in which the vehicle can touch nothing.

        The wire of PLACEBO listens on every seam, so PLACEBO flies with the server's steps: its flights compare both
        steppers in every campaign.
        """
        fast_path = self.stack.fast_path
        if self._compiled is None or fast_path is None or not self._autopilot_alive or not agrees():
            return self._served
        if any(map(self._wire.listens, fast_path.seams)):
            return self._served
        self._attempt("autopilot", self._steps / STEP_HZ, self._compiled.begin)
        if not self._autopilot_alive:
            return self._served
        return self._compiled.advance

    def _drive(self, step: int) -> None:
        """Let flight control set the thrust of physics step number `step`."""
        order = self._attempt("autopilot", step / STEP_HZ, self._ordered, step) if self._autopilot_alive else None
        self.airframe.actuate(NO_THRUST if order is None else order)

    def _ordered(self, step: int) -> Array | None:
        """The thrusts that flight control orders for a physics step.

        Raises:
            StackError: they are no array (4,), beyond whose end the compiled step would read.
        """
        thrust = self.stack.step(step / STEP_HZ, self.sensors.imu(step, self.airframe.state))
        if thrust is None:
            return None
        if thrust.rotors.shape != NO_THRUST.shape:
            name, shape = self._declared.name, thrust.rotors.shape
            raise StackError(
                f"stack {name!r}: `step` returns the thrust of rotors of shape {shape}, which must be (4,)"
            )
        return thrust.rotors

    def log(self) -> FlightLog:
        """The log of the flight so far.

        Raises:
            SignalError: a signal of the study is not what it declares.
        """
        truth, beliefs = self._truth.signals(), self._beliefs.signals()
        for name in self._scenario.world.signals:
            SIGNALS[name].hold(truth[name])
        counts: Mapping[str, SeamCount] = getattr(self._wire, "counts", {})
        struck, struck_at_s = self._observer.struck, self._observer.struck_at_s
        error = self._stack_error or str(getattr(self.stack, "complaint", ""))
        declared, began = self._declared, self._around.began
        return FlightLog(
            {**truth, **beliefs}, self._ending(self.ticks / TICK_HZ) or Ending.TIMED_OUT, struck, struck_at_s, error,
            counts, self._scenario.t_max_s, beliefs=declared.belief_names,
            events=events_of(
                truth["elapsed_s"], declared.beliefs, beliefs, counts, struck, struck_at_s, error, began
            ),
        )  # fmt: skip

    def close(self) -> None:
        """Let the stack end what it started."""
        close = getattr(self.stack, "close", None)
        if close is not None:
            close()

    def _ending(self, now_s: float) -> Ending | None:
        if self._observer.struck:
            return Ending.STRUCK
        if self._observer.landed:
            return Ending.LANDED
        return Ending.TIMED_OUT if now_s >= self._scenario.t_max_s else None

    def _sense(self, now_s: float) -> SensorFrames:
        """Measure with the stack's clocks and exposure; with the true time once the autopilot has failed."""
        stamps = self._attempt("autopilot", now_s, self.stack.stamps, now_s) if self._autopilot_alive else None
        return self.sensors.frames(self.ticks, self.airframe.state, self.airframe.thrusts, self.stack.exposure, stamps)

    def _think(self, now_s: float, frames: SensorFrames) -> None:
        if self._autopilot_alive:
            self._attempt("autopilot", now_s, self.stack.autopilot, now_s, frames)
        if self._companion_alive:
            self._attempt("companion", now_s, self.stack.companion, now_s, frames)

    def _attempt(self, part: str, now_s: float, method: Callable[..., R], *arguments: object) -> R | None:
        """What a method of the stack under test returns; None where it raises, and that part of the drone is dead."""
        try:
            return method(*arguments)
        except HARNESS:
            raise
        except foreign() as error:
            self._companion_alive, self._autopilot_alive = False, self._autopilot_alive and part == "companion"
            text = f"{part} at {now_s:.3f} s: {type(error).__name__}: {' '.join(str(error).split())}"
            self._stack_error = self._stack_error or text
            return None
