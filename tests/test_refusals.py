"""Bad inputs recorded from every key of every document: no refusal tells less than its record.

The record has a line for each bad input: file, line, change, and the sentence of its refusal, with place, name, value,
what is allowed, nearest name.  `RECORD=1 pytest tests/test_refusals.py` writes it anew.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from options import usually
from studies import every_key_study

from scaloft_fi.errors import InputError
from scaloft_fi.outside.command import load_command
from scaloft_fi.outside.records import load_record_map
from scaloft_fi.study import Study

RECORD = Path(__file__).parent / "support" / "refusals.txt"
KEY = re.compile(
    r"(?P<before>^\s*(?:- )?|[{,] ?)(?P<key>[\w-]+):(?P<value> (?:\[[^\]]*\]|[^,{}#\n]+?)|)(?=\s*(?:[,}#]|$))"
)
PASSES = "is read"
ONE = "human"
"""The parameter whose file stands for those of all: they have the same keys."""
EVERY = usually(24, release=1)


class BadInput(NamedTuple):
    """A study with one change: the file, from the study's folder, which line of it, and the line after the change."""

    name: str
    file: str
    line: int
    text: str


def bad_inputs(folder: Path) -> Iterator[BadInput]:
    """The bad inputs of a study: of each key of each file the first place, in a few ways each."""
    for path in sorted(folder.glob("*/**/*.yaml")):
        file, seen = str(path.relative_to(folder)), set[str]()
        if path.parent.name == "matrix" and path.stem != ONE:
            continue
        for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
            for match in KEY.finditer(line) if not line.lstrip().startswith("#") else ():
                key, before, value = match["key"], match["before"], match["value"].strip()
                if key in seen:
                    continue
                seen.add(key)
                changes = {"misspelt": f"{before}{key}x: {value}", "left out": ""}
                for change, text in {"a list": "[[]]", "a word": "zzz", "a great number": "-1.0e+9"}.items():
                    changes |= {change: f"{before}{key}: {text}"} if value else {}
                for change, text in changes.items():
                    changed = line[: match.start()] + text + line[match.end() :]
                    yield BadInput(f"{file}:{number} {key} {change}", file, number, changed)


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


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return every_key_study(tmp_path_factory.mktemp("every_key") / "study")


def test_each_bad_input_is_refused_as_the_record_says(study: Path):
    if os.environ.get("RECORD"):
        said = {bad.name: told(study, bad) for bad in bad_inputs(study)}
        RECORD.write_text("".join(f"{name}\t{text}\n" for name, text in said.items() if text != PASSES), "utf-8")
    record = dict(line.split("\t", 1) for line in RECORD.read_text("utf-8").splitlines())
    bad = [one for one in bad_inputs(study) if one.name in record]
    assert len(bad) == len(record) >= 300, "the record is made with RECORD=1"
    said = {one.name: told(study, one) for one in bad[::EVERY]}
    assert said == {name: record[name] for name in said}
