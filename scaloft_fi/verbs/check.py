"""`scaloft-fi check`: the whole study dry."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Annotated

from scaloft_fi.checks.check import Check, GridCheck, check_study
from scaloft_fi.errors import ExitCode
from scaloft_fi.hazop.load import find_study
from scaloft_fi.output import line
from scaloft_fi.verbs.options import Option, StudyFolder, TableFormat, TablesFolder, Untrusted, allow, answer, verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Format, Table, TableCell, counted, render

NOT_CHECKED = "not checked"
CHECK = Output("check", "1.0", Check, rows="findings")


def check_tables(check: Check) -> tuple[Table, Table]:
    """The findings; and how much was checked, with the sum."""
    rows = ((f.severity.value, f.place, f.what, f.situation, f.remedy) for f in check.findings)
    errors = counted(check.errors, "error") if check.errors else "no errors"
    sum_ = f"{check.study}: {errors}, {counted(check.notes, 'note')}."
    return (
        Table("Findings", ("severity", "place", "what", "situation", "remedy"), tuple(rows)),
        Table("Checked", ("what", "how much"), tuple(_rows(check)), (sum_,)),
    )


def _rows(check: Check) -> Iterator[tuple[TableCell, ...]]:
    checked = check.checked
    yield "documents", checked.documents
    yield "plugins", checked.plugins
    yield "requirements", _known(checked.requirements)
    for grid in check.grids:
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
    which = "all" if grid.built == grid.situations else str(grid.built)
    told = f"{grid.situations} situations, {which} built with {grid.pairs} pairs of values; {grid.legs} places and legs"
    return told if grid.built else NOT_CHECKED


def _known(number: int | None) -> TableCell:
    return NOT_CHECKED if number is None else number


def checked(check: Check) -> Answer:
    """Every finding of a check with its place and remedy, and how much was checked."""

    def told(how: Format) -> str:
        findings, sums = check_tables(check)
        if how is not Format.TABLE:
            return render((findings, sums), how)
        # a line as compilers write it, so that an editor jumps to the place
        lines = "".join(f"{line(str(finding))}\n" for finding in check.findings)
        return f"{lines}\n" * bool(lines) + render((sums,), how)

    return Answer(CHECK, lambda: check, lambda: check_tables(check), told=told)


@verb("check")
def check_command(
    *,
    study_folder: StudyFolder,
    fly: Annotated[bool, Option("Fly one baseline flight too, and show which seams the stack polls.")],
    untrusted: Untrusted,
    style: TableFormat,
    tables_folder: TablesFolder,
) -> int:
    """Check the whole study without flying, and print every finding with its place and remedy.

    An error (exit code 2) is what a verb would refuse, or what no flight can mean.  A note (exit code 0) is
    what somebody should know.  Nothing in the study is written.

    Examples:
        Check the study before the first flight: `scaloft-fi check`
        See too which seams the stack polls, by one flight: `scaloft-fi check --fly`
        Let a script read the findings: `scaloft-fi check --study my_study --format json`
    """
    check = check_study(find_study(study_folder), fly=fly, allow=partial(allow, untrusted=untrusted))
    answer(checked(check), style, tables_folder)
    return ExitCode.BAD_INPUT if check.errors else ExitCode.DONE
