"""Studies for tests: copies of the reference study, one with every key, documents as items, keys of schemas."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from runpy import run_path
from typing import Any, TypeVar

from scaloft_fi.document import Item
from scaloft_fi.model import Schema, read
from scaloft_fi.verbs.new import example_files, write_new

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("hazop", "mutants", "sim")


def copied(folder: Path, *without: str, parts: tuple[str, ...] = FOLDERS, study: Path = ROOT) -> Path:
    """Copy a study into a folder, without files and folders of these names; returns the folder."""
    for name in parts:
        shutil.copytree(study / name, folder / name, ignore=shutil.ignore_patterns(*without))
    return folder


def edit_in(path: Path, old: str, new: str) -> None:
    """Replace a text in a file once; it must be there."""
    before = path.read_text(encoding="utf-8")
    assert old in before
    path.write_text(before.replace(old, new, 1), encoding="utf-8")


def example(name: str, folder: Path, *edits: tuple[str, str]) -> Path:
    """Copy an example as `scaloft-fi example` does, with edits of `sim/stack.yaml`; returns the folder."""
    write_new(folder, example_files(name))
    for old, new in edits:
        edit_in(folder / "sim" / "stack.yaml", old, new)
    return folder


OVER_ROS2 = (
    ("border: lines", "border: ros2"),
    ("over_lines.py", "over_ros2.py"),
    ("deterministic: true", "deterministic: false"),
)
"""The edits by which the planner of the example `outside_planner` flies over ROS 2."""
RECORDS = ("table", "bag")
"""What the program of the example `own_simulator` records."""


def own_simulator(folder: Path, record: str = RECORDS[0]) -> Path:
    """Copy this example; returns the folder."""
    example("own_simulator", folder)
    if record != RECORDS[0]:
        shutil.copytree(folder / "rosbag2" / "sim", folder / "sim", dirs_exist_ok=True)
    return folder


def mission_study(folder: Path, *scripts: Path) -> None:
    """Write the study of the example `testbed` with these scripts."""
    run_path(str(ROOT / "examples" / "testbed" / "make_study.py"))["make_study"](folder, scripts, ROOT)


GRIDS = Path(__file__).parent / "grids"
"""Further grids for the `sim/grids/` of a study."""
OWN = Path(__file__).parent / "every_key_study"
"""What it has of its own; the rest is the reference study's."""


def every_key_study(folder: Path) -> Path:
    """Write the study, and beside its `sim/` folders with `sim/flyer.yaml` and `sim/record.yaml`, which it has not."""
    copied(folder, parts=("hazop", "mutants"))
    (folder / "sim").mkdir()
    for name in ("vehicle", "sensors", "stack", "requirements"):
        shutil.copy(ROOT / "sim" / f"{name}.yaml", folder / "sim")
    shutil.copytree(OWN, folder, dirs_exist_ok=True)
    return folder


T = TypeVar("T")


def item_of(value: Any, name: str = "entry", file: str = "s.yaml") -> Item:
    """The item of a plain value, all of it on line 1."""
    if isinstance(value, dict):
        value = {key: item_of(one, key, file) for key, one in value.items()}
    elif isinstance(value, list | tuple):
        value = tuple(item_of(one, f"{name}[{place}]", file) for place, one in enumerate(value))
    return Item(Path(file), 1, name, value)


def build(cls: type[T], values: dict[str, Any]) -> T:
    """The model that is read from plain values."""
    return read(cls, item_of(values, "stack"))


Pointer = tuple[str | int, ...]


def keys_of(schema: Schema | bool, pointer: Pointer = ()) -> Iterator[Pointer]:
    """The pointer of every key of a schema."""
    if isinstance(schema, bool):
        return
    for key, one in schema.get("properties", {}).items():
        yield (*pointer, "properties", key)
        yield from keys_of(one, (*pointer, "properties", key))
    for pattern, one in schema.get("patternProperties", {}).items():
        yield from keys_of(one, (*pointer, "patternProperties", pattern))
    for word in ("additionalProperties", "items", "then"):
        if isinstance(schema.get(word), dict):
            yield from keys_of(schema[word], (*pointer, word))
    for word in ("oneOf", "anyOf", "allOf"):
        for place, one in enumerate(schema.get(word, ())):
            yield from keys_of(one, (*pointer, word, place))
