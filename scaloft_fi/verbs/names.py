"""The names that a shell completes: mutants, situations, campaigns, and what a study and its packages declare.

They are read from the files of the study as plain text, without numpy and without a check of the study; a file that
cannot be read has no names.  No store is opened: one that somebody else has made may take for ever to answer.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from scaloft_fi.document import CATALOGUE_BYTES, Item, load, read_text
from scaloft_fi.hazop.load import find_study, shipped
from scaloft_fi.registry import plugins

BELIEF, FORMAT, SEAM, SIGNAL = "Belief", "@export_format", "Seam", "@signal"
OPERATOR = r"@(?:operator|on(?:_\w+)?)"
"""What a declaration begins with; its first argument is the name, or the second behind a type of messages."""
OWN = Path(__file__).parents[1]
"""The sources of this package."""
MOST_FILES = 256
"""Most files of a plugin that are read."""


def declared(what: str, *folders: str) -> Iterator[str]:
    """The names that this package declares in some of its folders, then those that installed plugins declare.

    Args:
        what: one of the words above.
        folders: below this package.
    """
    indent = "" if what.startswith("@") else r" *(?:\*\()?"  # an example in a docstring is indented
    name = re.compile(rf'^{indent}{what}\(\s*(?:[A-Z]\w*,\s*)?f?"([\w{{}}-]+)"', re.MULTILINE)
    own = (path for folder in folders for path in sorted((OWN / folder).rglob("*.py")))
    for path in (*own, *_plugins()):
        for found in name.findall(read_text(path)):
            yield from (found.replace("{axis}", axis) for axis in ("xyz" if "{axis}" in found else "x"))


def rows(pattern: str, file: str) -> list[str]:
    """What a pattern finds at the beginnings of the lines of a file of this package."""
    return re.findall(pattern, read_text(OWN / file), re.MULTILINE)


def _plugins() -> Iterator[Path]:
    """The sources of the packages that have plugins; none of them is imported."""
    for top in sorted({plugin.module.partition(".")[0] for plugin in plugins()}):
        spec = find_spec(top)
        if spec is not None and spec.submodule_search_locations is not None:
            for folder in spec.submodule_search_locations:
                yield from islice(sorted(Path(folder).rglob("*.py")), MOST_FILES)
        elif spec is not None and spec.origin is not None:
            yield Path(spec.origin)


def example_names() -> tuple[str, ...]:
    """The names of the examples of this installation."""
    return tuple(sorted(path.parent.name for path in shipped("examples").glob("*/README.md")))


MOST = 256
"""Most names that are offered at once; the next letters choose among the others."""
PHASED = "#"
"""Begins the phase of an id: a mutant at a phase is offered once this letter was typed."""
Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]
Names = Iterable[str]


def _completer(names: Callable[[Path, click.Context, str], Names]) -> Completer:
    """What `shell_complete` of an option or argument takes.

    Args:
        names: gives names of a study's folder, in the order in which they are offered, some that do not fit included.
    """

    def complete(context: click.Context, _parameter: click.Parameter, typed: str) -> list[CompletionItem]:
        try:
            return [CompletionItem(name) for name in _first(names(_study(context), context, typed), typed)]
        except Exception:  # noqa: BLE001 - whatever a study is, a completion says nothing of it
            return []

    return complete


def _first(names: Names, typed: str) -> list[str]:
    # a word that begins with - is an option
    fits = (name for name in names if name.startswith(typed) and name[:1] not in ("", "-"))
    return list(islice(dict.fromkeys(fits), MOST))


def _study(context: click.Context) -> Path:
    return find_study(context.params.get("study_folder") or context.params.get("study"))


def _catalogue(study: Path) -> Iterator[dict[str, Any]]:
    lines = read_text(study / "mutants" / "catalogue.jsonl", CATALOGUE_BYTES).splitlines()
    return map(json.loads, filter(None, lines))


def _mutant_names(study: Path, typed: str, more: Names = ()) -> Iterator[str]:
    mutants = list(_catalogue(study))
    yield from more
    yield from (_cell(one) for one in mutants)
    yield from (one["id"] for one in mutants if PHASED not in one["id"] or PHASED in typed)


def _cell(mutant: dict[str, Any]) -> str:
    return f"{mutant['guideword']}-{mutant['parameter']}"


def _situation_names(study: Path, grid: str | None, typed: str) -> Iterator[str]:
    item = _grid(study, grid)
    yield from _keys(item, typed)
    yield from _entries(item, "aliases")
    if (found := study / "sim" / "found.yaml").is_file() and grid and grid.endswith("+found"):
        yield from load(found).need("finds").mapping()


def _stack(study: Path) -> Item:
    return load(study / "sim" / "stack.yaml")


def _grid(study: Path, name: str | None) -> Item:
    further = study / "sim" / "grids" / f"{name}.yaml"
    known = name and re.fullmatch(r"[\w-]+", name) and further.is_file()
    return load(further if known else study / "sim" / "situations.yaml")


def _entries(item: Item, key: str) -> Names:
    entries = item.get(key)
    return entries.mapping() if entries is not None else ()


def _keys(grid: Item, typed: str) -> Names:
    """The keys that begin with `typed`; none of a grid with an axis that is a range of a number."""
    axes = grid.need("axes").mapping()
    keys: list[tuple[str, dict[str, str]]] = [("", {})]
    for axis, item in axes.items():
        values = item.get("values")
        if values is None:
            return ()
        ids = [str(value.need("id").value) for value in values]
        longer = [(f"{key}{axis}{id_}", {**point, axis: id_}) for key, point in keys for id_ in ids]
        keys = [one for one in longer if one[0].startswith(typed[: len(one[0])])][: MOST * MOST]
    excluded = [
        {axis: [str(one.value) for one in (ids if isinstance(ids.value, tuple) else (ids,))] for axis, ids in entries}
        for constraint in grid.get("constraints") or ()
        for entries in [constraint.need("exclude").mapping().items()]
    ]

    def fits(point: dict[str, str]) -> bool:
        return not any(all(point.get(axis) in ids for axis, ids in one.items()) for one in excluded)

    return [key for key, point in keys if fits(point)]


def _campaign_names(study: Path, _context: click.Context, _typed: str) -> Names:
    packaged = Path(__file__).resolve().parents[1] / "_study"
    folder = (Path.cwd() if study.resolve() == packaged else study) / "results" / "campaigns"
    return sorted(path.name for path in folder.iterdir() if path.is_dir())


def _grid_names(study: Path, _context: click.Context, _typed: str) -> Iterator[str]:
    name = load(study / "sim" / "situations.yaml").get("name")
    own = name.text() if name else "situations"
    yield own
    yield from sorted(path.stem for path in (study / "sim" / "grids").glob("*.yaml"))
    if (study / "sim" / "found.yaml").is_file():
        yield f"{own}+found"


def _flight_names(study: Path, context: click.Context, typed: str) -> Iterator[str]:
    """`MUTANT/`, then `MUTANT/SITUATION/`, then `MUTANT/SITUATION/0`: one part after the other."""
    mutant, *rest = typed.split("/")
    if not rest:
        yield from (f"{name}/" for name in _mutant_names(study, typed, ("baseline", "PLACEBO")))
    elif len(rest) == 1:
        yield from (f"{mutant}/{key}/0" for key in _situation_names(study, context.params.get("grid"), rest[0]))


def _operator_names(study: Path, _context: click.Context, _typed: str) -> Names:
    outside = ["outside"] if _stack(study).need("name").value == "outside" else []
    return sorted(declared(OPERATOR, "mutants", *outside))


def _seam_names(study: Path, _context: click.Context, _typed: str) -> Iterator[str]:
    yield from _entries(_stack(study), "seams")  # of stages outside
    yield from _stack_names(study, SEAM)


def _stack_names(study: Path, what: str) -> Names:
    """Names that the sources of the study's stack declare; of a plugin's stack those of every plugin."""
    own = _stack(study).need("name").value == "reference"
    return declared(what, *(["stack/reference"] if own else []))


def _signal_names(study: Path, _context: click.Context, _typed: str) -> Iterator[str]:
    yield from rows(r"^ +([a-z]\w*) +\| ", "sim/log.py")
    for surface in ("wall", "ground", *load(study / "sim" / "world.yaml").need("bodies").mapping()):
        yield f"clearance_{surface}_m"
    yield from _stack_names(study, BELIEF)
    yield from declared(SIGNAL, "sim")


mutants = _completer(lambda study, _context, typed: _mutant_names(study, typed))
sought = _completer(lambda study, _context, typed: _mutant_names(study, typed, ("baseline", "PLACEBO")))
axes = _completer(lambda study, context, _: _grid(study, context.params.get("grid")).need("axes").mapping())
documents = _completer(lambda *_: rows(r'^ +Document\("(\w+)"', "verbs/schema.py"))
operators = _completer(_operator_names)
seams = _completer(_seam_names)
signals = _completer(_signal_names)
seeds = _completer(lambda *_: ("1", "3", "5", "10"))
choices = _completer(
    lambda *_: ("all", "random:10", "draws:100", "draws:90%", "sobol:10", "first:10", "2-way", "3-way")
)
cells = _completer(lambda study, *_: (_cell(one) for one in _catalogue(study)))
guidewords = _completer(lambda study, *_: (one["guideword"] for one in _catalogue(study)))
parameters = _completer(lambda study, *_: (one["parameter"] for one in _catalogue(study)))
situations = _completer(lambda study, context, typed: _situation_names(study, context.params.get("grid"), typed))
campaigns = _completer(_campaign_names)
grids = _completer(_grid_names)
flights = _completer(_flight_names)
examples = _completer(lambda *_: example_names())
formats = _completer(lambda *_: sorted(declared(FORMAT, "verbs/export")))
