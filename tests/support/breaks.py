"""Forty deliberate breaks of the package, drawn by seed from its syntax trees, and the tests that catch them.

`python tests/support/breaks.py draw` writes `breaks.json`: file, function, line and the text before and after of each.
`python tests/support/breaks.py again` breaks a copy of the checkout once for each that was caught, and notes which
tests fail then and pass where nothing is broken.
A break is found again by its function and text, wherever that stands by then.
"""

from __future__ import annotations

import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "scaloft_fi"
RECORD = Path(__file__).with_name("breaks.json")
SEED, NUMBER = 34, 40
MOST_S = 500
"""How long the tests of a break may take [s, wall]."""
FLOWN_AGAIN = "tests/campaign/flights/test_published_flights_again.py"
"""The test that sees any change of a flight."""
USAGE, NO_TESTS, NEVER_ENDS = 4, 5, "it never ends"
"""How pytest ends where it does not know a test or finds none, and what stands for tests that take too long."""
SWAPS = {
    ast.Lt: "<=",
    ast.LtE: "<",
    ast.Gt: ">=",
    ast.GtE: ">",
    ast.Eq: "!=",
    ast.NotEq: "==",
    ast.Is: "is not",
    ast.IsNot: "is",
    ast.In: "not in",
    ast.NotIn: "in",
}
ARITHMETIC = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}


@dataclass(frozen=True)
class Break:
    """A change of one expression.

    Attributes:
        file: from the package's folder; function: qualified name.
        line: of the expression; before, after: the whole lines of its statement's expression, as text.
        caught: the tests that fail with it; None before they were asked.
    """

    file: str
    function: str
    line: int
    before: str
    after: str
    caught: tuple[str, ...] | None = None


def breaks_in(path: Path) -> Iterator[Break]:
    """All breaks of a file: comparisons, arithmetic, `and` and `or`, `not`, truth values and whole numbers."""
    source = path.read_text("utf-8")
    tree = ast.parse(source)
    for name, function in _functions(tree, ""):
        for node in ast.walk(function):
            after = _changed(node, source)
            before = ast.get_source_segment(source, node)
            if after and before and "\n" not in before and source.count(before) >= 1:
                yield Break(str(path.relative_to(PACKAGE)), name, node.lineno, before, after)  # type: ignore[attr-defined]


def _functions(tree: ast.AST, prefix: str) -> Iterator[tuple[str, ast.AST]]:
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            yield prefix + node.name, node
        elif isinstance(node, ast.ClassDef):
            yield from _functions(node, f"{prefix}{node.name}.")


def _changed(node: ast.AST, source: str) -> str:
    """The text of an expression after its break; empty where it has none."""

    def text(part: ast.AST) -> str:
        return ast.get_source_segment(source, part) or ""

    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        return f"{text(node.left)} {SWAPS[type(node.ops[0])]} {text(node.comparators[0])}"
    if isinstance(node, ast.BinOp) and type(node.op) in ARITHMETIC:
        return f"{text(node.left)} {ARITHMETIC[type(node.op)]} {text(node.right)}"
    if isinstance(node, ast.BoolOp):
        return (" or " if isinstance(node.op, ast.And) else " and ").join(map(text, node.values))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return f"bool({text(node.operand)})"
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        return str(not node.value)
    if isinstance(node, ast.Constant) and isinstance(node.value, int):
        return str(node.value + 1)
    return ""


def draw() -> list[Break]:
    """The breaks: files are drawn by their number of breaks."""
    every = [one for path in sorted(PACKAGE.rglob("*.py")) for one in breaks_in(path)]
    return sorted(random.Random(SEED).sample(every, NUMBER), key=lambda one: (one.file, one.line))


def place_of(one: Break, package: Path) -> tuple[Path, int]:
    """File and offset of the expression, by function and text; the file that had it first.

    Raises:
        LookupError: no function of that name has it.
    """
    paths = [package / one.file, *sorted(package.rglob("*.py"))]
    for path in dict.fromkeys(paths):
        if not path.exists():
            continue
        source = path.read_text("utf-8")
        lines = source.splitlines(keepends=True)
        near = {id(node): node for name, node in _functions(ast.parse(source), "") if name == one.function}
        for function in near.values():
            found = [
                node
                for node in ast.walk(function)
                if hasattr(node, "lineno") and ast.get_source_segment(source, node) == one.before
            ]
            if found:
                exact = [node for node in found if node.lineno == one.line and path == package / one.file]
                node = (exact or found)[0]
                before = "".join(lines[: node.lineno - 1]) + lines[node.lineno - 1].encode()[: node.col_offset].decode()
                return path, len(before)
    raise LookupError(f"{one.file}: {one.function}: {one.before}")


def apply(one: Break, package: Path) -> tuple[Path, int]:
    """Break a copy of the package; the file and the line of the break."""
    path, offset = place_of(one, package)
    source = path.read_text("utf-8")
    path.write_text(source[:offset] + one.after + source[offset + len(one.before) :], "utf-8")
    return path, source.count("\n", 0, offset) + 1


def _copied(scratch: str) -> Path:
    copy = Path(scratch) / "copy"
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".git", "campaigns_", "__pycache__", "*.sqlite"))
    return copy


def failing(copy: Path, tests: Sequence[str], *options: str) -> tuple[str, ...]:
    """The tests that fail in a copy of the checkout, with options of pytest; `NEVER_ENDS` where they take too long.

    A name that pytest does not know, such as that of a test which is no more, is left out.
    """
    call = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--tb=no", "-rfE", *options]
    environment = {**os.environ, "PYTHONPATH": str(copy)}
    asked = list(tests)
    while asked:
        try:
            done = subprocess.run(
                [*call, *asked], cwd=copy, capture_output=True, text=True, timeout=MOST_S, env=environment, check=False
            )
        except subprocess.TimeoutExpired:
            return (NEVER_ENDS,)
        rows = [row for row in done.stdout.splitlines() if row[:7] in ("FAILED ", "ERROR t")]
        unknown = {test for test in asked if f"{test}\n" in done.stderr} if done.returncode == USAGE else set()
        if rows or not unknown:
            break
        asked = [test for test in asked if test not in unknown]
    else:
        return ()
    if not rows and done.returncode not in (0, NO_TESTS):
        return (f"pytest ends with {done.returncode}",)
    return tuple(row.split(" - ")[0].split(" ", 1)[1] for row in rows)


def caught(one: Break, known: dict[str, list[str]]) -> tuple[str, ...]:
    """Up to three tests that fail with a break.

    Asked are of the recorded ones those that still are, wherever they stand; then published flights flown again, those
    that mirror its folder, and those of the verbs; then the same with `--release`, which stands before the tests that
    only a release runs.
    """
    names = {test.split("::")[-1].split("[")[0] for test in one.caught or ()}
    with tempfile.TemporaryDirectory() as scratch:
        copy = _copied(scratch)
        path, _ = apply(one, copy / "scaloft_fi")
        near = Path("tests") / path.relative_to(copy / "scaloft_fi").parent
        tests = [place for name in sorted(names) for place in known.get(name, ())]
        every = [tests, [FLOWN_AGAIN], [str(near)], ["tests/verbs", "tests/test_outputs.py"]]
        for options in ((), ("--release", "-m", "release")):
            for asked in every:
                found = failing(copy, asked, "--maxfail=3", *options) if asked else ()
                if found:
                    return (*options[:1], *found)
    return ()


def tests_by_name() -> dict[str, list[str]]:
    """Where the test of each name stands now."""
    told: dict[str, list[str]] = {}
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        for node in ast.parse(path.read_text("utf-8")).body:
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                told.setdefault(node.name, []).append(f"{path.relative_to(ROOT)}::{node.name}")
    return told


def without_those_that_fail_anyway(every: Sequence[Break]) -> list[Break]:
    """The breaks, each caught only by tests that pass where nothing is broken."""
    named = sorted({test for one in every for test in one.caught or () if "::" in test})
    with tempfile.TemporaryDirectory() as scratch:
        anyway = failing(_copied(scratch), named)
    return [replace(one, caught=tuple(test for test in one.caught or () if test not in anyway)) for one in every]


def recorded() -> list[Break]:
    """The record."""
    return [
        Break(**{**row, "caught": None if row["caught"] is None else tuple(row["caught"])})
        for row in json.loads(RECORD.read_text("utf-8"))
    ]


def _write(every: list[Break]) -> None:
    RECORD.write_text(json.dumps([asdict(one) for one in every], indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    if sys.argv[1] == "draw":
        _write(draw())
    else:
        every = recorded()
        for number, one in enumerate(every):
            if one.caught:
                every[number] = replace(one, caught=caught(one, tests_by_name()))
                _write(every)
        _write(without_those_that_fail_anyway(every))
