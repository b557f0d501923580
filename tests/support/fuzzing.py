"""Changes files of a study by chance, and reports each input that neither passes nor is refused in one sentence.

A seed always makes the same change.  By hand, for more seeds than the tests try:
`python tests/support/fuzzing.py STUDY FIRST LAST FILE...` prints the failures of these seeds as JSON.
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
from pathlib import Path
from unittest import mock

from click.testing import CliRunner
from copies import copied

from scaloft_fi.cli import main as command_line
from scaloft_fi.errors import InputError
from scaloft_fi.mutants import catalogue
from scaloft_fi.study import Study

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
