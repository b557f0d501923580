"""What the reference stack declares, and how it is made."""

from __future__ import annotations

from scaloft_fi.stack.contract import Stack, Task
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.stack.reference.beliefs import BELIEFS
from scaloft_fi.stack.reference.seams import SEAMS
from scaloft_fi.stack.seam import Wire


def _make(task: Task, wire: Wire) -> Stack:
    from scaloft_fi.stack.reference.stack import ReferenceStack

    return ReferenceStack(task, wire)


def _settings() -> type:
    from scaloft_fi.stack.reference.stack import ReferenceConfig

    return ReferenceConfig


REFERENCE = Declaration(
    name="reference",
    seams=SEAMS,
    beliefs=BELIEFS,
    make=_make,
    settings=_settings,
    canaries=("velcmd", "pose", "imu", "goal"),
    operators=("scaloft_fi.mutants.reference",),
)
