"""Mutants as plain JSON values: what `mutants` prints for programs."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import count, flag, listing, number, record, text
from scaloft_fi.views.worksheet.matrix_record import ARGUMENTS

MUTANTS = Output(
    "mutants",
    "1.0",
    "the mutants that the deviation matrix gives",
    {
        "catalogue": record(
            "the written catalogue",
            {
                "path": text("its file"),
                "current": flag("whether it is what the matrix gives"),
                "written": flag("whether this call has written it"),
                "mutants": count("mutants that the matrix gives"),
                "cells": count("cells that have mutants"),
            },
        ),
        "mutants": listing(
            "the mutants asked for; with --write and --check all of them",
            record(
                "a mutant",
                {
                    "id": text("canonical id"),
                    "guideword": text("its guideword"),
                    "parameter": text("its parameter"),
                    "magnitude": text("its magnitude with the unit, as in the id; empty where there is none"),
                    "phase_s": number("its shift in time", "s"),
                    "event": text("the event at which it strikes; empty for none"),
                    "seam": text("where it is patched in"),
                    "operator": text("what alters the samples"),
                    "arguments": ARGUMENTS,
                    "default": flag("whether the name of its cell stands for it"),
                },
            ),
        ),
    },
    rows="mutants",
)


def mutant_values(
    path: Path,
    derived: Sequence[Mutant],
    chosen: Sequence[Mutant],
    defaults: Collection[str],
    *,
    current: bool,
    written: bool,
) -> dict[str, Any]:
    """Plain JSON values of the form `MUTANTS`.

    Args:
        path: file of the catalogue.
        derived: every mutant that the matrix gives.
        chosen: those asked for.
        defaults: ids of the cells' defaults.
        current: whether the file has what the matrix gives.
        written: whether this call has written it.
    """
    return {
        "catalogue": {
            "path": str(path),
            "current": current,
            "written": written,
            "mutants": len(derived),
            "cells": len(defaults),
        },
        "mutants": [{"event": "", **one.to_json(), "default": one.id in defaults} for one in chosen],
    }
