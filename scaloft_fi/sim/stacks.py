"""The stacks that can be put under test, and the choice of one in `sim/stack.yaml`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError
from scaloft_fi.registry import Registry
from scaloft_fi.stack.config import ConfigError, build
from scaloft_fi.stack.declaration import Declaration

STACKS = Registry[Declaration]("stack")
STACKS.promise("reference", "scaloft_fi.stack.reference.stack:REFERENCE")
STACKS.promise("outside", "scaloft_fi.outside.declaration:OUTSIDE")


def declare_stack(declared: Declaration) -> None:
    """Declare a stack, so that `sim/stack.yaml` can name it.

    Raises:
        ValueError: the name is taken.
    """
    STACKS.declare(declared.name, declared)


@dataclass(frozen=True, eq=False)
class StackChoice:
    """The choice of the stack.

    Attributes:
        name: name in the registry of stacks.
        parameters: settings of the stack, plain data.
        document: the document of the settings, for the places of errors.
    """

    name: str
    parameters: Mapping[str, Any]
    document: Item

    @classmethod
    def read(cls, document: Item) -> StackChoice:
        """Read `sim/stack.yaml`; the settings are checked when they are asked for.

        Raises:
            InputError: the document names no stack.
        """
        parameters = {key: entry.plain() for key, entry in document.mapping().items() if key != "name"}
        return cls(document.need("name").text(), parameters, document)

    @cached_property
    def declaration(self) -> Declaration:
        """The declaration of the stack; of a stack whose seams are data, the one that follows from the settings.

        Raises:
            InputError: there is no such stack, or its settings do not fit.
        """
        try:
            declared = STACKS[self.name]
        except InputError as error:
            raise InputError(f"{self.document.need('name').place}: {error}") from None
        if declared.shape is None:
            return declared
        try:
            return declared.shape(self.settings(declared))
        except ConfigError as error:
            raise InputError(f"{self.place_of(error.path)}: {error}") from error

    def settings(self, declared: Declaration) -> Any:
        """The settings in the schema that the stack declares.

        Raises:
            InputError: the settings do not fit; the message names the place.
        """
        if declared.settings is None:
            return self.parameters
        try:
            return build(declared.settings(), self.parameters)
        except ConfigError as error:
            raise InputError(f"{self.place_of(error.path)}: {error}") from error

    def place_of(self, path: str) -> str:
        """`file:line` of the setting at `path`, such as `stack.mission.goal_radius_m`, or of its nearest parent."""
        item = self.document
        for key in path.replace("[", ".").split(".")[1:]:
            inner = item.value.get(key) if isinstance(item.value, dict) else None
            if inner is None:
                break
            item = inner
        return item.place
