"""Schemas beside a study, and the line of a document by which an editor finds its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import PurePosixPath

from scaloft_fi.registry import load_plugins
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.views.documents.declared import Declared
from scaloft_fi.views.documents.listed import DOCUMENTS, schema_texts

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
