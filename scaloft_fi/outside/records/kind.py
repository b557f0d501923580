"""The kinds of records, by the ending of the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from scaloft_fi.document import is_folder
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.outside.records.source import Series, Source, Timing
from scaloft_fi.registry import Registry

FOLDER = "folder"
"""The kind of a record that is a folder: rosbag2."""


class Read(Protocol):
    """Reads a record."""

    def __call__(self, path: Path, sources: Sequence[Source], timing: Timing) -> Mapping[Source, Series]:
        """The series of each source.

        Raises:
            InputError: the record cannot be read, is too large, or lacks a source; or a value is no finite number.
        """
        ...


class Names(Protocol):
    """Lists what a record has."""

    def __call__(self, path: Path) -> Sequence[str]:
        """Its columns, or its fields, each after its topic and a colon.

        Raises:
            InputError: the record cannot be read.
        """
        ...


@dataclass(frozen=True)
class RecordKind:
    """How records of a kind are read.  Their libraries are imported by these functions."""

    read: Read
    names: Names


RECORDS = Registry[RecordKind]("kind of record")
RECORDS.promise(".csv", "scaloft_fi.outside.records.table:TABLE")
RECORDS.promise(".mcap", "scaloft_fi.outside.records.mcap:MCAP")
RECORDS.promise(".ulg", "scaloft_fi.outside.records.ulog:ULOG")
RECORDS.promise(".bag", "scaloft_fi.outside.records.rosbag:ROSBAG")
RECORDS.promise(".db3", "scaloft_fi.outside.records.rosbag:ROSBAG")
RECORDS.promise(FOLDER, "scaloft_fi.outside.records.rosbag:ROSBAG")


def kind_of(path: Path) -> RecordKind:
    """The kind of the record at `path`.

    Raises:
        InputError: no record ends so.
    """
    ending = FOLDER if is_folder(path) else path.suffix.lower()
    if ending not in RECORDS:
        endings = sorted(name for name in RECORDS if name != FOLDER)
        hint = did_you_mean(ending, endings) if ending else f"; allowed: {', '.join(map(repr, endings))}"
        raise InputError(f"{path}: a record must end in one of the known endings, or be a folder of rosbag2{hint}")
    return RECORDS[ending]
