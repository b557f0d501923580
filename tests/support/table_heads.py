"""Every heading that a table of the package can have, read from the code that makes the tables."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import EnumMeta
from itertools import product
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
MAKERS = {"Table": 1, "tabulated": 0, "_tabulated": 0, "csv_text": 0}
"""What makes a table, and which of its arguments are the headings."""
FOLDERS = ("views", "verbs")
UNTOLD = "\0"
"""What marks the source of an expression whose value only a run tells."""


@dataclass(frozen=True)
class Heading:
    """A heading and the place that makes it; `text` is None where the code alone does not tell it."""

    text: str | None
    place: str


@dataclass(frozen=True)
class _Scope:
    """What a name can mean: the functions around it, innermost first, and its module."""

    functions: tuple[ast.FunctionDef, ...]
    module: dict[str, Any]


def headings() -> list[Heading]:
    """Of every table that `views` and `verbs` make.

    A heading that only a run tells has no text; its place is `file: expression`.
    """
    package = ROOT / "scaloft_fi"
    paths = sorted(path for folder in FOLDERS for path in (package / folder).rglob("*.py"))
    return [heading for path in paths for heading in _of_file(path)]


def _of_file(path: Path) -> Iterator[Heading]:
    name = path.relative_to(ROOT).as_posix()
    tree = ast.parse(path.read_text())
    if not any(isinstance(node, ast.Call) and _maker(node) in MAKERS for node in ast.walk(tree)):
        return
    module = vars(importlib.import_module(name.removesuffix(".py").replace("/", ".")))
    for call, functions in _calls(tree, ()):
        maker = _maker(call)
        if maker not in MAKERS or len(call.args) <= MAKERS[maker]:
            continue
        heads = call.args[MAKERS[maker]]
        for text in _texts(heads, _Scope(functions, module)):
            if text.startswith(UNTOLD):
                yield Heading(None, f"{name}: {text.removeprefix(UNTOLD)}")
            else:
                yield Heading(text, name)


def _maker(call: ast.Call) -> str:
    return call.func.id if isinstance(call.func, ast.Name) else ""


def _calls(
    node: ast.AST, around: tuple[ast.FunctionDef, ...]
) -> Iterator[tuple[ast.Call, tuple[ast.FunctionDef, ...]]]:
    for child in ast.iter_child_nodes(node):
        inner = (child, *around) if isinstance(child, ast.FunctionDef) else around
        if isinstance(child, ast.Call):
            yield child, inner
        yield from _calls(child, inner)


def _texts(node: ast.AST, scope: _Scope) -> set[str]:
    """The texts that an expression can hold; a marked expression for what only a run tells."""
    match node:
        case ast.Constant(value=str(text)):
            return {text}
        case ast.Constant() | ast.Slice() | ast.UnaryOp():
            return set()
        case ast.Tuple(elts=parts) | ast.List(elts=parts):
            return set().union(*(_texts(part, scope) for part in parts))
        case ast.Starred(value=inner):
            return _texts(inner, scope)
        case ast.IfExp(body=one, orelse=other):
            return _texts(one, scope) | _texts(other, scope)
        case ast.JoinedStr(values=parts):
            choices = [_texts(part.value if isinstance(part, ast.FormattedValue) else part, scope) for part in parts]
            joined = {"".join(choice) for choice in product(*choices)}
            return {f"{UNTOLD}{ast.unparse(node)}" if UNTOLD in text else text for text in joined}
    if isinstance(node, ast.Name) and (assigned := _assigned(node.id, scope)):
        return set().union(*(_texts(value, scope) for value in assigned))
    return _evaluated(node, scope)


def _assigned(name: str, scope: _Scope) -> list[ast.AST]:
    """What the functions around it, the innermost first, assign to a name."""
    for function in scope.functions:
        values = list(_assignments(name, function))
        if values:
            return values
        if any(argument.arg == name for argument in (*function.args.args, *function.args.kwonlyargs)):
            return []
    return []


def _assignments(name: str, function: ast.FunctionDef) -> Iterator[ast.AST]:
    for node in ast.walk(function):
        if not isinstance(node, ast.Assign):
            continue
        for target in node.targets:
            if isinstance(target, ast.Name) and target.id == name:
                yield node.value
            elif isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                yield from (
                    value
                    for part, value in zip(target.elts, node.value.elts, strict=True)
                    if isinstance(part, ast.Name) and part.id == name
                )


def _evaluated(node: ast.AST, scope: _Scope) -> set[str]:
    source = ast.unparse(node)
    listed = f"list({source})" if isinstance(node, ast.GeneratorExp) else source
    parameters = {argument.arg for function in scope.functions for argument in function.args.args}
    if {inner.id for inner in ast.walk(node) if isinstance(inner, ast.Name)} & parameters:
        return {f"{UNTOLD}{source}"}
    try:
        value = eval(listed, dict(scope.module))
    except Exception:  # noqa: BLE001 - what only a run tells
        return {f"{UNTOLD}{source}"}
    return set(_strings(value))


def _strings(value: Any) -> Iterable[str]:
    if isinstance(value, str):
        return [value]
    if isinstance(value, EnumMeta):
        return [member.value for member in value]  # type: ignore[var-annotated]
    if isinstance(value, dict | list | tuple | set | frozenset):
        return [text for part in value for text in _strings(part)]
    return []
