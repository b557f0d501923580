"""`scaloft-fi seams`: list the study's seams, without flying."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from types import CodeType
from typing import Annotated, Any, ClassVar

from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.stack.declaration import Seam
from scaloft_fi.stack.messages import field_names
from scaloft_fi.study import Study
from scaloft_fi.verbs.listing import Entry, Listing, MessageField, fields_of
from scaloft_fi.verbs.names import seams
from scaloft_fi.verbs.options import Option
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output

OVERVIEW = {
    "seam": "name",
    "message": "message",
    "Hz": "rate_hz",
    "edge": "edge",
    "cells": "used_by",
    "operators": "fitting",
}
EVERYTHING = "all of the sample"


@dataclass(frozen=True)
class ListedSeam(Entry):
    """A seam.

    Attributes:
        message: type of its samples.
        about: what the message says of itself.
        edge: who sends, and who receives.
        rate_hz: how often it is polled [Hz].
        fields: the fields of a sample.
        acts_on: what of a sample the consumer acts on; it is altered only where this differs.
        canary: whether `run --mutant` flies a control here.
        carried: who alters the samples where a command flies; empty where our simulator flies.
        operators: the operators that fit.
        cells: the cells that have a fault here.
    """

    message: str
    about: str
    edge: str
    rate_hz: float
    fields: tuple[MessageField, ...]
    acts_on: tuple[str, ...]
    canary: bool
    carried: str
    operators: tuple[str, ...]
    cells: tuple[str, ...]
    KEYS: ClassVar = (
        *("name", "message", "about", "edge", "rate_hz", "fields", "acts_on", "canary", "carried"),
        *("operators", "cells", "used_by", "fitting"),
    )

    @property
    def used_by(self) -> int:
        """How many cells."""
        return len(self.cells)

    @property
    def fitting(self) -> int:
        """How many operators."""
        return len(self.operators)

    def sheet(self) -> Sequence[tuple[str, str]]:
        """The seam whole."""
        every = self.acts_on == tuple(field.name for field in self.fields)
        return [
            ("edge", self.edge),
            ("rate", f"{self.rate_hz:g} Hz"),
            ("message", f"{self.message}: {self.about}"),
            *(("fields", str(field)) for field in self.fields),
            ("its consumer acts on", EVERYTHING if every else ", ".join(self.acts_on)),
            ("altered by", self.carried),
            ("canary", "yes: `run --mutant` flies a control here" if self.canary else ""),
            ("operators that fit", ", ".join(self.operators)),
            ("cells", ", ".join(self.cells) or "none"),
        ]


@dataclass(frozen=True)
class Seams:
    """The seams of the study's stack, where faults can be patched in.

    Attributes:
        seams: the seams.
    """

    seams: tuple[ListedSeam, ...]


FORM = Output("seams", "1.0", Seams, rows="seams")


def seam_list(study: Study) -> Listing[ListedSeam]:
    """Every seam of the study's stack.

    Raises:
        InputError: a part of the study cannot be read.
    """
    stack, matrix = study.stack, study.matrix
    listed = tuple(
        ListedSeam(
            name=seam.name,
            message=seam.message.__name__,
            about=" ".join((seam.message.__doc__ or "").split()),
            edge=seam.edge,
            rate_hz=seam.rate_hz,
            fields=fields_of(seam),
            acts_on=acted_on(seam),
            canary=seam.name in stack.canaries,
            carried=_carried(study, seam.name),
            operators=tuple(name for name in sorted(OPERATORS) if OPERATORS[name].need.met_by(seam.message)),
            cells=tuple(cell.name for cell in matrix if any(fault.seam == seam.name for fault in cell.faults)),
        )
        for seam in stack.seams
    )
    notes = (
        "edge: who sends, and who receives.  cells: how many cells of the matrix have a fault here.",
        "operators: how many fit its message.  `scaloft-fi seams NAME` shows one whole.",
    )
    return Listing("seam", f"Seams of the stack {stack.name}: {len(listed)}", OVERVIEW, listed, FORM, notes)


def acted_on(seam: Seam) -> tuple[str, ...]:
    """What of a sample its consumer acts on, fields or properties; a sample is altered only where these differ.

    A declared effect is a function of the sample; it acts on what its code names.
    """
    fields = field_names(seam.message)
    if seam.effect is Seam.__dataclass_fields__["effect"].default:
        return tuple(fields)
    named = set(_names(seam.effect))
    properties = [name for name, one in vars(seam.message).items() if isinstance(one, property)]
    return tuple(name for name in (*fields, *properties) if name in named)


def _names(function: Callable[..., Any]) -> Iterator[str]:
    waiting = [function.__code__] if hasattr(function, "__code__") else []
    while waiting:
        code = waiting.pop()
        yield from code.co_names
        waiting += [inner for inner in code.co_consts if isinstance(inner, CodeType)]


def _carried(study: Study, seam: str) -> str:
    """Who alters the samples of a faulty seam where a command flies; "" where our wire does."""
    if study.command is None:
        return ""
    relay = study.command.relays.get(seam)
    if relay is None:
        return "the command: it gets the fault in {fault} and injects it itself"
    return f"our relay from {relay.source} to {relay.to} over {relay.border}"


@verb(
    "seams",
    examples=(
        ("List all seams", "scaloft-fi seams"),
        ("Show one whole, with the operators that fit", "scaloft-fi seams velcmd"),
        ("Write them all as JSON", "scaloft-fi seams --format json"),
    ),
)
def seams_command(
    study: Study, names: Annotated[tuple[str, ...], Option("", "", metavar="[NAME]...", complete=seams)] = ()
) -> Answer:
    """List the seams of the study's stack, where faults can be patched in.

    Without a NAME an overview; NAME, or a pattern with *, ? or [, shows these whole: the fields with their units,
    what the consumer acts on, the operators that fit, and the cells that use the seam.
    """
    return seam_list(study).answer(names)
