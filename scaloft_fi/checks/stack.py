"""The stack of a study, the command that flies it, and the signals that both bring."""

from __future__ import annotations

import math
import re
import shutil
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.checks.finding import Finding, Findings, Severity, finding_of
from scaloft_fi.checks.requirements import KnownSignals
from scaloft_fi.document import Item, is_file, is_there, load
from scaloft_fi.errors import InputError
from scaloft_fi.judge.bounds import ANY, Ranges, ranges_of, within_rock, without
from scaloft_fi.registry import PLUGIN_GROUP, load_plugin
from scaloft_fi.sim.grids import FILE, FOLDER
from scaloft_fi.sim.load import StackChoice
from scaloft_fi.sim.log import SIGNALS, signal_names
from scaloft_fi.sim.patch import leaves
from scaloft_fi.sim.world import GROUND, WALL

if TYPE_CHECKING:
    from scaloft_fi.outside.exchange import OutsideConfig
    from scaloft_fi.sim.world import World
    from scaloft_fi.stack.declaration import Declaration
    from scaloft_fi.study import Study

_CHANGES_MINE = re.compile(r"\.set\.(world\.)?mine\b")


def check_plugins(findings: Findings) -> int:
    """Load every plugin; returns how many there are."""
    plugins = sorted(entry_points(group=PLUGIN_GROUP))
    for plugin in plugins:
        try:
            load_plugin(plugin)
        except InputError as error:
            what, _, remedy = str(error).rpartition("; ")
            findings.add(Finding(Severity.ERROR, "", None, what, remedy))
    return len(plugins)


def check_stack_choice(study: Study, findings: Findings) -> Declaration | None:
    """The declaration of the study's stack, with its settings checked; None where it cannot be read."""
    declared: Declaration | None = None
    with findings.collecting():
        _ = study.command
    with findings.collecting():
        declared = study.stack
        choice = StackChoice.read(load(study.folder / "sim" / "stack.yaml"))
        settings = choice.settings(choice.declaration)
        if choice.name == "outside":
            _check_processes(study, choice.document, settings, findings)
    return declared


def _check_processes(study: Study, document: Item, settings: OutsideConfig, findings: Findings) -> None:
    """The programs of a stack outside, and the software of its border, on this machine."""
    from scaloft_fi.outside.border import BORDERS

    try:
        BORDERS[settings.border].need()
    except InputError as error:
        place = document.need("border").place
        findings.note(place, f"border {settings.border!r} cannot be used on this machine: {error}", "install it there")
    items = document.need("processes").items()
    for item, process in zip(items, settings.processes, strict=True):
        program, *words = process.run
        folder = study.folder / process.folder
        if "{" not in program and shutil.which(program) is None and not is_file(folder / program):
            what = f"there is no program {program!r} on this machine"
            findings.note(item.place, what, "install it where flights run")
        for word in words:
            path = Path(word.replace("{study}", str(study.folder)))
            if word.startswith("{study}/") and not is_there(path):
                findings.wrong(item.place, f"the study has no file {word.removeprefix('{study}/')!r}", "add it")


def known_signals(study: Study, stack: Declaration | None, world: World | None) -> KnownSignals | None:
    """The signals of the study in one of its worlds; None where its stack is unknown.

    Where the world cannot be read, the bodies are known by their names alone.

    Raises:
        InputError: the mapping of a command's record cannot be read.
    """
    if stack is None:
        return None
    if world is None:
        entries = load(study.folder / "sim" / "world.yaml").mapping()
        bodies = entries["bodies"].value if "bodies" in entries else {}
        surfaces = (WALL, GROUND, *(bodies if isinstance(bodies, dict) else ()))
        return KnownSignals(dict.fromkeys(signal_names(surfaces, stack.beliefs, list(SIGNALS)), ANY), stack.caps)
    ours = signal_names(world.surfaces, stack.beliefs, world.signals)
    optional = {name: SIGNALS[name].most for name in world.signals if math.isfinite(SIGNALS[name].most)}
    ranges = dict(ranges_of(world, stack.beliefs, ours))
    if study.command is not None:
        return KnownSignals({**dict.fromkeys(_recorded(study), ANY), **ranges}, {**stack.caps, **optional})
    return KnownSignals(ranges | dict(without(world)) | dict(_rock(study, world)), {**stack.caps, **optional})


def _recorded(study: Study) -> tuple[str, ...]:
    """The signals that the record of a command brings."""
    from scaloft_fi.outside.records.record_map import load_record_map

    path = study.folder / "sim" / "record.yaml"
    return tuple(load_record_map(path).signals) if is_there(path) else ()


def _rock(study: Study, world: World) -> Ranges:
    """Where the rock ends, unless an axis changes the mine."""
    sim = study.folder / "sim"
    for path in (sim / FILE, *sorted((sim / FOLDER).glob("*.yaml"))):
        if any(_CHANGES_MINE.search(place) for place, _ in leaves(load(path))):
            return {}
    return within_rock(world)


def check_command_of(study: Study, findings: Findings) -> None:
    """What would fail in each flight of the study's command."""
    from scaloft_fi.campaign.flights.command_check import check_command
    from scaloft_fi.campaign.flights.recorded import mapping_of

    command = study.command
    if command is None:
        with findings.collecting():
            mapping_of(study)
        return
    for name in command.inputs:
        if not is_file(study.folder / name):
            what = f"the study has no file {name!r}, which decides what is flown"
            findings.wrong(command.place, what, "add it, or take it out of `inputs`")
    notes: list[str] = []
    with findings.collecting():
        check_command(study, command, notes.append)
    record = study.folder / "sim" / "record.yaml"
    for note in notes:
        findings.add(finding_of(f"{record}:1: {note}; map it under `signals`", Severity.NOTE))
