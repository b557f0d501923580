"""`scaloft-fi axes`: list the study's axes, without flying."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from scaloft_fi.sim.situation import Distribution, Shape, number_text
from scaloft_fi.verbs.listing import Listing, Record, tell_listing
from scaloft_fi.verbs.names import axes
from scaloft_fi.verbs.options import GridOfStudy, Option, StudyFolder, TableFormat, TablesFolder
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Output, anything, listing, number, optional, record, text, texts

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.sim.situation import Axis, AxisValue, FreeAxis


VALUES, RANGE, FREE = "values", "range", "free"
_SETS = record("a change", {"path": text("path of a value of the study"), "value": anything("its new value")})
_RANGE = "an axis with single values"
FORM = Output(
    "axes",
    "1.0",
    "the axes of a grid of situations",
    {
        "axes": listing(
            "the axes, the free ones last",
            record(
                "an axis",
                {
                    "name": text("its name in keys"),
                    "title": text("its name in tables"),
                    "category": text("category of the operational design domain"),
                    "kind": text(
                        "single values, a range of one number, or a number that spans no grid", (VALUES, RANGE, FREE)
                    ),
                    "keys": texts("how keys of situations name its values"),
                    "benign": text("its benign value"),
                    "summary": text("its values in words"),
                    "values": listing(
                        "its values, of a range its bins; none of a free axis",
                        record(
                            "a value",
                            {
                                "name": text("its name in keys"),
                                "title": text("its name in tables"),
                                "set": listing("what it sets", _SETS),
                                "realised": text("formula: whether a flight met it"),
                            },
                        ),
                    ),
                    "distribution": text("distribution of the number; empty for single values"),
                    "set": text("path of the number; empty for single values"),
                    "realised": text("formula of a range, with the word `number`; empty for others"),
                    "unit": text("unit of the number; empty for single values"),
                    "from": optional(number("lower end"), _RANGE),
                    "to": optional(number("upper end"), _RANGE),
                    "also": listing("what else a number off the benign value sets", _SETS),
                    "only_with": listing(
                        "values of other axes without which a free axis has no effect or cannot be",
                        record("an axis", {"axis": text("its name"), "values": texts("ids of its values")}),
                    ),
                },
            ),
        )
    },
    rows="axes",
)
OVERVIEW = {"axis": "name", "title": "title", "category": "category", "kind": "kind", "values": "summary"}


def axis_list(grid: Grid) -> Listing:
    """Every axis of a grid, the free ones last; `FORM` says what a record has."""
    records = (*map(_record, grid.axes), *map(_free, grid.free))
    situations = f"{len(grid):,} situations with keys like {''.join(f'{axis.id}0' for axis in grid.axes)}"
    notes = [f"{situations}; 0 is the benign value of an axis."]
    if grid.free:
        notes.append(
            "A free axis spans no grid: at its benign value it is left out of the key, else it stands at the end."
        )
    notes += [f"excluded: {_combination(one.excluded)}: {one.reason}" for one in grid.constraints]
    if grid.aliases:
        notes.append("other names: " + ", ".join(f"{alias} = {key}" for alias, key in list(grid.aliases.items())[:12]))
    notes.append("`scaloft-fi axes NAME` shows one whole; category: of the operational design domain.")
    return Listing(
        "axis", f"Axes of the grid {grid.name}: {len(records)}", OVERVIEW, records, _sheet, FORM, tuple(notes)
    )


def _combination(excluded: Any) -> str:
    return " with ".join(f"{axis}{'/'.join(map(str, sorted(values)))}" for axis, values in excluded.items())


def _record(axis: Axis) -> Record:
    values = [_value(axis, value) for value in axis.values]
    benign, *others = (value.title for value in axis.values)
    told = {
        "name": axis.id,
        "title": axis.title,
        "category": axis.category,
        "kind": RANGE if axis.range else VALUES,
        "keys": [value["name"] for value in values],
        "benign": benign,
        "summary": f"{benign} (benign), {', '.join(others)}",
        "values": values,
        **_nothing(),
    }
    if (own := axis.range) is None:
        return told
    low, high = number_text(own.edges[0]), number_text(own.edges[-1])
    middle = next(bin_ for bin_ in own.ids if bin_ != 0)
    return told | {
        "keys": [*told["keys"], f"{axis.id}{middle}={number_text(own.middle(middle))}"],
        "benign": own.told(own.benign),
        "summary": f"{low} to {high} {own.unit}, {_shape(own.distribution)}, {len(own.ids)} bins",
        "unit": own.unit,
        "from": own.edges[0],
        "to": own.edges[-1],
        "distribution": _shape(own.distribution),
        "set": own.path,
        "realised": axis.realised.text() if axis.realised else "",
    }


def _nothing() -> dict[str, Any]:
    """What an axis with single values lacks."""
    words = dict.fromkeys(("distribution", "set", "realised", "unit"), "")
    return {**words, "from": None, "to": None, "also": [], "only_with": []}


def _value(axis: Axis, value: AxisValue) -> Record:
    sets = [{"path": path, "value": item.plain()} for path, item in value.changes.items()]
    others = [f"{axis.id}{other.id}" for other in axis.values if other.realised]
    return {
        "name": f"{axis.id}{value.id}",
        "title": value.title,
        "set": sets,
        "realised": value.realised or f"none of {', '.join(others)} is met",
    }


def _free(axis: FreeAxis) -> Record:
    own = axis.distribution
    return {
        "name": axis.id,
        "title": axis.title,
        "category": axis.category,
        "kind": FREE,
        "keys": [f"{axis.id}={number_text(axis.at(0.5))}"],
        "benign": f"{number_text(axis.benign)} {axis.unit}",
        "summary": f"{number_text(own.low)} to {number_text(own.high)} {axis.unit}, {_shape(own)}",
        "values": [],
        **_nothing(),
        "unit": axis.unit,
        "from": own.low,
        "to": own.high,
        "distribution": _shape(own),
        "set": axis.path,
        "also": [{"path": path, "value": item.plain()} for path, item in axis.also.items()],
        "only_with": [
            {"axis": name, "values": list(map(str, sorted(values)))} for name, values in axis.only_with.items()
        ],
    }


def _shape(own: Distribution) -> str:
    if own.shape is Shape.NORMAL:
        return f"{own.shape} (mean {own.centre:g}, sd {own.sd:g})"
    return f"{own.shape} (mode {own.centre:g})" if own.shape is Shape.TRIANGULAR else str(own.shape)


def _sheet(one: Record) -> list[tuple[str, str]]:
    rows = [
        ("title", one["title"]),
        ("category", one["category"]),
        ("benign", one["benign"]),
        ("in keys", ", ".join(one["keys"])),
    ]
    if one["kind"] != VALUES:
        rows.append(("numbers", one["summary"]))
        rows.append(("sets", one["set"]))
        rows += [("sets off benign", _set(each)) for each in one["also"]]
        rows += [("only with", f"{each['axis']}{'/'.join(each['values'])}") for each in one["only_with"]]
        rows.append(("realised", one["realised"]))
    for value in one["values"]:
        heading = f"{value['name']} {value['title']}"
        if one["kind"] == VALUES:
            rows += [(heading, f"sets {_set(each)}") for each in value["set"]]
            rows.append((heading, f"met if {value['realised']}"))
        else:
            rows.append(("bins", heading))
    return rows


def _set(change: Record) -> str:
    return f"{change['path']}: {change['value']}"


@verb(
    "axes",
    examples=(
        ("List the axes of the study's own grid", "scaloft-fi axes"),
        ("Show one whole", "scaloft-fi axes H"),
        ("List those of the grid `search`, as Markdown", "scaloft-fi axes --grid search --format markdown"),
    ),
)
def axes_command(
    *,
    names: Annotated[tuple[str, ...], Option("", "", metavar="[NAME]...", complete=axes)] = (),
    study_folder: StudyFolder,
    grid: GridOfStudy,
    style: TableFormat,
    tables_folder: TablesFolder,
) -> None:
    """List the axes of a grid of situations.

    Without a NAME an overview; NAME, or a pattern with *, ? or [, shows these whole: what each value sets, and the
    formula by which a flight is known to have met it.
    """
    tell_listing(lambda study: axis_list(study.grid), names, style, study_folder, grid, tables=tables_folder)
