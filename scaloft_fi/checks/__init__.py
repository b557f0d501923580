"""The dry check of a whole study: every part on its own, every finding with place and remedy, nothing flown.

A finding, and the collector that goes on after an error.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TypeVar

from scaloft_fi.document import UnreadableError
from scaloft_fi.errors import FaultsError, InputError
from scaloft_fi.registry import in_one_line, plugin_behind

T = TypeVar("T")
U = TypeVar("U")

_PLACE = re.compile(
    r"(?:(?P<file>[^\n]+?\.[A-Za-z0-9]+):(?P<line>\d+)|(?P<whole>[^\n]+?\.(?:yaml|jsonl))): (?P<rest>.*)", re.DOTALL
)


class Severity(StrEnum):
    """Whether a study with the finding is wrong."""

    ERROR = "error"
    """A verb refuses the study, or its flights would not mean what they seem to mean."""
    NOTE = "note"
    """The study can be flown; somebody should know."""


@dataclass(frozen=True)
class Finding:
    """One thing that the check found.

    Attributes:
        severity: how bad it is.
        file: the file to mend; empty where none is meant.
        line: its line, from 1; null: the whole file is meant.
        what: what is wrong, in a sentence.
        situation: key of a situation in which it shows; empty where none is meant.
        remedy: what to do about it; empty where the sentence says it.
    """

    severity: Severity
    file: str
    line: int | None
    what: str
    situation: str = ""
    remedy: str = ""

    @property
    def place(self) -> str:
        """`file:line`, or what is known of it."""
        return self.file if self.line is None else f"{self.file}:{self.line}"

    def __str__(self) -> str:
        """One line, as compilers write it: an editor jumps to the place."""
        where = f"{self.place}: " if self.file else ""
        shows = f" (situation {self.situation})" if self.situation and self.situation not in self.what else ""
        return f"{where}{self.severity}: {self.what}{shows}{f'; {self.remedy}' if self.remedy else ''}"


def finding_of(sentence: str, severity: Severity = Severity.ERROR, *, situation: str = "") -> Finding:
    """The finding of an error message, which begins with its place and may end with the remedy after a semicolon.

    >>> str(finding_of("sim/a.yaml:3: no stack 'x'; did you mean 'y'?"))
    "sim/a.yaml:3: error: no stack 'x'; did you mean 'y'?"
    """
    located = _PLACE.fullmatch(sentence)
    what, _, remedy = (located["rest"] if located else sentence).partition("; ")
    return Finding(
        severity,
        (located["file"] or located["whole"]) if located else "",
        int(located["line"]) if located and located["line"] else None,
        what,
        situation,
        remedy,
    )


@dataclass
class Findings:
    """Collects findings, each once, in the order in which they are found."""

    found: dict[tuple[str, str], Finding] = field(default_factory=dict)
    _told: int = 0

    def __iter__(self) -> Iterator[Finding]:
        return iter(self.found.values())

    @property
    def errors(self) -> int:
        """Number of errors."""
        return sum(finding.severity is Severity.ERROR for finding in self)

    def add(self, finding: Finding) -> None:
        """Keep a finding; the same sentence about the same place counts once."""
        self._told += 1
        self.found.setdefault((finding.place, finding.what), finding)

    def error(self, error: InputError, *, situation: str = "") -> None:
        """Keep an error that a reader raised."""
        if isinstance(error, FaultsError):
            for fault in error.faults:
                self.error(fault, situation=situation)
        elif isinstance(error, UnreadableError):
            self.add(Finding(Severity.ERROR, str(error.path), None, f"cannot be read: {error.reason}", situation))
        else:
            self.add(finding_of(str(error), situation=situation))

    def note(self, place: str, what: str, remedy: str, *, situation: str = "") -> None:
        """Keep a note about `file:line`."""
        self.add(finding_of(f"{place}: {what}; {remedy}", Severity.NOTE, situation=situation))

    def wrong(self, place: str, what: str, remedy: str, *, situation: str = "") -> None:
        """Keep an error about `file:line`."""
        self.add(finding_of(f"{place}: {what}; {remedy}", situation=situation))

    @contextmanager
    def collecting(self, *, situation: str = "") -> Iterator[None]:
        """Keep the error that ends the block; code of a plugin may raise anything."""
        try:
            yield
        except InputError as error:
            self.error(error, situation=situation)
        except Exception as error:
            plugin = plugin_behind(error)
            if not plugin:
                raise
            what = f"{plugin}: {in_one_line(error)}"
            self.add(Finding(Severity.ERROR, "", None, what, remedy="mend or uninstall it"))

    def each(self, read: Callable[[U], T], entries: Iterable[U]) -> list[T]:
        """What `read` makes of the entries that it can read; the errors of the others are kept."""
        read_ones: list[T] = []
        for entry in entries:
            with self.collecting():
                read_ones.append(read(entry))
        return read_ones

    def all_of(self, errors: Iterable[InputError]) -> bool:
        """Keep the errors of a generator; whether there was none."""
        before = self._told
        with self.collecting():
            for error in errors:
                self.error(error)
        return self._told == before
