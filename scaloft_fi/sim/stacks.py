"""Registry of the stacks that can be put under test, by the name in `sim/stack.yaml`."""

from __future__ import annotations

from scaloft_fi.registry import Registry
from scaloft_fi.stack.declaration import Declaration

STACKS = Registry[Declaration]("stack")
STACKS.promise("reference", "scaloft_fi.stack.reference.declaration:REFERENCE")


def declare_stack(declared: Declaration) -> None:
    """Declare a stack, so that `sim/stack.yaml` can name it.

    Raises:
        ValueError: the name is taken.
    """
    STACKS.declare(declared.name, declared)
