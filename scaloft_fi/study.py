"""A study: the folder that a user edits, read part by part, with its accepted survivors, and checks across parts."""

from __future__ import annotations

import hashlib
import json
import shlex
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from datetime import date
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from scaloft_fi.analysis.detection import ALPHA, MOST_ALPHA
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.document import Item, digest, is_file, is_there, load, parse_date, read_text
from scaloft_fi.errors import Faults, InputError, did_you_mean, refused, shown
from scaloft_fi.hazop.load import find_study, is_packaged, load_matrix
from scaloft_fi.hazop.matrix import Cell, Matrix
from scaloft_fi.marks import MOST, Bounds, Either, Examples, Reads, Size
from scaloft_fi.model import read, value_of
from scaloft_fi.mutants.catalogue import check_catalogue, realise, with_events
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.output import write_own
from scaloft_fi.registry import Registry, grouped, load_plugins, plugins
from scaloft_fi.setup import Setup
from scaloft_fi.sim import grid as grids
from scaloft_fi.sim.events import events_in
from scaloft_fi.sim.happenings import HAPPENINGS
from scaloft_fi.sim.log import SIGNALS
from scaloft_fi.sim.situation import Situation
from scaloft_fi.sim.stacks import STACKS
from scaloft_fi.sim.world import ROLES
from scaloft_fi.sources import closure, digest_of


@dataclass(frozen=True)
class KnownFinds:
    """The finds of a study.

    Attributes:
        finds: those that fit the study, in the file's order.
        misfits: why the others are left out, by name.
        grid: name of the grid that flies them.
        searched: the grid that was searched, whose keys they have; None without one.
        breaks: situations that break the unmutated drone, in the file's order; misfits are told as those of finds.
    """

    finds: tuple[grids.Find, ...] = ()
    misfits: Mapping[str, str] = field(default_factory=dict)
    grid: str = ""
    searched: grids.Grid | None = None
    breaks: tuple[grids.Break, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence for each reason for which finds are left out."""
        return tuple(
            f"sim/{grids.FOUND_FILE}: left out, because the study has changed since: {', '.join(some)}: {why}"
            for why, some in grouped(self.misfits, self.misfits.__getitem__).items()
        )

    def of(self, mutant: str) -> tuple[grids.Find, ...]:
        """The finds that show a mutant, the one that it was found for first."""
        shown_in = [find for find in self.finds if mutant in find.shows]
        return tuple(sorted(shown_in, key=lambda find: find.mutant != mutant))


NO_FINDS = KnownFinds()


def known_finds(folder: Path, matrix: Matrix, requirements: Collection[str]) -> KnownFinds:
    """The finds of a study; those of another version of the study are left out.

    Args:
        folder: the study's `sim` folder.
        matrix: the study's matrix.
        requirements: names of the study's requirements.

    Raises:
        InputError: as `read_finds`.
    """
    found = grids.read_finds(folder)
    if found is None:
        return NO_FINDS
    grid = grids.own_name(folder) + grids.WITH_FOUND
    try:
        searched = grids.searched_grid(folder, found)
    except InputError as error:
        return KnownFinds((), dict.fromkeys(found.named, str(error)), grid)
    misfits: dict[str, str] = {}
    named: tuple[grids.Find | grids.Break, ...] = (*found.finds, *found.breaks)
    for one in named:
        if why := refused(_check, one, searched, matrix, requirements):
            misfits[one.name] = str(why)
    return KnownFinds(
        tuple(find for find in found.finds if find.name not in misfits),
        misfits,
        grid,
        searched,
        tuple(one for one in found.breaks if one.name not in misfits),
    )


def _check(one: grids.Find | grids.Break, searched: grids.Grid, matrix: Matrix, requirements: Collection[str]) -> None:
    """Refuse what has a situation, mutants or requirements that the study does not have.

    Raises:
        InputError: it has them.
    """
    searched.situation(one.situation)
    shows = one.shows if isinstance(one, grids.Find) else {}
    for mutant in shows:
        realise(matrix, mutant)
    judged = [evidence.requirement for evidence in shows.values()] if isinstance(one, grids.Find) else [one.requirement]
    for requirement in judged:
        if requirement not in requirements:
            raise InputError(f"no requirement {shown(requirement)}{did_you_mean(requirement, requirements)}")


HEADER = """\
# Accepted survivors; `scaloft-fi score --ratchet` fails on any other survivor.
# Each entry names the person responsible (owner), the reason, and the last day of its validity (expires);
# optional `situations` limit the entry: a survival in another situation is not accepted.
# An entry with `status: to_do` accepts nothing: its survivor stays open.
"""


def load_dispositions(path: Path, matrix: Matrix, situations: Collection[str]) -> tuple[Disposition, ...]:
    """Read the dispositions of a study; a study without the file has none.

    Args:
        path: `hazop/dispositions.yaml`.
        matrix: matrix of the study.
        situations: keys of its grids.

    Raises:
        InputError: a mutant, a situation or a date does not exist, a key is missing, empty or unknown, or a mutant
            occurs twice; the message names the place.
    """
    if not is_there(path):
        return ()
    places: dict[str, str] = {}
    accepted = []
    for name, item in load(path).mapping().items():
        mutant, disposition = read_disposition(name, item, matrix, situations)
        if mutant in places:
            raise InputError(f"{item.place}: mutant {name!r} is {mutant!r}, which is already at {places[mutant]}")
        places[mutant] = item.place
        if disposition is not None:
            accepted.append(disposition)
    return tuple(accepted)


@dataclass(frozen=True)
class AcceptedEntry:
    """An accepted survivor.

    Attributes:
        status: a survivor that the team accepts.
        owner: who answers for it.
        reason: why the team accepts it.
        expires: last day of its validity.
        situations: keys of the situations in which it is accepted; left out: in all.
    """

    status: Literal["accepted"]
    owner: Annotated[str, Examples("A. Engineer")]
    reason: str
    expires: Annotated[date, Reads(lambda item: _date(item), lambda _names: _DAY), Examples("2027-01-31")]
    situations: Annotated[tuple[str, ...], Size(1, MOST, "a list of at least one, or left out")] = ()


@dataclass(frozen=True)
class OpenEntry:
    """A survivor that nobody has accepted.

    Attributes:
        status: somebody has to accept it, with the keys of an accepted one, or to add a test that shows it.
    """

    status: Literal["to_do"]


DispositionModel = Annotated[AcceptedEntry | OpenEntry, Either(by="status")]
_DAY = {"type": "string", "pattern": r"^\d{4}-\d{2}-\d{2}$", "format": "date"}


@dataclass(frozen=True)
class ScoreModel:
    """How sure a score has to be; without the file alpha is 0.01.

    Attributes:
        alpha: accepted chance that a fault which does nothing is called detected.
    """

    alpha: Annotated[float, Bounds(above=0.0, most=MOST_ALPHA), Examples(0.01)]


def read_disposition(
    name: str, item: Item, matrix: Matrix, situations: Collection[str]
) -> tuple[str, Disposition | None]:
    """Read one entry: the canonical id of its mutant, and its disposition; None for one that accepts nothing.

    Args:
        name: the mutant, in any form.
        item: its entry.
        matrix: matrix of the study.
        situations: keys of its grids.

    Raises:
        InputError: a mutant, a situation or a date does not exist, or a key is missing, empty or unknown.
    """
    try:
        mutant = realise(matrix, name)
    except InputError as error:
        raise InputError(f"{item.place}: {error}") from None
    faults, model = Faults(), None
    with faults.collecting():
        model = value_of(DispositionModel, item)
    for entry in item.get("situations") or ():
        if entry.value not in situations:
            hint = did_you_mean(str(entry.value), situations)
            faults.add(InputError(f"{entry.place}: no situation {entry.value!r}{hint}"))
    faults.end()
    if not isinstance(model, AcceptedEntry):
        return mutant.id, None
    return mutant.id, Disposition(mutant.id, model.owner, model.reason, model.expires, model.situations, item.place)


def _date(item: Item) -> date:
    day = parse_date(str(item.value))
    if day is None:
        raise item.error("a date such as 2027-01-31")
    return day


def append_drafts(path: Path, matrix: Matrix, mutants: Iterable[str]) -> list[str]:
    """Append an entry for each mutant that has none to `hazop/dispositions.yaml`, which is made where it is missing.

    Returns the canonical ids of the entries that are new.

    Raises:
        InputError: the file cannot be read or written.
    """
    before, known = HEADER, set[str]()
    if is_there(path):
        before, known = read_text(path), {realise(matrix, name).id for name in load(path).mapping()}
    new = [mutant for mutant in mutants if mutant not in known]
    if new:
        write_own(path, (before.rstrip("\n") + "\n" + draft(new)).encode())
    return new


def draft(mutants: Iterable[str]) -> str:
    """Draft the YAML entries of survivors that nobody has accepted; each stays open until a person accepts it.

    Args:
        mutants: canonical ids.
    """
    how = "accepted: with owner, reason, and expires, the last day, such as 2027-01-31"
    return "".join(f"\n{mutant}:\n  status: to_do  # {how}\n" for mutant in mutants)


PACKAGE = Path(__file__).resolve().parent
FLYING = ("scaloft_fi.campaign.flights.fly", "scaloft_fi.setup")
"""The modules that fly and judge; these modules and all that they import can change an outcome."""
COMMANDED = ("scaloft_fi.campaign.flights.command", "scaloft_fi.outside.command")
"""The modules that fly besides where a command flies."""
FLYING_DATA = ("world", "vehicle", "sensors", "stack")
"""The documents of `sim/` that decide every flight; of `situations.yaml` only the values of the situation do."""


_APART = (".yaml", ".md")
"""Files of `sim/` whose bytes do not decide a flight: YAML counts as parsed data, Markdown does not count."""


@dataclass(frozen=True)
class Study(Setup):
    """A study; each part is read at its first use.

    Attributes:
        folder: holds `hazop/`, `mutants/` and `sim/`.
        archived_name: the name that an archive tells; empty for a study that is named like its folder.
    """

    archived_name: str = ""

    @classmethod
    def open(cls, folder: Path | str | None = None, grid: str | None = None) -> Study:
        """Open the study in `folder`; by default the nearest study upwards from here, else the packaged study.

        Args:
            folder: the folder.
            grid: name of one of its grids; None for its own grid.

        Raises:
            InputError: `folder` is no study, or has no such grid.
        """
        load_plugins()
        found = find_study(folder)
        if grid is None:
            return cls(found)
        names = grids.grid_names(found / "sim")
        if grid not in names:
            raise InputError(f"--grid={shown(grid)} must be the name of a grid of the study{did_you_mean(grid, names)}")
        return cls(found, grid if grid != names[0] else None)

    def __getstate__(self) -> dict[str, Any]:
        """Its fields alone: what was read of them is read anew in the process that gets the study."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        """The study, in a process that knows the plugins."""
        load_plugins()
        self.__dict__.update(state)

    @property
    def name(self) -> str:
        """The name of the study."""
        return self.archived_name or self.folder.resolve().name

    @property
    def tests_of(self) -> str:
        """The file of the suite whose tests run in place of flights; "" for a study that flies."""
        return ""

    @property
    def again(self) -> str:
        """The command that flies, or runs the tests, as people type it."""
        return f"scaloft-fi suite {shlex.quote(self.tests_of)}" if self.tests_of else "scaloft-fi run"

    def noted(self) -> dict[str, Any]:
        """What a campaign keeps of a suite, in plain JSON values; {} of a study that flies."""
        return {}

    @property
    def packaged(self) -> bool:
        """Whether this is the study of the installed package, whose folder takes no results."""
        return is_packaged(self.folder)

    @property
    def results_folder(self) -> Path:
        """Folder of the campaigns."""
        return (Path.cwd() if self.packaged else self.folder) / "results"

    @cached_property
    def matrix(self) -> Matrix:
        """The deviation matrix."""
        matrix, world = load_matrix(self.folder / "hazop", self.stack.by_name), self.folder / "sim" / "world.yaml"
        return with_events(matrix, events_in(load(world), self.stack.beliefs))

    @cached_property
    def catalogue(self) -> tuple[Mutant, ...]:
        """Every mutant; checked to equal the mutants derived from the matrix."""
        return check_catalogue(self.folder / "mutants", self.matrix)

    @cached_property
    def roster(self) -> Roster:
        """The mutants for scores."""
        return Roster.of(self.matrix, [mutant.id for mutant in self.catalogue])

    @cached_property
    def alpha(self) -> float:
        """Accepted chance that a fault without effect is called detected: `hazop/score.yaml`, else 0.01.

        Raises:
            InputError: the number is not above 0 and at most 0.1; the message names its place.
        """
        path = self.folder / "hazop" / "score.yaml"
        if not is_there(path):
            return ALPHA
        return read(ScoreModel, load(path)).alpha

    @property
    def dispositions_path(self) -> Path:
        """Path of the accepted survivors; the file need not exist."""
        return self.folder / "hazop" / "dispositions.yaml"

    @cached_property
    def dispositions(self) -> tuple[Disposition, ...]:
        """The accepted survivors."""
        return load_dispositions(self.dispositions_path, self.matrix, SituationKeys(self))

    @cached_property
    def finds(self) -> KnownFinds:
        """The situations that a search found, those that still fit the study."""
        names = [requirement.name for requirement in self.requirements]
        return known_finds(self.folder / "sim", self.matrix, names)

    @cached_property
    def inputs(self) -> Mapping[str, str]:
        """Hashes of everything that decides an outcome, by part; comments and the order of keys do not count.

        The part `operator NAME` is what only the mutants with that operator fly.
        """
        sim = self.folder / "sim"
        parts = {"stack": load(sim / "stack.yaml"), **self.grid.documents}
        documents = {name: parts[name].plain() for name in FLYING_DATA} | self._command_documents()
        files = {path.relative_to(sim): path for path in _files(sim) if path.suffix not in _APART}
        others = {
            path.as_posix(): digest(file)
            for path, file in files.items()
            if self.grid_name is not None or path.parts[0] != grids.FOLDER
        }
        programs = {f"../{name}": name for name in (self.command.inputs if self.command else ())}
        programs |= {f"stack {Path(name).name}": name for name in self.stack.files}
        for said, name in programs.items():  # an archive has no programs, and its flights count without them
            gone = self.archived_name and not is_there(self.folder / name)
            others[said] = "" if gone else digest(self.folder / name)
        roles = [(b.name, ROLES[b.role].seen_as) for b in self.grid.recorded.bodies.values()]
        judged = [(r.name, r.kind, r.text, r.trigger, r.definitions) for r in self.requirements]
        code = closure(self.flying_modules)
        modules = self.operator_modules
        added = {module: digest_of(closure([module], beside=code)) for module in {*modules.values()}}
        return {
            "sim": value_digest([documents, others, roles]),
            "requirements": value_digest(judged),
            "code": digest_of(code),
            **{f"operator {name}": added[module] for name, module in modules.items()},
        }

    def _command_documents(self) -> dict[str, Any]:
        """The documents that decide a flight of a command, beside those of every flight."""
        if self.command is None:
            return {}
        paths = {name: self.folder / "sim" / f"{name}.yaml" for name in ("flyer", "record")}
        return {name: load(path).plain() for name, path in paths.items() if is_there(path)}

    @property
    def flying_modules(self) -> tuple[str, ...]:
        """The modules that fly and judge, and the modules of the stack, sensors, signals and happenings in the study.

        These modules and all that they import can change every outcome; a plugin that the study does not use cannot.
        """
        declared = sys.modules.get("scaloft_fi.sim.sensors.sensor")  # a plugin that declares a sensor has imported it
        kinds = declared.SENSORS if declared else Registry[Any]("sensor")
        sensors = self.grid.documents["sensors"].mapping()
        modules = [
            _module_of(STACKS, load(self.folder / "sim" / "stack.yaml").need("name").text(), self.stack.make),
            *(_module_of(kinds, name, kinds[name].make) for name in sensors if name in kinds),
            *(_module_of(SIGNALS, name, SIGNALS[name].make) for name in self.grid.recorded.signals),
            *(_module_of(HAPPENINGS, name, HAPPENINGS[name].effect) for name in self._happenings if name in HAPPENINGS),
        ]
        return *FLYING, *(COMMANDED if self.command else ()), *dict.fromkeys([*modules, *self._looked_up])

    @property
    def _looked_up(self) -> Iterator[str]:
        """The modules that a flight looks up by name: those of its borders, and of the reader of a command's record."""
        documents = [load(self.folder / "sim" / "stack.yaml").plain(), *self._command_documents().values()]
        if borders := {name for document in documents for name in _values(document, "border")}:
            from scaloft_fi.outside.border import BORDERS

            yield from (BORDERS.declared_in[name] for name in sorted(borders) if name in BORDERS)
        if self.command and self.command.record:
            from scaloft_fi.outside.records import FOLDER, RECORDS

            ending = Path(self.command.record).suffix.lower() or FOLDER
            yield from [RECORDS.declared_in[ending]] if ending in RECORDS else []

    @property
    def operator_modules(self) -> Mapping[str, str]:
        """The module of each operator that PLACEBO or a mutant of the study has.

        It and all that it imports can change an outcome of those mutants, and of no baseline.
        """
        used = {PLACEBO.operator, *(fault.operator for cell in self.matrix for fault in cell.faults)}
        return {name: _module_of(OPERATORS, name, OPERATORS[name].make) for name in sorted(used) if name in OPERATORS}

    @property
    def _happenings(self) -> list[str]:
        """The kinds of all happenings in the study, active or not."""
        declared = self.grid.documents["world"].plain().get("happenings") or {}
        return sorted({str(entry.get("kind")) for entry in declared.values() if isinstance(entry, dict)})

    def check_requirements(self, cells: Iterable[Cell]) -> None:
        """Find the requirements that cells name.

        Raises:
            InputError: the study has no such requirement.
        """
        known = [requirement.name for requirement in self.requirements]
        for cell in cells:
            for name in cell.requirements:
                if name not in known:
                    hint = did_you_mean(name, known)
                    raise InputError(f"{cell.requirements_place}: {name!r} of {cell.name} is no requirement{hint}")

    def check(self, situations: Iterable[Situation] | None = None) -> None:
        """Read every part, and check the parts against each other.

        Args:
            situations: situations whose worlds are checked; None = all.

        Raises:
            InputError: parts contradict each other; the message names the place of the first contradiction.
        """
        self.check_requirements(self.matrix)
        # reading a part checks it
        _ = (
            self.sim.stack.settings(self.stack),
            self.catalogue,
            self.realisation,
            [self.scenario(situation) for situation in situations or self.grid.situations],
        )


@dataclass(frozen=True)
class SituationKeys(Collection[str]):
    """The keys of every grid of a study; another grid than that of the study is read when a key is not in that one."""

    study: Study

    def __contains__(self, key: object) -> bool:
        return any(key in one.space.point for one in self._studies())

    def __iter__(self) -> Iterator[str]:
        return (key for one in self._studies() for key in one.space.point)

    def __len__(self) -> int:
        return sum(len(one.space.points) for one in self._studies())

    def _studies(self) -> Iterator[Study]:
        yield self.study
        _, *further = grids.grid_names(self.study.folder / "sim")
        names = [None, *further]
        yield from (replace(self.study, grid_name=name) for name in names if name != self.study.grid_name)


def _module_of(registry: Registry[Any], name: str, make: Any) -> str:
    """The module whose code decides what an entry makes: a plugin's that declares it, else that of what makes it.

    What a plugin declares may be made by a function of a library, which the plugin imports.
    """
    declares = registry.declared_in.get(name, "")
    theirs = {plugin.module.partition(".")[0] for plugin in plugins()}
    return declares if declares.partition(".")[0] in theirs else str(make.__module__)


def _values(document: Any, key: str) -> Iterator[str]:
    """The texts under a key, wherever the key stands in a document."""
    if isinstance(document, Mapping):
        yield from (value for name, value in document.items() if name == key and isinstance(value, str))
    inner = document.values() if isinstance(document, Mapping) else document if isinstance(document, list) else ()
    for each in inner:
        yield from _values(each, key)


def _files(folder: Path) -> Iterator[Path]:
    return (path for path in sorted(folder.rglob("*")) if is_file(path) and not path.name.startswith("."))


def value_digest(content: Any) -> str:
    """A hash of plain JSON values, independent of the order of keys."""
    text = json.dumps(content, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()
