"""`scaloft-fi doctor`: the platform, the installation, and whether a known flight has its published digest."""

from __future__ import annotations

import os
import re
from importlib.metadata import PackageNotFoundError, distribution, entry_points, version
from pathlib import Path
from typing import Annotated, Any

from scaloft_fi.campaign.processes import THREAD_SETTINGS, cores, one_thread_each
from scaloft_fi.campaign.store.origin import DECIDES, fingerprint
from scaloft_fi.console import say
from scaloft_fi.errors import GateError, InputError, ScaloftError
from scaloft_fi.hazop.load import find_study
from scaloft_fi.registry import PLUGIN_GROUP, in_one_line
from scaloft_fi.study import Study
from scaloft_fi.verbs.options import Option, StudyFolder, TableFormat, TablesFolder, answer
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output, count, flag, listing, number, optional, record, text, texts
from scaloft_fi.views.table import Table

_FOR_TESTS = "test"
"""The extra of developers, which is not listed."""
_REQUIREMENT = re.compile(r"(?P<name>[\w.-]+)(?P<range>[^;]*)(?:;.*extra == .(?P<extra>[\w-]+).)?")
_GIB = 1024**3
Values = dict[str, Any]
_UNUSABLE = "the catalogue cannot be used"
DOCTOR = Output(
    "doctor",
    "1.0",
    "what decides the bits of a flight, and what is installed",
    {
        "platform": listing(
            "the parts of the platform",
            record(
                "a part",
                {
                    "part": text("its name"),
                    "value": optional(text("its version or setting"), "not set"),
                    "decides_bits": flag("whether it decides the bits of a flight"),
                    "why": text("how; else empty"),
                },
            ),
        ),
        "packages": listing(
            "the packages that scaloft-fi needs, and those of its extras",
            record(
                "a package",
                {
                    "package": text("its name"),
                    "version": optional(text("the installed version"), "not installed"),
                    "extra": optional(text("the extra that needs it"), "always needed"),
                    "asks": text("the versions that are asked for"),
                },
            ),
        ),
        "plugins": listing(
            "the plugins",
            record(
                "a plugin",
                {
                    "plugin": text("name of its entry point"),
                    "package": text("its package"),
                    "version": text("of the package; empty where it has none"),
                    "loads": flag("whether it can be loaded"),
                },
            ),
        ),
        "study": record(
            "the study",
            {
                "folder": text("its folder"),
                "packaged": flag("whether it is the one in the package"),
                "mutants": optional(count("mutants of its catalogue"), _UNUSABLE),
                "situations": optional(count("situations of its grid"), _UNUSABLE),
            },
        ),
        "machine": record(
            "the machine",
            {
                "kernels": optional(text("where compiled kernels are kept"), "nowhere"),
                "kernels_writable": flag("whether that place can be written"),
                "processors": count("for this process"),
                "processors_in_all": count("in the machine"),
                "memory_gib": optional(number("memory", "GiB"), "not known"),
                "memory_available_gib": optional(number("available memory", "GiB"), "not known"),
            },
        ),
        "known_flight": optional(
            record(
                "the flight whose digest is published",
                {"same": flag("whether it is as published but for its bits"), "told": text("how it compares")},
            ),
            "not flown",
        ),
        "faults": texts("what is wrong with plugins and study, a sentence each"),
    },
    rows="platform",
)


def platform_values() -> list[Values]:
    """The platform's fingerprint, with what decides the bits of a flight."""
    why = {**DECIDES, "OPENBLAS_CORETYPE": "yes: it names the kernels"}
    why |= dict.fromkeys(THREAD_SETTINGS, "yes: the division of a product")
    parts: dict[str, str | None] = {**fingerprint()}
    parts |= {name: os.environ.get(name) for name in ("OPENBLAS_CORETYPE", *THREAD_SETTINGS)}
    return [
        {
            "part": name,
            "value": value,
            "decides_bits": why[name].startswith("yes"),
            "why": re.sub(r"^(yes|no)[:,]? ?", "", why[name]),
        }
        for name, value in parts.items()
    ]


def package_values() -> list[Values]:
    """The packages that scaloft-fi needs, and those of its extras, with their versions; none where it is no package."""
    try:
        required = distribution("scaloft-fi").requires or []
    except PackageNotFoundError:
        return []
    found = [match for text in required if (match := _REQUIREMENT.match(text))]
    return [
        {
            "package": entry["name"],
            "version": _version(entry["name"]),
            "extra": entry["extra"],
            "asks": entry["range"].strip(),
        }
        for entry in found
        if entry["extra"] != _FOR_TESTS
    ]


def plugin_values() -> tuple[list[Values], list[str]]:
    """The plugins, and a sentence for each that cannot be loaded."""
    found: list[Values] = []
    failed: list[str] = []
    for plugin in sorted(entry_points(group=PLUGIN_GROUP)):
        name, number = (plugin.dist.name, plugin.dist.version) if plugin.dist else (plugin.module, "")
        loads = True
        try:
            plugin.load()
        except (Exception, SystemExit) as error:  # noqa: BLE001 - code from outside may raise anything
            loads = False
            failed.append(f"plugin {plugin.name!r} of package {name!r} cannot be loaded: {in_one_line(error)}")
        found.append({"plugin": plugin.name, "package": name, "version": number, "loads": loads})
    return found, failed


def study_values(folder: Path | None) -> tuple[Values, list[str]]:
    """The study and a sentence for each of its faults.

    Raises:
        InputError: `folder` is no study.
    """
    study = Study(find_study(folder))
    told: Values = {"folder": str(study.folder), "packaged": study.packaged, "mutants": None, "situations": None}
    try:
        return told | {"mutants": len(study.catalogue), "situations": len(study.grid.situations)}, []
    except ScaloftError as error:
        return told, [str(error)]


def machine_values() -> Values:
    """Compiled kernels, processors and memory."""
    from scaloft_fi.sim.vehicle import rotor_step

    kept = getattr(getattr(rotor_step, "stats", None), "cache_path", None)
    writable = False
    if kept:
        existing = next(folder for folder in (Path(kept), *Path(kept).parents) if folder.exists())
        writable = os.access(existing, os.W_OK)
    return {
        "kernels": str(kept) if kept else None,
        "kernels_writable": writable,
        "processors": cores(),
        "processors_in_all": os.cpu_count() or cores(),
        **_memory(),
    }


def installation_tables(values: Values) -> tuple[Table, ...]:
    """The same for people.

    Args:
        values: of the form `DOCTOR`.
    """
    tables = (_platform(values["platform"]), _packages(values["packages"]), _plugins(values["plugins"]))
    known = values["known_flight"]
    flight = () if known is None else (Table("Known flight", ("answer",), ((known["told"],),)),)
    return (*tables, _places(values["study"], values["machine"]), *flight)


def _platform(parts: list[Values]) -> Table:
    rows = tuple(
        (
            one["part"],
            one["value"] or "not set",
            ("yes" if one["decides_bits"] else "no") + f": {one['why']}" * bool(one["why"]),
        )
        for one in parts
    )
    note = "Flights have equal bits on platforms that agree in every line that decides them."
    return Table("Platform", ("part", "value", "decides bits"), rows, (note,))


def _packages(packages: list[Values]) -> Table:
    rows = tuple(
        (one["package"], one["version"] or "none", f"extra {one['extra']}" if one["extra"] else "all", one["asks"])
        for one in packages
    )
    lacking = sorted({f"extra {one['extra']}" for one in packages if one["version"] is None and one["extra"]})
    notes = (f"`pip install 'scaloft-fi[...]'` installs what is missing: {', '.join(lacking)}.",) if lacking else ()
    if not packages:
        notes = ("scaloft-fi is not installed as a package, so its extras are not known.",)
    return Table("Packages", ("package", "version", "for", "asks"), rows, notes)


def _plugins(plugins: list[Values]) -> Table:
    rows = tuple((one["plugin"], one["package"], one["version"], "yes" if one["loads"] else "no") for one in plugins)
    notes = () if rows else (f"No package has an entry point in the group {PLUGIN_GROUP}.",)
    return Table("Plugins", ("plugin", "package", "version", "loads"), rows, notes)


def _places(study: Values, machine: Values) -> Table:
    kind = "packaged" if study["packaged"] else "own"
    known = study["mutants"] is not None
    kernels = "kept nowhere: neither the package's folder nor the cache folder of the user can be written"
    if machine["kernels"]:
        can = "can" if machine["kernels_writable"] else "cannot"
        kernels = f"beside each module, as in {machine['kernels']} ({can} be written)"
    memory = "unknown"
    if machine["memory_gib"] is not None:
        memory = f"{machine['memory_available_gib']:.1f} GiB available of {machine['memory_gib']:.1f} GiB"
    rows = (
        ("study", f"{study['folder']} ({kind})"),
        ("catalogue", f"current, {study['mutants']} mutants" if known else "cannot be used"),
        *((("situations", study["situations"]),) if known else ()),
        ("compiled kernels", kernels),
        ("processors", f"{machine['processors']} for this process, {machine['processors_in_all']} in the machine"),
        ("memory", memory),
    )
    return Table("Places", ("what", "value"), rows)


def _memory() -> Values:
    try:
        lines = Path("/proc/meminfo").read_text(encoding="utf-8").splitlines()
        sizes = {line.split(":")[0]: int(line.split()[1]) * 1024 / _GIB for line in lines}
        return {"memory_gib": sizes["MemTotal"], "memory_available_gib": sizes["MemAvailable"]}
    except (OSError, KeyError, ValueError, IndexError):
        return {"memory_gib": None, "memory_available_gib": None}


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


@verb(
    "doctor",
    examples=(
        ("See whether this machine has the published bits", "scaloft-fi doctor"),
        ("List versions only, and fly nothing", "scaloft-fi doctor --no-flight"),
        ("Check that plugins and a study load", "scaloft-fi doctor --study my_study --no-flight"),
    ),
)
def doctor_command(
    *,
    study_folder: StudyFolder,
    style: TableFormat,
    tables_folder: TablesFolder,
    no_flight: Annotated[bool, Option("Do not fly the known flight.")],
) -> None:
    """Print what decides the bits of a flight and what is installed, and fly a flight whose digest is published.

    Other bits on another platform are no failure; another status, ending or violation is: exit code 4.
    """
    one_thread_each()

    plugins, broken = plugin_values()
    study, faults = study_values(study_folder)
    failure: Exception | None = None
    known = None
    if not no_flight:
        from scaloft_fi.campaign.runs.gates import fly_again

        try:
            known = {"same": True, "told": fly_again(say)}
        except GateError as error:
            known, failure = {"same": False, "told": str(error)}, error
    values = {
        "platform": platform_values(),
        "packages": package_values(),
        "plugins": plugins,
        "study": study,
        "machine": machine_values(),
        "known_flight": known,
        "faults": [*broken, *faults],
    }
    answer(Answer(DOCTOR, lambda: values, lambda: installation_tables(values)), style, tables_folder)
    if failure is not None:
        raise failure
    if broken or faults:
        raise InputError("; ".join((*broken, *faults)))
