"""The flyers: one simulates flights in PyBullet, one has the command of the study fly them; and PyBullet's window."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from multiprocessing import current_process, get_context
from multiprocessing.process import BaseProcess
from threading import Timer

from scaloft_fi.aside import answers_apart
from scaloft_fi.campaign.flights.fly import (
    Batch,
    Flight,
    Flyer,
    Worker,
    fly_log,
    fly_shared,
    judged,
    left_of,
    lost,
    wire_of,
)
from scaloft_fi.campaign.processes import LINUX, PATIENCE_S, ProcessPool, cores, die_with
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.stack.declaration import TICK_HZ, TICK_S, Declaration, PlainWire, Task
from scaloft_fi.study import Study

KERNELS_S = 5.0
"""Length of the trial flight; by then the drone has climbed and plans, so every kernel was called [s]."""
NOTICE_S = 1.0
"""A preparation that takes longer prints a notice [s, wall]."""


class Physics:
    """Flies in PyBullet."""

    @answers_apart()
    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        """Build the stack, compile its kernels and parse the formulas: fly and judge a few seconds.

        Processes that are forked afterwards inherit all of it.

        Raises:
            InputError: the settings of the stack do not fit.
        """
        from scaloft_fi.sim import build, flight, vehicle
        from scaloft_fi.stack import kernel

        def tell() -> None:
            if kernel.compiles():
                say("compiling kernels (first run on this machine only)")

        first, beside = study.grid.situations[0], None
        if kernel.lacks(vehicle.free_step):
            task = flight.task_of(study.sim, study.stack, study.scenario(first))
            beside = _compiling(study.stack, task)  # before the notice's thread, because it is a fork
        notice = Timer(NOTICE_S, tell)
        notice.start()
        try:
            with build.physics_server() as client:
                rehearsed = study.stack.rehearsed
                trial = flight.FlightLoop(client, study.sim, study.scenario(first), 0, PlainWire(), rehearsed)
                trial.step()
                for _ in range(round(KERNELS_S * TICK_HZ)):
                    trial.tick()
                    trial.advance()
                judged(study, Flight(None, first, 0), trial.log())
        finally:
            notice.cancel()
            notice.join()
            if beside is not None:
                beside.kill()
                beside.join()

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        """Fly and judge one flight from take-off; with a stack that does not fork, in a process of its own."""
        if study.stack.forks:
            return judged(study, flight, fly_log(study, flight))
        with ProcessPool(partial(_fly_all, study), 1, left=left_of, lost=lost, patience_s=PATIENCE_S) as apart:
            (outcome,) = apart.map([Batch((flight,))])
        return outcome

    def share(self, study: Study, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Fly the baseline once, and each mutant from the moment at which it leaves the baseline."""
        # in a process of its own, so that a crash loses one flight only
        with ProcessPool(Worker(study, self), 1, left=left_of, lost=lost, patience_s=PATIENCE_S) as apart:
            fly_shared(study, batch, report, lambda flight: apart.map([Batch((flight,))]))


def _compiling(stack: Declaration, task: Task) -> BaseProcess | None:
    """A process that compiles some of the kernels of a stack, where a processor is free for it; else None."""
    alone = not LINUX or cores() < 2 or current_process().daemon  # which may have no child
    if stack.kernels is None or alone:
        return None
    process = get_context("fork").Process(target=_call, args=(stack.kernels, task, os.getpid()), daemon=True)
    process.start()
    return process


def _call(kernels: Callable[[Task], None], task: Task, parent: int) -> None:
    die_with(parent)
    with suppress(Exception):  # the trial flight meets the same error, and tells it
        kernels(task)


def _fly_all(study: Study, batch: Batch, report: Callable[[Outcome], None]) -> None:
    """The work of a process that flies and ends, with whatever threads the stack has started in it."""
    for flight in batch.flights:
        report(judged(study, flight, fly_log(study, flight)))


DISTANCE_M, TURN_DEG, TILT_DEG = 3.0, 15.0, -60.0
"""Position of the window's camera relative to the vehicle: steeply above and slightly behind (the roof is invisible
from outside)."""


@answers_apart()
def fly_in_window(study: Study, flight: Flight) -> FlightLog:
    """Fly in a window; returns the log.

    Raises:
        InputError: there is no display.
    """
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise InputError("--gui needs a display, and there is none (DISPLAY is not set); without it a map is drawn")
    from scaloft_fi.sim import build
    from scaloft_fi.sim import flight as flying

    pybullet = build.bullet()
    client = pybullet.connect(pybullet.GUI)
    if client < 0:
        raise InputError("--gui: PyBullet could not open a window on this display")
    pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, physicsClientId=client)
    try:
        wire = wire_of(study, flight)
        under_way = flying.FlightLoop(client, study.sim, study.scenario(flight.situation), flight.seed, wire)
        due_s = time.monotonic()
        while under_way.tick():
            follow = under_way.airframe.state[:3].tolist()
            pybullet.resetDebugVisualizerCamera(DISTANCE_M, TURN_DEG, TILT_DEG, follow, physicsClientId=client)
            under_way.advance()
            due_s += TICK_S
            time.sleep(max(0.0, due_s - time.monotonic()))
        return under_way.log()
    finally:
        pybullet.disconnect(physicsClientId=client)


@dataclass(frozen=True)
class Commanded:
    """Flies with the command of the study, each flight alone."""

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        """Prove before the first flight what would fail in each, and parse the formulas.

        Raises:
            InputError: the study cannot be flown.
        """
        from scaloft_fi.campaign.flights.command import check_command

        assert study.command is not None
        check_command(study, study.command, say)

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        """Fly and judge one flight; a failure of the command is raised."""
        return judged(study, flight, fly_log(study, flight))

    def share(self, study: Study, batch: Batch, report: Callable[[Outcome], None]) -> None:
        """Fly each flight alone: nobody can fork a simulator of somebody else's."""
        alone = Worker(study, self)
        for flight in batch.flights:
            alone(Batch((flight,)), report)


def flyer_of(study: Study) -> Flyer:
    """What flies a study: our simulator, the command of the study, or the tests of a suite."""
    if study.tests_of:  # by name: who flies or reads flights needs no tests
        tester: Flyer = import_module("scaloft_fi.campaign.flights.suite").Tester()
        return tester
    return Commanded() if study.command else Physics()
