"""Measure the speed of flights: CPU time of the 32 baselines of seed 0, beside a bare PyBullet loop in the same mine.

    python benchmarks/flight.py [--situation GLOB ...] [--gym]

`sim_s_per_cpu_s`: simulated seconds per CPU second of one core: scenario, flight and requirements, kernels compiled.
`bare_pybullet_sim_s_per_cpu_s`: a loop that reads the state, applies forces, steps at 240 Hz and renders the same
number of frames with TinyRenderer, over the same simulated time, in the same run.
`gym_sim_s_per_cpu_s`: with --gym, a hover of gym-pybullet-drones' own drone under its own control at 60 Hz, in the same
mine with pictures of the same size and number; the package must be importable.
`server_only_sim_s_per_cpu_s`: the flights once more, with every physics step in the physics server.
`ms_per_sim_s`: CPU time by part, from a second, instrumented pass; the probes cost time, so the parts are scaled to the
total of the first pass.
"""

from __future__ import annotations

import checkout  # first: it sets the path and the threads

# isort: split
import functools
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np

from scaloft_fi.judge.requirement import judge
from scaloft_fi.sim import flight as flight_module
from scaloft_fi.sim.build import build, physics_server
from scaloft_fi.sim.contact import Feeler
from scaloft_fi.sim.flight import CompiledStepper, FlightLoop, fly
from scaloft_fi.sim.observer import Observer
from scaloft_fi.sim.sensors import suite
from scaloft_fi.sim.sensors.camera import DepthSensor, Detector
from scaloft_fi.sim.vehicle import Airframe, spawn
from scaloft_fi.stack.declaration import PlainWire
from scaloft_fi.stack.reference import stack as reference_stack
from scaloft_fi.stack.reference.estimator import Estimator
from scaloft_fi.stack.reference.memory import ObstacleMemory
from scaloft_fi.stack.reference.planner import Planner
from scaloft_fi.stack.reference.proximity import ProximityMonitor
from scaloft_fi.study import Study

# The timed functions: (owner, attribute, part).  The time of a nested part is subtracted from the outer part.
PROBES: tuple[tuple[Any, str, str], ...] = (
    (Airframe, "step", "physics"),
    (Feeler, "feel", "physics"),
    (suite, "look", "camera"),
    (DepthSensor, "measure", "camera"),
    (Detector, "measure", "perception"),
    (ObstacleMemory, "observe", "perception"),
    (ObstacleMemory, "update", "perception"),
    (ObstacleMemory, "map", "perception"),
    (ProximityMonitor, "sectors", "perception"),
    (ProximityMonitor, "flag", "perception"),
    (Planner, "plan", "planner"),
    (reference_stack, "shape_velocity", "planner"),
    (FlightLoop, "_drive", "inertial sensor, control, rotors"),
    (CompiledStepper, "advance", "free flight"),
    (Estimator, "tick", "estimator"),
    (Observer, "step", "oracle"),
    (Observer, "sample", "oracle"),
)


class Clock:
    """Adds up CPU time by part; the time of a nested part does not count for the outer part."""

    def __init__(self) -> None:
        self.spent: defaultdict[str, float] = defaultdict(float)
        self._inner: list[float] = []

    def probe(self, function: Callable[..., Any], part: str) -> Callable[..., Any]:
        """`function`, timed."""

        @functools.wraps(function)
        def timed(*args: Any, **kwargs: Any) -> Any:
            self._inner.append(0.0)
            begin = time.process_time()
            try:
                return function(*args, **kwargs)
            finally:
                took = time.process_time() - begin
                self.spent[part] += took - self._inner.pop()
                if self._inner:
                    self._inner[-1] += took

        return timed


@contextmanager
def instrumented(clock: Clock) -> Iterator[None]:
    """Time the probed functions."""
    with ExitStack() as patches:
        for owner, name, part in PROBES:
            patches.enter_context(patch.object(owner, name, clock.probe(getattr(owner, name), part)))
        yield


def flights(study: Study, situations: list[Any], clock: Clock | None = None) -> tuple[float, float]:
    """Fly each situation's baseline and judge it; returns simulated and CPU seconds."""
    judging = clock.probe(judge, "requirements") if clock else judge
    simulated_s, begin = 0.0, time.process_time()
    for situation in situations:
        log = fly(study.sim, situation, 0, PlainWire())
        for requirement in study.requirements:
            judging(requirement, log)
        simulated_s += log.duration_s
    return simulated_s, time.process_time() - begin


def bare_loop(study: Study, situation: Any, simulated_s: float) -> float:
    """CPU seconds of a loop that only steps, applies forces and renders."""
    import pybullet

    scenario = study.sim.scenario(situation)
    camera, vehicle = scenario.sensors.depth.camera, scenario.vehicle
    with physics_server() as client:
        build(client, scenario.world)
        draw(client, scenario.world.scene)
        body = spawn(client, vehicle, (0.0, 0.0, 1.65), 0.0)
        fov_deg = np.degrees(2 * np.arctan(np.tan(camera.fov_rad / 2) * camera.height / camera.width))
        lens = pybullet.computeProjectionMatrixFOV(fov_deg, camera.width / camera.height, 0.05, 20.0)
        hover, torque = [0.0, 0.0, vehicle.mass_kg * 9.81], [0.0, 0.0, 0.0]
        blank = 0.0
        begin = time.process_time()
        for step in range(round(simulated_s * 240)):
            (x, y, z), _ = pybullet.getBasePositionAndOrientation(body, client)
            pybullet.getBaseVelocity(body, client)
            if step % 12 == 0:
                eye = pybullet.computeViewMatrix([x, y, z], [x, y + 1.0, z], [0.0, 0.0, 1.0])
                *_, depth, _ = pybullet.getCameraImage(
                    camera.width, camera.height, eye, lens, shadow=0,
                    flags=pybullet.ER_NO_SEGMENTATION_MASK, renderer=pybullet.ER_TINY_RENDERER, physicsClientId=client,
                )  # fmt: skip
                blank = max(blank, float(np.mean(depth == 1.0)))
            pybullet.applyExternalForce(body, -1, hover, [x, y, z], pybullet.WORLD_FRAME, client)
            pybullet.applyExternalTorque(body, -1, torque, pybullet.WORLD_FRAME, client)
            pybullet.stepSimulation(physicsClientId=client)
        spent_s = time.process_time() - begin
    if blank > 0.05:
        raise SystemExit(f"the bare loop renders an empty mine: {blank:.0%} of a picture is blank")
    return spent_s


def gym_loop(study: Study, situation: Any, simulated_s: float) -> float:
    """CPU seconds of the same by gym-pybullet-drones."""
    from gym_pybullet_drones.control.DSLPIDControl import DSLPIDControl  # type: ignore[import-not-found]
    from gym_pybullet_drones.envs.CtrlAviary import CtrlAviary  # type: ignore[import-not-found]
    from gym_pybullet_drones.utils.enums import DroneModel  # type: ignore[import-not-found]

    scenario, place = study.sim.scenario(situation), np.array([[0.0, 0.0, 1.65]])
    camera = scenario.sensors.depth.camera
    env = CtrlAviary(initial_xyzs=place, pyb_freq=240, ctrl_freq=60, gui=False)
    env.IMG_RES, blank = np.array([camera.width, camera.height]), 0.0
    env.reset()
    build(env.CLIENT, scenario.world)
    draw(env.CLIENT, scenario.world.scene)
    control, rotors = DSLPIDControl(drone_model=DroneModel.CF2X), np.zeros((1, 4))
    begin = time.process_time()
    for step in range(round(simulated_s * 60)):
        seen, *_ = env.step(rotors)
        rotors[0], *_ = control.computeControlFromState(1.0 / 60.0, seen[0], target_pos=place[0])
        if step % 3 == 0:
            _, depth, _ = env._getDroneImages(0, segmentation=False)
            blank = max(blank, float(np.mean(depth == 1.0)))
    spent_s = time.process_time() - begin
    fallen_m = float(np.linalg.norm(seen[0][:3] - place[0]))
    env.close()
    if blank > 0.05 or fallen_m > 0.2:
        raise SystemExit(f"gym-pybullet-drones: {blank:.0%} of a picture is blank, {fallen_m:.2f} m from the hover")
    return spent_s


def draw(client: int, scene: Any) -> None:
    """Add the triangles of the world as visual shapes; the renderer draws nothing else, and only front sides."""
    import pybullet

    for owner in range(len(scene.names)):
        faces = scene.faces[scene.owner == owner]
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=scene.vertices[faces.ravel()].tolist(),
            indices=list(range(faces.size)),
            normals=np.repeat(normals(scene.vertices[faces]), 3, axis=0).tolist(),
            physicsClientId=client,
        )
        pybullet.createMultiBody(baseVisualShapeIndex=shape, physicsClientId=client)


def normals(triangles: Any) -> Any:
    """(N, 3) unit normals of (N, 3, 3) triangles."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return across / np.linalg.norm(across, axis=1, keepdims=True)


def main() -> None:
    """Measure and print."""
    parser = checkout.parser(__doc__)
    parser.add_argument("--situation", action="append", default=[], help="key or glob, repeatable (default: all)")
    parser.add_argument("--gym", action="store_true", help="fly gym-pybullet-drones too")
    options = parser.parse_args()
    study = Study.open(None)
    situations = list(study.sim.grid.select(options.situation))
    flights(study, situations[:1])
    simulated_s, cpu_s = flights(study, situations)
    with patch.object(flight_module, "agrees", lambda: False):  # so that the physics server makes every step
        server_simulated_s, server_s = flights(study, situations)
    clock = Clock()
    with instrumented(clock):
        _, probed_s = flights(study, situations, clock)
    bare_s = sum(bare_loop(study, situation, 10.0) for situation in situations[::8])
    bare_simulated_s = 10.0 * len(situations[::8])
    gym_s = sum(gym_loop(study, situation, 10.0) for situation in situations[::8]) if options.gym else 0.0
    parts = {**clock.spent, "rest": probed_s - sum(clock.spent.values())}
    scale = cpu_s / probed_s * 1000.0 / simulated_s
    figures = {
        "situations": len(situations),
        "simulated_s": round(simulated_s, 2),
        "cpu_s": round(cpu_s, 2),
        "sim_s_per_cpu_s": round(simulated_s / cpu_s, 1),
        "server_only_sim_s_per_cpu_s": round(server_simulated_s / server_s, 1),
        "bare_pybullet_sim_s_per_cpu_s": round(bare_simulated_s / bare_s, 1),
        **({"gym_sim_s_per_cpu_s": round(bare_simulated_s / gym_s, 1)} if gym_s else {}),
        "ms_per_sim_s": {part: round(spent * scale, 2) for part, spent in sorted(parts.items(), key=lambda p: -p[1])},
    }
    checkout.tell(figures)


if __name__ == "__main__":
    main()
