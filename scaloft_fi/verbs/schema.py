"""`scaloft-fi schema`: the JSON Schemas of the YAML documents of a study."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scaloft_fi.console import say, tell, tell_line
from scaloft_fi.errors import InputError
from scaloft_fi.verbs.names import documents
from scaloft_fi.verbs.options import study_option, write
from scaloft_fi.verbs.verb import verb

if TYPE_CHECKING:
    from scaloft_fi.verbs.documents.schema import Declared


@verb(
    "schema",
    examples=(
        ("List the documents that have a schema", "scaloft-fi schema"),
        ("Print the schema of sim/world.yaml", "scaloft-fi schema world"),
        ("Write all schemas for an editor, those of installed plugins included", "scaloft-fi schema --write schemas"),
    ),
)
@click.argument("name", required=False, shell_complete=documents)
@study_option
@click.option(
    "--write",
    "folder",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Write every schema as DIR/NAME.json; the folder is made if it is not there.",
)
def schema_command(name: str | None, study_folder: Path | None, folder: Path | None) -> None:
    """Print the JSON Schema (draft 2020-12) of a YAML document of a study, or write them all.

    The schemas know the seams of the study, and what installed plugins declare.  An editor with a language server for
    YAML completes keys and shows what they mean, when the first line of the document is
    `# yaml-language-server: $schema=` with the path of the schema.
    """
    from scaloft_fi.verbs.documents.listed import DOCUMENTS, document, schema_text, schema_texts
    from scaloft_fi.views.table import Format, Table, render

    if name and folder:
        raise click.UsageError("--write writes every schema and goes with no NAME")
    if folder:
        _write(folder, schema_texts(_declared(study_folder)))
    elif name:
        one = document(name)
        tell(schema_text(one.schema(_declared(study_folder))))
    else:
        rows = tuple((one.name, one.files) for one in DOCUMENTS.values())
        tell(render((Table("Schemas of YAML documents", ("document", "files"), rows),), Format.TABLE))


def _declared(folder: Path | None) -> Declared:
    """What is declared; without the seams of a study whose stack cannot be read yet, as while it is written."""
    from scaloft_fi.study import Study
    from scaloft_fi.verbs.documents.schema import Declared

    study = Study.open(folder)
    try:
        seams = {seam.name: seam.edge for seam in study.stack.seams}
    except InputError as error:
        say(f"warning: without the names of seams: {error}")
        seams = {}
    return replace(Declared.everything(), seams=seams)


def _write(folder: Path, texts: dict[str, str]) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--write={str(folder)!r} cannot be written: {error.strerror}") from error
    for name, text in texts.items():
        write(folder / name, text.encode())
    tell_line(f"{folder}: {len(texts)} schemas")
