"""What a setting may be: marks in the type of a field, `Annotated[float, Bounds(least=0.0)]`.

A frozen dataclass or named tuple whose fields carry such marks describes a mapping of settings once: reading, bounds
and schema follow from it (`scaloft_fi.model`).  The texts stand in the docstring of the class, under `Attributes:`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

LARGEST = 1e9
"""Largest number of a setting that states no bounds of its own."""
MOST = 1_000
"""Most entries of a list or mapping of which each entry costs time or memory in every flight."""


@dataclass(frozen=True)
class Bounds:
    """Allowed numbers, `least` <= number <= `most` and number > `above`; `infinite` allows the infinities too."""

    least: float = -LARGEST
    most: float = LARGEST
    above: float = -math.inf
    infinite: bool = False


@dataclass(frozen=True)
class Size:
    """Allowed number of entries of a list or mapping; `allowed` says it where there are too few or too many."""

    least: int = 0
    most: int = MOST
    allowed: str = ""


@dataclass(frozen=True)
class Pattern:
    """A regular expression that all of a text, or of each key of a mapping, matches; `allowed` says it in words."""

    text: str
    allowed: str


@dataclass(frozen=True, eq=False)
class Choices:
    """Allowed texts, with the meaning of each if it is a mapping.

    Attributes:
        texts: they, or a function that finds them.
        named: the name under which a reader of the document hands over others in their stead, such as `seams`; without
            any, where `texts` has none either, every text is allowed.
        elsewhere: texts that a package of ours allows once it is installed, each with the command that installs it.
    """

    texts: Collection[str] | Callable[[], Collection[str]] = ()
    named: str = ""
    elsewhere: tuple[tuple[str, str], ...] = ()

    def among(self, names: Mapping[str, Collection[str]]) -> Collection[str]:
        """The allowed texts; `names` has those that are handed over."""
        if self.named in names:
            return names[self.named]
        return self.texts() if callable(self.texts) else self.texts


@dataclass(frozen=True)
class About:
    """What a field is, for one whose class cannot say it in its docstring."""

    text: str


@dataclass(frozen=True)
class Called:
    """The key of a field in the document, where it is no name of Python, such as `from`."""

    key: str


@dataclass(frozen=True)
class Reads:
    """A value that a function reads from its entry; `schema` says, for names of the study, what its JSON Schema is."""

    read: Callable[[Any], Any]
    schema: Callable[[Mapping[str, Collection[str]]], dict[str, Any]]


@dataclass(frozen=True)
class Given:
    """A field that no key has: a function finds it from the whole entry, such as its place."""

    find: Callable[[Any], Any]


@dataclass(frozen=True)
class Either:
    """A value of one of some forms, `Annotated[Box | Capsule, Either(by="shape")]`.

    Attributes:
        allowed: the forms, in words.
        by: the key that tells them apart, which has a fixed value in each; without it the keys do that only one has.
    """

    allowed: str = ""
    by: str = ""


@dataclass(frozen=True)
class Otherwise:
    """The value of a field whose key is left out, where the class itself asks for one."""

    value: Any


@dataclass(frozen=True)
class Needed:
    """A field whose key may not be left out, although its class has a default."""


@dataclass(frozen=True)
class ByName:
    """A tuple that a document writes as a mapping by name."""


@dataclass(frozen=True)
class Listed:
    """A mapping of records by name that an answer lists: `key` is the key of the name, `about` says what it is."""

    key: str
    about: str


@dataclass(frozen=True)
class Examples:
    """Examples of a value."""

    values: tuple[Any, ...]

    def __init__(self, *values: Any) -> None:
        object.__setattr__(self, "values", values)


Scalar = str | int | float | bool
Positive = Annotated[float, Bounds(least=1e-6)]
MoreThanZero = Annotated[float, Bounds(above=0.0)]
NotNegative = Annotated[float, Bounds(least=0.0)]
Share = Annotated[float, Bounds(least=0.0, most=1.0)]
Whole = Annotated[int, Bounds(least=0)]
OneOrMore = Annotated[int, Bounds(least=1)]
Count = Annotated[int, Bounds(least=1, most=MOST)]
Key = Annotated[str, Given(lambda item: item.name)]
"""The name under which the entry stands in its mapping."""
Place = Annotated[str, Given(lambda item: item.place)]
"""`file:line` of the entry."""
