"""What is installed and what decides the bits of a flight, as tables."""

from __future__ import annotations

import os
import re
from importlib.metadata import PackageNotFoundError, distribution, entry_points, version
from pathlib import Path

from scaloft_fi.campaign.processes.start import THREAD_SETTINGS, cores
from scaloft_fi.campaign.store.fingerprint import DECIDES, fingerprint
from scaloft_fi.errors import ScaloftError
from scaloft_fi.hazop.folder import find_study
from scaloft_fi.registry import PLUGIN_GROUP, in_one_line
from scaloft_fi.study import Study
from scaloft_fi.views.tables.table import Table, TableCell

_FOR_TESTS = "test"
"""The extra of developers, which is not listed."""
_REQUIREMENT = re.compile(r"(?P<name>[\w.-]+)(?P<range>[^;]*)(?:;.*extra == .(?P<extra>[\w-]+).)?")
_GIB = 1024**3
Row = tuple[TableCell, ...]


def platform_table() -> Table:
    """The platform's fingerprint, with what decides the bits of a flight."""
    rows: list[Row] = [(name, value, DECIDES[name]) for name, value in fingerprint().items()]
    for name in ("OPENBLAS_CORETYPE", *THREAD_SETTINGS):
        why = "yes: it names the kernels" if name == "OPENBLAS_CORETYPE" else "yes: the division of a product"
        rows.append((name, os.environ.get(name, "not set"), why))
    note = "Flights have equal bits on platforms that agree in every line that decides them."
    return Table("Platform", ("part", "value", "decides bits"), tuple(rows), (note,))


def packages_table() -> Table:
    """The packages that scaloft-fi needs, and those of its extras, with their versions."""
    try:
        required = distribution("scaloft-fi").requires or []
    except PackageNotFoundError:
        note = "scaloft-fi is not installed as a package, so its extras are not known."
        return Table("Packages", ("package", "version", "for", "asks"), (), (note,))
    found = [match for text in required if (match := _REQUIREMENT.match(text))]
    rows = [
        (entry["name"], _version(entry["name"]), f"extra {entry['extra']}" if entry["extra"] else "all", entry["range"])
        for entry in found
        if entry["extra"] != _FOR_TESTS
    ]
    lacking = sorted({row[2] for row in rows if row[1] == "none"})
    notes = (f"`pip install 'scaloft-fi[...]'` installs what is missing: {', '.join(lacking)}.",) if lacking else ()
    return Table("Packages", ("package", "version", "for", "asks"), tuple(rows), notes)


def plugins_table() -> tuple[Table, list[str]]:
    """The plugins, and a sentence for each that cannot be loaded."""
    rows: list[Row] = []
    failed: list[str] = []
    for plugin in sorted(entry_points(group=PLUGIN_GROUP)):
        name, number = (plugin.dist.name, plugin.dist.version) if plugin.dist else (plugin.module, "")
        loads = "yes"
        try:
            plugin.load()
        except (Exception, SystemExit) as error:  # noqa: BLE001 - code from outside may raise anything
            loads = "no"
            failed.append(f"plugin {plugin.name!r} of package {name!r} cannot be loaded: {in_one_line(error)}")
        rows.append((plugin.name, name, number, loads))
    notes = () if rows else (f"No package has an entry point in the group {PLUGIN_GROUP}.",)
    return Table("Plugins", ("plugin", "package", "version", "loads"), tuple(rows), notes), failed


def places_table(study: Path | None) -> tuple[Table, list[str]]:
    """Study, catalogue, compiled kernels, processors and memory, and a sentence for each fault of the study.

    Raises:
        InputError: `study` is no study.
    """
    found, failed = _study_rows(Study(find_study(study)))
    rows: list[Row] = [
        *found,
        ("compiled kernels", _kernels()),
        ("processors", f"{cores()} for this process, {os.cpu_count()} in the machine"),
        ("memory", _memory()),
    ]
    return Table("Places", ("what", "value"), tuple(rows)), failed


def _study_rows(study: Study) -> tuple[list[Row], list[str]]:
    kind = "packaged" if study.packaged else "own"
    rows: list[Row] = [("study", f"{study.folder} ({kind})")]
    try:
        rows.append(("catalogue", f"current, {len(study.catalogue)} mutants"))
        rows.append(("situations", len(study.grid.situations)))
    except ScaloftError as error:
        rows.append(("catalogue", "cannot be used"))
        return rows, [str(error)]
    return rows, []


def _kernels() -> str:
    """Where numba keeps the compiled kernels, and whether that place can be written."""
    from scaloft_fi.sim.vehicle import rotor_step

    path = getattr(getattr(rotor_step, "stats", None), "cache_path", None)
    if not path:
        return "kept nowhere: neither the package's folder nor the cache folder of the user can be written"
    existing = next(folder for folder in (Path(path), *Path(path).parents) if folder.exists())
    return f"beside each module, as in {path} ({'can' if os.access(existing, os.W_OK) else 'cannot'} be written)"


def _memory() -> str:
    try:
        lines = Path("/proc/meminfo").read_text(encoding="utf-8").splitlines()
        sizes = {line.split(":")[0]: int(line.split()[1]) * 1024 for line in lines}
        return f"{sizes['MemAvailable'] / _GIB:.1f} GiB available of {sizes['MemTotal'] / _GIB:.1f} GiB"
    except (OSError, KeyError, ValueError, IndexError):
        return "unknown"


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"
