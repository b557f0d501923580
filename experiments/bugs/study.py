"""The reference study with another stack, so that a flight of its baseline is a flight of that stack."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from scaloft_fi.sim.load import SimConfig
from scaloft_fi.sim.stacks import STACKS
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.study import Study


@dataclass(frozen=True)
class StackStudy(Study):
    """A study that flies another stack than its `sim/stack.yaml` names, with the same settings.

    Attributes:
        stack_name: name of a declared stack.
    """

    stack_name: str = "reference"

    @cached_property
    def stack(self) -> Declaration:
        """The declaration of that stack."""
        own = super().stack
        return STACKS[self.stack_name] if self.stack_name != own.name else own

    @cached_property
    def sim(self) -> SimConfig:
        """Mine, vehicle, sensors and situations of the study, and that stack."""
        own = super().sim
        return replace(own, stack=replace(own.stack, name=self.stack_name))
