"""The stacks that can be put under test with their claims, and the choice of one in `sim/stack.yaml`."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.model import read
from scaloft_fi.registry import Registry
from scaloft_fi.stack.declaration import Claim, ConfigError, Declaration

CLAIMS = Registry[tuple[Claim, ...]]("claims of the stack")
CLAIMS.promise("reference", "scaloft_fi.stack.reference.declaration:CLAIMS")


def declare_claims(stack: str, *claims: Claim) -> None:
    """Declare what the stages of a stack believe of the world.

    Args:
        stack: name of the stack.
        claims: a claim for each belief that the ground truth can contradict.

    Raises:
        ValueError: claims of that stack are declared already.
    """
    CLAIMS.declare(stack, claims)


def claims_of(declared: Declaration, signals: Collection[str]) -> tuple[Claim, ...]:
    """The claims of a stack; none where none are declared.

    Args:
        declared: the stack.
        signals: names of the log's signals.

    Raises:
        InputError: a claim names a seam or a signal that does not exist.
    """
    if declared.name not in CLAIMS:
        return ()
    claims = CLAIMS[declared.name]
    for claim in claims:
        seams = [claim.seam] if claim.seam else []
        for noun, names, known in (("seam", seams, declared.by_name), ("signal", claim.about, signals)):
            for name in names:
                if name not in known:
                    place = f"stack {declared.name!r}: claim {claim.stage!r}"
                    raise InputError(f"{place}: {noun} {name!r} does not exist{did_you_mean(name, known)}")
    return claims


STACKS = Registry[Declaration]("stack")
STACKS.promise("reference", "scaloft_fi.stack.reference.declaration:REFERENCE")
STACKS.promise("outside", "scaloft_fi.outside.stack:OUTSIDE")
STACKS.promise("firmware", "scaloft_fi.firmware.stack:FIRMWARE")
STACKS.promise("outside_firmware", "scaloft_fi.firmware.stack:OUTSIDE_FIRMWARE")


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
        """The settings as the model that the stack declares.

        Raises:
            InputError: the settings do not fit; the message names the place.
        """
        if declared.settings is None:
            return self.parameters
        return read(declared.settings(), self.document, beside=("name",))

    def place_of(self, path: str) -> str:
        """`file:line` of the setting at `path`, such as `stack.mission.goal_radius_m`, or of its nearest parent."""
        item = self.document
        for key in path.replace("[", ".").split(".")[1:]:
            inner = item.value.get(key) if isinstance(item.value, dict) else None
            if inner is None:
                break
            item = inner
        return item.place
