"""`scaloft-fi example`: list the examples, or copy one, with the documents of the reference study that its study lacks.

The examples are the folder `examples/` of the checkout, which the wheel carries as `_examples`.  The first paragraph of
the README.md of each is its sentence, and the first block of commands there is what to do next.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.load import shipped
from scaloft_fi.sim.load import DOCUMENTS
from scaloft_fi.verbs.names import example_names, examples
from scaloft_fi.verbs.new import Files, files_in, reference_files, said, way, write_new
from scaloft_fi.verbs.options import Option, verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table

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


@verb(
    "example",
    examples=(
        ("List the examples", "scaloft-fi example"),
        ("Copy one into a folder of its name", "scaloft-fi example own_tests"),
        ("Copy one into another folder", "scaloft-fi example outside_planner my_planner"),
    ),
)
def example_command(
    *,
    name: Annotated[str | None, Option("", "", complete=examples)] = None,
    folder: Annotated[Path | None, Option("", "", metavar="[DIR]")] = None,
) -> Answer:
    """List the examples, or copy one into a folder, and print what to do next.

    DIR must be empty or new; without it the folder has the example's name.  What of a study an example leaves to the
    reference study is copied too, so that it flies wherever it is put.
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
