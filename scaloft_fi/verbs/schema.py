"""`scaloft-fi schema`: every YAML document of a study with its model, and the JSON Schema that follows from it."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path, PurePosixPath
from typing import Annotated, Any

import click

import scaloft_fi.mutants.reference  # noqa: F401 - it declares operators
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.load import GUIDEWORD, CellModel, Guidewords, Parameters
from scaloft_fi.hazop.matrix import Classes, Fault
from scaloft_fi.judge.requirement import RequirementsModel
from scaloft_fi.marks import About, Pattern
from scaloft_fi.model import Names, Schema, schema, schema_of
from scaloft_fi.mutants.operator import Argument, Operator
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.output import say, tell, tell_line, write_named, writing
from scaloft_fi.outside.border import PORTS
from scaloft_fi.outside.command import FlightCommand
from scaloft_fi.outside.exchange import BELOW, OutsideConfig
from scaloft_fi.outside.records import RecordMap
from scaloft_fi.outside.stack import VelocityConfig
from scaloft_fi.outside.suite import Suite
from scaloft_fi.registry import load_plugins
from scaloft_fi.sim.grid import Finds, FurtherGridModel, GridModel
from scaloft_fi.sim.happenings import HAPPENINGS
from scaloft_fi.sim.load import DOCUMENTS as PREFIXES
from scaloft_fi.sim.load import NumberSource
from scaloft_fi.sim.log import SIGNALS
from scaloft_fi.sim.sensors.sensor import SENSORS
from scaloft_fi.sim.sensors.suite import sensors_model
from scaloft_fi.sim.situation import PARTS
from scaloft_fi.sim.stacks import STACKS
from scaloft_fi.sim.vehicle import Vehicle
from scaloft_fi.sim.world import ROLES, World
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.study import DispositionModel, ScoreModel, Study
from scaloft_fi.verbs import VERBS, module_of
from scaloft_fi.verbs.listing import OWN, argument_facts, package_of
from scaloft_fi.verbs.names import documents
from scaloft_fi.verbs.options import FORMATS, FormatOption, Option, StudyFolder, verb
from scaloft_fi.views.output import Output
from scaloft_fi.views.table import Format, Table, render

DIALECT = "https://json-schema.org/draft/2020-12/schema"
PUBLISHED = "docs/schemas/study"
"""Folder of the published schemas in the repository."""
FOLDER = "schemas"
"""The folder of the schemas in the folder of a study."""
OWN_ROLES = ("obstacle", "person", "structure")
"""Roles are data, which do not tell who declared them."""


def declared_names(*, own: bool = False, seams: Mapping[str, str] | None = None) -> Names:
    """Everything that documents name and that is declared now.

    Args:
        own: leave out what other packages declare.
        seams: the seams of the study with their edges; without them any text is one.
    """

    def chosen(entries: Mapping[str, Any], maker: Callable[[Any], Any]) -> list[str]:
        return [name for name in sorted(entries) if not own or package_of(maker(entries[name])) == OWN]

    return {
        "operators": {name: OPERATORS[name].summary for name in chosen(OPERATORS, lambda one: one.make)},
        "sensors": chosen(SENSORS, lambda one: one.make),
        "happenings": chosen(HAPPENINGS, lambda one: one.effect),
        "roles": {name: role.meaning for name, role in ROLES.items() if name in OWN_ROLES or not own},
        "signals": {name: SIGNALS[name].meaning for name in chosen(SIGNALS, lambda one: one.make)},
        "stacks": chosen(STACKS, lambda one: one.make),
        **({"seams": seams} if seams else {}),
    }


@dataclass(frozen=True)
class Document:
    """A YAML document of a study.

    Attributes:
        name: by which its schema is asked for.
        files: pattern of its files in the folder of a study.
        make: makes the schema from what is declared.
        written: whether a verb writes it; people edit the others.
    """

    name: str
    files: str
    make: Callable[[Names], Schema]
    written: bool = False

    def schema(self, names: Names) -> Schema:
        """The whole schema."""
        head = {"$schema": DIALECT, "$id": f"urn:scaloft-fi:study:{self.name}", "title": self.files}
        return {**head, **self.make(names)}


def _model(hint: Any) -> Callable[[Names], Schema]:
    """The schema of a model, or of a mapping of models with a text about it."""
    about = [mark.text for mark in getattr(hint, "__metadata__", ()) if isinstance(mark, About)]

    def make(names: Names) -> Schema:
        return {**schema_of(hint, names), **({"description": about[0]} if about else {})}

    return make


def _of_operator(name: str, operator: Operator) -> Schema:
    """Under an operator's name its own arguments, and no others."""
    arguments = {key: _argument(argument) for key, argument in operator.arguments.items()}
    then: dict[str, Any] = {
        "arguments": {"properties": arguments, "additionalProperties": False},
        "magnitude": {"properties": {"argument": {"enum": list(arguments)}}},
    }
    return {"if": {"properties": {"operator": {"const": name}}, "required": ["operator"]}, "then": {"properties": then}}


def _argument(argument: Argument) -> Schema:
    facts = argument_facts(argument)
    unit = f" [{facts.unit}]" if facts.unit else ""
    told: Schema = {"description": f"{facts.range or facts.kind}{unit}"}
    if not argument.required:
        told["default"] = argument.default
    if argument.kind in (float, int):
        bounds = {"minimum": facts.least, "exclusiveMinimum": facts.above, "maximum": facts.most}
        return told | {"type": "number"} | {key: bound for key, bound in bounds.items() if bound is not None}
    if argument.kind is bool:
        return told | {"type": "boolean"}
    if argument.choices:
        return told | {"enum": list(argument.choices)}
    return told | ({"type": "string"} if argument.kind is str else {"type": ["number", "string", "boolean"]})


def _cells(names: Names) -> Schema:
    conditions = [_of_operator(name, OPERATORS[name]) for name in names.get("operators", ())]
    hint = Annotated[Mapping[str, CellModel], Pattern(GUIDEWORD, "")]
    made = schema_of(hint, names, lambda cls, one: {**one, "allOf": conditions} if cls is Fault else one)
    return {**made, "description": "The cells of one parameter, one for each guideword."}


def _sensors(names: Names) -> Schema:
    return schema(sensors_model(names), names)


SOURCES = Annotated[
    Mapping[str, NumberSource],
    Pattern(rf"(?:{'|'.join(PREFIXES)})(?:\..+)?", ""),
    About("The source of each number of `sim/` by dotted path, its document first; a path covers all below it."),
]


def _grid(names: Names) -> Schema:
    """The schema of a further grid, which may have entries of other documents."""
    made = schema(FurtherGridModel, names)
    parts = {"world": schema(World, names), "vehicle": schema(Vehicle), "sensors": _sensors(names)}
    added = {part: _loosened(parts[part], f"new entries of sim/{part}.yaml") for part in PARTS}
    own = {"type": "object", "properties": added, "required": [], "additionalProperties": False}
    for key, more in (("adds", own), ("sources", schema_of(SOURCES))):
        made["properties"][key] = {**more, "description": made["properties"][key]["description"]}
    return made


def _loosened(document: Schema, about: str) -> Schema:
    """A mapping of which nothing is needed, and whose entries by name may be parts of entries."""
    keys = {}
    for key, one in document["properties"].items():
        each = one.get("additionalProperties") or next(iter(one.get("patternProperties", {}).values()), None)
        if each:
            part = {"anyOf": [each, {"type": "object", "description": "new keys of an entry that exists"}]}
            one = {"type": "object", "description": one["description"], "additionalProperties": part}
        elif one.get("type") == "object":
            one = {**one, "required": []}
        keys[key] = one
    return {**document, "description": about, "properties": keys, "required": []}


def _stack(names: Names) -> Schema:
    forms = [form for name in names.get("stacks", STACKS) for form in _forms(STACKS[name])]
    return {"description": "The stack under test: its name, and its settings.", "oneOf": forms}


def _forms(declared: Declaration) -> list[Schema]:
    """The forms of the document for one stack; of one outside a form for each part of our drone that flies below it."""
    name = {"name": {"const": declared.name, "description": "the stack; another name means other settings"}}
    if declared.settings is None:
        free = {"type": "object", "description": f"The stack {declared.name}.", "properties": name}
        return [{**free, "required": ["name"], "additionalProperties": True}]
    forms = []
    for settings in declared.forms() if declared.forms else (declared.settings(),):
        made = _outside(settings) if issubclass(settings, OutsideConfig) else schema(settings)
        if not declared.forms:
            made["description"] = f"The stack {declared.name}."
        forms.append({**made, "properties": {**name, **made["properties"]}, "required": ["name", *made["required"]]})
    return forms


def _outside(settings: type) -> Schema:
    below = "flight_control" if issubclass(settings, VelocityConfig) else "planner"
    ports = {name: port.meaning for name, port in PORTS.items() if port.outward or name in BELOW[below]}
    made = schema(settings, {"ports": ports})
    made["properties"]["below"]["enum"] = [below]
    return made


GUIDEWORDS = Annotated[Guidewords, About("The guidewords by name, in the order of the columns of the matrix.")]
PARAMETERS = Annotated[
    Parameters, About("The parameters by name, in the order of the rows of the matrix; each has a file of cells.")
]
SEVERITIES = Annotated[
    Classes, About("The study's own classes of severity by name, the worst first; they enter no ratio.")
]
DISPOSITIONS = Annotated[
    Mapping[str, DispositionModel], About("The accepted survivors by a mutant's id; a bare cell name is its default.")
]

DOCUMENTS: Mapping[str, Document] = {
    one.name: one
    for one in (
        Document("guidewords", "hazop/guidewords.yaml", _model(GUIDEWORDS)),
        Document("parameters", "hazop/parameters.yaml", _model(PARAMETERS)),
        Document("severities", "hazop/severities.yaml", _model(SEVERITIES)),
        Document("matrix", "hazop/matrix/*.yaml", _cells),
        Document("score", "hazop/score.yaml", _model(ScoreModel)),
        Document("dispositions", "hazop/dispositions.yaml", _model(DISPOSITIONS)),
        Document("world", "sim/world.yaml", _model(World)),
        Document("vehicle", "sim/vehicle.yaml", _model(Vehicle)),
        Document("sensors", "sim/sensors.yaml", _sensors),
        Document("stack", "sim/stack.yaml", _stack),
        Document("situations", "sim/situations.yaml", _model(GridModel)),
        Document("grid", "sim/grids/*.yaml", _grid),
        Document("requirements", "sim/requirements.yaml", _model(RequirementsModel)),
        Document("sources", "sim/sources.yaml", _model(SOURCES)),
        Document("found", "sim/found.yaml", _model(Finds), written=True),
        Document("flyer", "sim/flyer.yaml", _model(FlightCommand)),
        Document("record", "sim/record.yaml", _model(RecordMap)),
        Document("suite", "suite.yaml", _model(Suite)),
    )
}
"""In the order in which a study is read about."""


def document(name: str) -> Document:
    """The document of a name.

    Raises:
        InputError: there is none; the message names the nearest.
    """
    if name not in DOCUMENTS:
        raise InputError(f"no document {name!r}{did_you_mean(name, DOCUMENTS)}")
    return DOCUMENTS[name]


_FORM_OF = {"matrix": "margin", "run": "score", "export": "export.dossier"}
"""The module that has the form of a verb's answer, where it is not that of the verb."""
ANSWERS = tuple(verb for verb in VERBS if verb not in ("schema", "completion"))
"""Verbs that print JSON of a declared form."""


def answer_form(verb: str) -> Output:
    """The form of a verb's JSON.

    Raises:
        InputError: the verb has none; the message names the nearest verb.
    """
    if verb not in ANSWERS:
        raise InputError(f"no verb {verb!r} that answers in JSON{did_you_mean(verb, ANSWERS)}")
    module = import_module(f"scaloft_fi.verbs.{_FORM_OF.get(verb) or module_of(verb)}")
    return {one.verb: one for one in vars(module).values() if isinstance(one, Output)}[verb]


def schema_texts(names: Names) -> dict[str, str]:
    """The text of each schema by its file name."""
    return {f"{one.name}.json": schema_text(one.schema(names)) for one in DOCUMENTS.values()}


def answer_texts() -> dict[str, str]:
    """The text of the schema of each verb's answer by its file name."""
    return {f"{verb}.json": schema_text(answer_form(verb).schema) for verb in ANSWERS}


def schema_text(made: Schema) -> str:
    """A schema as JSON."""
    return json.dumps(made, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def pointed(files: Mapping[str, bytes], below: str = "") -> dict[str, bytes]:
    """Files of a study by path; each document that has a schema begins with the line that names it.

    Args:
        files: content by path.
        below: folder of the study among the files, such as "study/".
    """
    return {name: _line(name.removeprefix(below)) + content for name, content in files.items()}


def schema_files(stack: Declaration) -> dict[str, bytes]:
    """The schemas of every document by path, with what is installed and the seams of a stack.

    Raises:
        InputError: a plugin that is installed cannot be loaded.
    """
    load_plugins()
    names = declared_names(seams={seam.name: seam.edge for seam in stack.seams})
    return {f"{FOLDER}/{name}": text.encode() for name, text in schema_texts(names).items()}


def _line(name: str) -> bytes:
    """The line for a document at this path in its study; nothing for another file."""
    path = PurePosixPath(name)
    for one in DOCUMENTS.values():
        if path.match(one.files) and len(path.parts) == one.files.count("/") + 1:
            up = "../" * one.files.count("/")
            return f"# yaml-language-server: $schema={up}{FOLDER}/{one.name}.json\n".encode()
    return b""


RATIO = "ratio"
MOST_FORMS = 10
"""More names than these are counted; `scaloft-fi operators`, `signals` and the like list them."""
KEY_NOTES = (
    "`?` behind a key says that it may be left out; `*` is a name that the study chooses, `[]` each entry of a list.",
    "Where a mapping has one of several forms, a key with one fixed value tells which.",
)


def keys_table(title: str, schema: Schema) -> Table:
    """A row for each key below a schema: type, range and default in words, and what the key means."""
    rows = tuple(dict.fromkeys(_keys("", schema)))  # forms share keys
    return Table(title, ("key", "value", "meaning"), rows, KEY_NOTES)


def _keys(name: str, schema: Schema) -> Iterator[tuple[str, str, str]]:
    for key, each in schema.get("properties", {}).items():
        optional = "" if key in schema.get("required", ()) else "?"
        yield from _key_row(f"{name}.{key}{optional}" if name else f"{key}{optional}", each)
    for beginning, each in schema.get("patternProperties", {}).items():
        begins = beginning[1:] if re.fullmatch(r"\^\w+", beginning) else ""
        yield from _key_row(f"{name}.{begins}*" if name else f"{begins}*", each)
    if isinstance(each := schema.get("additionalProperties"), dict):
        yield from _key_row(f"{name}.*" if name else "*", each)
    if isinstance(schema.get("items"), dict):
        yield from _keys(f"{name}[]", schema["items"])
    for word in ("oneOf", "anyOf"):
        for each in schema.get(word, ()):
            yield from _keys(name, each)


def _key_row(name: str, schema: Schema) -> Iterator[tuple[str, str, str]]:
    about = " ".join(schema.get("description", "").replace("\n- ", "; ").split())
    examples = ", ".join(map(_key_said, schema.get("examples", ())))
    kind, default = _kind(schema), f"; left out: {_key_said(schema['default'])}" if "default" in schema else ""
    yield name, kind + default, about + (f"  Such as {examples}." if examples else "")
    if not kind.startswith(RATIO):
        yield from _keys(name, schema)


def _kind(schema: Schema) -> str:
    if "const" in schema:
        return _key_said(schema["const"])
    if "enum" in schema:
        return "one of " + ", ".join(map(_key_said, schema["enum"]))
    if "oneOf" in schema or "anyOf" in schema:
        forms = tuple(dict.fromkeys(map(_kind, (*schema.get("oneOf", ()), *schema.get("anyOf", ())))))
        return " or ".join(forms) if len(forms) <= MOST_FORMS else f"one of {len(forms)} names"
    if schema.get("properties", {}).keys() == {"part", "whole"}:
        return RATIO
    kind = schema.get("type", "any value")
    if isinstance(kind, list):
        return " or ".join(map(_TYPES.__getitem__, kind))
    if kind == "array":
        return _list(schema)
    bounds = (("minimum", "from"), ("exclusiveMinimum", "above"), ("maximum", "to"))
    limits = " ".join(f"{word} {schema[key]:g}" for key, word in bounds if key in schema)
    return f"{_TYPES.get(kind, kind)} {limits}".rstrip()


_TYPES = {
    "string": "text",
    "number": "number",
    "integer": "whole number",
    "boolean": "true or false",
    "object": "mapping",
}


def _list(schema: Schema) -> str:
    least, most = schema.get("minItems"), schema.get("maxItems")
    size = f"{least} " if least == most and least else ""
    each = _kind(schema["items"]) if isinstance(schema.get("items"), dict) else "values"
    return f"list of {size}{each}" if size or least is None else f"list of {least} or more: {each}"


def _key_said(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | dict):
        return json.dumps(value)
    return f"{value:g}" if isinstance(value, float) else str(value)


@verb("schema")
def schema_command(
    *,
    name: Annotated[str | None, Option("", "", complete=documents)] = None,
    answer: Annotated[bool, Option("NAME is a verb: show what it prints with --format json.")] = False,
    style: Annotated[
        str,
        FormatOption("How the keys are printed; json is the JSON Schema (draft 2020-12).", type=click.Choice(FORMATS)),
    ],
    study_folder: StudyFolder,
    folder: Annotated[
        Path | None,
        Option("Write every schema as DIR/NAME.json; the folder is made if it is not there.", "--write", metavar="DIR"),
    ],
) -> None:
    """Show the keys of a YAML document of a study, or of what a verb answers, with their ranges, units and defaults.

    The schemas know the seams of the study, and what installed plugins declare.  An editor with a language server for
    YAML completes keys and shows what they mean.  The first line of the document must be `# yaml-language-server:
    $schema=` with the path of the schema, which --write writes.

    Examples:
        List the documents that have a schema: `scaloft-fi schema`
        Show the keys of sim/world.yaml, and what they mean: `scaloft-fi schema world`
        Show the keys of what `score --format json` prints: `scaloft-fi schema score --answer`
        Write all schemas for an editor, those of installed plugins included: `scaloft-fi schema --write schemas`
    """
    if name and folder:
        raise click.UsageError("--write writes every schema and goes with no NAME")
    if answer and not name:
        raise click.UsageError("--answer goes with the NAME of a verb")
    if folder:
        _write(folder, schema_texts(_of_study(study_folder)))
        return
    how = Format(style)
    if name is None:
        rows = tuple((one.name, one.files) for one in DOCUMENTS.values())
        tell(render((Table("Schemas of YAML documents", ("document", "files"), rows),), how))
        return
    title, made = _asked_for(name, study_folder, answer=answer)
    tell(schema_text(made) if how is Format.JSON else render((keys_table(title, made),), how))


def _asked_for(name: str, folder: Path | None, *, answer: bool) -> tuple[str, Schema]:
    if answer:
        form = answer_form(name)
        return f"{name} --format json, version {form.version}: {form.says}", form.schema
    one = document(name)
    made = one.schema(_of_study(folder))
    return f"{one.files}: {made['description']}", made


def _of_study(folder: Path | None) -> Names:
    """What is declared; without the seams of a study whose stack cannot be read yet, as while it is written."""
    study, seams = Study.open(folder), dict[str, str]()
    try:
        seams = {seam.name: seam.edge for seam in study.stack.seams}
    except InputError as error:
        say(f"warning: without the names of seams: {error}")
    return declared_names(seams=seams)


def _write(folder: Path, texts: dict[str, str]) -> None:
    with writing(f"--write={str(folder)!r} cannot be written"):
        folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        write_named(folder / name, text.encode())
    tell_line(f"{folder}: {len(texts)} schemas")
