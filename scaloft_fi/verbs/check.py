"""`scaloft-fi check`: the whole study dry."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Annotated, Any

from scaloft_fi.checks.check import Check, Checked, check_study
from scaloft_fi.checks.finding import Severity
from scaloft_fi.checks.situations import GridCheck
from scaloft_fi.console import line
from scaloft_fi.errors import ExitCode
from scaloft_fi.hazop.load import find_study
from scaloft_fi.verbs.options import Option, StudyFolder, TableFormat, TablesFolder, answer
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output, count, listing, optional, record, text
from scaloft_fi.views.table import Format, Table, TableCell, render

NOT_CHECKED = "not checked"
_UNREAD = "an error before it left it unchecked"
CHECK = Output(
    "check",
    "1.0",
    "what the dry check of a study found",
    {
        "study": text("folder of the study"),
        "errors": count("findings that a verb refuses, or that make flights mean nothing; the exit code is then 2"),
        "notes": count("findings that somebody should know"),
        "findings": listing(
            "what was found, errors first",
            record(
                "one finding",
                {
                    "severity": text("how bad it is", Severity),
                    "file": text("the file to mend; empty where none is meant"),
                    "line": optional(count("its line, from 1"), "the whole file is meant"),
                    "what": text("what is wrong, in a sentence"),
                    "situation": text("key of a situation in which it shows; empty where none is meant"),
                    "remedy": text("what to do about it; empty where the sentence says it"),
                },
            ),
        ),
        "checked": record(
            "how much was checked",
            {
                "documents": count("YAML files"),
                "plugins": count("plugins of this installation"),
                "requirements": optional(count("requirements"), _UNREAD),
                "cells": count("cells of the matrix"),
                "faulty": count("cells of the matrix that have faults"),
                "mutants": optional(count("mutants that matrix and catalogue have"), _UNREAD),
                "seams": optional(count("seams that the stack declares"), _UNREAD),
                "polled": optional(count("seams that the stack polls in one baseline flight"), "nothing was flown"),
                "unflown": text("why nothing was flown; empty where it was"),
                "found": count("situations in sim/found.yaml"),
                "accepted": count("survivors in hazop/dispositions.yaml"),
            },
        ),
        "grids": listing(
            "how much of each grid was checked",
            record(
                "one grid",
                {
                    "name": text("its name"),
                    "situations": count("its situations; 0 where it cannot be read"),
                    "built": count("situations whose world, vehicle, sensors and route were built"),
                    "pairs": count("pairs of values of two axes in these"),
                    "predicates": count("formulas `realised`"),
                    "legs": count("places and legs of routes where the hull was compared with rock and bodies"),
                },
            ),
        ),
    },
    rows="findings",
)


def check_values(check: Check) -> dict[str, Any]:
    """Plain JSON values of the form `CHECK`."""
    checked = asdict(check.checked)
    grids = checked.pop("grids")
    findings = [asdict(finding) | {"severity": finding.severity.value} for finding in check.findings]
    return {
        "study": str(check.folder),
        "errors": check.errors,
        "notes": check.notes,
        "findings": findings,
        "checked": checked,
        "grids": list(grids),
    }


def finding_lines(check: Check) -> str:
    """One line for each finding, as compilers write them, so that an editor jumps to the place."""
    return "".join(f"{line(str(finding))}\n" for finding in check.findings)


def findings_table(check: Check) -> Table:
    """The findings as a table."""
    rows = ((f.severity.value, f.place, f.what, f.situation, f.remedy) for f in check.findings)
    return Table("Findings", ("severity", "place", "what", "situation", "remedy"), tuple(rows))


def checked_table(check: Check) -> Table:
    """How much was checked, and the sum."""
    errors = f"{check.errors} error{'s' * (check.errors != 1)}" if check.errors else "no errors"
    sum_ = f"{check.folder}: {errors}, {check.notes} note{'s' * (check.notes != 1)}."
    return Table("Checked", ("what", "how much"), tuple(_rows(check.checked)), (sum_,))


def _rows(checked: Checked) -> Iterator[tuple[TableCell, ...]]:
    yield "documents", checked.documents
    yield "plugins", checked.plugins
    yield "requirements", _known(checked.requirements)
    for grid in checked.grids:
        yield f"grid {grid.name}", _built(grid)
        yield f"grid {grid.name}: realised", f"{grid.predicates} formulas"
    yield "cells", f"{checked.cells}, {checked.faulty} with faults"
    yield "mutants", _known(checked.mutants)
    yield "seams", _known(checked.seams)
    polled = f"{NOT_CHECKED}: {checked.unflown}" if checked.polled is None else checked.polled
    yield "seams that the stack polls", polled
    yield "found situations", checked.found
    yield "accepted survivors", checked.accepted


def _built(grid: GridCheck) -> str:
    if not grid.built:
        return NOT_CHECKED
    which = "all" if grid.built == grid.situations else str(grid.built)
    return f"{grid.situations} situations, {which} built with {grid.pairs} pairs of values; {grid.legs} places and legs"


def _known(number: int | None) -> TableCell:
    return NOT_CHECKED if number is None else number


def checked(check: Check) -> Answer:
    """Every finding of a check with its place and remedy, and how much was checked."""

    def told(how: Format) -> str:
        if how is not Format.TABLE:
            return render((findings_table(check), checked_table(check)), how)
        lines, summary = finding_lines(check), render((checked_table(check),), how)
        return f"{lines}\n{summary}" if lines else summary

    return Answer(CHECK, lambda: check_values(check), lambda: (findings_table(check), checked_table(check)), told=told)


@verb(
    "check",
    examples=(
        ("Check the study before the first flight", "scaloft-fi check"),
        ("See too which seams the stack polls, by one flight", "scaloft-fi check --fly"),
        ("Let a script read the findings", "scaloft-fi check --study my_study --format json"),
    ),
)
def check_command(
    *,
    study_folder: StudyFolder,
    fly: Annotated[bool, Option("Fly one baseline flight too, and show which seams the stack polls.")],
    style: TableFormat,
    tables_folder: TablesFolder,
) -> int:
    """Check the whole study without flying, and print every finding with its place and remedy.

    An error (exit code 2) is what a verb would refuse, or what no flight can mean; a note (exit code 0) is what
    somebody should know.  Nothing in the study is written.
    """
    check = check_study(find_study(study_folder), fly=fly)

    answer(checked(check), style, tables_folder)
    return ExitCode.BAD_INPUT if check.errors else ExitCode.DONE
