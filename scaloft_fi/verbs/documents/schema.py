"""Parts of the JSON Schemas of YAML documents, hand-written or found out by asking the reader of an entry.

Mappings are closed: they have the named keys and no others.  Bounds are those of the loaders, and a test holds them to
that.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import cleandoc
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from scaloft_fi.document import LARGEST, Item
from scaloft_fi.mutants.operator import Operator
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.sim.happenings import HAPPENINGS, HappeningKind
from scaloft_fi.sim.log import SIGNALS, DeclaredSignal
from scaloft_fi.sim.sensors.sensor import SENSORS, SensorKind
from scaloft_fi.sim.world import ROLES, Role
from scaloft_fi.stack.config import Bounds, Scalar
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.verbs.operators import OWN, package_of

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


Schema = dict[str, Any]
"""A JSON Schema (draft 2020-12)."""


def text(about: str, *examples: str, pattern: str = "") -> Schema:
    """A text that is not empty; `pattern` is a regular expression that all of it matches."""
    limits = {"pattern": f"^(?:{pattern})$"} if pattern else {"minLength": 1}
    return {"type": "string", "description": about, **limits, **_examples(examples)}


def number(
    about: str,
    unit: str = "",
    *examples: float,
    least: float | None = None,
    above: float | None = None,
    most: float | None = None,
    default: float | None = None,
) -> Schema:
    """A number with `least` <= number <= `most` and number > `above`; `default` stands where it is left out."""
    return {"type": "number", **_about(about, unit), **_bounds(least, above, most), **_rest(default, examples)}


def whole(
    about: str, *examples: int, least: int | None = 0, most: int | None = None, default: int | None = None
) -> Schema:
    """A whole number with `least` <= number <= `most`."""
    return {"type": "integer", "description": about, **_bounds(least, None, most), **_rest(default, examples)}


def flag(about: str, *, default: bool | None = None) -> Schema:
    """True or false."""
    return {"type": "boolean", "description": about, **_rest(default, ())}


def choice(about: str, values: Sequence[str] | Mapping[str, str], *, default: str | None = None) -> Schema:
    """One of some texts; a mapping says what each means."""
    meanings = (
        "".join(f"\n- {value}: {meaning}" for value, meaning in values.items()) if isinstance(values, Mapping) else ""
    )
    return {"enum": list(map(str, values)), "description": about + meanings, **_rest(default, ())}


def fixed(value: str | bool | int, about: str) -> Schema:
    """Exactly this value."""
    return {"const": value, "description": about}


def anything(about: str) -> Schema:
    """A value whose form something else decides."""
    return {"description": about}


def listed(
    about: str, each: Schema, *, least: int = 0, most: int | None = None, examples: Sequence[Any] = ()
) -> Schema:
    """A list of `least` to `most` values."""
    limits = {"minItems": least} if least else {}
    if most is not None:
        limits["maxItems"] = most
    return {"type": "array", "description": about, "items": each, **limits, **_examples(examples)}


def numbers(about: str, count: int, unit: str = "", *examples: Sequence[float], **bounds: float) -> Schema:
    """A list of `count` numbers, each within `least` and `most`."""
    each: Schema = {"type": "number", **_bounds(bounds.get("least"), None, bounds.get("most"))}
    limits = {"minItems": count, "maxItems": count}
    return {"type": "array", **_about(about, unit), "items": each, **limits, **_examples(examples)}


def mapping(about: str, needed: Mapping[str, Schema], optional: Mapping[str, Schema] | None = None) -> Schema:
    """A mapping with these keys, of which the optional ones may be left out."""
    return {
        "type": "object",
        "description": about,
        "properties": {**needed, **(optional or {})},
        "required": list(needed),
        "additionalProperties": False,
    }


def named(about: str, each: Schema, *, pattern: str = "", least: int = 0, most: int | None = None) -> Schema:
    """A mapping whose keys are names of the study; `pattern` is a regular expression that all of a name matches."""
    limits: Schema = {"minProperties": least} if least else {}
    if most is not None:
        limits["maxProperties"] = most
    if pattern:
        names = {"patternProperties": {f"^(?:{pattern})$": each}, "additionalProperties": False}
    else:
        names = {"additionalProperties": each}
    return {"type": "object", "description": about, **names, **limits}


def either(about: str, *alternatives: Schema) -> Schema:
    """One of some forms; where they are mappings, a key with a fixed value tells which."""
    return {"description": about, "oneOf": list(alternatives)}


def _about(about: str, unit: str) -> Schema:
    return {"description": f"{about} [{unit}]" if unit else about}


def _bounds(least: float | None, above: float | None, most: float | None) -> Schema:
    bounds = {"minimum": least, "exclusiveMinimum": above, "maximum": most}
    return {name: _plain(bound) for name, bound in bounds.items() if bound is not None}


def _plain(bound: float) -> float | int:
    return int(bound) if bound == int(bound) else bound


def _rest(default: Any, examples: Sequence[Any]) -> Schema:
    return {**({} if default is None else {"default": default}), **_examples(examples)}


def _examples(examples: Sequence[Any]) -> Schema:
    return {"examples": [list(one) if isinstance(one, tuple) else one for one in examples]} if examples else {}


NOT_TOLD = Bounds()
"""The bounds of a number that states none."""
Instead = Mapping[str, Schema]
"""Schemas by name of a field, which stand in place of what its type says."""


def settings_schema(cls: type, *, about: str = "", instead: Instead | None = None) -> Schema:
    """The schema of a mapping with the fields of a dataclass or named tuple.

    Args:
        cls: the class; its docstring says what each field is.
        about: what the mapping is; by default the first paragraph of the docstring.
        instead: schemas of fields that the type alone does not tell.
    """
    hints, told = get_type_hints(cls, include_extras=True), attributes_of(cls)
    defaults = _defaults(cls)
    needed: dict[str, Schema] = {}
    optional: dict[str, Schema] = {}
    for name in _names(cls):
        schema = dict((instead or {}).get(name) or _typed(hints[name]))
        schema["description"] = told.get(name) or schema.get("description") or name.replace("_", " ")
        if name in defaults:
            plain = defaults[name]
            optional[name] = schema | ({"default": plain} if isinstance(plain, str | int | float | bool) else {})
        else:
            needed[name] = schema
    return mapping(about or summary_of(cls), needed, optional)


def _names(cls: type) -> tuple[str, ...]:
    if dataclasses.is_dataclass(cls):
        return tuple(field.name for field in dataclasses.fields(cls))
    return tuple(getattr(cls, "_fields", ()))


def _defaults(cls: type) -> Mapping[str, Any]:
    """The default of each field that has one; of one with a factory what the factory makes."""
    if not dataclasses.is_dataclass(cls):
        return dict(getattr(cls, "_field_defaults", {}))
    missing = dataclasses.MISSING
    found: dict[str, Any] = {}
    for member in dataclasses.fields(cls):
        if member.default is not missing:
            found[member.name] = member.default
        elif member.default_factory is not missing:
            found[member.name] = member.default_factory()
    return found


def _typed(hint: Any) -> Schema:
    marks = getattr(hint, "__metadata__", ())
    hint = hint.__origin__ if marks else hint
    if dataclasses.is_dataclass(hint) or hasattr(hint, "_fields"):
        return settings_schema(hint)
    if get_origin(hint) is Mapping:
        return {"type": "object", "additionalProperties": _typed(get_args(hint)[1])}
    if hint == Scalar:
        return {"type": ["string", "number", "boolean"]}
    if hint in (float, int):
        bounds = next((mark for mark in marks if isinstance(mark, Bounds)), NOT_TOLD)
        return {"type": "number" if hint is float else "integer", **_limits(bounds)}
    if hint in (str, bool):
        return {"type": "string" if hint is str else "boolean"}
    if hint is Any:
        return {}
    return _list(get_args(hint))


def _limits(bounds: Bounds) -> Schema:
    told = {"minimum": (bounds.least, NOT_TOLD.least), "maximum": (bounds.most, NOT_TOLD.most)}
    return {name: bound for name, (bound, untold) in told.items() if bound != untold}


def _list(inner: tuple[Any, ...]) -> Schema:
    if inner[-1] is Ellipsis:
        return {"type": "array", "items": _typed(inner[0])}
    each = [_typed(hint) for hint in inner]
    count = {"minItems": len(each), "maxItems": len(each)}
    if all(one == each[0] for one in each):
        return {"type": "array", "items": each[0], **count}
    return {"type": "array", "prefixItems": each, **count}


@dataclass
class Notes:
    """What was asked of a stand-in.

    Attributes:
        schema: as a schema without descriptions.
        keys: the stand-in of each key that was asked for.
        needed: the keys without which the reader does not go on.
        each: the stand-in of each entry of a list; None where no list was asked for.
    """

    schema: Schema = field(default_factory=dict)
    keys: dict[str, Probe] = field(default_factory=dict)
    needed: set[str] = field(default_factory=set)
    each: Probe | None = None


class Probe(Item):
    """Stands for a value of YAML that is not there: it answers with the least value that is allowed."""

    notes: Notes

    def __init__(self, name: str) -> None:
        super().__init__(Path("probe"), 0, name, {})
        object.__setattr__(self, "notes", Notes())  # items are frozen

    def get(self, key: str) -> Item | None:
        """Answer with an entry, which is optional."""
        return self.notes.keys.setdefault(key, Probe(key))

    def need(self, key: str, meaning: str = "") -> Item:
        """Answer with an entry, which is needed."""
        self.notes.needed.add(key)
        return self.notes.keys.setdefault(key, Probe(key))

    def close(self) -> None:
        """Refuse nothing."""

    def mapping(self, *, most: int = 0) -> dict[str, Item]:
        """Answer with no entries."""
        self.notes.schema.setdefault("type", "object")
        return {}

    def items(self, *, most: int = 0) -> tuple[Item, ...]:
        """Answer with one entry."""
        self.notes.schema["type"] = "array"
        self.notes.each = Probe(f"{self.name}[0]")
        return (self.notes.each,)

    def __iter__(self) -> Iterator[Item]:
        return iter(self.items())

    def text(self) -> str:
        """Answer with a text."""
        self.notes.schema.update({"type": "string", "minLength": 1})
        return "text"

    def number(
        self, *, least: float = -LARGEST, most: float = LARGEST, above: float = -math.inf, infinite: bool = False
    ) -> float:
        """Answer with the least number that is allowed, or 0."""
        bounds = {"minimum": least, "maximum": most, "exclusiveMinimum": above}
        told = {name: bound for name, bound in bounds.items() if abs(bound) < LARGEST}
        self.notes.schema.update({"type": "number", **told})
        return max(least, above + 1e-9) if "minimum" in told or "exclusiveMinimum" in told else min(0.0, most)

    def whole(self, *, least: int = 0, most: int = int(LARGEST)) -> int:
        """Answer with the least number that is allowed."""
        self.notes.schema.update({"type": "integer", "minimum": least, **({"maximum": most} if most < LARGEST else {})})
        return least

    def flag(self) -> bool:
        """Answer with true."""
        self.notes.schema.update({"type": "boolean"})
        return True

    def choice(self, allowed: Sequence[str]) -> str:
        """Answer with the first choice."""
        self.notes.schema.update({"enum": [str(one) for one in allowed]})
        return str(allowed[0])

    def numbers(self, count: int | None = None, *, least: float = -LARGEST, most: float = LARGEST) -> tuple[float, ...]:
        """Answer with numbers of the least value that is allowed, or 0."""
        each = Probe(self.name)
        value = each.number(least=least, most=most)
        size = {"minItems": count, "maxItems": count} if count is not None else {}
        self.notes.schema.update({"type": "array", "items": each.notes.schema, **size})
        return (value,) * (count if count is not None else 1)

    def plain(self) -> Any:
        """Answer with nothing."""
        return {}


def probed(read: Callable[[Item], Any], about: str, texts: Mapping[str, str], *, closed: bool) -> Schema:
    """The schema of the mapping that a function reads.

    Args:
        read: the function.
        about: what the mapping is.
        texts: what each key is.
        closed: whether no other keys are allowed; not where the reader may ask for more of other values.
    """
    probe = Probe("entry")
    try:
        read(probe)
    except Exception:  # noqa: BLE001 - the reader of a plugin may not take what stands in
        closed = False
    return _schema(probe, about, texts, closed=closed)


def _schema(probe: Probe, about: str, texts: Mapping[str, str], *, closed: bool) -> Schema:
    notes = probe.notes
    schema = dict(notes.schema)
    if notes.each is not None:
        schema["items"] = _schema(notes.each, "", texts, closed=closed)
    if notes.keys:
        told = {key: texts.get(key, key.replace("_", " ")) for key in notes.keys}
        keys = {key: _schema(entry, told[key], texts, closed=closed) for key, entry in notes.keys.items()}
        schema |= {"type": "object", "properties": keys, "required": [key for key in keys if key in notes.needed]}
        schema |= {"additionalProperties": False} if closed else {}
    return ({"description": about} if about else {}) | schema


T = TypeVar("T")


@dataclass(frozen=True)
class Declared:
    """Declared things by name: operators, sensors, kinds of happenings, roles of bodies, optional signals, stacks.

    Attributes:
        seams: of one study, by name with who sends and who receives; empty where no study is meant.
    """

    operators: Mapping[str, Operator]
    sensors: Mapping[str, SensorKind]
    happenings: Mapping[str, HappeningKind]
    roles: Mapping[str, Role]
    signals: Mapping[str, DeclaredSignal]
    stacks: Mapping[str, Declaration]
    seams: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def everything(cls, *, own: bool = False) -> Declared:
        """What is declared now; `own` leaves out what other packages declare.

        The operators of the package's stacks are declared first.
        """
        import scaloft_fi.mutants.reference
        import scaloft_fi.outside.faults  # noqa: F401 - both declare operators
        from scaloft_fi.sim.stacks import STACKS

        return cls(
            operators=_chosen(OPERATORS, lambda one: one.make, own=own),
            sensors=_chosen(SENSORS, lambda one: one.make, own=own),
            happenings=_chosen(HAPPENINGS, lambda one: one.read, own=own),
            roles={name: role for name, role in ROLES.items() if name in OWN_ROLES or not own},
            signals=_chosen(SIGNALS, lambda one: one.make, own=own),
            stacks=_chosen(STACKS, lambda one: one.make, own=own),
        )


OWN_ROLES = ("obstacle", "person", "structure")
"""Roles are data, which do not tell who declared them."""


def _chosen(entries: Mapping[str, T], maker: Callable[[T], Any], *, own: bool) -> dict[str, T]:
    """The entries by name, in the order of their names."""
    return {name: entries[name] for name in sorted(entries) if not own or package_of(maker(entries[name])) == OWN}
