"""Flights that a command of the study flies, and records of flights from anywhere: read, checked, judged."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.document import is_there
from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.judge.requirement import Reading, Requirement, comparisons, judge_signals
from scaloft_fi.judge.stl import parse, tokenize
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.mutants.wire import SeamCount
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
    runs,
)
from scaloft_fi.outside.exchange import FlightFolder
from scaloft_fi.outside.records import (
    DERIVED,
    PLACE,
    READY,
    RECORDS,
    Known,
    RecordedFlight,
    RecordMap,
    flight_log,
    kind_of,
    lacking,
    load_record_map,
    names_of,
    own_map,
    ready_map,
)
from scaloft_fi.sim.log import CLEARANCE_CAP_M, FAR_M, FlightLog
from scaloft_fi.sim.situation import leaves
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.sim.situation import Situation
    from scaloft_fi.stack.declaration import Wire


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
    with closing(FlightFolder()) as made:
        folder, beside = made.path / "flight", made.path / "beside"
        folder.mkdir()
        beside.mkdir()
        values = values_of(study, flight, folder, command)
        words = [word.filled(values) for word in command.run]
        env = {name: text.filled(values) for name, text in command.env.items()}
        relays = Relays(command.relays, study.stack, wire, beside, command.clock)
        try:
            env |= relays.begin()
            attend = relays.attend if command.relays else None
            own = study.folder.resolve()
            told = run_command(words, env, own, command.limit_s, beside, attend, made.lifeline)
        finally:
            relays.close()
        try:
            log = _read(study, folder, command, mapping, known)
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
    return {**TRACK, **needed_by(study.requirements, study.signals)}


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


def _read(study: Study, folder: Path, command: FlightCommand, mapping: RecordMap, known: Known) -> FlightLog:
    """The log of the record that the command wrote.

    Raises:
        InputError: there is none, or more than one fits, or it cannot be read.
    """
    found = sorted(folder.glob(command.record))
    if len(found) != 1:
        raise InputError(f"{len(found)} files {command.record!r} must be 1: the command writes it to {{record}}")
    needed, beliefs = needs_of(study), study.stack.belief_names
    wanted = mapping.signals
    log = flight_log(found[0], mapping, known, needed=needed, wanted=wanted, beliefs=beliefs, limited=True).log
    count = len(log.signals["elapsed_s"])
    far = {name: np.full(count, value) for name, value in FAR.items() if name not in log.signals}
    return replace(log, signals={**log.signals, **far})


def _counts(
    command: FlightCommand,
    flight: Flight,
    recorded: Mapping[str, SeamCount],
    relayed: Mapping[str, SeamCount],
    told: Told,
) -> Mapping[str, SeamCount]:
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
        return {seam: SeamCount(carried, told.altered, told.first_altered_s)}
    if recorded or flight.mutant == PLACEBO:
        return recorded
    raise CommandError('neither a last line {"altered": COUNT} nor the record says how many samples the fault altered')


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
    if not runs(program, study.folder):
        raise InputError(f"{command.run[0].place}: there is no program {program!r} here that can be run")
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


@dataclass(frozen=True)
class JudgedRequirement:
    """What a requirement says of a record.

    Attributes:
        reading: the reading.
        place: where the requirement is first violated (x, y, z) [m, world]; None without a violation.
        unknown: the signal that the requirement needs and that is too old to say it; "" where it is known.
        between_s: when messages between two samples violate what holds in the samples [s]; None = nowhere.
    """

    reading: Reading
    place: tuple[float, float, float] | None
    unknown: str
    between_s: float | None


@dataclass(frozen=True)
class JudgedRecord:
    """A record, the flight that it tells of, and a finding for each requirement of the study."""

    path: Path
    flight: RecordedFlight
    findings: tuple[JudgedRequirement, ...]


def mapping_of(study: Study, named: Path | str | None = None, record: Path | None = None) -> RecordMap:
    """The mapping `named`, else the study's `sim/record.yaml`, else that of the records that we write ourselves.

    Args:
        study: the study.
        named: a file, or the name of a ready mapping.
        record: the record, for a ready mapping.

    Raises:
        InputError: it is no mapping.
    """
    own = study.folder / "sim" / "record.yaml"
    if named is None:
        return load_record_map(own) if is_there(own) else own_map(study.signals)
    if str(named) in READY and record is not None and not is_there(Path(named)):
        return ready_map(str(named), frozenset(names_of(record)))
    if not is_there(Path(named)) and not Path(named).suffix:
        raise InputError(
            f"--record={shown(str(named))} must be a file or a ready mapping{did_you_mean(str(named), READY)}"
        )
    return load_record_map(Path(named))


def known_of(study: Study, situation: Situation | None) -> Known:
    """What is known of a flight beside its record; without a `situation` neither route nor time limit."""
    if situation is None:
        world = study.grid.world()
        return Known(world.surfaces, world.mission.home)
    scenario = study.scenario(situation)
    world = scenario.world
    return Known(world.surfaces, world.mission.home, scenario.route, study.limit_s(situation))


def needed_by(requirements: Iterable[Requirement], names: Collection[str]) -> Mapping[str, str]:
    """The signals among `names` that requirements need, each with the first requirement that needs it."""
    needed = dict[str, str]()
    for requirement in requirements:
        for name in sorted(_words(requirement).intersection(names)):
            needed.setdefault(name, f"requirement {requirement.name}")
    return needed


def _words(requirement: Requirement) -> set[str]:
    texts = (requirement.text, requirement.trigger, *(text for _, text in requirement.definitions))
    return {word for text in texts for word in tokenize(text)}


def judged_record(study: Study, path: Path, mapping: RecordMap, known: Known) -> JudgedRecord:
    """Judge a record with the study's requirements.

    Raises:
        InputError: the record cannot be read, or lacks what a requirement needs.
    """
    recorded = [*mapping.signals, *DERIVED]
    requirements = study.requirements if mapping.ours else study.requirements_over(recorded)
    needed = needed_by(requirements, {*study.signals, *recorded})
    flight = flight_log(path, mapping, known, needed=needed, beliefs=study.stack.belief_names)
    return JudgedRecord(path, flight, tuple(_finding(requirement, flight) for requirement in requirements))


def _finding(requirement: Requirement, flight: RecordedFlight) -> JudgedRequirement:
    log, words = flight.log, _words(requirement)
    judgement = judge_signals(requirement, log.signals, cut_short=log.ending.cut_short)
    at = slice(None) if judgement.sample is None else slice(judgement.sample, judgement.sample + 1)
    unknown = next((name for name in sorted(words & flight.stale.keys()) if flight.stale[name][at].any()), "")
    if judgement.sample is None:
        return JudgedRequirement(judgement.reading, None, unknown, _between(requirement, flight))
    x_m, y_m, z_m = (float(log.signals[name][judgement.sample]) for name in PLACE)
    return JudgedRequirement(judgement.reading, (x_m, y_m, z_m), unknown, None)


def _between(requirement: Requirement, flight: RecordedFlight) -> float | None:
    """When the least or the greatest values between samples violate a requirement that holds in the samples [s].

    A signal takes the value that a comparison with a number in the requirement holds least.
    """
    texts = [requirement.text, *(text for _, text in requirement.definitions)]
    senses = {(name, sense[0]) for text in texts for _, name, sense, _ in comparisons(parse(tokenize(text)))}
    for sense, worst in (("<", 1), (">", 0)):
        names = [name for name, own in senses if own == sense and name in flight.between]
        signals = {**flight.log.signals, **{name: flight.between[name][worst] for name in names}}
        reading = judge_signals(requirement, signals, cut_short=False).reading if names else None
        if reading is not None and reading.violated_at_s is not None:
            return reading.violated_at_s
    return None
