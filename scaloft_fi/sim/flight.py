"""One flight: simulate the vehicle, its sensors and the stack under test in a situation until the flight ends.

Physics, inertial sensor and flight control run at 240 Hz; the other sensors, the companion and the log run at 20 Hz.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from scaloft_fi.errors import InputError, ScaloftError
from scaloft_fi.mutants.wire import SeamCount, TapError
from scaloft_fi.sim.build import build, physics_server, place
from scaloft_fi.sim.contact import Feeler
from scaloft_fi.sim.events import Lookout, events_of
from scaloft_fi.sim.load import SimConfig
from scaloft_fi.sim.log import Ending, FlightLog, Recorder
from scaloft_fi.sim.observer import Observer
from scaloft_fi.sim.scenario import Scenario
from scaloft_fi.sim.sensors import Sensors
from scaloft_fi.sim.situation import Situation
from scaloft_fi.sim.stepper import CompiledStepper, ServerStepper, Stepper, agrees
from scaloft_fi.sim.vehicle import Airframe
from scaloft_fi.stack.declaration import (
    STEP_HZ,
    STEP_S,
    STEPS_PER_TICK,
    TICK_HZ,
    TICK_S,
    ConfigError,
    Declaration,
    Stack,
    Task,
    Wire,
)
from scaloft_fi.stack.messages import Array, DepthCamera, SensorFrames

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


def make_stack(config: SimConfig, declared: Declaration, scenario: Scenario, wire: Wire) -> Stack:
    """Build the stack, ready for take-off.

    Raises:
        InputError: the settings of the stack do not fit.
    """
    mission, camera = scenario.world.mission, scenario.sensors.depth.camera
    task = Task(
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
    )
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
        self._server: Stepper = ServerStepper(self.airframe, self._drive)
        self._compiled: CompiledStepper | None = None
        if self.stack.fast_path is not None:
            self._compiled = CompiledStepper(self.stack.fast_path, self.sensors.inertial, self.airframe)
        self.ticks = self._steps = 0
        self._companion_alive = self._autopilot_alive = True
        self._stack_error = ""

    def tick(self) -> bool:
        """Record a sample; unless the flight is over, run sensors and companion.  Returns whether it continues."""
        now_s = self.ticks / TICK_HZ
        self._change_surroundings(now_s)
        truth = self._observer.sample(now_s, self.airframe.state, self.sensors.view)
        self._truth.add(truth)
        self._feeler.look(self.airframe.truth, self._observer.room_m - self._around.top_body_mps * TICK_S)
        believed = self._believed(now_s)
        self._beliefs.add(believed)
        if self._ending(now_s) is not None:
            return False
        if self._lookout:
            self._lookout.look(now_s, truth, believed.tolist())
        frames = self._sense(now_s)
        if frames is not None and self._autopilot_alive:
            self._think(now_s, frames)
        self.ticks += 1
        return True

    def _change_surroundings(self, now_s: float) -> None:
        """Let happen what happens at this tick."""
        around = self._around
        around.update(now_s, *self.airframe.truth[:2])
        if around.shifts:
            place(self._client, self._ids, around.shifts)
        if around.top_wind_mps:
            self.airframe.blow(around.wind_mps)

    def _believed(self, now_s: float) -> Array:
        """The stack's beliefs.

        Raises:
            StackError: `beliefs` raised, or returned another number of values than declared.
        """
        name, due = self._declared.name, len(self._declared.beliefs)
        try:
            values = np.asarray(self.stack.beliefs(now_s), dtype=np.float64)
        except Exception as error:
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
        top_square = self._stepper().advance(self._steps, STEPS_PER_TICK)
        self._steps += STEPS_PER_TICK
        self._observer.pass_by(top_square, self.airframe.truth)

    def step(self) -> None:
        """Let the server make one physics step, and find its contacts."""
        if self._around.top_body_mps:
            self._around.move(self._steps * STEP_S)
            place(self._client, self._ids, self._around.shifts)
        self._server.advance(self._steps, 1)
        self._steps += 1
        self._watch()

    def _stepper(self) -> Stepper:
        """The stepper for a tick in which the vehicle can touch nothing.

        The wire of PLACEBO listens on every seam, so PLACEBO flies with the server's steps: its flights compare both
        steppers in every campaign.
        """
        fast_path = self.stack.fast_path
        if self._compiled is None or fast_path is None or not self._autopilot_alive or not agrees():
            return self._server
        if any(map(self._wire.listens, fast_path.seams)):
            return self._server
        try:
            self._compiled.begin()
        except HARNESS:
            raise
        except Exception as error:  # noqa: BLE001 - whatever the stack under test raises
            self._autopilot_fails(self._steps / STEP_HZ, error)
            return self._server
        return self._compiled

    def _drive(self, step: int) -> None:
        """Let flight control set the thrust of physics step number `step`."""
        order = NO_THRUST
        if self._autopilot_alive:
            now_s = step / STEP_HZ
            try:
                thrust = self.stack.step(now_s, self.sensors.imu(step, self.airframe.state))
                order = NO_THRUST if thrust is None else thrust.rotors
            except HARNESS:
                raise
            except Exception as error:  # noqa: BLE001 - whatever the stack under test raises
                self._autopilot_fails(now_s, error)
        self.airframe.actuate(order)

    def _watch(self) -> None:
        """Pass the last step to touch sensor and observer."""
        airframe = self.airframe
        touched = self._feeler.feel(airframe.truth, airframe.state)
        if touched:
            self.sensors.feel(touched)
        self._observer.step(self._steps * STEP_S, airframe.truth, touched)

    def log(self) -> FlightLog:
        """The log of the flight so far."""
        truth, beliefs = self._truth.signals(), self._beliefs.signals()
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

    def _sense(self, now_s: float) -> SensorFrames | None:
        """Measure with the stack's clocks and exposure; with the true time once the autopilot has failed."""
        stamps = None
        if self._autopilot_alive:
            try:
                stamps = self.stack.stamps(now_s)
            except HARNESS:
                raise
            except Exception as error:  # noqa: BLE001 - whatever the stack under test raises
                self._autopilot_fails(now_s, error)
        return self.sensors.frames(self.ticks, self.airframe.state, self.airframe.thrusts, self.stack.exposure, stamps)

    def _think(self, now_s: float, frames: SensorFrames) -> None:
        try:
            self.stack.autopilot(now_s, frames)
        except HARNESS:
            raise
        except Exception as error:  # noqa: BLE001 - whatever the stack under test raises
            self._autopilot_fails(now_s, error)
            return
        if not self._companion_alive:
            return
        try:
            self.stack.companion(now_s, frames)
        except HARNESS:
            raise
        except Exception as error:  # noqa: BLE001 - whatever the stack under test raises
            self._companion_alive = False
            self._note(now_s, "companion", error)

    def _autopilot_fails(self, now_s: float, error: Exception) -> None:
        self._autopilot_alive = self._companion_alive = False
        self._note(now_s, "autopilot", error)

    def _note(self, now_s: float, part: str, error: Exception) -> None:
        text = f"{part} at {now_s:.3f} s: {type(error).__name__}: {' '.join(str(error).split())}"
        self._stack_error = self._stack_error or text
