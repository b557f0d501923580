"""`scaloft-fi doctor`: the platform, the installation, and whether a known flight has its published digest."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution, entry_points
from pathlib import Path
from typing import Annotated

from scaloft_fi.campaign.processes import THREAD_SETTINGS, cores, one_thread_each
from scaloft_fi.campaign.runs.gates import fly_again
from scaloft_fi.campaign.store.platforms import DECIDES, fingerprint
from scaloft_fi.errors import GateError, InputError, ScaloftError
from scaloft_fi.hazop.load import find_study
from scaloft_fi.output import say
from scaloft_fi.registry import PLUGIN_GROUP, in_one_line
from scaloft_fi.study import Study
from scaloft_fi.verbs.options import Option, StudyFolder, TableFormat, TablesFolder, answer, verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table

_FOR_TESTS = "test"
"""The extra of developers, which is not listed."""
_REQUIREMENT = re.compile(r"(?P<name>[\w.-]+)(?P<range>[^;]*)(?:;.*extra == .(?P<extra>[\w-]+).)?")


@dataclass(frozen=True)
class Part:
    """A part.

    Attributes:
        part: its name.
        value: its version or setting; null: not set.
        decides_bits: whether it decides the bits of a flight.
        why: how; else empty.
    """

    part: str
    value: str | None
    decides_bits: bool
    why: str


@dataclass(frozen=True)
class Package:
    """A package.

    Attributes:
        package: its name.
        version: the installed version; null: not installed.
        extra: the extra that needs it; null: always needed.
        asks: the versions that are asked for.
    """

    package: str
    version: str | None
    extra: str | None
    asks: str


@dataclass(frozen=True)
class Plugin:
    """A plugin.

    Attributes:
        plugin: name of its entry point.
        package: its package.
        version: of the package; empty where it has none.
        loads: whether it can be loaded.
    """

    plugin: str
    package: str
    version: str
    loads: bool


@dataclass(frozen=True)
class FoundStudy:
    """The study.

    Attributes:
        folder: its folder.
        packaged: whether it is the one in the package.
        mutants: mutants of its catalogue; null: the catalogue cannot be used.
        situations: situations of its grid; null: the catalogue cannot be used.
    """

    folder: Path
    packaged: bool
    mutants: int | None = None
    situations: int | None = None


@dataclass(frozen=True)
class Machine:
    """The machine.

    Attributes:
        kernels: where compiled kernels are kept; null: nowhere.
        kernels_writable: whether that place can be written.
        processors: for this process.
        processors_in_all: in the machine.
        memory_gib: memory [GiB]; null: not known.
        memory_available_gib: available memory [GiB]; null: not known.
    """

    kernels: str | None
    kernels_writable: bool
    processors: int
    processors_in_all: int
    memory_gib: float | None = None
    memory_available_gib: float | None = None


@dataclass(frozen=True)
class KnownFlight:
    """The flight whose digest is published.

    Attributes:
        same: whether it is as published but for its bits.
        told: how it compares.
    """

    same: bool
    told: str


@dataclass(frozen=True)
class Installation:
    """What decides the bits of a flight, and what is installed.

    Attributes:
        platform: the parts of the platform.
        packages: the packages that scaloft-fi needs, and those of its extras.
        plugins: the plugins.
        study: the study.
        machine: the machine.
        known_flight: the flight whose digest is published; null: not flown.
        faults: what is wrong with plugins and study, a sentence each.
    """

    platform: tuple[Part, ...]
    packages: tuple[Package, ...]
    plugins: tuple[Plugin, ...]
    study: FoundStudy
    machine: Machine
    known_flight: KnownFlight | None
    faults: tuple[str, ...]


DOCTOR = Output("doctor", "1.0", Installation, rows="platform")


def platform_parts() -> tuple[Part, ...]:
    """The platform's fingerprint, with what decides the bits of a flight."""
    why = {**DECIDES, "OPENBLAS_CORETYPE": "yes: it names the kernels"}
    why |= dict.fromkeys(THREAD_SETTINGS, "yes: the division of a product")
    parts: dict[str, str | None] = {**fingerprint()}
    parts |= {name: os.environ.get(name) for name in ("OPENBLAS_CORETYPE", *THREAD_SETTINGS)}
    return tuple(
        Part(name, value, why[name].startswith("yes"), re.sub(r"^(yes|no)[:,]? ?", "", why[name]))
        for name, value in parts.items()
    )


def packages() -> tuple[Package, ...]:
    """The packages that scaloft-fi needs, and those of its extras, with their versions; none where it is no package."""
    own = _installed("scaloft-fi")
    required = map(_REQUIREMENT.match, (own and own.requires) or ())
    return tuple(
        Package(one["name"], found.version if found else None, one["extra"], one["range"].strip())
        for one in required
        if one and one["extra"] != _FOR_TESTS
        for found in [_installed(one["name"])]
    )


def _installed(package: str) -> Distribution | None:
    try:
        return distribution(package)
    except PackageNotFoundError:
        return None


def plugins() -> tuple[tuple[Plugin, ...], list[str]]:
    """The plugins, and a sentence for each that cannot be loaded."""
    found: list[Plugin] = []
    failed: list[str] = []
    for plugin in sorted(entry_points(group=PLUGIN_GROUP)):
        name, number = (plugin.dist.name, plugin.dist.version) if plugin.dist else (plugin.module, "")
        try:
            plugin.load()
            found.append(Plugin(plugin.name, name, number, loads=True))
        except (Exception, SystemExit) as error:  # noqa: BLE001 - code from outside may raise anything
            found.append(Plugin(plugin.name, name, number, loads=False))
            failed.append(f"plugin {plugin.name!r} of package {name!r} cannot be loaded: {in_one_line(error)}")
    return tuple(found), failed


def found_study(folder: Path | None) -> tuple[FoundStudy, list[str]]:
    """The study and a sentence for each of its faults.

    Raises:
        InputError: `folder` is no study.
    """
    study = Study(find_study(folder))
    try:
        return FoundStudy(study.folder, study.packaged, len(study.catalogue), len(study.grid.situations)), []
    except ScaloftError as error:
        return FoundStudy(study.folder, study.packaged), [str(error)]


def machine() -> Machine:
    """Compiled kernels, processors and memory."""
    from scaloft_fi.sim.vehicle import rotor_step

    kept = getattr(getattr(rotor_step, "stats", None), "cache_path", None)
    existing = next(folder for folder in (Path(kept), *Path(kept).parents) if folder.exists()) if kept else None
    try:
        lines = Path("/proc/meminfo").read_text(encoding="utf-8").splitlines()
        sizes = {line.split(":")[0]: int(line.split()[1]) / 1024**2 for line in lines}
        memory = {"memory_gib": sizes["MemTotal"], "memory_available_gib": sizes["MemAvailable"]}
    except (OSError, KeyError, ValueError, IndexError):
        memory = {}
    return Machine(
        kernels=str(kept) if kept else None,
        kernels_writable=existing is not None and os.access(existing, os.W_OK),
        processors=cores(),
        processors_in_all=os.cpu_count() or cores(),
        **memory,
    )


def installation_tables(told: Installation) -> tuple[Table, ...]:
    """The same for people."""
    known = told.known_flight
    flight = () if known is None else (Table("Known flight", ("answer",), ((known.told,),)),)
    parts = tuple(
        (one.part, one.value or "not set", ("yes" if one.decides_bits else "no") + f": {one.why}" * bool(one.why))
        for one in told.platform
    )
    equal = "Flights have equal bits on platforms that agree in every line that decides them."
    loaded = tuple((one.plugin, one.package, one.version, "yes" if one.loads else "no") for one in told.plugins)
    none = () if loaded else (f"No package has an entry point in the group {PLUGIN_GROUP}.",)
    return (
        Table("Platform", ("part", "value", "decides bits"), parts, (equal,)),
        _packages(told.packages),
        Table("Plugins", ("plugin", "package", "version", "loads"), loaded, none),
        _places(told.study, told.machine),
        *flight,
    )


def _packages(packages: Sequence[Package]) -> Table:
    rows = tuple(
        (one.package, one.version or "none", f"extra {one.extra}" if one.extra else "all", one.asks) for one in packages
    )
    lacking = sorted({f"extra {one.extra}" for one in packages if one.version is None and one.extra})
    notes = (f"`pip install 'scaloft-fi[...]'` installs what is missing: {', '.join(lacking)}.",) if lacking else ()
    unknown = "scaloft-fi is not installed as a package, so its extras are not known."
    return Table("Packages", ("package", "version", "for", "asks"), rows, notes if packages else (unknown,))


def _places(study: FoundStudy, machine: Machine) -> Table:
    known = study.mutants is not None
    kernels = "kept nowhere: neither the package's folder nor the cache folder of the user can be written"
    if machine.kernels:
        can = "can" if machine.kernels_writable else "cannot"
        kernels = f"beside each module, as in {machine.kernels} ({can} be written)"
    memory = "unknown"
    if machine.memory_gib is not None:
        memory = f"{machine.memory_available_gib:.1f} GiB available of {machine.memory_gib:.1f} GiB"
    rows = (
        ("study", f"{study.folder} ({'packaged' if study.packaged else 'own'})"),
        ("catalogue", f"current, {study.mutants} mutants" if known else "cannot be used"),
        *((("situations", study.situations),) if known else ()),
        ("compiled kernels", kernels),
        ("processors", f"{machine.processors} for this process, {machine.processors_in_all} in the machine"),
        ("memory", memory),
    )
    return Table("Places", ("what", "value"), rows)


@verb("doctor")
def doctor_command(
    *,
    study_folder: StudyFolder,
    style: TableFormat,
    tables_folder: TablesFolder,
    no_flight: Annotated[bool, Option("Do not fly the known flight.")],
) -> None:
    """Print what decides the bits of a flight and what is installed, and fly a flight whose digest is published.

    Other bits on another platform are no failure; another status, ending or violation is: exit code 4.

    Examples:
        See whether this machine has the published bits: `scaloft-fi doctor`
        List versions only, and fly nothing: `scaloft-fi doctor --no-flight`
        Check that plugins and a study load: `scaloft-fi doctor --study my_study --no-flight`
    """
    one_thread_each()

    loaded, broken = plugins()
    study, faults = found_study(study_folder)
    failure: Exception | None = None
    known = None
    if not no_flight:
        try:
            known = KnownFlight(same=True, told=fly_again(say))
        except GateError as error:
            known, failure = KnownFlight(same=False, told=str(error)), error
    wrong = (*broken, *faults)
    told = Installation(platform_parts(), packages(), loaded, study, machine(), known, wrong)
    answer(Answer(DOCTOR, lambda: told, lambda: installation_tables(told)), style, tables_folder)
    if failure is not None:
        raise failure
    if wrong:
        raise InputError("; ".join(wrong))
