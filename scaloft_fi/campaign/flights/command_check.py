"""Prove before the first flight of a command what would fail in each."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from scaloft_fi.campaign.flights.command_log import known_in, needs_of, values_of
from scaloft_fi.campaign.flights.recorded import mapping_of
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.errors import InputError
from scaloft_fi.judge.requirement import judge_signals
from scaloft_fi.judge.stl import tokenize
from scaloft_fi.outside.command import FlightCommand
from scaloft_fi.outside.records.record_map import RECORDS, RecordMap, kind_of
from scaloft_fi.outside.records.recorded import Known, lacking
from scaloft_fi.study import Study


def check_command(study: Study, command: FlightCommand, say: Callable[[str], None]) -> None:
    """Check the program, the places of its words and the mapping of its record, and parse the formulas.

    Args:
        study: the study.
        command: its command.
        say: told which values of axes count as not met.

    Raises:
        InputError: the study cannot be flown.
    """
    first = Flight(None, study.grid.situations[0], 0)
    values = values_of(study, first, Path("folder"), command)
    program, *_ = [word.filled(values) for word in command.run]
    for text in command.env.values():
        text.filled(values)
    if shutil.which(program) is None and not (study.folder / program).is_file():
        raise InputError(f"{command.run[0].place}: there is no program {program!r} here")
    if Path(command.record).suffix.lower() not in RECORDS and Path(command.record).suffix:
        kind_of(Path(command.record))
    mapping, known = mapping_of(study), known_in(study, command, first.situation)
    for name, by in needs_of(study).items():
        if lack := lacking(mapping, known, name):
            raise InputError(f"{study.folder / 'sim' / 'record.yaml'}: {by} needs the signal {name!r}, and {lack}")
    for sentence in _unmet(study, mapping, known):
        say(sentence)
    zeros = dict.fromkeys((*study.signals, "elapsed_s"), np.zeros(2))
    for requirement in study.requirements:
        judge_signals(requirement, zeros, cut_short=False)


def _unmet(study: Study, mapping: RecordMap, known: Known) -> Iterator[str]:
    """A sentence for each value of an axis of which no record can tell whether a flight met it."""
    for axis in study.grid.axes:
        for value in axis.values:
            names = set(tokenize(value.realised)) & set(study.signals) if value.realised else set[str]()
            lost = next((name for name in sorted(names) if lacking(mapping, known, name)), None)
            if lost:
                yield f"{axis.id}{value.id} counts as not met in every flight: {mapping.name} maps no signal {lost!r}"
