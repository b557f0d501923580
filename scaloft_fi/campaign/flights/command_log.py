"""Fly one flight with the command of the study, and read its record."""

from __future__ import annotations

import json
import math
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scaloft_fi.campaign.flights.recorded import known_of, mapping_of, needed_by
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.errors import InputError
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.outside.command import (
    FAULT,
    FLIGHT_FOLDER,
    PYTHON,
    RECORD,
    SEED,
    SITUATION,
    STUDY,
    CommandError,
    FlightCommand,
    Relays,
    Told,
    run_command,
)
from scaloft_fi.outside.records.recorded import RecordCount, flight_log
from scaloft_fi.sim.log import CLEARANCE_CAP_M, FAR_M, Count, FlightLog
from scaloft_fi.sim.patch import leaves

if TYPE_CHECKING:
    from scaloft_fi.outside.records.record_map import RecordMap
    from scaloft_fi.outside.records.recorded import Known
    from scaloft_fi.sim.situation import Situation
    from scaloft_fi.stack.declaration import Wire
    from scaloft_fi.study import Study

TRACK = {"speed_mps": "the track of a flight"}
"""What a record needs beside what the requirements need."""
FAR: Mapping[str, float] = {"clearance_m": CLEARANCE_CAP_M, "person_sight_m": FAR_M}
"""What the track says where neither the record nor a requirement has the signal: that nothing is near."""


def command_log(study: Study, command: FlightCommand, flight: Flight, wire: Wire) -> FlightLog:
    """Run the command, with its relays, and read its record.

    Args:
        study: the study.
        command: its command.
        flight: the flight.
        wire: carries the samples of the relays.

    Raises:
        BorderError: the command or a relay cannot be started, or a relay cannot carry what comes.
        CommandError: the command fails, or its record cannot be read.
        InputError: the command has a place for a value that there is not, or the mapping of its record is wrong.
    """
    if flight.mutant is not None and flight.mutant.event and not command.injects(flight.mutant.seam):
        raise CommandError(f"{flight.mutant.id} strikes at an event, and a relay is told of none")
    mapping, known = mapping_of(study), known_in(study, command, flight.situation)
    with tempfile.TemporaryDirectory(prefix="scaloft-fi-", ignore_cleanup_errors=True) as made:
        folder, beside = Path(made) / "flight", Path(made) / "beside"
        folder.mkdir()
        beside.mkdir()
        values = values_of(study, flight, folder, command)
        words = [word.filled(values) for word in command.run]
        env = {name: text.filled(values) for name, text in command.env.items()}
        relays = Relays(command.relays, study.stack, wire, beside, command.clock)
        try:
            env |= relays.begin()
            attend = relays.attend if command.relays else None
            told = run_command(words, env, study.folder.resolve(), command.limit_s, beside, attend)
        finally:
            relays.close()
        try:
            log = _read(study, _record_in(folder, command), mapping, known)
        except InputError as error:
            raise CommandError(f"its record: {error}") from error
    carried = getattr(wire, "counts", {}) if command.relays else {}
    return replace(log, stack_error=told.stack_error, counts=_counts(command, flight, log.counts, carried, told))


def known_in(study: Study, command: FlightCommand, situation: Situation) -> Known:
    """What is known of a flight of the command beside its record."""
    known = known_of(study, situation)
    return known if command.mission_s is None else replace(known, limit_s=command.mission_s)


def needs_of(study: Study) -> Mapping[str, str]:
    """The signals that a record of the command must have, each with who needs it."""
    return {**TRACK, **needed_by(study)}


def values_of(study: Study, flight: Flight, folder: Path, command: FlightCommand) -> dict[str, Any]:
    """The values that a command may ask for: of the flight, of its axes, and of the documents of its situation."""
    situation, grid = flight.situation, study.grid
    mutant = flight.mutant
    fault = mutant.to_json() if mutant is not None and command.injects(mutant.seam) else None
    documents = grid.documents_with(grid.values(situation).values())
    plain = {f"{name}.{path}": item.value for name, item in documents.items() for path, item in leaves(item)}
    return {
        **{path: value for path, value in plain.items() if not isinstance(value, float) or math.isfinite(value)},
        **dict(situation.levels),
        **dict(situation.numbers),
        SITUATION: situation.key,
        SEED: flight.seed,
        FLIGHT_FOLDER: str(folder),
        RECORD: str(folder / command.record),
        PYTHON: sys.executable,
        STUDY: str(study.folder.resolve()),
        FAULT: json.dumps(fault, sort_keys=True),
    }


def _record_in(folder: Path, command: FlightCommand) -> Path:
    """The record that the command wrote.

    Raises:
        InputError: there is none, or more than one fits.
    """
    found = sorted(folder.glob(command.record))
    if len(found) != 1:
        raise InputError(f"{len(found)} files {command.record!r} must be 1: the command writes it to {{record}}")
    return found[0]


def _read(study: Study, path: Path, mapping: RecordMap, known: Known) -> FlightLog:
    log = flight_log(
        path, mapping, known, needed=needs_of(study), wanted=mapping.signals, beliefs=study.stack.belief_names
    )
    count = len(log.signals["elapsed_s"])
    far = {name: np.full(count, value) for name, value in FAR.items() if name not in log.signals}
    return replace(log, signals={**log.signals, **far})


def _counts(
    command: FlightCommand,
    flight: Flight,
    recorded: Mapping[str, Count],
    relayed: Mapping[str, Count],
    told: Told,
) -> Mapping[str, Count]:
    """How many samples the fault altered: by the relays, the last line of output, or else by the record.

    Raises:
        CommandError: the simulator injected the fault, and nothing says it.
    """
    if flight.mutant is None:
        return {}
    seam = flight.mutant.seam
    if not command.injects(seam):
        return {name: count for name, count in relayed.items() if name in command.relays}
    if told.altered is not None:
        carried = max(told.carried or 0, told.altered)
        return {seam: RecordCount(carried, told.altered, told.first_altered_s)}
    if recorded or flight.mutant == PLACEBO:
        return recorded
    raise CommandError('neither a last line {"altered": COUNT} nor the record says how many samples the fault altered')
