"""The public surface changes on purpose only: `RECORD=1` writes it anew, and CHANGELOG.md tells of it."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from options import as_recorded

import scaloft_fi
from scaloft_fi import api

HEAD = (
    "The public names of scaloft_fi and scaloft_fi.api, with their signatures.  docs/api.md says which change needs\n"
    "# which version.  Who changes a line on purpose runs `RECORD=1 pytest tests/test_api_surface.py`, and tells\n"
    "# of it in CHANGELOG.md."
)


def entries(name: str, value: Any, *, members: bool) -> Iterator[str]:
    """The lines of a public name: its signature, and of a class that scripts use each public member."""
    if inspect.isclass(value) and members:
        bases = [base.__name__ for base in value.__bases__ if base is not object]
        yield f"class {name}({', '.join(bases)})"
        own = [one for one in value.__mro__ if one.__module__.startswith("scaloft_fi")]
        names = {member for one in own for member in (*vars(one), *inspect.get_annotations(one))}
        public = (one for one in names if not one.startswith("_") or one.startswith("_repr_"))
        yield from (f"  {member(value, one)}" for one in sorted(public))
    elif inspect.isclass(value) or inspect.isfunction(value):
        yield f"{'class' if inspect.isclass(value) else 'def'} {name}{signature(value)}"
    elif type(value).__module__ in ("typing", "collections.abc"):
        yield f"{name} = {without_addresses(str(value))}"
    else:
        yield f"{name}: {type(value).__name__}"


def member(owner: type, name: str) -> str:
    value = inspect.getattr_static(owner, name, None)
    getter = value.fget if isinstance(value, property) else getattr(value, "func", None)  # of a cached property
    if getter is not None:
        return f"{name}: {getter.__annotations__.get('return', '?')}"
    if callable(value):
        return f"{name}{signature(value)}"
    annotated = [inspect.get_annotations(one)[name] for one in owner.__mro__ if name in inspect.get_annotations(one)]
    return f"{name}: {annotated[0]}" if annotated else f"{name} = {value!r}"


def signature(value: Any) -> str:
    """With annotations as the source has them, without quotes."""
    try:
        found = re.sub(r"ForwardRef\(('[^']*')\)", r"\1", str(inspect.signature(value)))
        return without_addresses(re.sub(r"(: |-> )'([^']*)'", r"\1\2", found))
    except (TypeError, ValueError):
        return "(...)"


def without_addresses(text: str) -> str:
    return re.sub(r" at 0x[0-9a-f]+", "", text)


@pytest.mark.skipif(sys.version_info[:2] != (3, 11), reason="other versions of Python write signatures otherwise")
def test_the_public_surface_is_the_one_that_was_written_down():
    lines = [
        line
        for module, members in ((scaloft_fi, True), (api, False))
        for name in sorted(module.__all__)
        for line in entries(f"{module.__name__}.{name}", getattr(module, name), members=members)
    ]
    as_recorded(str(Path(__file__).with_name("api_surface")), {HEAD: "\n".join(lines)})


def test_every_public_name_is_there_and_says_what_it_is():
    for module in (scaloft_fi, api):
        for name in module.__all__:
            value = getattr(module, name)
            if inspect.isfunction(value) or inspect.isclass(value):
                assert value.__doc__, name
