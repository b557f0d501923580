"""The public surface of the package as a text; run as a program it writes tests/api_surface.txt anew."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import scaloft_fi
from scaloft_fi import api

FILE = Path(__file__).parents[1] / "api_surface.txt"
_ADDRESS = re.compile(r" at 0x[0-9a-f]+")
HEAD = """\
# The public names of scaloft_fi and scaloft_fi.api, with their signatures.  docs/api.md says which change needs which
# version.  Who changes a line on purpose runs `python tests/support/api_surface.py` and tells of it in CHANGELOG.md.
"""


def surface() -> str:
    """Each public name, and of the classes that scripts use each public member, with signatures."""
    lines = [HEAD]
    for name in sorted(scaloft_fi.__all__):
        lines += _entries(f"scaloft_fi.{name}", getattr(scaloft_fi, name), members=True)
    for name in sorted(api.__all__):
        lines += _entries(f"scaloft_fi.api.{name}", getattr(api, name), members=False)
    return "\n".join([*lines, ""])


def _entries(name: str, value: Any, *, members: bool) -> Iterator[str]:
    if inspect.isclass(value):
        if members:
            bases = [base.__name__ for base in value.__bases__ if base is not object]
            yield f"class {name}({', '.join(bases)})"
            for member in sorted(_members(value)):
                yield f"  {_member(value, member)}"
        else:
            yield f"class {name}{_signature(value)}"
    elif inspect.isfunction(value):
        yield f"def {name}{_signature(value)}"
    elif type(value).__module__ in ("typing", "collections.abc"):
        yield f"{name} = {_ADDRESS.sub('', str(value))}"
    else:
        yield f"{name}: {type(value).__name__}"


def _members(value: type) -> set[str]:
    """The public members of a class of this package, and of its bases here; fields of data classes too."""
    own = [one for one in value.__mro__ if one.__module__.startswith("scaloft_fi")]
    names = {name for one in own for name in (*vars(one), *vars(one).get("__annotations__", {}))}
    return {name for name in names if not name.startswith("_") or name.startswith("_repr_")}


def _member(owner: type, name: str) -> str:
    value = inspect.getattr_static(owner, name, None)
    if isinstance(value, property):
        return f"{name}: {_returned(value.fget)}"
    if hasattr(value, "func"):  # a cached property
        return f"{name}: {_returned(value.func)}"
    if callable(value):
        return f"{name}{_signature(value)}"
    annotated = [_annotated(one)[name] for one in owner.__mro__ if name in _annotated(one)]
    return f"{name}: {annotated[0]}" if annotated else f"{name} = {value!r}"


def _annotated(owner: type) -> dict[str, str]:
    return vars(owner).get("__annotations__", {})


def _returned(getter: Any) -> str:
    return str(getter.__annotations__.get("return", "?"))


def _signature(value: Any) -> str:
    try:
        found = inspect.signature(value)
    except (TypeError, ValueError):
        return "(...)"
    bare = [one.replace(annotation=_Bare(one.annotation)) for one in found.parameters.values()]
    return _ADDRESS.sub("", str(found.replace(parameters=bare, return_annotation=_Bare(found.return_annotation))))


class _Bare:
    """An annotation that is written without quotes."""

    def __new__(cls, annotation: Any) -> Any:
        return annotation if annotation is inspect.Signature.empty else super().__new__(cls)

    def __init__(self, annotation: Any) -> None:
        self._text = getattr(annotation, "__forward_arg__", None) or str(annotation)

    def __repr__(self) -> str:
        return self._text


if __name__ == "__main__":
    FILE.write_text(surface())
