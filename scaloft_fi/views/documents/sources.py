"""The JSON Schema of `sim/sources.yaml`: the source of each number."""

from __future__ import annotations

from scaloft_fi.sim.load import DOCUMENTS
from scaloft_fi.views.documents.build import Schema, choice, mapping, named, text
from scaloft_fi.views.documents.declared import Declared

KINDS = {
    "published": "a paper, its repository, or another publication",
    "datasheet": "maker's data, or the configuration that a device is shipped with",
    "derived": "computed from those",
    "assumption": "chosen for the study; tables of sensitivity vary these",
}


def sources(_: Declared) -> Schema:
    """`sim/sources.yaml`."""
    about = "The source of each number of `sim/` by dotted path, its document first; a path covers all below it."
    return source_entries(about)


def source_entries(about: str) -> Schema:
    """Sources by dotted path."""
    keys = {
        "kind": choice("what kind of source it is", KINDS),
        "source": text("the source, or the reason of an assumption"),
    }
    paths = rf"(?:{'|'.join(DOCUMENTS)})(?:\..+)?"
    return named(about, mapping("The source of the numbers at this path.", keys), pattern=paths)
