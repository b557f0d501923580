"""Studies that nobody meant: files changed by chance, and inputs that once hung a verb, filled memory or crashed it.

A seed always makes the same change; each input has to pass or be refused in one sentence.  By hand, for more seeds
than the tests try: `python tests/support/fuzzing.py STUDY FIRST LAST FILE...` prints the failures of these seeds as
JSON.
"""

from __future__ import annotations

import json
import os
import random
import re
import resource
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from unittest import mock

from click.testing import CliRunner
from studies import copied, edit_in

from scaloft_fi.cli import main as command_line
from scaloft_fi.errors import InputError
from scaloft_fi.mutants import catalogue
from scaloft_fi.study import Study

HOSTILE = (
    "<script>alert(1)</script>",
    "\"quotes\" and 'others'",
    "=cmd|' /C calc'!A0",
    "@SUM(1+1)*cmd|' /C calc'!A0",
    "+1",
    "-1+1",
    "=HYPERLINK(...)",
    "人が検出されない — Ürümqi ñ ٣",
    "a|b||c",
    r"\input{/etc/passwd} $x_1^2$ 100 % #1 & ~ {} \\",
    "line one\nline two\r\nline three\ttab",
    "[x](javascript:1) *b* _i_ `c` ![i](u) &lt; # h",
    "\x1b[31mred\x1b[0m\x07\x00",
    "x" * 40_000,
    "--- \\ | \\| \\\\|",
    "_x0041_ x",
    "long " * 8000,
)
"""Texts that a format could take for its own words: a tag, a formula, an escape; and long ones."""


def text(words: str) -> Callable[[Path], object]:
    return lambda path: path.write_text(words)


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


MOST_S = 5.0
"""CPU time that one input may take [s]."""
MOST_BYTES = 3 << 30
"""Memory that the process may take."""
VERBS = (("mutants", "--check"), ("matrix", "--format", "json"), ("mutants", "LATE-*"))
EVERY = 10
"""Each tenth input is tried through the command line too."""

NASTY = Path(__file__).with_name("nasty_words.txt").read_text("utf-8")
NUMBERS, PLAIN = (part.splitlines() for part in NASTY.split("\n\n"))
WORDS = (
    *NUMBERS,
    *PLAIN,
    "9" * 401,
    "9" * 5000,
    "1" + ":59" * 500,
    "0." + "1" * 500,
    "[" * 40,
    "[" * 600,
    "{a: " * 600,
    "- " * 200,
    "(" * 300,
    "not " * 300,
    "\x1b[31m",
    "\u202e",
    "\u2028",
    "\ufeff",
    "x" * 300,
    "x" * 100_000,
    "a" * 300 + ".obj",
    "f " + "1 " * 5_000,
)


def flipped(data: bytes, chance: random.Random) -> bytes:
    """A few bytes changed."""
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 8))):
        if changed:
            changed[chance.randrange(len(changed))] = chance.randrange(256)
    return bytes(changed)


def cut(data: bytes, chance: random.Random) -> bytes:
    """A piece left out."""
    start = chance.randrange(len(data) + 1)
    return data[:start] + data[start + chance.choice((1, 3, 20, 200, len(data))) :]


def repeated(data: bytes, chance: random.Random) -> bytes:
    """A piece repeated, sometimes a thousand times."""
    start = chance.randrange(len(data) + 1)
    piece = data[start : start + chance.choice((1, 5, 40))]
    return data[:start] + piece * chance.choice((2, 2, 50, 1000)) + data[start:]


def lined(data: bytes, chance: random.Random) -> bytes:
    """A line left out, moved, repeated, or indented by another number of spaces."""
    lines = data.splitlines(keepends=True) or [b""]
    place = chance.randrange(len(lines))
    line = lines.pop(place)
    choices = ([], [line, line], [b"  " + line], [line[1:]], [line.lstrip()], [line.rstrip() + b"x\n"])
    for piece in chance.choice(choices):
        lines.insert(chance.choice((place, place, chance.randrange(len(lines) + 1))), piece)
    return b"".join(lines)


def worded(data: bytes, chance: random.Random) -> bytes:
    """A word replaced by a nasty one or by another word of the file, or a nasty one inserted."""
    words = list(re.finditer(rb"[\w.+-]+", data))
    if not words:
        return data
    old = chance.choice(words)
    new = chance.choice((*(word.encode() for word in WORDS), *[chance.choice(words)[0] for _ in range(30)]))
    return data[: old.start()] + new + data[old.end() if chance.random() < 0.8 else old.start() :]


def numbered(data: bytes, chance: random.Random) -> bytes:
    """Some numbers replaced."""
    numbers = list(re.finditer(rb"(?<![\w.])-?\d+(\.\d+)?(?![\w.])", data))
    for old in sorted(chance.sample(numbers, min(len(numbers), chance.choice((1, 1, 2)))), key=lambda m: -m.start()):
        data = data[: old.start()] + chance.choice(NUMBERS).encode() + data[old.end() :]
    return data


CHANGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    *(flipped, cut, repeated, lined, lined, worded, worded, worded, worded, numbered, numbered, numbered),
)


def exchange(path: Path, chance: random.Random) -> None:
    """Put something else in the place of a file."""
    path.unlink()
    kind = chance.randrange(8)
    if kind == 0:
        os.mkfifo(path)
    elif kind == 1:
        path.mkdir()
    elif kind in (2, 3, 4, 5):
        path.symlink_to(("/dev/zero", "/dev/null", path.name, "nowhere")[kind - 2])
    elif kind == 6:
        path.write_bytes(bytes(chance.choice((0, 1, 70_000))))


def change(path: Path, chance: random.Random) -> None:
    """Change the file, once or a few times."""
    if chance.random() < 0.03:
        exchange(path, chance)
        return
    data = path.read_bytes()
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        data = chance.choice(CHANGES)(data, chance)
    path.write_bytes(data)


def probe(folder: Path) -> None:
    """Read all that a study holds, as the verbs do before a flight."""
    study = Study.open(folder)
    with mock.patch("scaloft_fi.sources.closure", lambda _modules, beside=(): dict.fromkeys(beside)):
        _ = study.inputs
    _ = study.alpha, study.dispositions, study.roster, study.sim.numbers
    study.check(study.grid.situations[:: 1 + len(study.grid) // 3])
    catalogue.check_catalogue(folder / "mutants", study.matrix)


def wrong_sentence(text: str) -> str:
    """What is wrong with the sentence of a refusal; "" if nothing."""
    if not text.strip() or "\n" in text:
        return f"not one sentence: {text[:300]!r}"
    return f"a sentence of {len(text)} characters: {text[:300]!r}" if len(text) > 2_000 else ""


def outcome(folder: Path) -> str:
    """What is wrong with the way in which `probe` ends; "" if nothing."""
    begun_s = time.process_time()
    try:
        probe(folder)
    except InputError as error:
        wrong = wrong_sentence(str(error))
    except BaseException:  # noqa: BLE001 - any other end is what the search is for
        wrong = traceback.format_exc()[-1500:]
    else:
        wrong = ""
    spent_s = time.process_time() - begun_s
    return wrong or (f"took {spent_s:.1f} s" if spent_s > MOST_S else "")


def told(folder: Path, verb: Sequence[str]) -> str:
    """What is wrong with the way in which a verb ends; "" if nothing."""
    done = CliRunner().invoke(command_line, [*verb, "--study", str(folder)])
    errors = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    if done.exit_code not in (0, 2) or len(errors) != (done.exit_code == 2):
        return f"{' '.join(verb)}: exit code {done.exit_code}: {done.stderr[:500]!r}"
    return ""


def fuzz(study: Path, seeds: Sequence[int], files: Sequence[str] = ()) -> dict[str, str]:
    """Failures by seed and file.  files: suffixes of the files that are changed; empty means all."""
    failures = {}
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "study"
        copied(folder, study=study)
        every = sorted(path for path in folder.rglob("*") if path.is_file() and path.suffix != ".md")
        paths = [path for path in every if not files or path.name.endswith(tuple(files))]
        for seed in seeds:
            chance = random.Random(f"{study.name} {seed}")
            path = chance.choice(paths)
            kept = path.read_bytes()
            change(path, chance)
            wrong = outcome(folder) or (told(folder, chance.choice(VERBS)) if seed % EVERY == 0 else "")
            if wrong:
                failures[f"{seed} {path.relative_to(folder)}"] = wrong
            if path.is_dir() and not path.is_symlink():
                path.rmdir()
            path.unlink(missing_ok=True)
            path.write_bytes(kept)
        assert not outcome(folder), "the unchanged study is refused"
    return failures


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    folder, first, last, *suffixes = sys.argv[1:]
    print(json.dumps(fuzz(Path(folder), range(int(first), int(last)), suffixes), indent=1))  # noqa: T201
