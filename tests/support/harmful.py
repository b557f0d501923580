"""Inputs that once hung a verb, filled the memory or crashed it, each with the sentence that refuses it."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path


def text(words: str) -> Callable[[Path], object]:
    return lambda path: path.write_text(words)


def edit_in(path: Path, old: str, new: str) -> None:
    before = path.read_text()
    assert old in before
    path.write_text(before.replace(old, new, 1))


def edit(old: str, new: str) -> Callable[[Path], object]:
    return lambda path: edit_in(path, old, new)


def link(target: str) -> Callable[[Path], object]:
    return lambda path: (path.unlink(missing_ok=True), path.symlink_to(target))


def pipe(path: Path) -> None:
    path.unlink(missing_ok=True)
    os.mkfifo(path)


def folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def aliases(levels: int) -> str:
    names = [f"a{level}" for level in range(levels + 1)]
    rows = [f"{here}: &{here} [{', '.join([f'*{below}'] * 10)}]" for below, here in pairwise(names)]
    return "\n".join(["a0: &a0 [1]", *rows, ""])


WORLD, STACK, CATALOGUE, OBJ = "sim/world.yaml", "sim/stack.yaml", "mutants/catalogue.jsonl", "sim/room.obj"
VEHICLE, SENSORS, SITUATIONS, RULES = (
    f"sim/{name}.yaml" for name in ("vehicle", "sensors", "situations", "requirements")
)
SCORE, CELLS = "hazop/score.yaml", "hazop/matrix/human.yaml"
TEN_THOUSAND = "\n".join(f"  b{i}: 1" for i in range(10_000))
VALUES = "[{id: 0, title: a}, {id: 1, title: b, realised: once(light < 1)}]"
FORTY_AXES = "\n".join(f"  A{'a' * i}: {{title: t, category: c, values: {VALUES}}}" for i in range(40))
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
MANY = "at most 30,000 values"
DEEP = "nested at most 50 deep"
CORPUS: dict[str, tuple[str, Callable[[Path], object], str]] = {
    "aliases, 6 levels": (WORLD, text(aliases(6)), MANY),
    "aliases, 40 levels": (SCORE, text(aliases(40)), MANY),
    "a long list": (STACK, text(f"name: [{'1,' * 50_000}]"), MANY),
    "flow lists, 500 deep": (WORLD, text("[" * 500), DEEP),
    "flow lists, 30,000 deep": (WORLD, text("[" * 30_000), DEEP),
    "flow mappings": (STACK, text("{a: " * 30_000), DEEP),
    "block lists": (SENSORS, text("- " * 30_000), DEEP),
    "aliases, nested": (SCORE, text("a: &a [[[[[[[[[1]]]]]]]]]\n" + "b: [" * 1 + "[" * 45 + "*a" + "]" * 46), DEEP),
    "an integer of 401 digits": (VEHICLE, edit("mass_kg: 1.5", "mass_kg: " + "9" * 401), "at most 100 digits"),
    "an integer of 5,000 digits": (STACK, edit("voxel_m: 0.15", "voxel_m: " + "9" * 5000), "at most 100 digits"),
    "a number in base sixty": (VEHICLE, edit("mass_kg: 1.5", "mass_kg: 1" + ":59" * 500), "at most 100 digits"),
    "a float beyond the largest": (VEHICLE, edit("mass_kg: 1.5", "mass_kg: 1.0e+999"), "mass_kg=inf must be a finite"),
    "a tag for bytes": (WORLD, edit("present: true", "present: !!binary aGk="), "has the tag"),
    "a tag for a program": (SCORE, text("alpha: !!python/object/apply:os.system [ls]"), "has the tag"),
    "not a number in the stack": (STACK, edit("voxel_m: 0.15", "voxel_m: .nan"), "voxel_m=nan must be a finite"),
    "infinity in the stack": (STACK, edit("axes: [1, 1, 0]", "axes: [1, .inf, 0]"), "must be a finite number"),
    "infinity in a situation": (SITUATIONS, edit("{light: 0.003}", "{light: .inf}"), "must be a finite number"),
    "not a number as alpha": (SCORE, text("alpha: .nan"), "must be a number"),
    "a billion pixels": (SENSORS, edit("width: 64", "width: 1000000000"), "width=1000000000 must be .* <= 1024"),
    "a mission of months": (WORLD, edit("cruise_mps: 0.5", "cruise_mps: 1.0e-6"), "must last at most 3,600 s"),
    "a drone that never arrives": (WORLD, edit("sink_mps: 0.5", "sink_mps: 1.0e-320"), "must last at most 3,600 s"),
    "ten thousand bodies": (WORLD, edit("bodies:", f"bodies:\n{TEN_THOUSAND}"), "at most 100 keys"),
    "ten thousand waypoints": (WORLD, edit("waypoints:", f"waypoints:\n{TEN_THOUSAND}"), "at most 1,000"),
    "a route of ten thousand": (WORLD, edit("[corner, home]", f"[{'corner, ' * 10_000}home]"), "at most 1,000"),
    "2^40 situations": (SITUATIONS, edit("axes:", f"axes:\n{FORTY_AXES}"), "must make at most 1000000"),
    "ten thousand values": (SITUATIONS, edit("values:", f"values: [{'1,' * 10_000}]\n    x:"), "and 1 more fault"),
    "an interval of years": (RULES, edit("[0:2](near)", "[0:99999999](near)"), "must end within 600 s"),
    "brackets, 300 deep": (RULES, edit("(clearance_m > 0)", f"{'(' * 300}clearance_m > 0{')' * 300}"), "brackets"),
    "a formula of a megabyte": (
        RULES,
        edit("(clearance_m > 0", "(clearance_m > 0" + " and light > 0" * 50_000),
        "at most 2,000",
    ),
    "a ladder of ten thousand": (CELLS, edit("ladder: [", f"ladder: [{'1, ' * 10_000}"), "at most 100 values"),
    "a key of 500 characters": (VEHICLE, edit("mass_kg", "m" * 500), "at most 200 characters"),
    "a text of a megabyte": (STACK, edit("name: reference", "name: " + "r" * 1_000_000), "no stack 'rrr"),
    "YAML that is a pipe": (WORLD, pipe, "a pipe"),
    "YAML that never ends": (STACK, link("/dev/zero"), "a device"),
    "YAML that links to itself": (SENSORS, link("sensors.yaml"), "symbolic links"),
    "YAML of 5 MiB": (VEHICLE, text("#" * (5 << 20)), "larger than 4,194,304 bytes"),
    "a choice that links to nothing": (SCORE, link("nowhere"), "cannot be read"),
    "a catalogue that is a pipe": (CATALOGUE, pipe, "a pipe"),
    "a catalogue that never ends": (CATALOGUE, link("/dev/zero"), "a device"),
    "JSON, 9,000 deep": (CATALOGUE, text("[" * 9_000 + "\n"), "not a mutant in JSON"),
    "JSON objects, 1,400 deep": (CATALOGUE, text('{"id": ' * 1_400 + "\n"), "not a mutant in JSON"),
    "JSON, 100,000 deep": (CATALOGUE, text("[" * 100_000), "at most 10,000 characters"),
    "a number of 5,000 digits in JSON": (CATALOGUE, text(f'{{"id": {"9" * 5000}}}\n'), "not a mutant in JSON"),
    "a mesh that is a pipe": (OBJ, pipe, "a pipe"),
    "a mesh that never ends": (OBJ, link("/dev/zero"), "a device"),
    "a NUL in the name of a mesh": (WORLD, edit("room.obj", '"a\\0b"'), "cannot be read"),
    "a mesh with a name of 300 characters": (WORLD, edit("room.obj", "a" * 300), "name too long"),
    "a mesh of nobody": (WORLD, edit("room.obj", "~nosuchuser/room.obj"), "cannot be read"),
    "a face of 200,000 corners": (OBJ, text(TRIANGLE + "f" + " 1 2 3" * 66_667), "at most 10 corners; `mesh_limits"),
    "a million triangles": (OBJ, text(TRIANGLE + "f 1 2 3\n" * 1_000_000), "at most 10,000 triangles"),
    "a million vertices": (OBJ, text("v 0 0 0\n" * 1_000_000), "at most 10,000 triangles"),
    "a mesh of 33 MiB": (OBJ, lambda path: os.truncate(path, 33 << 20), "larger than 33,554,432 bytes; `mesh_limits"),
    "a mesh of empty lines": (OBJ, text("\n" * (16 << 20)), "must have faces"),
    "a vertex beyond the horizon": (OBJ, text("v 1e300 0 0\n"), "within 100,000 m"),
    "limits beyond all bounds": (WORLD, edit("10_000", "10_000_000_000"), "must be .* <= 10000000"),
}
"""By name: the file, what happens to it, and the sentence that refuses it, a regular expression."""
