"""Every YAML document of a study, with its JSON Schema."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.views.documents import hazop, outside, requirements, situations, sources, stack, vehicle, world
from scaloft_fi.views.documents.build import Schema
from scaloft_fi.views.documents.declared import Declared

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
        Document("guidewords", "hazop/guidewords.yaml", hazop.guidewords),
        Document("parameters", "hazop/parameters.yaml", hazop.parameters),
        Document("severities", "hazop/severities.yaml", hazop.severities),
        Document("matrix", "hazop/matrix/*.yaml", hazop.matrix),
        Document("score", "hazop/score.yaml", hazop.score),
        Document("dispositions", "hazop/dispositions.yaml", hazop.dispositions),
        Document("world", "sim/world.yaml", world.world),
        Document("vehicle", "sim/vehicle.yaml", vehicle.vehicle),
        Document("sensors", "sim/sensors.yaml", vehicle.sensors),
        Document("stack", "sim/stack.yaml", stack.stack),
        Document("situations", "sim/situations.yaml", situations.situations),
        Document("grid", "sim/grids/*.yaml", situations.grid),
        Document("requirements", "sim/requirements.yaml", requirements.requirements),
        Document("sources", "sim/sources.yaml", sources.sources),
        Document("found", "sim/found.yaml", requirements.found, written=True),
        Document("flyer", "sim/flyer.yaml", outside.flyer),
        Document("record", "sim/record.yaml", outside.record),
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
