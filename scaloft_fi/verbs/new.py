"""`scaloft-fi new`: write a small study, or a plugin package with a study that uses it."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from scaloft_fi.errors import InputError
from scaloft_fi.verbs.options import LineFormat, Option, answer, verb
from scaloft_fi.views.output import Answer, Output


@dataclass(frozen=True)
class Written:
    """What was written into a new folder.

    Attributes:
        folder: the new folder.
        kind: a study, or a plugin package with a study in its folder study/.
        files: the files, relative to the folder.
        next: the commands to give next, quoted for a shell, in their order.
    """

    folder: Path
    kind: Literal["study", "plugin"]
    files: tuple[str, ...]
    next: tuple[str, ...]


NEW = Output("new", "1.0", Written, rows="files")


@verb(
    "new",
    examples=(
        ("Write a study to edit", "scaloft-fi new my_mine"),
        ("Write a package with an operator, a stack, a sensor and a signal", "scaloft-fi new my_faults --plugin"),
        ("Give the package another name than the folder", "scaloft-fi new work/faults --plugin --name my_faults"),
    ),
)
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
    name: Annotated[
        str | None,
        Option("Name of the package, with --plugin.", metavar="NAME", otherwise="the last part of DIR, - read as _"),
    ],
    style: LineFormat,
) -> None:
    """Write a small study that flies in about a minute, and whose files say what each of their keys means.

    A corridor, a cart, a person, two axes, two requirements, six cells.  DIR must be empty or new.  With --plugin, DIR
    is a package of yours that any study can use once it is installed.

    The first line of each document names its JSON Schema in schemas/, with which an editor completes keys; in a
    package, `scaloft-fi schema --write` makes that folder once the package is installed.
    """
    from scaloft_fi.sim.stacks import STACKS
    from scaloft_fi.templates import check_package_name, plugin_files, study_files, write_new
    from scaloft_fi.verbs.schema import pointed, schema_files

    if name is not None and not plugin:
        raise InputError(f"--name={name!r} is the name of a package; give --plugin with it, or leave it out")
    if plugin:
        package = folder.absolute().name.replace("-", "_") if name is None else name
        check_package_name(package, "DIR" if name is None else "--name")
        files = pointed(plugin_files(package), "study/")
        what = f"the package {package}, and a study that uses it, {len(files)} files"
    else:
        documents, schemas = pointed(study_files()), schema_files(STACKS["reference"])
        files = documents | schemas
        what = f"a study of 6 cells and 6 situations, {len(documents)} files, and {len(schemas)} schemas for an editor"
    write_new(folder, files)
    commands = _next(folder, plugin=plugin)
    told = f"{folder}: {what}.  Next:\n\n" + "".join(f"  {command}\n" for command in commands)
    written = Written(folder, "plugin" if plugin else "study", tuple(sorted(files)), commands)
    answer(Answer(NEW, lambda: written, told=lambda _: told), style)


def _next(folder: Path, *, plugin: bool) -> tuple[str, ...]:
    here = shlex.quote(str(folder))
    if plugin:
        study, schemas = (shlex.quote(str(folder / below)) for below in ("study", "study/schemas"))
        return (
            f"pip install -e {shlex.quote(f'{folder}[test]')}",
            f"python -m pytest {here}",
            f"scaloft-fi schema --study {study} --write {schemas}",
            f"scaloft-fi run --study {study}",
        )
    there = () if folder.resolve() == Path.cwd() else (f"cd {here}",)
    return *there, "scaloft-fi check", "scaloft-fi run"
