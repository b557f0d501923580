"""Bad inputs, drawn line by line from a study with every key, and what the package says of each.

`python tests/support/refusals.py` writes `refusals.txt`, one line a bad input: file, line, change, and the sentence of
its refusal.  A test holds that no sentence tells less than it: place, name, value, what is allowed, nearest name.
"""

from __future__ import annotations

import re
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from every_key import every_key_study

from scaloft_fi.errors import InputError
from scaloft_fi.outside.command import load_command
from scaloft_fi.outside.records.record_map import load_record_map
from scaloft_fi.study import Study

RECORD = Path(__file__).with_name("refusals.txt")
KEY = re.compile(
    r"(?P<before>^\s*(?:- )?|[{,] ?)(?P<key>[\w-]+):(?P<value> (?:\[[^\]]*\]|[^,{}#\n]+?)|)(?=\s*(?:[,}#]|$))"
)
PASSES = "is read"
ONE = "human"
"""The parameter whose file stands for those of all: they have the same keys."""


@dataclass(frozen=True)
class BadInput:
    """A study with one change.

    Attributes:
        file: the file, from the study's folder; line: its number; change: what is done, in a word.
        text: the line after the change.
    """

    file: str
    line: int
    change: str
    text: str

    @property
    def name(self) -> str:
        """Which bad input it is."""
        return f"{self.file}:{self.line} {self.change}"


def bad_inputs(folder: Path) -> Iterator[BadInput]:
    """The bad inputs of a study: of each key of each file the first place, in a few ways each."""
    for path in sorted(folder.glob("*/**/*.yaml")):
        file = str(path.relative_to(folder))
        if path.parent.name == "matrix" and path.stem != ONE:
            continue
        seen: set[str] = set()
        for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
            if line.lstrip().startswith("#"):
                continue
            for match in KEY.finditer(line):
                key = match["key"]
                if key in seen:
                    continue
                seen.add(key)
                for change, text in _changes(match["value"].strip()):
                    name = f"{key}{'x' * (change == 'misspelt')}"
                    changed = "" if change == "left out" else f"{match['before']}{name}: {text}"
                    yield BadInput(
                        file, number, f"{key} {change}", line[: match.start()] + changed + line[match.end() :]
                    )


def _changes(value: str) -> Iterator[tuple[str, str]]:
    yield "misspelt", value
    yield "left out", ""
    if value:
        yield "a list", "[[]]"
        yield "a word", "zzz"
        yield "a great number", "-1.0e+9"


def told(folder: Path, bad: BadInput) -> str:
    """The sentence of the refusal of a bad input, with places from the study's folder; `PASSES` where it is none."""
    path = folder / bad.file
    kept = path.read_text("utf-8")
    lines = kept.splitlines()
    lines[bad.line - 1] = bad.text
    path.write_text("\n".join([*lines, ""]), "utf-8")
    try:
        _read(folder, path)
    except InputError as error:
        return str(error).replace(f"{folder}/", "").replace(str(folder), "STUDY")
    finally:
        path.write_text(kept, "utf-8")
    return PASSES


def _read(folder: Path, path: Path) -> None:
    """Read what the study reads of a file."""
    if path.name == "flyer.yaml":
        load_command(path)
    elif path.name == "record.yaml":
        load_record_map(path)
    else:
        study = Study.open(folder, path.stem if path.parent.name == "grids" else None)
        _ = study.matrix, study.alpha, study.dispositions, study.requirements, study.finds, study.sim.numbers
        if path.name == "stack.yaml":
            study.check(study.grid.situations[:1])


def recorded() -> dict[str, str]:
    """The record: the sentence by name of the bad input."""
    return dict(line.split("\t", 1) for line in RECORD.read_text("utf-8").splitlines())


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        study = every_key_study(Path(scratch) / "study")
        said = [(bad.name, told(study, bad)) for bad in bad_inputs(study)]
    RECORD.write_text("".join(f"{name}\t{sentence}\n" for name, sentence in said if sentence != PASSES), "utf-8")
