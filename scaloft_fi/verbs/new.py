"""`scaloft-fi new`: write a small study, one of a real autopilot, or a package of a plugin or a planner with its study.

`scaloft-fi example`: list the examples, or copy one, with the documents of the reference study that its study lacks.
The examples are the folder `examples/` of the checkout, which the wheel carries as `_examples`.  The first paragraph of
the README.md of each is its sentence, and the first block of commands there is what to do next.
"""

from __future__ import annotations

import json
import keyword
import re
import shlex
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib.util import find_spec
from itertools import takewhile
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Literal

from scaloft_fi.document import is_file, is_folder, is_there, read_bytes
from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.firmware.kind import ATTITUDE, KINDS, MOTORS, POSITION, FirmwareConfig
from scaloft_fi.hazop.load import FOLDERS, reference_study, shipped
from scaloft_fi.mutants.catalogue import derive, write_catalogue
from scaloft_fi.output import unwritable, write_whole
from scaloft_fi.registry import load_plugins
from scaloft_fi.sim.grid import FOUND_FILE
from scaloft_fi.sim.load import DOCUMENTS
from scaloft_fi.sim.stacks import STACKS
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.stack.reference.declaration import SEAMS
from scaloft_fi.study import Study
from scaloft_fi.verbs.names import example_names, examples
from scaloft_fi.verbs.options import LineFormat, Option, answer, verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table

Files = Mapping[str, bytes]
"""Content by path, relative to the new folder."""

WORD = "your_plugin"
"""The word in the templates that stands for the name of the package."""
MORE = ".more.yaml"
"""The end of the name of a template whose text is appended to the file of the study."""
SHARED = ("sim/vehicle.yaml", "sim/sensors.yaml", "sim/stack.yaml")
"""The files of the reference study that a new study takes as they are."""
MINE = (
    *SHARED,
    *(f"sim/{name}.yaml" for name in ("world", "situations", "requirements")),
    *(f"hazop/{name}.yaml" for name in ("guidewords", "severities", "matrix/imu", "matrix/pose", "matrix/velcmd")),
)
"""The files of the reference study that a study of a firmware takes, with `CHANGES`."""
QUAD_X = b"""\
# The layout of PX4, ArduPilot and Betaflight: front right and rear left turn counter-clockwise seen from above, so
# their torque on the body is clockwise.
spins: [-1, -1, 1, 1]
throttle_exponent: 2.0           # curve of the speed controllers: a rotor's thrust is its greatest times throttle^2"""
PARAMETERS = "sim/firmware/parameters.txt"
"""The firmware's own parameters, for a kind that has a template of them."""
IMU = "hazop/matrix/imu.yaml"
SENSORS = {"px4": ("barometer", "magnetometer"), "ardupilot": ("battery",)}
"""Further sensors of the firmware in such a study, by kind; its template has their settings and their cells."""
CHANGES = (
    ("sim/stack.yaml", b"name: reference  ", b"name: firmware   "),
    ("sim/stack.yaml", b"spins: [1, 1, -1, -1]", b"spins: [-1, -1, 1, 1]"),
    ("sim/vehicle.yaml", b"spins: [1, 1, -1, -1]", QUAD_X),
    ("sim/world.yaml", b": sources.yaml.", b": sources.yaml of the reference study."),
)
"""What differs there: file, text, which it has once, and the text in its place."""


def study_files() -> Files:
    """The files of a small study with the reference stack."""
    reference = reference_study()
    return {**_template("study"), **{name: read_bytes(reference / name) for name in SHARED}}


def plugin_files(package: str) -> Files:
    """The files of a plugin package, whose folder `study/` is the small study with its own matrix and stack.

    Args:
        package: name of the package; see `check_package_name`.
    """
    files = {f"study/{name}": text for name, text in study_files().items() if not name.startswith(("hazop", "mutants"))}
    return _filled(_joined(files, _template("plugin")), {WORD: package})


def planner_files(package: str) -> Files:
    """The files of a package with a planner, whose folder `study/` is the reference study with that planner.

    Args:
        package: name of the package; see `check_package_name`.
    """
    files = reference_files()
    files["sim/stack.yaml"] = files["sim/stack.yaml"].replace(b"name: reference", b"name: " + package.encode(), 1)
    return _filled(_template("planner"), {WORD: package}) | {f"study/{name}": text for name, text in files.items()}


def reference_files() -> dict[str, bytes]:
    """The files of the reference study without what a search found for its drone."""
    reference = reference_study()
    paths = (path for below in FOLDERS for path in (reference / below).rglob("*") if path.is_file())
    own = {path.relative_to(reference).as_posix(): path for path in paths if path.suffix != ".md"}
    return {name: read_bytes(path) for name, path in own.items() if path.name != FOUND_FILE}


def firmware_files(kind: str, program: Path) -> Files:
    """The files of a study of the paper's mine with a firmware, and a HAZOP of its seams.

    Args:
        kind: of firmware, a key of `KINDS`.
        program: the firmware's program.

    Raises:
        InputError: the firmware lacks a seam of the HAZOP.
    """
    seams, reference = KINDS[kind].seams, reference_study()
    position, owner = ("position", "firmware") if POSITION in seams else ("fix", "companion")
    orders, units = ("attitude", "rad, rad/s, 0..1") if ATTITUDE in seams else ("velocity", "m/s, rad")
    files = {name: read_bytes(reference / name) for name in MINE}
    for name, old, new in CHANGES:
        assert files[name].count(old) == 1, name
        files[name] = files[name].replace(old, new)
    if orders == "velocity":  # its own estimator keeps it up: what turns the companion's is no control
        control, credible = b"REVERSE:\n  status: control", b"REVERSE:\n  status: credible\n  severity: damage"
        files[IMU] = files[IMU].replace(control, credible)
    own, sensors = _template(f"firmware/{kind}"), SENSORS.get(kind, ())
    words = {
        "your_kind": kind,
        "your_program": json.dumps(str(program.absolute()), ensure_ascii=False),
        "your_node": f"positioning -> estimator of the {owner}",
        "your_position": position,
        "your_order": units,
        "your_parameters": f"[{PARAMETERS}]" if PARAMETERS in own else "[]",
        "your_sensors": f"[{', '.join(sensors)}]",
    }
    more = {**_template("firmware/study"), **_template(f"firmware/{orders}"), **own}
    files = _filled(_joined(files, more), words)
    return files | {"mutants/catalogue.jsonl": _catalogue(files)}


def _joined(files: Files, more: Files) -> dict[str, bytes]:
    """The files and those of a template; one whose name ends in `MORE` is appended to the file of the study."""
    joined = dict(files)
    for name, text in more.items():
        below = name.removesuffix(MORE) + ".yaml"
        joined |= {below: joined[below] + b"\n" + text} if name.endswith(MORE) else {name: text}
    return joined


def _filled(files: Files, words: Mapping[str, str]) -> dict[str, bytes]:
    """The files with each word, in names and texts, replaced by what it stands for."""
    filled = dict(files)
    for word, said in words.items():
        filled = {name.replace(word, said): t.replace(word.encode(), said.encode()) for name, t in filled.items()}
    return filled


def _catalogue(files: Files) -> bytes:
    """The catalogue of the mutants of a study with these files."""
    with TemporaryDirectory() as made:
        folder = Path(made)
        _write(folder, files)
        return read_bytes(write_catalogue(folder / "mutants", derive(Study(folder).matrix)))


def check_package_name(name: str, place: str) -> None:
    """Refuse a name that no package can have, or that hides another package.

    Args:
        name: the name.
        place: where it comes from, for the message.

    Raises:
        InputError: as above; the message names a near name that is possible.
    """
    if not name.isidentifier() or not name.isascii() or name.startswith("_") or keyword.iskeyword(name):
        near = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in name).strip("_")
        possible = near.isidentifier() and not keyword.iskeyword(near)
        hint = f"; --name {near} is one" if possible else "; --name my_faults is one"
        raise InputError(f"{place}={shown(name)} must be the name of a Python package: letters, digits and _{hint}")
    if name in sys.stdlib_module_names or _is_installed(name):
        raise InputError(
            f"{place}={shown(name)} is the name of a package that is installed; choose another, as --name my_{name}"
        )


def write_new(folder: Path, files: Files) -> None:
    """Write the files into a folder that is empty or does not exist; after a failure nothing of them is left.

    Raises:
        InputError: the folder is not empty, is no folder, or cannot be written.
    """
    try:
        if is_there(folder) and (not is_folder(folder) or any(folder.iterdir())):
            what = "is not empty" if is_folder(folder) else "is no folder"
            raise InputError(f"{str(folder)!r} {what}; only an empty or a new folder is written into")
        _write(folder, files)
    except (OSError, ValueError) as error:
        raise InputError(f"{str(folder)!r} cannot be written: {unwritable(error)}; nothing of it is left") from error


def _write(folder: Path, files: Files) -> None:
    made: list[Path] = []
    try:
        for name, content in files.items():
            path = folder / name
            made += _make_folders(path.parent)
            write_whole(path, content)
            made.append(path)
            if content.startswith(b"#!"):
                path.chmod(path.stat().st_mode | 0o111)
    except BaseException:
        for path in reversed(made):
            with suppress(OSError):
                path.rmdir() if is_folder(path) else path.unlink()
        raise


def _make_folders(folder: Path) -> list[Path]:
    """Make a folder and those above it; returns the folders that were missing, the highest first."""
    missing = list(takewhile(lambda one: not is_there(one), (folder, *folder.parents)))[::-1]
    for one in missing:
        one.mkdir()
    return missing


def _template(name: str) -> dict[str, bytes]:
    """The files of one template."""
    return files_in(shipped("templates") / name)


def files_in(folder: Path) -> dict[str, bytes]:
    """The files in a folder and below it."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file() and "__pycache__" not in path.parts)
    return {path.relative_to(folder).as_posix(): read_bytes(path) for path in files}


def _is_installed(name: str) -> bool:
    """Whether a package of this name can be imported; a bare folder, such as the new one, is none."""
    spec = find_spec(name)
    return spec is not None and spec.origin is not None


@dataclass(frozen=True)
class Written:
    """What was written into a new folder.

    Attributes:
        folder: the new folder.
        kind: a study, or a package (of a plugin or a planner) with a study in its folder study/.
        files: the files, relative to the folder.
        next: the commands to give next, quoted for a shell, in their order.
    """

    folder: Path
    kind: Literal["study", "plugin"]
    files: tuple[str, ...]
    next: tuple[str, ...]


NEW = Output("new", "1.0", Written, rows="files")


@verb("new")
def new_command(
    *,
    folder: Annotated[Path, Option("", "", metavar="DIR")],
    plugin: Annotated[
        bool,
        Option(
            "Write a Python package instead: one operator, one stack, one sensor, one signal, their tests, and in "
            "DIR/study a study that uses them."
        ),
    ],
    planner: Annotated[
        bool,
        Option("Write a package with a planner for the reference stack instead, and in DIR/study the reference study."),
    ],
    name: Annotated[
        str | None,
        Option(
            "Name of the package, with --plugin or --planner.",
            metavar="NAME",
            otherwise="the last part of DIR, - read as _",
        ),
    ],
    firmware: Annotated[
        str | None,
        Option("Write a study of an autopilot: px4, ardupilot, betaflight, lines or a plugin's.", metavar="KIND"),
    ],
    program: Annotated[Path | None, Option("The autopilot's program, with --firmware.", metavar="PATH")],
    style: LineFormat,
) -> None:
    """Write a small study that flies in about a minute, and whose files say what each of their keys means.

    A corridor, a cart, a person, two axes, two requirements, six cells.  DIR must be empty or new.  With --plugin, DIR
    is a package of yours that any study can use once it is installed.  With --planner, it is a package whose planner
    flies the reference drone through the 32 situations of the reference study.

    With --firmware, DIR is a study of the paper's mine with 32 situations.  A real autopilot flies below the
    reference stack's perception and navigation.  The HAZOP, of 96 cells or more, is of what flows into the
    autopilot and out of it.  PATH is its program, built for simulation (SITL), which is not copied.  `lines` is any
    program that speaks lines of JSON.

    The first line of each document names its JSON Schema in schemas/, with which an editor completes keys.  In a
    package, `scaloft-fi schema --write` makes that folder once the package is installed.

    Examples:
        Write a study to edit: `scaloft-fi new my_mine`
        Write a package with an operator, a stack, a sensor and a signal: `scaloft-fi new my_faults --plugin`
        Put a planner of your own into the reference drone: `scaloft-fi new my_planner --planner`
        Put a real autopilot below the companion: `scaloft-fi new my_px4 --firmware px4 --program /opt/px4/bin/px4`
    """
    from scaloft_fi.verbs.schema import pointed, schema_files

    asked = [way for way, given in (("--plugin", plugin), ("--planner", planner), ("--firmware", firmware)) if given]
    if len(asked) > 1:
        raise InputError(f"{' and '.join(asked)} write different things; give one of them")
    if name is not None and not (plugin or planner):
        raise InputError(f"--name={name!r} is the name of a package; give --plugin or --planner, or leave it out")
    if program is not None and firmware is None:
        raise InputError(f"--program={shown(str(program))} is an autopilot's; give --firmware with it, or leave it out")
    if plugin or planner:
        package = folder.absolute().name.replace("-", "_") if name is None else name
        check_package_name(package, "DIR" if name is None else "--name")
        files = pointed(planner_files(package) if planner else plugin_files(package), "study/")
        what = f"the package {package}, and a study that uses it, {len(files)} files"
    else:
        if firmware is not None:
            own, stack, what = _firmware(firmware, program)
        else:
            own, stack, what = study_files(), STACKS["reference"], "a study of 6 cells and 6 situations"
        documents, schemas = pointed(own), schema_files(stack)
        files = documents | schemas
        what += f", {len(documents)} files, and {len(schemas)} schemas for an editor"
    write_new(folder, files)
    chosen = FIRST if firmware else " --mutant LATE-human" if planner else ""
    commands = _next(folder, package=plugin or planner, chosen=chosen)
    written = Written(folder, "plugin" if plugin or planner else "study", tuple(sorted(files)), commands)
    answer(Answer(NEW, lambda: written, told=lambda _: said(folder, what, commands)), style)


FIRST = " --situation 'T0O0W0D0*' --mutant LATE-gyro"
"""What a study of an autopilot flies first: one fault in light, without a person and with one."""


def _firmware(kind: str, program: Path | None) -> tuple[Files, Declaration, str]:
    """The files of a study of an autopilot, its stack, and what they are in words.

    Raises:
        InputError: the kind is unknown, or the program is no file.
    """
    from scaloft_fi.firmware.stack import FIRMWARE

    load_plugins()
    if kind not in KINDS:
        raise InputError(f"--firmware={shown(kind)} must be a kind of firmware{did_you_mean(kind, KINDS)}")
    if program is None:
        raise InputError(f"--firmware={shown(kind)} needs --program, the path of the autopilot's program")
    if not is_file(program) or not str(program).isprintable():
        raise InputError(f"--program={shown(str(program))} must be the path of a file, in printable characters")
    files = firmware_files(kind, program)
    config = FirmwareConfig(kind, str(program), "", sensors=SENSORS.get(kind, ()))
    stack = replace(FIRMWARE, seams=(*SEAMS, *config.seams, MOTORS))
    cells = sum(name.startswith("hazop/matrix/") for name in files) * 12
    return files, stack, f"a study of {kind} with {cells} cells and 32 situations"


def _next(folder: Path, *, package: bool, chosen: str) -> tuple[str, ...]:
    if package:
        here = shlex.quote(str(folder))
        study, schemas = (shlex.quote(str(folder / below)) for below in ("study", "study/schemas"))
        return (
            f"pip install -e {shlex.quote(f'{folder}[test]')}",
            f"python -m pytest {here}",
            f"scaloft-fi schema --study {study} --write {schemas}",
            f"scaloft-fi run --study {study}{chosen}",
        )
    return *way(folder), "scaloft-fi check", f"scaloft-fi run{chosen}"


def way(folder: Path) -> tuple[str, ...]:
    """The command that goes into a folder; none where one stands in it already."""
    return () if folder.resolve() == Path.cwd() else (f"cd {shlex.quote(str(folder))}",)


def said(folder: Path, what: str, commands: Sequence[str]) -> str:
    """What was written into a folder, and what to do next."""
    return f"{folder}: {what}.  Next:\n\n" + "".join(f"  {command}\n" for command in commands)


BLOCK = re.compile(r"^```console\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NEEDED = tuple(f"sim/{name}.yaml" for name in (*DOCUMENTS, "requirements"))
"""The documents of `sim/` without which there is no study."""


@dataclass(frozen=True)
class ShippedExample:
    """An example.

    Attributes:
        name: its name.
        about: what it shows.
        files: its files, relative to its folder.
        next: the commands to give in its folder, in their order; of one that was copied, with the way there.
        folder: where it was copied; null: it was not.
    """

    name: str
    about: str
    files: tuple[str, ...]
    next: tuple[str, ...]
    folder: Path | None = None


@dataclass(frozen=True)
class ShippedExamples:
    """The examples of this installation, or the one that was copied.

    Attributes:
        examples: they.
    """

    examples: tuple[ShippedExample, ...]


EXAMPLE = Output("example", "1.0", ShippedExamples, rows="examples")


def example_files(name: str) -> Files:
    """The files of an example; the folders and documents that its study lacks are those of the reference study.

    Raises:
        InputError: there is no such example; the message names the nearest.
    """
    if name not in example_names():
        raise InputError(f"no example {name!r}{did_you_mean(name, example_names())}")
    own = files_in(shipped("examples") / name)
    parts = {path.partition("/")[0] for path in own}
    lacks = {
        path: text for path, text in reference_files().items() if path in NEEDED or path.split("/")[0] not in parts
    }
    return {**lacks, **own} if "sim" in parts else own


def example(name: str) -> ShippedExample:
    """What there is to know of an example.

    Raises:
        InputError: as for `example_files`.
    """
    files = example_files(name)
    readme = files["README.md"].decode()
    first = BLOCK.search(readme)
    commands = first[1].replace("$ ", "").splitlines() if first else ()
    return ShippedExample(name, " ".join(readme.split("\n\n")[1].split()), tuple(sorted(files)), tuple(commands))


@verb("example")
def example_command(
    *,
    name: Annotated[str | None, Option("", "", complete=examples)] = None,
    folder: Annotated[Path | None, Option("", "", metavar="[DIR]")] = None,
) -> Answer:
    """List the examples, or copy one into a folder, and print what to do next.

    DIR must be empty or new; without it the folder has the example's name.  What of a study an example leaves to the
    reference study is copied too, so that it flies wherever it is put.

    Examples:
        List the examples: `scaloft-fi example`
        Copy one into a folder of its name: `scaloft-fi example own_tests`
        Copy one into another folder: `scaloft-fi example outside_planner my_planner`
    """
    if name is None:
        every = ShippedExamples(tuple(map(example, example_names())))
        rows = tuple((one.name, one.about) for one in every.examples)
        table = Table(
            f"Examples: {len(rows)}", ("example", "what it shows"), rows, ("`scaloft-fi example NAME` copies one.",)
        )
        return Answer(EXAMPLE, lambda: every, lambda: (table,))
    folder, files = folder or Path(name), example_files(name)
    write_new(folder, files)
    one = example(name)
    one = replace(one, folder=folder, next=(*way(folder), *one.next))
    told = said(folder, f"the example {name}, {len(files)} files", one.next)
    return Answer(EXAMPLE, lambda: ShippedExamples((one,)), told=lambda _: told)
