"""A mapping of a study as a typed model: one class gives its reading, its bounds, its texts and its JSON Schema.

A model is a frozen dataclass or a named tuple whose fields carry the marks of `scaloft_fi.marks`:

    @dataclass(frozen=True)
    class Lamp:
        '''A lamp.

Attributes:
            power_w: its power [W].
        '''

        power_w: Annotated[float, Bounds(least=0.0, most=1e3)]
        place: Place = ""

        def contradictions(self, item: Item) -> Iterator[InputError]:
            if self.power_w == 13:
                yield item.need("power_w").error("another number")

`read(Lamp, item)` reads one, and tells everything that is wrong with it at once; `schema(Lamp)` is its JSON Schema.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import re
import types
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache, cached_property
from inspect import cleandoc, get_annotations
from typing import Annotated, Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

from scaloft_fi import marks
from scaloft_fi.document import ITEMS, Item
from scaloft_fi.errors import Faults, InputError, did_you_mean

T = TypeVar("T")
Schema = dict[str, Any]
"""A JSON Schema (draft 2020-12)."""
Names = Mapping[str, Collection[str]]
"""Names that only the study knows, by what they name; see `Choices`."""
NO_NAMES: Names = types.MappingProxyType({})

_NEAR = 0.75
"""How alike an unknown key and a missing one must be to be the same, misspelled."""
_ENTRY = re.compile(r"^ {4}(?P<names>\w+(?:, \w+)*): (?P<text>.*)$")
_UNITS = {float: "number", int: "integer", str: "string", bool: "boolean"}


@dataclass(frozen=True)
class Field:
    """A field of a model: `name` in the code, `key` in the document, its type, its default if it may be left out."""

    name: str
    key: str
    hint: Any
    optional: bool
    default: Any
    about: str
    given: marks.Given | None
    """How the field is found where no key has it."""

    @cached_property
    def reader(self) -> Reader:
        """What reads it."""
        return _reader(self.hint)


def is_model(hint: Any) -> bool:
    """Whether a type is a model."""
    return isinstance(hint, type) and (dataclasses.is_dataclass(hint) or hasattr(hint, "_fields")) and hint is not Item


@cache
def fields_of(cls: type) -> tuple[Field, ...]:
    """The fields of a model, in their order; private ones left out."""
    hints, told = _hints(cls), attributes_of(cls)
    found = []
    for name, default in _defaults(cls).items():
        if name.startswith("_"):
            continue
        hint, called, about = hints[name], _mark(hints[name], marks.Called), _mark(hints[name], marks.About)
        text = told.get(name) or (about.text if about else "")
        if (otherwise := _mark(hint, marks.Otherwise)) is not None:
            default = otherwise.value
        optional = default is not dataclasses.MISSING and _mark(hint, marks.Needed) is None
        found.append(
            Field(name, called.key if called else name, hint, optional, default, text, _mark(hint, marks.Given))
        )
    return tuple(found)


def _hints(cls: type) -> dict[str, Any]:
    """The types of all fields; a base class of another module names what its own module imports."""
    if hasattr(cls, "_fields"):
        return get_type_hints(cls, include_extras=True)
    return {name: hint for base in reversed(cls.__mro__) for name, hint in get_annotations(base, eval_str=True).items()}


def _defaults(cls: type) -> dict[str, Any]:
    """The default of each field, `MISSING` where it has none."""
    if hasattr(cls, "_fields"):
        defaults = getattr(cls, "_field_defaults", {})
        return {name: defaults.get(name, dataclasses.MISSING) for name in cls._fields}
    found: dict[str, Any] = {}
    for field in dataclasses.fields(cls) if dataclasses.is_dataclass(cls) else ():
        made = field.default_factory
        found[field.name] = field.default if made is dataclasses.MISSING else made()
    return found


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


def _mark(hint: Any, kind: type[T]) -> T | None:
    """The mark of a kind that a type carries; that of an optional type too."""
    found: T | None = _found_mark(hint, cast(Any, kind))
    return found


@cache
def _found_mark(hint: Any, kind: Any) -> Any:
    for mark in getattr(hint, "__metadata__", ()):
        if isinstance(mark, kind):
            return mark
    if hasattr(hint, "__metadata__"):
        return _found_mark(hint.__origin__, kind)
    alternatives = get_args(hint) if _is_union(hint) else ()
    return next((mark for one in alternatives if (mark := _found_mark(one, kind)) is not None), None)


def _is_union(hint: Any) -> bool:
    return get_origin(hint) in (Union, types.UnionType)


@cache
def _present(hint: Any) -> tuple[Any, ...]:
    """The alternatives of a type without their marks, None left out."""
    if hasattr(hint, "__metadata__"):
        return _present(hint.__origin__)
    if _is_union(hint):
        return tuple(kind for one in get_args(hint) if one is not type(None) for kind in _present(one))
    return (hint,)


def keys_of(cls: type) -> tuple[str, ...]:
    """The keys of a model."""
    return tuple(field.key for field in fields_of(cls) if field.given is None)


def read(
    cls: type[T],
    item: Item,
    names: Names = NO_NAMES,
    *,
    beside: Collection[str] = (),
    fixed: Mapping[str, Any] | None = None,
) -> T:
    """Read a model.

    Args:
        cls: the model.
        item: the entry.
        names: names that only the study knows.
        beside: other keys of the entry, which somebody else reads.
        fixed: values of fields that no key has.

    Raises:
        InputError: all that is wrong: each value that is not allowed, each missing and unknown key, and what
            `contradictions` of the model yields.
    """
    faults, entries, values, fields = Faults(), item.mapping(), dict(fixed or {}), fields_of(cast(Any, cls))
    allowed, needed = _keys(cast(Any, cls))
    if values:
        fields = tuple(field for field in fields if field.name not in values)
    if values or not needed <= entries.keys() <= allowed:
        faults.add(*_wrong_keys(item, fields, beside))
    for field in fields:
        if field.given is not None:
            values[field.name] = field.given.find(item)
        elif field.key in entries:
            with faults.collecting():
                values[field.name] = field.reader(entries[field.key], names)
        elif field.optional:
            values[field.name] = field.default
    model = _partly(cls, values) if faults else cls(**values)
    faults.add(*_contradictions(model, item, partly=bool(faults)))
    faults.end()
    return model


def _partly(cls: type, values: Mapping[str, Any]) -> Any:
    """A model of which some fields cannot be read."""
    if not dataclasses.is_dataclass(cls):
        return None
    model = object.__new__(cls)
    vars(model).update(values)
    return model


def _contradictions(model: Any, item: Item, *, partly: bool) -> Iterator[InputError]:
    """What `contradictions` of a model yields; of one that was read partly, up to the first field that is missing."""
    find = getattr(model, "contradictions", None)
    if find is None:
        return
    try:
        yield from find(item)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError):
        if not partly:
            raise
    except InputError as error:
        if not partly:
            raise
        yield error


@cache
def _keys(cls: type) -> tuple[frozenset[str], frozenset[str]]:
    """The keys that a model may have, and those that it must have."""
    found = [field for field in fields_of(cls) if field.given is None]
    return frozenset(field.key for field in found), frozenset(field.key for field in found if not field.optional)


def _wrong_keys(item: Item, fields: tuple[Field, ...], beside: Collection[str]) -> Iterator[InputError]:
    """An error for each key that is missing, and each that is unknown; one for both where one is misspelled."""
    entries = item.mapping()
    by_key = {field.key: field for field in fields if field.given is None}
    known = [*by_key, *beside]
    unknown = {key: entry for key, entry in entries.items() if key not in known}
    missing = [field for field in by_key.values() if not field.optional and field.key not in entries]
    for field in missing:
        near = difflib.get_close_matches(field.key, sorted(unknown), n=1, cutoff=_NEAR)
        if near:
            yield InputError(
                f"{unknown.pop(near[0]).place}: unknown key {near[0]!r} in {item.name}; did you mean {field.key!r}?"
            )
        else:
            about = field.about.rstrip(".")
            meaning = f": {about}" if about else ""
            yield InputError(f"{item.place}: {item.name} lacks the key {field.key!r}{meaning}")
    for key, entry in unknown.items():
        yield InputError(f"{entry.place}: unknown key {key!r} in {item.name}{did_you_mean(key, known)}")


Reader = Callable[[Item, Names], Any]
"""Makes of an entry, and names of the study, a value."""


def value_of(hint: Any, item: Item, names: Names = NO_NAMES) -> Any:
    """The value of an entry as its type and marks ask for it.

    Raises:
        InputError: it is not allowed; all that is wrong with it.
    """
    return _reader(hint)(item, names)


@cache
def _reader(hint: Any) -> Reader:
    """What reads values of a type; found once, because a study has thousands of values."""
    if (reads := _mark(hint, marks.Reads)) is not None:
        return lambda item, _names: reads.read(item)
    kinds = _present(hint)
    if set(kinds) <= {str, int, float, bool} and len(kinds) > 1:
        return _scalar(hint, kinds)
    if len(kinds) > 1:
        return lambda item, names: read(_form(hint, kinds, item), item, names)
    (kind,) = kinds
    if kind is Item:
        return lambda item, _names: item
    if kind is Any:
        return lambda item, _names: item.plain()
    if is_model(kind):
        return lambda item, names: read(kind, item, names)
    origin = get_origin(kind)
    if origin in (tuple, frozenset):
        return _several(hint, kind)
    if origin is Mapping:
        return _by_name(hint, get_args(kind)[1])
    if origin is Literal:
        return lambda item, _names: _literal(get_args(kind), item)
    if issubclass(kind, Enum):
        values = [member.value for member in kind]
        return lambda item, _names: kind(item.choice(values))
    if kind is bool:
        return lambda item, _names: item.flag()
    bounds = _mark(hint, marks.Bounds) or marks.Bounds()
    least, most, above, infinite = bounds.least, bounds.most, bounds.above, bounds.infinite
    if kind is float:
        return lambda item, _names: item.number(least=least, most=most, above=above, infinite=infinite)
    if kind is int:
        return lambda item, _names: item.whole(least=int(least), most=int(most))
    return _text(hint)


def _text(hint: Any) -> Reader:
    choices, pattern = _mark(hint, marks.Choices), _mark(hint, marks.Pattern)

    def reader(item: Item, names: Names) -> str:
        if choices is not None and (among := choices.among(names)):
            for text, install in choices.elsewhere:
                if item.value == text and text not in among:
                    package = f"is of a package that is not installed: {install}"
                    raise InputError(f"{item.place}: {item.name}={text!r} {package}")
            return item.choice(tuple(among))
        if pattern is None:
            return item.text()
        if not isinstance(item.value, str) or not re.fullmatch(pattern.text, item.value):
            raise item.error(pattern.allowed)
        return item.value

    return reader


def _scalar(hint: Any, kinds: Collection[type]) -> Reader:
    """Of a value of several plain types; a text obeys the pattern, a number the bounds."""
    text, number = _text(hint), _reader(_marked(float, hint))
    numbers = bool({int, float} & set(kinds))

    def reader(item: Item, names: Names) -> Any:
        value = item.value
        if isinstance(value, bool) and bool in kinds:
            return value
        if isinstance(value, str) and str in kinds:
            return text(item, names)
        if isinstance(value, int | float) and not isinstance(value, bool) and numbers:
            return number(item, names)
        told = {str: "a text", float: "a number", int: "a number", bool: "true or false"}
        raise item.error(" or ".join(dict.fromkeys(told[kind] for kind in kinds)))

    return reader


def _marked(kind: type, hint: Any) -> Any:
    """A plain type with the bounds of another."""
    bounds = _mark(hint, marks.Bounds)
    return Annotated[kind, bounds] if bounds else kind


def _literal(allowed: tuple[Any, ...], item: Item) -> Any:
    for one in allowed:
        if item.value == one and isinstance(item.value, bool) is isinstance(one, bool):
            return one
    if all(isinstance(one, str) for one in allowed):
        return item.choice(allowed)
    raise item.error(" or ".join("true" if one is True else f"{one!r}" for one in allowed))


def _entries(size: marks.Size | None, item: Item, kind: str) -> Any:
    """The entries of a list or mapping, as many as its size allows."""
    size = size or marks.Size(most=ITEMS)
    entries: Any = item.items(most=max(size.most, size.least)) if kind == "list" else item.mapping(most=size.most)
    if len(entries) < size.least:
        raise item.error(size.allowed or f"a {kind} of at least {'one' if size.least == 1 else size.least}")
    return entries


def _several(hint: Any, kind: Any) -> Reader:
    inner, size, made = get_args(kind), _mark(hint, marks.Size), get_origin(kind)
    if _mark(hint, marks.ByName) is not None:
        by_name = _by_name(hint, inner[0])
        return lambda item, names: tuple(by_name(item, names).values())
    exact = made is tuple and inner[-1] is not Ellipsis
    readers = tuple(map(_reader, inner if exact else inner[:1]))

    def reader(item: Item, names: Names) -> Any:
        if exact and len(item.items()) != len(inner):
            noun = "numbers" if all(_present(one)[0] in (float, int) for one in inner) else "values"
            raise item.error((size.allowed if size else "") or f"a list of {len(inner)} {noun}")
        faults, values = Faults(), []
        for place, entry in enumerate(item.items() if exact else _entries(size, item, "list")):
            with faults.collecting():
                values.append(readers[place if exact else 0](entry, names))
        faults.end()
        return made(values)

    return reader


def _by_name(hint: Any, inner: Any) -> Reader:
    pattern, choices, size = _mark(hint, marks.Pattern), _mark(hint, marks.Choices), _mark(hint, marks.Size)

    def reader(item: Item, names: Names) -> dict[str, Any]:
        faults, values, read_one = Faults(), dict[str, Any](), _reader(inner)
        for key, entry in _entries(size, item, "mapping").items():
            if pattern is not None and not re.fullmatch(pattern.text, key):
                faults.add(InputError(f"{entry.place}: name {key!r} must be {pattern.allowed}"))
            elif choices is not None and (among := choices.among(names)) and key not in among:
                faults.add(InputError(f"{entry.place}: {item.name} {key!r} is not known{did_you_mean(key, among)}"))
            else:
                with faults.collecting():
                    values[key] = read_one(entry, names)
        faults.end()
        return values

    return reader


def _form(hint: Any, models: tuple[Any, ...], item: Item) -> Any:
    """The form, of those that a value may have, that an entry has."""
    either = _mark(hint, marks.Either) or marks.Either()
    entries = item.mapping()
    if either.by:
        by_value = {value: model for model in models for value in _fixed(model, either.by)}
        return by_value[item.need(either.by).choice(list(by_value))]
    own = {model: set(keys_of(model)) for model in models}
    shared = set.intersection(*own.values())
    fitting = [model for model in models if (own[model] - shared) & entries.keys()]
    whole = [model for model in fitting if entries.keys() & set.union(*own.values()) <= own[model]]
    if len(whole) == 1 or (len(fitting) == 1 and not either.allowed):
        return (whole or fitting)[0]
    strange = entries.keys() - set.union(*own.values())
    for model in models:
        if not fitting and any(difflib.get_close_matches(key, own[model] - shared, 1, _NEAR) for key in strange):
            return model
    if either.allowed:
        raise item.error(either.allowed)
    if len(fitting) > 1:
        raise _two_forms(item, {model: own[model] - shared for model in fitting})
    return max(models, key=lambda model: len(own[model] & entries.keys()))


def _two_forms(item: Item, own: Mapping[Any, set[str]]) -> InputError:
    """The error for an entry with keys of its own of several forms; the form that lacks least replaces the others."""
    entries = item.mapping()
    form = min(own, key=lambda model: (len(_keys(model)[1] - entries.keys()), len(own[model] & entries.keys())))
    keys = [key for key in entries if key in own[form] & _keys(form)[1]] or [key for key in entries if key in own[form]]
    others = [key for key in entries if key not in own[form] and any(key in one for one in own.values())]
    return InputError(
        f"{entries[keys[0]].place}: {' and '.join(map(repr, keys))} in {item.name} stands in place of "
        f"{', '.join(map(repr, others))}; leave out the one or the others"
    )


def _fixed(model: type, key: str) -> tuple[Any, ...]:
    field = next(one for one in fields_of(model) if one.key == key)
    return get_args(_present(field.hint)[0])


Hook = Callable[[type, Schema], Schema]
"""Adds to the schema of a model what its types cannot say."""


def schema(cls: type, names: Names = NO_NAMES, *, about: str = "", hook: Hook = lambda _cls, made: made) -> Schema:
    """The JSON Schema of a model.

    Args:
        cls: the model.
        names: names that only the study knows.
        about: what the mapping is; by default the first paragraph of the docstring.
        hook: called with each model and its schema.
    """
    properties, required = {}, []
    for field in fields_of(cls):
        if field.given is not None:
            continue
        made = schema_of(field.hint, names, hook)
        told = field.about.rstrip(".") or field.key.replace("_", " ")
        meanings = made.get("description", "") if "enum" in made else ""
        made["description"] = told + meanings if meanings.startswith("\n") else told
        if field.optional and _tells(field.default):
            made["default"] = field.default
        properties[field.key] = made
        if not field.optional:
            required.append(field.key)
    closed = {"properties": properties, "required": required, "additionalProperties": False}
    conditions = getattr(cls, "CONDITIONS", {})
    return hook(cls, {"type": "object", "description": about or summary_of(cls), **closed, **conditions})


def _tells(default: Any) -> bool:
    """Whether a schema can name a default."""
    if isinstance(default, float):
        return math.isfinite(default)
    return isinstance(default, str | int) and default != ""


def schema_of(hint: Any, names: Names = NO_NAMES, hook: Hook = lambda _cls, made: made) -> Schema:
    """The JSON Schema of a type with its marks."""
    examples = _mark(hint, marks.Examples)
    told: Schema = {"examples": [_plain(one) for one in examples.values]} if examples else {}
    return {**_schema_of(hint, names, hook), **told}


def _schema_of(hint: Any, names: Names, hook: Hook) -> Schema:
    if (reads := _mark(hint, marks.Reads)) is not None:
        return reads.schema(names)
    kinds = _present(hint)
    if set(kinds) <= {str, int, float, bool} and len(kinds) > 1:
        pattern = _mark(hint, marks.Pattern)
        words = {"pattern": f"^(?:{pattern.text})$"} if pattern else {}
        return {"type": list(dict.fromkeys(_UNITS[float if kind is int else kind] for kind in kinds)), **words}
    if len(kinds) > 1:
        return {"oneOf": [schema(kind, names, hook=hook) for kind in kinds]}
    (kind,) = kinds
    if kind in (Item, Any):
        return {}
    if is_model(kind):
        return schema(kind, names, hook=hook)
    origin = get_origin(kind)
    if origin in (tuple, frozenset) and _mark(hint, marks.ByName) is None:
        return _list_schema(hint, kind, names, hook)
    if origin in (tuple, Mapping):
        return _mapping_schema(hint, get_args(kind)[-1 if origin is Mapping else 0], names, hook)
    if origin is Literal:
        (first, *more) = get_args(kind)
        return {"enum": [first, *more]} if more else {"const": first}
    if issubclass(kind, Enum):
        told = _text_schema(hint, names)
        return told if "enum" in told else {"enum": [member.value for member in kind]}
    if kind in (float, int):
        return {"type": _UNITS[kind], **_bounds(_mark(hint, marks.Bounds) or marks.Bounds())}
    return {"type": "boolean"} if kind is bool else _text_schema(hint, names)


def _text_schema(hint: Any, names: Names) -> Schema:
    choices, pattern = _mark(hint, marks.Choices), _mark(hint, marks.Pattern)
    if choices is not None and (among := choices.among(names)):
        meanings = among.items() if isinstance(among, Mapping) else ()
        told = "".join(f"\n- {value}: {meaning}" for value, meaning in meanings)
        return {"enum": [str(one) for one in among], **({"description": told} if told else {})}
    return {"type": "string", **({"pattern": f"^(?:{pattern.text})$"} if pattern else {"minLength": 1})}


def _list_schema(hint: Any, kind: Any, names: Names, hook: Hook) -> Schema:
    inner = get_args(kind)
    if get_origin(kind) is frozenset or inner[-1] is Ellipsis:
        return {"type": "array", "items": schema_of(inner[0], names, hook), **_size(hint, "Items")}
    each = [schema_of(one, names, hook) for one in inner]
    count = {"minItems": len(each), "maxItems": len(each)}
    if all(one == each[0] for one in each):
        return {"type": "array", "items": each[0], **count}
    return {"type": "array", "prefixItems": each, **count}


def _mapping_schema(hint: Any, inner: Any, names: Names, hook: Hook) -> Schema:
    each, pattern, choices = schema_of(inner, names, hook), _mark(hint, marks.Pattern), _mark(hint, marks.Choices)
    told: Schema = {"additionalProperties": each}
    if pattern is not None:
        told = {"patternProperties": {f"^(?:{pattern.text})$": each}, "additionalProperties": False}
    elif choices is not None and (among := choices.among(names)):
        told = {"properties": dict.fromkeys(among, each), "additionalProperties": False}
    return {"type": "object", **told, **_size(hint, "Properties")}


def _size(hint: Any, noun: str) -> Schema:
    size = _mark(hint, marks.Size)
    if size is None:
        return {}
    return {**({f"min{noun}": size.least} if size.least else {}), f"max{noun}": size.most}


def _bounds(bounds: marks.Bounds) -> Schema:
    told = {"minimum": bounds.least, "exclusiveMinimum": bounds.above, "maximum": bounds.most}
    return {name: _plain(bound) for name, bound in told.items() if abs(bound) < marks.LARGEST}


def _plain(value: Any) -> Any:
    if isinstance(value, float) and value == int(value):
        return int(value)
    return [_plain(one) for one in value] if isinstance(value, tuple) else value
