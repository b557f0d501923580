"""Every YAML document of a study with its JSON Schema, and the line by which an editor finds it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import PurePosixPath

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.registry import load_plugins
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.verbs.documents import hazop, sim
from scaloft_fi.verbs.documents.hazop import dispositions, guidewords, matrix, parameters, score, severities
from scaloft_fi.verbs.documents.schema import Declared, Schema
from scaloft_fi.verbs.documents.sim import flyer, record

DIALECT = "https://json-schema.org/draft/2020-12/schema"
PUBLISHED = "docs/schemas/study"
"""Folder of the published schemas in the repository."""


@dataclass(frozen=True)
class Document:
    """A YAML document of a study.

    Attributes:
        name: by which its schema is asked for.
        files: pattern of its files in the folder of a study.
        make: makes the schema from what is declared.
        written: whether a verb writes it; people edit the others.
    """

    name: str
    files: str
    make: Callable[[Declared], Schema]
    written: bool = False

    def schema(self, declared: Declared) -> Schema:
        """The whole schema."""
        schema = self.make(declared)
        head = {"$schema": DIALECT, "$id": f"urn:scaloft-fi:study:{self.name}", "title": self.files}
        return {**head, **schema}


DOCUMENTS: Mapping[str, Document] = {
    one.name: one
    for one in (
        Document("guidewords", "hazop/guidewords.yaml", guidewords),
        Document("parameters", "hazop/parameters.yaml", parameters),
        Document("severities", "hazop/severities.yaml", severities),
        Document("matrix", "hazop/matrix/*.yaml", matrix),
        Document("score", "hazop/score.yaml", score),
        Document("dispositions", "hazop/dispositions.yaml", dispositions),
        Document("world", "sim/world.yaml", sim.world),
        Document("vehicle", "sim/vehicle.yaml", sim.vehicle),
        Document("sensors", "sim/sensors.yaml", sim.sensors),
        Document("stack", "sim/stack.yaml", sim.stack),
        Document("situations", "sim/situations.yaml", sim.situations),
        Document("grid", "sim/grids/*.yaml", sim.grid),
        Document("requirements", "sim/requirements.yaml", hazop.requirements),
        Document("sources", "sim/sources.yaml", sim.sources),
        Document("found", "sim/found.yaml", hazop.found, written=True),
        Document("flyer", "sim/flyer.yaml", flyer),
        Document("record", "sim/record.yaml", record),
    )
}
"""In the order in which a study is read about."""


def document(name: str) -> Document:
    """The document of a name.

    Raises:
        InputError: there is none; the message names the nearest.
    """
    if name not in DOCUMENTS:
        raise InputError(f"no document {name!r}{did_you_mean(name, DOCUMENTS)}")
    return DOCUMENTS[name]


def schema_texts(declared: Declared) -> dict[str, str]:
    """The text of each schema by its file name."""
    return {f"{one.name}.json": schema_text(one.schema(declared)) for one in DOCUMENTS.values()}


def schema_text(schema: Schema) -> str:
    """A schema as JSON."""
    return json.dumps(schema, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


FOLDER = "schemas"
"""The folder of the schemas in the folder of a study."""


def pointed(files: Mapping[str, bytes], below: str = "") -> dict[str, bytes]:
    """Files of a study by path; each document that has a schema begins with the line that names it.

    Args:
        files: content by path.
        below: folder of the study among the files, such as "study/".
    """
    return {name: _line(name.removeprefix(below)) + content for name, content in files.items()}


def schema_files(stack: Declaration) -> dict[str, bytes]:
    """The schemas of every document by path, with what is installed and the seams of a stack.

    Raises:
        InputError: a plugin that is installed cannot be loaded.
    """
    load_plugins()
    declared = replace(Declared.everything(), seams={seam.name: seam.edge for seam in stack.seams})
    return {f"{FOLDER}/{name}": text.encode() for name, text in schema_texts(declared).items()}


def _line(name: str) -> bytes:
    """The line for a document at this path in its study; nothing for another file."""
    path = PurePosixPath(name)
    for one in DOCUMENTS.values():
        if path.match(one.files) and len(path.parts) == one.files.count("/") + 1:
            up = "../" * one.files.count("/")
            return f"# yaml-language-server: $schema={up}{FOLDER}/{one.name}.json\n".encode()
    return b""
