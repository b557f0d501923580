"""What a stack outside declares: its seams and beliefs follow from `sim/stack.yaml`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from scaloft_fi.outside.ports import PORTS
from scaloft_fi.outside.settings import OutsideConfig
from scaloft_fi.stack.config import ConfigError
from scaloft_fi.stack.declaration import Belief, Declaration, Seam, Stack, Task, Wire
from scaloft_fi.stack.reference.messages import BELIEFS
from scaloft_fi.stack.reference.stack import SEAMS

FLIGHT_CONTROL = ("imu", "fix", "thrust")
"""Seams of our drone that are left where velocities come from outside."""
REPLACED = ("person", "route", "goal", "speedlimit")
"""Seams of the reference stack that nobody uses where the mission is outside."""
_MOVED = tuple(one for one in BELIEFS if one.name.startswith(("cmd_", "est_")) or one.name == "mode")


def seams_of(config: OutsideConfig) -> tuple[Seam, ...]:
    """The seams at the border, then those of the part of our drone that flies below.

    Raises:
        ConfigError: two seams have one name.
    """
    border = tuple(_seam(name, config) for name in config.seams)
    own = tuple(
        seam
        for seam in SEAMS
        if (seam.name in FLIGHT_CONTROL if config.below == "flight_control" else seam.name not in REPLACED)
    )
    for seam in own:
        if seam.name in config.seams:
            raise ConfigError(f"stack.seams.{seam.name}", "is the name of a seam of our drone, give it another one")
    return (*border, *own)


def _seam(name: str, config: OutsideConfig) -> Seam:
    declared = config.seams[name]
    port = PORTS[declared.carries]
    ends = ("our drone", declared.topic) if port.outward else (declared.topic, "our drone")
    return Seam(name, port.message, port.rate_hz, " -> ".join(ends), units=port.units)


def beliefs_of(config: OutsideConfig) -> tuple[Belief, ...]:
    """The beliefs of the part of our drone that flies below."""
    return _MOVED if config.below == "flight_control" else BELIEFS


def shaped(settings: Any) -> Declaration:
    """The declaration that follows from the settings.

    Raises:
        ConfigError: the settings do not fit together.
    """
    config: OutsideConfig = settings
    config.check()
    orders = [name for name, seam in config.seams.items() if not PORTS[seam.carries].outward]
    odometry = [name for name, seam in config.seams.items() if seam.carries == "odometry"]
    return replace(
        OUTSIDE,
        seams=seams_of(config),
        beliefs=beliefs_of(config),
        settings=_with_velocities if config.below == "flight_control" else _with_goals,
        canaries=(*orders[:1], *odometry[:1]),
        deterministic=config.deterministic,
    )


def _make(task: Task, wire: Wire) -> Stack:
    from scaloft_fi.outside.exchange import Exchange
    from scaloft_fi.outside.stack import DeclaredWire, words_of

    config: OutsideConfig = task.settings
    declared = DeclaredWire(wire, [seam.name for seam in seams_of(config)])
    exchange = Exchange.begin(config, declared, Path(task.folder), words_of(task))
    try:
        return _stack(task, declared, exchange)
    except BaseException:
        exchange.close()
        raise


def _rehearsed(task: Task, wire: Wire) -> Stack:
    from scaloft_fi.outside.border import BORDERS

    BORDERS[task.settings.border].need()
    return _stack(task, wire, None)


def _stack(task: Task, wire: Wire, exchange: Any) -> Stack:
    from scaloft_fi.outside.stack import GoalStack, VelocityStack

    config: OutsideConfig = task.settings
    return (VelocityStack if config.below == "flight_control" else GoalStack)(task, wire, exchange)


def _settings() -> type:
    return OutsideConfig


def _with_velocities() -> type:
    from scaloft_fi.outside.stack import VelocityConfig

    return VelocityConfig


def _with_goals() -> type:
    from scaloft_fi.outside.stack import GoalConfig

    return GoalConfig


OUTSIDE = Declaration(
    name="outside",
    seams=(),
    beliefs=(),
    make=_make,
    settings=_settings,
    operators=("scaloft_fi.mutants.reference", "scaloft_fi.outside.faults"),
    deterministic=False,
    forks=False,
    shape=shaped,
    rehearse=_rehearsed,
)
