"""The stacks that can be put under test, by the name that `sim/stack.yaml` gives."""

from __future__ import annotations

from collections.abc import Callable

from scaloft_fi.registry import Registry
from scaloft_fi.stack.reference.stack import ReferenceStack, Stack, Task
from scaloft_fi.stack.seam import Wire

STACKS = Registry[Callable[[Task, Wire], Stack]]("stack")
STACKS.declare("reference", ReferenceStack)
