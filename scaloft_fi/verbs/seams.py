"""`scaloft-fi seams`: list the study's seams, without flying."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import CodeType
from typing import TYPE_CHECKING, Annotated, Any

from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.stack.declaration import Seam
from scaloft_fi.stack.messages import field_names
from scaloft_fi.verbs.listing import Listing, Record, fields_of, tell_listing
from scaloft_fi.verbs.names import seams
from scaloft_fi.verbs.options import Option, StudyFolder, TableFormat, TablesFolder
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Output, count, flag, listing, number, record, text, texts

if TYPE_CHECKING:
    from scaloft_fi.hazop.matrix import Matrix
    from scaloft_fi.study import Study


OVERVIEW = {
    "seam": "name",
    "message": "message",
    "Hz": "rate_hz",
    "edge": "edge",
    "cells": "used_by",
    "operators": "fitting",
}
FORM = Output(
    "seams",
    "1.0",
    "the seams of the study's stack, where faults can be patched in",
    {
        "seams": listing(
            "the seams",
            record(
                "a seam",
                {
                    "name": text("its name"),
                    "message": text("type of its samples"),
                    "about": text("what the message says of itself"),
                    "edge": text("who sends, and who receives"),
                    "rate_hz": number("how often it is polled", "Hz"),
                    "fields": listing(
                        "the fields of a sample",
                        record(
                            "a field",
                            {
                                "name": text("its name"),
                                "kind": text("what it is"),
                                "unit": text("its unit; empty for none"),
                            },
                        ),
                    ),
                    "acts_on": texts("what of a sample the consumer acts on; it is altered only where this differs"),
                    "canary": flag("whether `run --mutant` flies a control here"),
                    "carried": text("who alters the samples where a command flies; empty where our simulator flies"),
                    "operators": texts("the operators that fit"),
                    "cells": texts("the cells that have a fault here"),
                    "used_by": count("how many cells"),
                    "fitting": count("how many operators"),
                },
            ),
        )
    },
    rows="seams",
)
EVERYTHING = "all of the sample"


def seam_list(study: Study) -> Listing:
    """Every seam of the study's stack; `FORM` says what a record has.

    Raises:
        InputError: a part of the study cannot be read.
    """
    stack, matrix = study.stack, study.matrix
    records = tuple(_record(seam, study, matrix) for seam in stack.seams)
    notes = (
        "edge: who sends, and who receives.  cells: how many cells of the matrix have a fault here.",
        "operators: how many fit its message.  `scaloft-fi seams NAME` shows one whole.",
    )
    return Listing("seam", f"Seams of the stack {stack.name}: {len(records)}", OVERVIEW, records, _sheet, FORM, notes)


def cells_at(matrix: Matrix, seam: str) -> list[str]:
    """The cells with a fault at a seam."""
    return [cell.name for cell in matrix if any(fault.seam == seam for fault in cell.faults)]


def _record(seam: Seam, study: Study, matrix: Matrix) -> Record:
    operators = [name for name in sorted(OPERATORS) if OPERATORS[name].need.met_by(seam.message)]
    cells = cells_at(matrix, seam.name)
    return {
        "name": seam.name,
        "message": seam.message.__name__,
        "about": " ".join((seam.message.__doc__ or "").split()),
        "edge": seam.edge,
        "rate_hz": seam.rate_hz,
        "fields": fields_of(seam),
        "acts_on": acted_on(seam),
        "canary": seam.name in study.stack.canaries,
        "carried": _carried(study, seam.name),
        "operators": operators,
        "cells": cells,
        "used_by": len(cells),
        "fitting": len(operators),
    }


def acted_on(seam: Seam) -> list[str]:
    """What of a sample its consumer acts on, fields or properties; a sample is altered only where these differ.

    A declared effect is a function of the sample; it acts on what its code names.
    """
    fields = field_names(seam.message)
    if seam.effect is Seam.__dataclass_fields__["effect"].default:
        return list(fields)
    named = set(_names(seam.effect))
    properties = [name for name, one in vars(seam.message).items() if isinstance(one, property)]
    return [name for name in (*fields, *properties) if name in named]


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


def _sheet(one: Record) -> list[tuple[str, str]]:
    every = [field["name"] for field in one["fields"]]
    return [
        ("edge", one["edge"]),
        ("rate", f"{one['rate_hz']:g} Hz"),
        ("message", f"{one['message']}: {one['about']}"),
        *(("fields", _field(field)) for field in one["fields"]),
        ("its consumer acts on", EVERYTHING if one["acts_on"] == every else ", ".join(one["acts_on"])),
        ("altered by", one["carried"]),
        ("canary", "yes: `run --mutant` flies a control here" if one["canary"] else ""),
        ("operators that fit", ", ".join(one["operators"])),
        ("cells", ", ".join(one["cells"]) or "none"),
    ]


def _field(field: dict[str, str]) -> str:
    return f"{field['name']}: {field['kind']}" + (f" [{field['unit']}]" if field["unit"] else "")


@verb(
    "seams",
    examples=(
        ("List all seams", "scaloft-fi seams"),
        ("Show one whole, with the operators that fit", "scaloft-fi seams velcmd"),
        ("Write them all as JSON", "scaloft-fi seams --format json"),
    ),
)
def seams_command(
    *,
    names: Annotated[tuple[str, ...], Option("", "", metavar="[NAME]...", complete=seams)] = (),
    study_folder: StudyFolder,
    style: TableFormat,
    tables_folder: TablesFolder,
) -> None:
    """List the seams of the study's stack, where faults can be patched in.

    Without a NAME an overview; NAME, or a pattern with *, ? or [, shows these whole: the fields with their units,
    what the consumer acts on, the operators that fit, and the cells that use the seam.
    """
    tell_listing(seam_list, names, style, study_folder, tables=tables_folder)
