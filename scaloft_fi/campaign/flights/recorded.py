"""Judge a record of a flight: what the study asks of it, and what it says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.document import is_there
from scaloft_fi.judge.requirement import Reading, Requirement, judge_signals
from scaloft_fi.judge.stl import tokenize
from scaloft_fi.outside.records.record_map import RecordMap, load_record_map, own_map
from scaloft_fi.outside.records.recorded import Known, flight_log

if TYPE_CHECKING:
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.sim.situation import Situation
    from scaloft_fi.study import Study


@dataclass(frozen=True)
class Finding:
    """What a requirement says of a record.

    Attributes:
        reading: the reading.
        place: where the requirement is first violated (x, y, z) [m, world]; None without a violation.
    """

    reading: Reading
    place: tuple[float, float, float] | None


@dataclass(frozen=True)
class JudgedRecord:
    """A record, its flight log, and a finding for each requirement of the study."""

    path: Path
    log: FlightLog
    findings: tuple[Finding, ...]


def mapping_of(study: Study, path: Path | None = None) -> RecordMap:
    """The mapping in `path`, else the study's `sim/record.yaml`, else that of the records that we write ourselves.

    Raises:
        InputError: it is no mapping, or maps a signal that the study does not know.
    """
    own = study.folder / "sim" / "record.yaml"
    if path is None and not is_there(own):
        return own_map(study.signals)
    return load_record_map(path or own, study.signals)


def known_of(study: Study, situation: Situation | None) -> Known:
    """What is known of a flight beside its record; without a `situation` neither route nor time limit."""
    if situation is None:
        world = study.grid.world()
        return Known(world.surfaces, world.mission.home)
    scenario = study.scenario(situation)
    world = scenario.world
    return Known(world.surfaces, world.mission.home, scenario.route, study.limit_s(situation))


def needed_by(study: Study) -> Mapping[str, str]:
    """The signals that the requirements need, each with the first requirement that needs it."""
    names, needed = frozenset(study.signals), dict[str, str]()
    for requirement in study.requirements:
        for name in sorted(_words(requirement) & names):
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
    log = flight_log(path, mapping, known, needed=needed_by(study), beliefs=study.stack.belief_names)
    return JudgedRecord(path, log, tuple(_finding(requirement, log) for requirement in study.requirements))


def _finding(requirement: Requirement, log: FlightLog) -> Finding:
    judgement = judge_signals(requirement, log.signals, cut_short=log.ending.cut_short)
    if judgement.sample is None:
        return Finding(judgement.reading, None)
    x_m, y_m, z_m = (float(log.signals[name][judgement.sample]) for name in ("x_m", "y_m", "z_m"))
    return Finding(judgement.reading, (x_m, y_m, z_m))
