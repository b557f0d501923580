"""What the docstring of a class says of each of its attributes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from inspect import cleandoc

_ENTRY = re.compile(r"^ {4}(?P<names>\w+(?:, \w+)*): (?P<text>.*)$")


def attributes_of(cls: type) -> Mapping[str, str]:
    """The text of each name under `Attributes:`, those of base classes too.

    >>> from scaloft_fi.stack.reference.mission import MissionConfig
    >>> attributes_of(MissionConfig)["settled_m"]
    'take-off ends within this distance of the altitude [m].'
    """
    found: dict[str, str] = {}
    for one in reversed(cls.__mro__):
        lines = cleandoc(one.__doc__ or "").partition("\nAttributes:\n")[2].splitlines()
        names: list[str] = []
        for line in lines:
            if entry := _ENTRY.match(line):
                names = entry["names"].split(", ")
                found |= dict.fromkeys(names, entry["text"])
            elif line.startswith(" " * 8):
                found |= {name: f"{found[name]} {line.strip()}" for name in names}
            else:
                break
    return found


def summary_of(cls: type) -> str:
    """The first paragraph of a class's docstring."""
    return " ".join(cleandoc(cls.__doc__ or "").partition("\n\n")[0].split())
